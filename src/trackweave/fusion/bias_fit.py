"""The bias that explains the differences between two sensors' tracks of the same objects."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.special import chdtri

from trackweave.arrays import FloatArray, IntArray
from trackweave.errors import InvalidInputError
from trackweave.fusion.bias import UNITS, BiasModel
from trackweave.fusion.learning import Learned

__all__ = ["PLAUSIBLE", "BiasFit", "Differences", "NotObservableError", "differences", "fit_bias"]

PLAUSIBLE = {"translation": 1e4, "rotation": 0.2, "range": 1e3, "azimuth": 0.2, "clock": 10.0}
"""How great biases may be at most [m, rad, s]. Data that leave one, or a mixture of them, as
uncertain as that say nothing of it."""
_HIDDEN = 0.2
"""Share of the information about a bias that may come from the tracks' own errors: tracks whose
velocities differ by their errors only say nothing of a clock, however many they are."""
_BEGINNING = 10.0
"""How many times the variance of a track's velocity may exceed its least, to tell of a clock."""
_HUBER, _TRIM, _PAIR_TRIM = 0.01, 1e-4, 1e-4
"""Probability that a right difference is given less weight, is left out, is left out with all
others of its pair."""
_PAIR_MARGIN = 1.5
_STEPS = 25
_SETTLED = 1e-3
"""The search ends where no bias moves by more than this part of its own sigma."""
_TYPICAL = 20.0
"""Numbers for which the covariances' word is taken before it is measured how right they are."""
_LAGS = 20


class NotObservableError(InvalidInputError):
    """The tracks do not tell a bias, or one bias from another; the message says which.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> state = [[100.0, 50.0, 10.0, 0.0]]  # x, y [m], vx, vy [m/s]
    >>> spread = np.diag([25.0, 25.0, 1.0, 1.0])[None]
    >>> still = {
    ...     name: [tw.LocalPicture(name, t, [1], state, spread) for t in (0.0, 1.0)]
    ...     for name in "AB"
    ... }
    >>> tw.register(still["A"], still["B"], process_noise=0.1, pairs=[[1, 1]])
    Traceback (most recent call last):
        ...
    trackweave.fusion.bias_fit.NotObservableError: registration: clock cannot be told: ...
    """


class Differences(NamedTuple):
    """What pairs of tracks learned at the same times, one row for each pair and time.

    ``pair`` is the place of the pair, ``trust`` the probability that it is one object.
    """

    pair: IntArray
    trust: FloatArray
    reference: FloatArray
    reference_information: FloatArray
    before: FloatArray
    spread: FloatArray
    other: FloatArray
    other_information: FloatArray


class BiasFit(NamedTuple):
    """A bias, its covariance, and what it rests on.

    ``used`` is the share of each pair's differences that count, ``scale`` the factor on the
    covariance that the differences turned out to need.
    """

    bias: FloatArray
    covariance: FloatArray
    used: FloatArray
    scale: float


class _Weighed(NamedTuple):
    """Differences at a bias: whitened errors and gradients, and how many numbers each has."""

    error: FloatArray
    gradient: FloatArray
    rank: IntArray
    weight: FloatArray

    @property
    def squared(self) -> FloatArray:
        return np.asarray(np.einsum("ri,ri->r", self.error, self.error))


def differences(
    reference: Learned, other: Learned, pairs: IntArray, trust: FloatArray
) -> Differences:
    """Return what pairs of tracks learned at the times at which both are there, pair by pair."""
    places: list[IntArray] = []
    for place, (first, second) in enumerate(pairs):
        mine, yours = (
            np.flatnonzero(table.track == number)
            for table, number in ((reference, first), (other, second))
        )
        _, at_mine, at_yours = np.intersect1d(
            reference.picture[mine], other.picture[yours], return_indices=True
        )
        rows = np.full(at_mine.shape[0], place)
        places.append(np.stack([rows, mine[at_mine], yours[at_yours]]))
    pair, mine, yours = np.concatenate([np.empty((3, 0), dtype=np.int64), *places], axis=1)
    return Differences(
        pair, trust[pair],
        reference.mean[mine], reference.information[mine],
        other.before[yours], other.spread[yours], other.mean[yours], other.information[yours],
    )  # fmt: skip


def fit_bias(rows: Differences, model: BiasModel, start: FloatArray, *, check: bool) -> BiasFit:
    """Return the bias that explains the differences best, with its covariance."""
    # Gauss-Newton steps on Huber's function first, which wrong pairs pull little; then least
    # squares over the differences, and pairs, that the result does not contradict. What cannot be
    # told is refused where ``check`` asks for it; otherwise it stays as uncertain as
    # ``PLAUSIBLE``.
    dim = rows.reference.shape[1] // 2
    free = model.is_estimated(dim)
    prior = np.diag(1.0 / model.each(model.prior, dim, np.inf)[free] ** 2)
    weak = np.diag(1.0 / model.each(PLAUSIBLE, dim, 1.0)[free] ** 2)
    if "clock" in model.estimate:
        rows = rows._replace(trust=rows.trust * _has_velocity(rows))
    bias = start.copy()
    for kept in (_huber, _trimmed):
        for _ in range(_STEPS):
            weighed = _weighed(rows, model, bias)
            normal, pull = _normal(weighed, kept(rows, weighed))
            # Damped where the differences say nothing; what is the best is left as it is.
            step = np.linalg.solve(normal + prior + weak, -pull - prior @ bias[free])
            bias[free] += step
            if np.all(np.abs(step) <= _SETTLED / np.sqrt(np.diagonal(normal + weak))):
                break
    weighed = _weighed(rows, model, bias)
    share = _trimmed(rows, weighed)
    normal = _normal(weighed, share)[0]
    if check:
        _require_observable(normal + prior, rows, weighed, share, model)
    scale = _scale(rows, weighed, share, int(free.sum()))
    covariance = np.zeros((free.shape[0], free.shape[0]))
    known = normal / scale + prior + (0.0 if check else 1.0) * weak
    covariance[np.ix_(free, free)] = np.linalg.inv(known)
    n_pairs = int(rows.pair.max(initial=-1)) + 1
    counted = np.bincount(rows.pair, minlength=n_pairs)
    used = np.bincount(rows.pair, weights=share > 0.0, minlength=n_pairs)
    return BiasFit(bias, covariance, used / np.maximum(counted, 1), scale)


def _has_velocity(rows: Differences) -> NDArray[np.bool_]:
    """Tell where the other sensor's track knows its velocity about as well as it ever does."""
    # A track that has just begun would show a clock offset of none, whatever it is.
    dim = rows.reference.shape[1] // 2
    unknown = np.trace(rows.spread[:, dim:, dim:], axis1=1, axis2=2)
    best = np.full(int(rows.pair.max(initial=-1)) + 1, np.inf)
    np.minimum.at(best, rows.pair, unknown)
    return np.asarray(unknown <= _BEGINNING * best[rows.pair])


def _weighed(rows: Differences, model: BiasModel, bias: FloatArray) -> _Weighed:
    """Return the differences left by a bias, in units of their own errors."""
    dim = rows.reference.shape[1] // 2
    free = model.is_estimated(dim)
    moved = model.gradient(rows.before, bias)
    # The velocity that a clock offset is multiplied by is the one foreseen, which makes the late
    # position less certain: by what was learned alone it would be compared with nothing.
    turn = moved.by_state.copy()
    turn[:, :dim, dim:] = 0.0
    error = moved.mean - rows.reference
    error += np.einsum("rij,rj->ri", turn, rows.other - rows.before)
    back = np.linalg.inv(turn)
    other = back.swapaxes(1, 2) @ rows.other_information @ back
    late = np.zeros_like(other)
    late[:, :dim, :dim] = bias[-1] ** 2 * rows.spread[:, dim:, dim:]
    other = np.linalg.solve(np.eye(2 * dim) + other @ late, other)
    # The weight is Y₁ (Y₁ + Y₂)⁺ Y₂, the inverse of the sum of the covariances where these exist,
    # and nothing along directions in which either track learned nothing.
    total = rows.reference_information + other
    # In units of what was known before, beside which rounding is nothing.
    unit = 1.0 / np.sqrt(np.diagonal(rows.spread, axis1=1, axis2=2))
    scaling = unit[:, :, None] * unit[:, None, :]
    inverse = np.linalg.pinv(total / scaling, rcond=1e-9, hermitian=True)
    weight = rows.reference_information / scaling @ inverse @ (other / scaling)
    value, vector = np.linalg.eigh((weight + weight.swapaxes(1, 2)) / 2.0)
    is_known = value > 1e-6
    root = np.sqrt(np.where(is_known, value, 0.0))
    # The symmetric root, so that errors of successive times can be set beside each other.
    root = np.einsum("rik,rk,rjk->rij", vector, root, vector) * unit[:, None, :]
    return _Weighed(
        np.einsum("rij,rj->ri", root, error),
        root @ moved.by_bias[:, :, free],
        is_known.sum(axis=1),
        root.swapaxes(1, 2) @ root,
    )


def _normal(weighed: _Weighed, share: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the matrix and the vector of the normal equations."""
    matrix = np.einsum("r,rki,rkj->ij", share, weighed.gradient, weighed.gradient)
    return matrix, np.einsum("r,rki,rk->i", share, weighed.gradient, weighed.error)


def _spread_factor(rows: Differences, weighed: _Weighed) -> float:
    """Return how much greater the middle squared difference is than expected, at least 1."""
    some = weighed.rank > 0
    if not some.any():
        return 1.0
    ratio = weighed.squared[some] / chdtri(weighed.rank[some], 0.5)
    order = np.argsort(ratio)
    # The middle by trust, so that unlikely pairs do not move it.
    below = np.cumsum(rows.trust[some][order])
    return max(1.0, float(ratio[order[np.searchsorted(below, 0.5 * below[-1])]]))


def _huber(rows: Differences, weighed: _Weighed) -> FloatArray:
    """Return the differences' shares by Huber's function."""
    bound = np.sqrt(chdtri(np.maximum(weighed.rank, 1), _HUBER))
    length = np.sqrt(np.maximum(weighed.squared, 1e-300))
    return np.asarray(rows.trust * np.minimum(1.0, bound / length))


def _trimmed(rows: Differences, weighed: _Weighed) -> FloatArray:
    """Return the differences' shares without those, and those pairs, that contradict the bias."""
    factor = _spread_factor(rows, weighed)
    squared, rank = weighed.squared, weighed.rank
    fits = squared <= factor * chdtri(np.maximum(rank, 1), _TRIM)
    sums = np.bincount(rows.pair, weights=squared)
    numbers = np.bincount(rows.pair, weights=rank)
    most = _PAIR_MARGIN * factor * chdtri(np.maximum(numbers, 1), _PAIR_TRIM)
    return np.asarray(rows.trust * (fits & (sums <= most)[rows.pair]))


def _scale(rows: Differences, weighed: _Weighed, share: FloatArray, n_biases: int) -> float:
    """Return by how much the differences vary more than their covariances and independence say."""
    is_used = share > 0.0
    error, pair, rank = weighed.error[is_used], rows.pair[is_used], weighed.rank[is_used]
    squared = np.einsum("ri,ri->r", error, error)
    n_numbers = float(rank.sum())
    expected = max(float(share[is_used] @ rank) - n_biases, 0.0)
    level = (_TYPICAL + share[is_used] @ squared) / (_TYPICAL + expected)
    repeated = 1.0
    for lag in range(1, min(_LAGS, error.shape[0] - 1) + 1):
        same = pair[lag:] == pair[:-lag]
        together = np.einsum("ri,ri->r", error[lag:], error[:-lag])[same].sum()
        correlation = together / max(squared.sum(), 1e-300)
        if correlation < 2.0 / np.sqrt(max(n_numbers, 1.0)):
            break
        repeated += 2.0 * correlation
    return float(level * repeated)


def _require_observable(
    normal: FloatArray,
    rows: Differences,
    weighed: _Weighed,
    share: FloatArray,
    model: BiasModel,
) -> None:
    """Refuse biases that the differences do not tell, saying which are entangled."""
    dim = rows.reference.shape[1] // 2
    free = model.is_estimated(dim)
    size = model.each(PLAUSIBLE, dim, 1.0)[free]
    names = [name for name, is_free in zip(model.names(dim), free, strict=True) if is_free]
    scaled = normal * size[:, None] * size
    value, vector = np.linalg.eigh(scaled)
    if value[0] < 1.0:
        raise _refusal(names, size, vector[:, 0], is_hidden=False)
    # What the tracks' own errors alone would seem to tell of a clock and of a turn.
    velocity = np.einsum("rij,rji->r", weighed.weight[:, :dim, :dim], rows.spread[:, dim:, dim:])
    state = np.einsum("rij,rji->r", weighed.weight, rows.spread)
    feigned = {"clock": velocity, "rotation": state, "azimuth": state}
    noise = np.array([share @ feigned[name] if name in feigned else 0.0 for name in names])
    value, vector = eigh(np.diag(noise * size**2), scaled)
    if value[-1] > _HIDDEN:
        raise _refusal(names, size, vector[:, -1], is_hidden=True)


def _refusal(
    names: list[str], size: FloatArray, direction: NDArray[np.float64], *, is_hidden: bool
) -> NotObservableError:
    """Return the error that says what the tracks do not tell."""
    matters = np.abs(direction) > 0.05 * np.abs(direction).max()
    entangled = [name for name, is_in in zip(names, matters, strict=True) if is_in]
    why = (
        "the tracks differ too little beside their own errors"
        if is_hidden
        else "the tracks leave it as uncertain as it was"
    )
    if len(entangled) == 1:
        what = f"{entangled[0]} cannot be told: {why}"
    else:
        parts = direction * size / np.abs(direction[matters]).max()
        mixture = ", ".join(
            f"{names[k]} {parts[k]:+.4g} {UNITS[names[k].partition('_')[0]]}"
            for k in np.flatnonzero(matters)
        )
        what = (
            f"{', '.join(entangled)} cannot be told apart ({mixture} together make no "
            f"difference): {why}"
        )
    return NotObservableError(
        f"registration: {what}; expected tracks in other places and of other velocities, a prior "
        "for one of these, or one fewer to estimate"
    )
