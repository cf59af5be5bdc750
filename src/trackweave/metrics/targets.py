"""Each target's own record: how long it was followed, how well and by whom."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.metrics.moments import Moments, usual_gap
from trackweave.metrics.pairing import Pairs, changes

__all__ = ["MOSTLY_LOST", "MOSTLY_TRACKED", "PARTLY_TRACKED", "TargetRecord", "target_records"]

MOSTLY_TRACKED, PARTLY_TRACKED, MOSTLY_LOST = "mostly tracked", "partly tracked", "mostly lost"
TRACKED_SHARE, LOST_SHARE = 0.8, 0.2


@dataclass(frozen=True, slots=True)
class TargetRecord:
    """How one target was followed.

    ``time_present`` is how long the truth knows where it is [s]: the intervals between its
    positions, but for those in which it was away, longer than 1.5 times the truth's usual
    interval; ``time_tracked`` the part of it in which it was followed at both ends of an interval.
    ``covered`` is the share of its positions that are paired with a track, ``rmse`` the root of
    the mean squared distance of its tracks [m], None where it was never followed. ``completeness``
    is "mostly tracked" from a share of 0.8 up, "mostly lost" below 0.2, else "partly tracked". A
    switch is another track than the one that it had last, a fragmentation an interruption after
    which it is found again. ``tracks`` are in the order in which they first followed it.
    """

    target: str
    first_time: float
    last_time: float
    time_present: float
    time_tracked: float
    positions: int
    tracked_positions: int
    covered: float
    completeness: str
    rmse: float | None
    switches: int
    fragmentations: int
    tracks: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return every entry by its name, ready for JSON."""
        return asdict(self) | {"tracks": list(self.tracks)}


def target_records(moments: Moments, pairs: Pairs) -> tuple[TargetRecord, ...]:
    """Return each target's record, in order of their identifiers as text.

    Parameters
    ----------
    moments
        Truth and tracks side by side, of ``align``.
    pairs
        Who follows whom in them, of ``pair_over_time``.

    Returns
    -------
    A record for each target.

    Examples
    --------
    >>> import trackweave as tw
    >>> from trackweave.metrics import align, pair_over_time, target_records
    >>> path = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [30.0, 0.0]]
    >>> truth = tw.TruthTable.from_columns(range(4), ["A"] * 4, path)
    >>> broken = tw.TruthTable.from_columns(range(4), ["1", "1", "2", "2"], path)
    >>> moments = align(truth, broken, None)
    >>> [(each.target, each.tracks) for each in target_records(moments, pair_over_time(moments))]
    [('A', ('1', '2'))]
    """
    moment = np.repeat(np.arange(len(moments)), np.diff(moments.truth.first))
    order = np.lexsort((moment, moments.truth.identity))
    identity, time = moments.truth.identity[order], moments.time[moment[order]]
    bounds = np.searchsorted(identity, np.arange(moments.n_targets + 1))
    paired = np.zeros(identity.size, dtype=bool)
    paired[bounds[pairs.target] + pairs.turn] = True
    own = np.searchsorted(pairs.target, np.arange(moments.n_targets + 1))
    counts = [np.bincount(which, minlength=moments.n_targets) for which in changes(pairs)]
    longest, records = usual_gap(time, identity), []
    for target, name in enumerate(moments.target_names):
        rows = slice(bounds[target], bounds[target + 1])
        pair = slice(own[target], own[target + 1])
        switches, fragmentations = (int(count[target]) for count in counts)
        life = _life(time[rows], paired[rows], longest, pairs.distance[pair])
        tracks = dict.fromkeys(pairs.track[pair].tolist())
        records.append(
            TargetRecord(
                target=name, **life, switches=switches, fragmentations=fragmentations,
                tracks=tuple(moments.track_names[track] for track in tracks),
            )
        )  # fmt: skip
    return tuple(records)


def _life(
    time: FloatArray, paired: NDArray[np.bool_], longest: float, distance: FloatArray
) -> dict[str, Any]:
    """Return how long, how often and how closely a target was followed."""
    interval = np.diff(time)
    interval[interval > longest] = 0.0
    covered, squared = float(paired.mean()), distance**2
    return {
        "first_time": float(time[0]),
        "last_time": float(time[-1]),
        "time_present": float(interval.sum()),
        "time_tracked": float(interval[paired[1:] & paired[:-1]].sum()),
        "positions": time.size,
        "tracked_positions": int(paired.sum()),
        "covered": covered,
        "completeness": _completeness(covered),
        "rmse": float(np.sqrt(squared.mean())) if squared.size else None,
    }


def _completeness(covered: float) -> str:
    if covered >= TRACKED_SHARE:
        return MOSTLY_TRACKED
    return PARTLY_TRACKED if covered >= LOST_SHARE else MOSTLY_LOST
