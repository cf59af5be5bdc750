"""CLEAR MOT: who is paired with whom over time, and how often that changes."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from trackweave.metrics._distances import check_cutoff, check_order
from trackweave.metrics.moments import Moment, Moments

__all__ = ["ClearMot", "clear_mot"]

FOUND_SHARE = 0.5


@dataclass(frozen=True, slots=True)
class ClearMot:
    """What pairing targets with tracks over time shows.

    Parameters
    ----------
    mota
        1 - (missed + false + switches) / target positions; None without targets.
    motp
        Mean distance of pairs [m]; None without pairs.
    rmse
        Root of the mean squared distance of pairs [m]; None without pairs.
    switches
        How often a target's track is another than the one that it had last.
    fragmentations
        How often a target is paired again after an interruption, by whichever track.
    n_pairs
        Number of pairs over all times.
    n_missed
        Number of target positions without a track.
    n_false
        Number of track positions without a target.
    covered
        Share of target positions that are paired; None without targets.
    n_found
        Number of targets paired for at least half of their positions.
    """

    mota: float | None
    motp: float | None
    rmse: float | None
    switches: int
    fragmentations: int
    n_pairs: int
    n_missed: int
    n_false: int
    covered: float | None
    n_found: int


class _Ledger:
    """What is remembered from time to time while pairing."""

    def __init__(self, n_targets: int) -> None:
        self.pairs: dict[int, int] = {}  # of the time before
        self.last_track: dict[int, int] = {}  # the last one that each target had
        self.interrupted: set[int] = set()  # targets that were paired once and then missed
        self.switches = self.fragmentations = 0
        self.distances: list[float] = []
        self.seen = np.zeros(n_targets, dtype=np.int64)
        self.paired = np.zeros(n_targets, dtype=np.int64)

    def enter(self, moment: Moment, pairs: dict[int, tuple[int, float]]) -> None:
        """Note the pairs of a time: target -> (track, distance)."""
        for target, (track, distance) in pairs.items():
            self.switches += self.last_track.get(target, track) != track
            self.fragmentations += target in self.interrupted
            self.last_track[target] = track
            self.distances.append(distance)
            self.paired[target] += 1
        self.interrupted -= pairs.keys()
        missed = set(moment.targets.tolist()) - pairs.keys()
        self.interrupted |= missed & self.last_track.keys()
        self.seen[moment.targets] += 1
        self.pairs = {target: track for target, (track, _) in pairs.items()}


def clear_mot(moments: Moments, cutoff: float = 50.0, order: float = 2.0) -> ClearMot:
    """Return the CLEAR MOT figures.

    At each time, pairs of the time before are kept while they are closer than the cutoff; then
    the remaining targets and tracks are paired at the least total of capped distances to the
    power of the order.

    Parameters
    ----------
    moments
        Truth and tracks at common times.
    cutoff
        Only closer pairs count [m]; positive.
    order
        Exponent of a distance while pairing; at least 1.

    Returns
    -------
    The figures over all times.

    References
    ----------
    .. [1] Bernardin, Stiefelhagen, *Evaluating multiple object tracking performance: the CLEAR
       MOT metrics*, EURASIP Journal on Image and Video Processing 2008, section 2.
       doi:10.1155/2008/246309
    """
    check_cutoff(cutoff)
    check_order(order)
    ledger, n_false = _Ledger(moments.n_targets), 0
    for moment in moments:
        pairs = _kept(moment, ledger.pairs, cutoff)
        pairs |= _new(moment, pairs, cutoff, order)
        n_false += moment.tracks.size - len(pairs)
        ledger.enter(moment, pairs)
    return _figures(ledger, n_false)


def _figures(ledger: _Ledger, n_false: int) -> ClearMot:
    distance = np.array(ledger.distances)
    n_pairs, n_positions = distance.size, int(ledger.seen.sum())
    n_missed = n_positions - n_pairs
    errors = n_missed + n_false + ledger.switches
    found = (ledger.seen > 0) & (ledger.paired >= FOUND_SHARE * ledger.seen)
    return ClearMot(
        mota=1 - errors / n_positions if n_positions else None,
        motp=float(distance.mean()) if n_pairs else None,
        rmse=float(np.sqrt(np.mean(distance**2))) if n_pairs else None,
        switches=ledger.switches,
        fragmentations=ledger.fragmentations,
        n_pairs=n_pairs,
        n_missed=n_missed,
        n_false=n_false,
        covered=n_pairs / n_positions if n_positions else None,
        n_found=int(found.sum()),
    )


def _kept(moment: Moment, before: dict[int, int], cutoff: float) -> dict[int, tuple[int, float]]:
    """Return the pairs of the time before that are still close."""
    row_of = {target: row for row, target in enumerate(moment.targets.tolist())}
    column_of = {track: column for column, track in enumerate(moment.tracks.tolist())}
    kept = {}
    for target, track in before.items():
        row, column = row_of.get(target), column_of.get(track)
        if row is not None and column is not None and moment.distance[row, column] < cutoff:
            kept[target] = (track, float(moment.distance[row, column]))
    return kept


def _new(
    moment: Moment, kept: dict[int, tuple[int, float]], cutoff: float, order: float
) -> dict[int, tuple[int, float]]:
    """Return the best pairs of those that have none yet."""
    taken = [track for track, _ in kept.values()]
    rows = np.flatnonzero(~np.isin(moment.targets, list(kept)))
    columns = np.flatnonzero(~np.isin(moment.tracks, taken))
    distance = moment.distance[np.ix_(rows, columns)]
    capped = np.minimum(distance / cutoff, 1.0) ** order
    return {
        int(moment.targets[rows[row]]): (
            int(moment.tracks[columns[column]]),
            distance[row, column],
        )
        for row, column in zip(*linear_sum_assignment(capped), strict=True)
        if distance[row, column] < cutoff
    }
