"""OSPA of OSPA: how far a set of tracks is from the set of true tracks, identities included."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from trackweave.arrays import FloatArray, IntArray
from trackweave.errors import InvalidInputError
from trackweave.metrics._distances import check_cutoff, check_order
from trackweave.metrics.moments import Moments, Presence

__all__ = ["Ospa2", "ospa2"]


@dataclass(frozen=True, slots=True, eq=False)
class Ospa2:
    """OSPA(2) over time, with its parts: total^p = localisation^p + cardinality^p.

    Each is of the window of so many times that ends at ``time`` [s]. Pairs of a target and a track
    add ``localisation`` [m]: their distance where both are there, the cutoff where only one is;
    targets or tracks too many add ``cardinality``.
    """

    time: FloatArray
    total: FloatArray
    localisation: FloatArray
    cardinality: FloatArray
    window: int


def ospa2(moments: Moments, window: int = 10, cutoff: float = 50.0, order: float = 2.0) -> Ospa2:
    """Return the distance of tracks from targets over a sliding window.

    Parameters
    ----------
    moments
        Truth and tracks side by side, of ``align``.
    window
        How many of the truth's times it is long, at least 1.
    cutoff
        The greatest distance of a pair [m], and the price of an object too many or too few.
    order
        The exponent p, at least 1.

    Returns
    -------
    The distance and its parts at each time.

    Raises
    ------
    InvalidInputError
        If the cutoff is not positive, or the window or the order is below 1.

    Examples
    --------
    >>> import trackweave as tw
    >>> from trackweave.metrics import align, ospa2
    >>> path = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [30.0, 0.0]]
    >>> truth = tw.TruthTable.from_columns(range(4), ["A"] * 4, path)
    >>> broken = tw.TruthTable.from_columns(range(4), ["1", "1", "2", "2"], path)
    >>> ospa2(align(truth, broken, None), window=2).total.round(1).tolist()
    [0.0, 0.0, 39.5, 0.0]
    """
    # Beard, Vo, Vo, *OSPA(2): using the OSPA metric to evaluate multi-target tracking
    # performance*, 2017, section III. doi:10.1109/ICCAIS.2017.8217598. A target and a track are as
    # far from each other as they are on average over those times of the window at which either is
    # there: their distance, at most the cutoff, where both are, and the cutoff where one is alone.
    # A track that breaks or changes its target therefore costs even where every position is right.
    # Between the sets of all that live in the window OSPA is taken with this distance. Near the
    # beginning windows are shorter.
    check_cutoff(cutoff)
    check_order(order)
    if window < 1:
        raise InvalidInputError(f"window: {window}; expected at least 1 of the truth's times")
    lives = _Lives.of(moments, cutoff)
    parts = np.zeros((len(moments), 2))
    for end in range(len(moments)):
        begin = max(end + 1 - window, 0)
        parts[end] = _parts(lives.distance(begin, end + 1), order)
    localisation, cardinality = cutoff * parts.T ** (1 / order)
    total = cutoff * parts.sum(axis=1) ** (1 / order)
    return Ospa2(moments.time, total, localisation, cardinality, window)


class _Lives(NamedTuple):
    """Who is there at each time, and who is near whom.

    Rows of what is near are grouped by time, those of time k in ``first[k]:first[k + 1]``.
    """

    targets: NDArray[np.bool_]  # (times, targets)
    tracks: NDArray[np.bool_]
    first: IntArray
    cell: IntArray  # target times the number of tracks, plus track
    nearness: FloatArray  # 1 at no distance, 0 from the cutoff on

    @classmethod
    def of(cls, moments: Moments, cutoff: float) -> "_Lives":
        """Return what the window slides over."""
        cells, nearness, counts = [np.empty(0, dtype=np.int64)], [np.empty(0)], [0]
        for moment in moments:
            row, column = np.nonzero(moment.distance < cutoff)
            cells.append(moment.targets[row] * moments.n_tracks + moment.tracks[column])
            nearness.append(1 - moment.distance[row, column] / cutoff)
            counts.append(row.size)
        return cls(
            _presence(moments.truth, moments.n_targets),
            _presence(moments.tracks, moments.n_tracks),
            np.cumsum(counts),
            np.concatenate(cells),
            np.concatenate(nearness),
        )

    def distance(self, begin: int, end: int) -> FloatArray:
        """Return how far all that live from one time to another are from each other."""
        n_target, n_track = self.targets[begin:end].sum(axis=0), self.tracks[begin:end].sum(axis=0)
        row_of, column_of = np.cumsum(n_target > 0) - 1, np.cumsum(n_track > 0) - 1
        mean = np.ones((np.count_nonzero(n_target), np.count_nonzero(n_track)))
        rows = slice(self.first[begin], self.first[end])
        # Only where two were ever near each other their mean is less than the cutoff.
        cell, place = np.unique(self.cell[rows], return_inverse=True)
        near = np.bincount(place, weights=self.nearness[rows], minlength=cell.size)
        target, track = np.divmod(cell, max(self.tracks.shape[1], 1))
        both = self.targets[begin:end, target] & self.tracks[begin:end, track]
        either = n_target[target] + n_track[track] - both.sum(axis=0)
        mean[row_of[target], column_of[track]] = 1 - near / either
        return mean


def _presence(present: Presence, count: int) -> NDArray[np.bool_]:
    n_times = len(present.first) - 1
    table = np.zeros((n_times, count), dtype=np.bool_)
    table[np.repeat(np.arange(n_times), np.diff(present.first)), present.identity] = True
    return table


def _parts(distance: FloatArray, order: float) -> tuple[float, float]:
    """Return what pairs and surplus add to the power of the order."""
    more, fewer = max(distance.shape), min(distance.shape)
    if more == 0:
        return 0.0, 0.0
    raised = distance**order
    paired = float(raised[linear_sum_assignment(raised)].sum())
    return paired / more, (more - fewer) / more
