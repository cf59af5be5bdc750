"""A first guess of a bias that exceeds the spacing of objects: the pattern that they make.

Two tracks of each sensor that may be the same two objects tell a whole bias: where, how turned
and how late the other picture lies. Guesses that these four tracks do not contradict are tried on
all others; the one that explains most of them beyond chance is taken.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree
from scipy.special import chdtri

from trackweave.arrays import FloatArray, IntArray
from trackweave.fusion.bias import BiasModel
from trackweave.fusion.bias_fit import PLAUSIBLE
from trackweave.fusion.pictures import LocalPicture

__all__ = ["BiasGuess", "guess_bias"]

_SEEDS = 12
_MOST_PAIRINGS = 3_000_000
"""Pairs of pairings that are looked at: fewer seeds where there are more tracks."""
_MOST_FITTED, _MOST_TRIED = 30_000, 200
_REJECTED = 1e-3
_BEYOND_CHANCE = 5.0
"""Evidence that the best guess needs beyond the logarithm of the number of guesses [nats]."""


class BiasGuess(NamedTuple):
    """A bias with its covariance; ``evidence`` says how far beyond chance it is [nats]."""

    bias: FloatArray
    covariance: FloatArray
    evidence: float


class _Fits(NamedTuple):
    """Biases from two pairings each, how badly they fit, and the tracks of the reference."""

    bias: FloatArray
    covariance: FloatArray
    misfit: FloatArray
    seeds: IntArray


def guess_bias(reference: LocalPicture, other: LocalPicture, model: BiasModel) -> BiasGuess | None:
    """Return the bias under which two pictures of one time show most of each other."""
    # None where nothing fits better than chance would have it. Biases are sought up to
    # ``PLAUSIBLE``, or within their priors.
    if min(len(reference), len(other)) < 3:
        return None
    fits = _fitted(reference, other, model, _pairings(reference, other, model))
    dim = reference.dim
    n_equations = 4 * dim - int(model.is_estimated(dim).sum())
    fitting = np.flatnonzero(fits.misfit <= chdtri(max(n_equations, 1), _REJECTED))
    if not fitting.size:
        return None
    fitting = fitting[np.argsort(fits.misfit[fitting], kind="stable")]
    evidence = [_evidence(reference, other, model, fits, row) for row in fitting[:_MOST_TRIED]]
    best = int(np.argmax(evidence))
    beyond = evidence[best] - float(np.log(fitting.size))
    if beyond < _BEYOND_CHANCE:
        return None
    row = fitting[best]
    return BiasGuess(fits.bias[row], fits.covariance[row], beyond)


def _pairings(reference: LocalPicture, other: LocalPicture, model: BiasModel) -> IntArray:
    """Return pairs of pairings that could be two objects: i, j of one, i', j' of the other."""
    dim = reference.dim
    speeds = [np.linalg.norm(p.mean[:, dim:], axis=1) for p in (reference, other)]
    wide = [np.linalg.eigvalsh(p.covariance[:, dim:, dim:])[:, -1] for p in (reference, other)]
    sigma = np.sqrt(wide[0][:, None] + wide[1])
    # Neither shifts, turns nor late clocks change a speed; a range bias hardly does.
    alike = np.abs(speeds[0][:, None] - speeds[1]) <= 4.0 * sigma
    size = {**PLAUSIBLE, **{name: 4.0 * sigma for name, sigma in model.prior.items()}}
    late = size["clock"] if "clock" in model.estimate else 0.0
    slack = 2.0 * size["range"] if "range" in model.estimate else 0.0
    found: list[IntArray] = []
    n_seeds = np.clip(np.sqrt(2.0 * _MOST_PAIRINGS) / len(other), 4, _SEEDS)
    seeds = _spread_out(reference.mean[:, :dim], int(n_seeds))
    for place, i in enumerate(seeds):
        for i2 in seeds[:place]:
            j, j2 = np.nonzero(alike[i][:, None] & alike[i2])
            apart = reference.mean[i] - reference.mean[i2], other.mean[j] - other.mean[j2]
            length = [np.linalg.norm(one[..., :dim], axis=-1) for one in apart]
            # How the two move by each other does not change either, and bounds a late clock.
            passing = [np.linalg.norm(one[..., dim:], axis=-1) for one in apart]
            errors = 4.0 * np.sqrt(sigma[i, j] ** 2 + sigma[i2, j2] ** 2)
            fits = (j != j2) & (np.abs(passing[0] - passing[1]) <= errors)
            bound = late * passing[1] + slack + 4.0 * _position_sigma(reference, other)
            fits &= np.abs(length[0] - length[1]) <= bound
            j, j2 = j[fits], j2[fits]
            order = np.argsort(np.abs(passing[0] - passing[1][fits]) / errors[fits], kind="stable")
            order = order[: _MOST_FITTED // max(1, len(seeds) * (len(seeds) - 1) // 2)]
            seed = np.full(order.shape[0], i), np.full(order.shape[0], i2)
            found.append(np.stack([seed[0], j[order], seed[1], j2[order]], axis=1))
    return np.concatenate([np.empty((0, 4), dtype=np.int64), *found])


def _position_sigma(reference: LocalPicture, other: LocalPicture) -> float:
    dim = reference.dim
    wide = [np.linalg.eigvalsh(p.covariance[:, :dim, :dim])[:, -1] for p in (reference, other)]
    return float(np.sqrt(2.0 * (np.median(wide[0]) + np.median(wide[1]))))


def _spread_out(position: FloatArray, count: int) -> IntArray:
    """Return tracks far from each other, the one farthest from the middle first."""
    away = np.linalg.norm(position - position.mean(axis=0), axis=1)
    chosen = [int(np.argmax(away))]
    nearest = np.full(position.shape[0], np.inf)
    while len(chosen) < min(count, position.shape[0]):
        nearest = np.minimum(nearest, np.linalg.norm(position - position[chosen[-1]], axis=1))
        chosen.append(int(np.argmax(nearest)))
    return np.array(chosen)


def _fitted(
    reference: LocalPicture, other: LocalPicture, model: BiasModel, pairings: IntArray
) -> _Fits:
    """Return the bias that each pair of pairings tells."""
    dim = reference.dim
    n_rows = pairings.shape[0]
    free = model.is_estimated(dim)
    size = {**PLAUSIBLE, **model.prior}
    prior = np.diag(1.0 / model.each(size, dim, 1.0)[free] ** 2)
    bias = np.zeros((n_rows, free.shape[0]))
    covariance = np.zeros((n_rows, free.shape[0], free.shape[0]))
    misfit = np.zeros(n_rows)
    for _ in range(4):
        normal, pull = np.tile(prior, (n_rows, 1, 1)), bias[:, free] @ prior
        misfit = np.einsum("ri,ij,rj->r", bias[:, free], prior, bias[:, free])
        for side in (0, 2):
            mine, yours = pairings[:, side], pairings[:, side + 1]
            moved = model.gradient(other.mean[yours], bias)
            error = moved.mean - reference.mean[mine]
            weight = np.linalg.inv(reference.covariance[mine] + other.covariance[yours])
            slope = moved.by_bias[:, :, free]
            normal += slope.swapaxes(1, 2) @ weight @ slope
            pull += np.einsum("rki,rkl,rl->ri", slope, weight, error)
            misfit += np.einsum("ri,rij,rj->r", error, weight, error)
        inverse = np.linalg.inv(normal)
        bias[:, free] -= np.einsum("rij,rj->ri", inverse, pull)
    covariance[np.ix_(np.arange(n_rows), np.flatnonzero(free), np.flatnonzero(free))] = inverse
    return _Fits(bias, covariance, misfit, pairings[:, [0, 2]])


def _evidence(
    reference: LocalPicture, other: LocalPicture, model: BiasModel, fits: _Fits, row: int
) -> float:
    """Return how much better than chance a guess explains the tracks that it was not made from."""
    moved = model.gradient(other.mean, fits.bias[row])
    spread = moved.by_state @ other.covariance @ moved.by_state.swapaxes(1, 2)
    spread += moved.by_bias @ fits.covariance[row] @ moved.by_bias.swapaxes(1, 2)
    # Nearest by the usual errors; then exactly.
    unit = np.sqrt(np.median(np.diagonal(spread, axis1=1, axis2=2), axis=0))
    rest = np.setdiff1d(np.arange(len(reference)), fits.seeds[row])
    nearest = KDTree(moved.mean / unit).query(reference.mean[rest] / unit)[1]
    total = reference.covariance[rest] + spread[nearest]
    apart = moved.mean[nearest] - reference.mean[rest]
    squared = np.einsum("ri,ri->r", apart, np.linalg.solve(total, apart[:, :, None])[:, :, 0])
    density = -0.5 * (squared + np.linalg.slogdet(2.0 * np.pi * total)[1])
    extent = np.ptp(other.mean, axis=0) + unit
    chance = np.log(len(other)) - np.log(extent).sum()
    gain = np.maximum(density - chance, 0.0)
    # One track of the other sensor explains one of the reference.
    best = np.zeros(len(other))
    np.maximum.at(best, nearest, gain)
    return float(best.sum())
