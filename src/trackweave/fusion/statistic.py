"""Whether tracks of several sensors are of one object: the statistic and its threshold."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from scipy.special import chdtri

from trackweave.arrays import FloatArray, float_array
from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.fusion._statistic import (
    ALL_PAIRS,
    CHAIN,
    FUSED_MEAN,
    Form,
    Rings,
    evaluate_all,
)
from trackweave.keys import COUNT, POSITIVE, PROBABILITY, Key

__all__ = ["Statistic", "TupleValues", "quantiles", "tuple_values"]

KINDS = {"chain": CHAIN, "all-pairs": ALL_PAIRS, "fused-mean": FUSED_MEAN}
FADED = 1e-3
"""Weight below which a fading memory forgets a time."""


@dataclass(frozen=True, slots=True)
class Statistic:
    """How far apart the tracks of a tuple are over time, and how far they may be.

    Parameters
    ----------
    kind
        Distances of neighbouring sensors, of all pairs, or to the fused mean.

        They are squared; "chain" goes by the order of sensors [1]_.
    memory
        All times count, the last ``length``, or each ``factor`` times as much as the next.

        "full" [1]_ takes memory and time that grow with the run.
    length
        How many times a sliding memory holds.
    factor
        What a fading memory keeps from time to time.
    false_rejection
        Probability of rejecting tracks of one object.
    correlation
        What to do about correlated errors.

        "none": nothing [1]_. "inflated": take each
        covariance ``inflation`` times. "effective": reckon with correlation in time, which makes
        the statistic vary more: fewer degrees of freedom, each worth more. "cross-covariance":
        take off each covariance what the common process noise put into all sensors' errors.
        "both": the last two.
    inflation
        Factor on the covariances, for ``correlation = "inflated"``.

    Raises
    ------
    InvalidInputError
        If a name is unknown or a number is out of range.

    Notes
    -----
    The correlations are reckoned from what the tracks' covariances tell of their filters' gains,
    P⁺ (P⁻)⁻¹ = I − K H, and from the process noise. For tracks that filters keep, "both" rejects
    about as often as asked for; with "none" the same tracks are rejected too often while young,
    and hardly ever later. Errors that are independent from time to time need none.

    References
    ----------
    .. [1] Huo, Zhang, Bai, Song, Xiong, 2008, eqs. (6), (7) and (9).

    Examples
    --------
    >>> import trackweave as tw
    >>> statistic = tw.Statistic(kind="fused-mean", memory="fading", factor=0.5)
    >>> statistic.weights(3)  # from the oldest time to the newest
    array([0.25, 0.5 , 1.  ])
    """

    kind: Annotated[Literal["chain", "all-pairs", "fused-mean"], Key()] = "fused-mean"
    memory: Annotated[Literal["full", "sliding", "fading"], Key()] = "sliding"
    length: Annotated[int, COUNT] = 5
    factor: Annotated[float, PROBABILITY] = 0.7
    false_rejection: Annotated[float, PROBABILITY] = 0.01
    correlation: Annotated[
        Literal["none", "inflated", "effective", "cross-covariance", "both"], Key()
    ] = "none"
    inflation: Annotated[float, POSITIVE] = 1.5

    def __post_init__(self) -> None:
        settle(self)

    @property
    def n_slots(self) -> int | None:
        """How many times it remembers at most; None for all."""
        if self.memory == "full":
            return None
        if self.memory == "sliding":
            return self.length
        return math.ceil(math.log(FADED) / math.log(self.factor))

    @property
    def scale(self) -> float:
        """Factor on all covariances."""
        return self.inflation if self.correlation == "inflated" else 1.0

    @property
    def takes_off_common(self) -> bool:
        """Whether common process noise is taken off the covariances."""
        return self.correlation in {"cross-covariance", "both"}

    def weights(self, n_slots: int) -> FloatArray:
        """Return what each of so many slots weighs, from the oldest to the newest."""
        if self.memory == "fading":
            return np.asarray(self.factor ** np.arange(n_slots - 1, -1, -1), dtype=np.float64)
        return np.ones(n_slots)

    def form(self, slot: np.ndarray, size: int, false_rejection: float | None = None) -> Form:
        """Return what kernels need to know.

        Parameters
        ----------
        slot
            The slots that count, from the oldest to the newest.
        size
            Most degrees of freedom that a tuple can have.
        false_rejection
            Another rate than the statistic's own; None for that.

        Returns
        -------
        The form.
        """
        rate = self.false_rejection if false_rejection is None else false_rejection
        return Form(
            KINDS[self.kind],
            np.asarray(slot, dtype=np.int64),
            self.weights(len(slot)),
            self.correlation in {"effective", "both"},
            quantiles(rate, 2 ** math.ceil(math.log2(max(size, 64)))),
        )


@dataclass(frozen=True, slots=True, eq=False)
class TupleValues:
    """Statistics λ of tuples, and what tuples of one object exceed at the false-rejection rate."""

    value: FloatArray
    threshold: FloatArray


@lru_cache(maxsize=32)
def quantiles(false_rejection: float, size: int) -> FloatArray:
    """Return what χ² exceeds so rarely, for 0, ¼, ½, … up to ``size`` degrees of freedom."""
    freedom = np.arange(4 * size + 1) / 4.0
    values = np.zeros(freedom.shape[0])
    values[1:] = chdtri(freedom[1:], false_rejection)
    return values


def tuple_values(mean: FloatArray, covariance: FloatArray, statistic: Statistic) -> TupleValues:
    """Return the statistics of tuples of tracks whose estimates are all known."""
    # Errors are taken to be independent from time to time; reckoning with their correlation takes
    # the process noise, as in ``TrackAssociator``. Estimates have the shape (tuples, times,
    # members, n).
    means = float_array(mean, "mean", (None,) * 4)
    spreads = float_array(covariance, "covariance", (*means.shape, means.shape[-1]))
    if statistic.correlation not in {"none", "inflated"}:
        raise InvalidInputError(
            f"correlation: {statistic.correlation!r}; expected 'none' or 'inflated' here"
        )
    n_tuples, n_times, n_members, n = means.shape
    most = statistic.n_slots
    slot = np.arange(0 if most is None else max(0, n_times - most), n_times)
    spread = statistic.scale * spreads.swapaxes(1, 2).reshape(-1, n_times, n, n)
    rows = n_tuples * n_members
    rings = Rings(
        np.ascontiguousarray(means.swapaxes(1, 2).reshape(rows, n_times, n)),
        np.ascontiguousarray(spread),
        np.ascontiguousarray(np.linalg.inv(spread)),
        np.ones((rows, n_times), dtype=np.bool_),
        np.zeros((rows, n_times)),
        np.ascontiguousarray(spread),
    )
    value, limit = np.empty((2, n_tuples))
    members = np.arange(rows).reshape(n_tuples, n_members)
    form = statistic.form(slot, n * len(slot) * n_members**2)
    evaluate_all(rings, form, members, value, limit)
    return TupleValues(value, limit)
