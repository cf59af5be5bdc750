"""Who follows whom: targets and tracks paired over time as CLEAR MOT does."""

from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from trackweave.arrays import FloatArray, IntArray
from trackweave.metrics._distances import check_cutoff, check_order
from trackweave.metrics.moments import Moment, Moments

__all__ = ["Pairs", "changes", "pair_over_time"]

Pairing = dict[int, tuple[int, float]]


class Pairs(NamedTuple):
    """All pairs of all times, sorted by target, then time: numbers, and distances [m].

    ``turn`` tells how many positions the target had before, from 0: neighbours in turn are
    neighbours in its own life, in which its absence leaves no gap.
    """

    moment: IntArray
    target: IntArray
    track: IntArray
    distance: FloatArray
    turn: IntArray

    def __len__(self) -> int:
        return len(self.moment)


def pair_over_time(moments: Moments, cutoff: float = 50.0, order: float = 2.0) -> Pairs:
    """Return which track follows which target at each time.

    Parameters
    ----------
    moments
        Truth and tracks side by side, of ``align``.
    cutoff
        The greatest distance of a pair [m]. Must be positive.
    order
        The exponent of capped distances by which new pairs are chosen, at least 1.

    Returns
    -------
    All pairs of all times.

    Raises
    ------
    InvalidInputError
        If the cutoff is not positive, or the order is below 1.

    Examples
    --------
    >>> import trackweave as tw
    >>> from trackweave.metrics import align, pair_over_time
    >>> path = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [30.0, 0.0]]
    >>> truth = tw.TruthTable.from_columns(range(4), ["A"] * 4, path)
    >>> broken = tw.TruthTable.from_columns(range(4), ["1", "1", "2", "2"], path)
    >>> pair_over_time(align(truth, broken, None)).track.tolist()
    [0, 0, 1, 1]
    """
    # Bernardin, Stiefelhagen, *Evaluating multiple object tracking performance: the CLEAR MOT
    # metrics*, 2008, section 2.2. doi:10.1155/2008/246309. At each time, pairs of the time before
    # are kept while they are closer than the cutoff; then the remaining targets and tracks are
    # paired at the least total of capped distances to the power of the order.
    check_cutoff(cutoff)
    check_order(order)
    met = np.zeros(moments.n_targets, dtype=np.int64)  # positions so far
    before: Pairing = {}
    rows: list[tuple[int, int, int, float, int]] = []
    for number, moment in enumerate(moments):
        pairs = _kept(moment, before, cutoff)
        pairs |= _new(moment, pairs, cutoff, order)
        rows += [
            (number, target, track, distance, int(met[target]))
            for target, (track, distance) in pairs.items()
        ]
        met[moment.targets] += 1
        before = pairs
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    # Stable: a target's pairs stay in order of time.
    table = table[np.argsort(table[:, 1], kind="stable")]
    whole = table.astype(np.int64)
    return Pairs(whole[:, 0], whole[:, 1], whole[:, 2], table[:, 3], whole[:, 4])


def changes(pairs: Pairs) -> tuple[IntArray, IntArray]:
    """Return the targets of the switches and of the fragmentations, one entry for each."""
    # In a switch a target's track is another than the one that it had last; in a fragmentation it
    # is paired again after it was there unpaired, by whichever track.
    same = np.diff(pairs.target) == 0
    switched = same & (np.diff(pairs.track) != 0)
    resumed = same & (np.diff(pairs.turn) > 1)
    return pairs.target[1:][switched], pairs.target[1:][resumed]


def _kept(moment: Moment, before: Pairing, cutoff: float) -> Pairing:
    """Return the pairs of the time before that are still close."""
    row_of = {target: row for row, target in enumerate(moment.targets.tolist())}
    column_of = {track: column for column, track in enumerate(moment.tracks.tolist())}
    kept = {}
    for target, (track, _) in before.items():
        row, column = row_of.get(target), column_of.get(track)
        if row is not None and column is not None and moment.distance[row, column] < cutoff:
            kept[target] = (track, float(moment.distance[row, column]))
    return kept


def _new(moment: Moment, kept: Pairing, cutoff: float, order: float) -> Pairing:
    """Return the best pairs of those that have none yet."""
    taken = [track for track, _ in kept.values()]
    rows = np.flatnonzero(~np.isin(moment.targets, list(kept)))
    columns = np.flatnonzero(~np.isin(moment.tracks, taken))
    distance = moment.distance[np.ix_(rows, columns)]
    capped = np.minimum(distance / cutoff, 1.0) ** order
    return {
        int(moment.targets[rows[row]]): (
            int(moment.tracks[columns[column]]),
            float(distance[row, column]),
        )
        for row, column in zip(*linear_sum_assignment(capped), strict=True)
        if distance[row, column] < cutoff
    }
