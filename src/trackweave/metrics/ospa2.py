"""OSPA of OSPA: how far a set of tracks is from the set of true tracks, identities included."""

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from trackweave.arrays import FloatArray, IntArray
from trackweave.errors import InvalidInputError
from trackweave.metrics._distances import check_cutoff, check_order
from trackweave.metrics.moments import Moment, Moments

__all__ = ["Ospa2", "ospa2"]


@dataclass(frozen=True, slots=True, eq=False)
class Ospa2:
    """OSPA(2) over time, with its parts: total^p = localisation^p + cardinality^p.

    Parameters
    ----------
    time
        End of each window [s], shape (times,).
    total
        The metric [m].
    localisation
        What pairs of a target and a track add [m]: their distance where both are there, the
        cutoff where only one is.
    cardinality
        What targets or tracks too many add [m].
    window
        Number of times in a window.
    """

    time: FloatArray
    total: FloatArray
    localisation: FloatArray
    cardinality: FloatArray
    window: int


def ospa2(moments: Moments, window: int = 10, cutoff: float = 50.0, order: float = 2.0) -> Ospa2:
    """Return the distance of tracks from targets over a sliding window.

    A target and a track are as far from each other as they are on average over those times of
    the window at which either is there: their distance, at most the cutoff, where both are, and
    the cutoff where one is alone. A track that breaks or changes its target therefore costs even
    where every position is right. Between the sets of all that live in the window OSPA is taken
    with this distance.

    Parameters
    ----------
    moments
        Truth and tracks at common times.
    window
        Number of times in a window, which ends at each time in turn; at least 1. Near the
        beginning windows are shorter. 1 gives OSPA.
    cutoff
        Greatest distance, and the price of an object too many or too few [m]; positive.
    order
        Exponent p of a distance between the sets; at least 1.

    Returns
    -------
    The metric and its parts at each time.

    Raises
    ------
    InvalidInputError
        If the window has no time, or cutoff or order are out of range.

    References
    ----------
    .. [1] Beard, Vo, Vo, *OSPA(2): using the OSPA metric to evaluate multi-target tracking
       performance*, ICCAIS 2017, section III. doi:10.1109/ICCAIS.2017.8217598
    """
    check_cutoff(cutoff)
    check_order(order)
    if window < 1:
        raise InvalidInputError(f"window: {window}; expected at least 1 of the truth's times")
    sums, inside = _Sums.nothing(moments), deque[Moment]()
    parts = np.zeros((len(moments), 2))
    for number, moment in enumerate(moments):
        inside.append(moment)
        sums.add(moment, 1, cutoff)
        if len(inside) > window:
            sums.add(inside.popleft(), -1, cutoff)
        parts[number] = _parts(sums.distance(), order)
    localisation, cardinality = cutoff * parts.T ** (1 / order)
    total = cutoff * parts.sum(axis=1) ** (1 / order)
    return Ospa2(moments.time, total, localisation, cardinality, window)


class _Sums(NamedTuple):
    """What the times of a window add up to; distances in units of the cutoff."""

    gap: FloatArray  # of each target and track, where both are there: distance less the cutoff
    both: IntArray
    targets: IntArray
    tracks: IntArray

    @classmethod
    def nothing(cls, moments: Moments) -> "_Sums":
        shape = moments.n_targets, moments.n_tracks
        return cls(
            np.zeros(shape),
            np.zeros(shape, dtype=np.int64),
            np.zeros(shape[0], dtype=np.int64),
            np.zeros(shape[1], dtype=np.int64),
        )

    def add(self, moment: Moment, sign: int, cutoff: float) -> None:
        """Take a time in, or out with the sign -1."""
        cells = np.ix_(moment.targets, moment.tracks)
        self.gap[cells] += sign * np.minimum(moment.distance / cutoff, 1.0)
        self.both[cells] += sign
        self.targets[moment.targets] += sign
        self.tracks[moment.tracks] += sign

    def distance(self) -> FloatArray:
        """Return the mean distance of all that live in the window from each other."""
        targets, tracks = np.flatnonzero(self.targets), np.flatnonzero(self.tracks)
        cells = np.ix_(targets, tracks)
        both = self.both[cells]
        either = self.targets[targets][:, None] + self.tracks[tracks][None, :] - both
        mean: FloatArray = (self.gap[cells] + (either - both)) / either
        # Taking times out leaves rounding errors, which must not leave the range.
        return np.clip(np.where(both > 0, mean, 1.0), 0.0, 1.0)


def _parts(distance: FloatArray, order: float) -> tuple[float, float]:
    """Return what pairs and surplus add to the power of the order."""
    more, fewer = max(distance.shape), min(distance.shape)
    if more == 0:
        return 0.0, 0.0
    raised = distance**order
    paired = float(raised[linear_sum_assignment(raised)].sum())
    return paired / more, (more - fewer) / more
