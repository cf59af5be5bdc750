"""Measurement noise and process noise by maximum likelihood on sure tracks."""

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.chi_squared import quantile_of
from trackweave.estimation._noise import WRONG, follow_chains
from trackweave.estimation.neighbours import expected_of, noise_beside_curves, noises_of_chains
from trackweave.estimation.simplex import least_by_simplex

__all__ = [
    "LONGEST_CHAIN",
    "MOST_CHAINS",
    "arrays_of",
    "calm_noise",
    "least_noise",
    "noise_in_turns",
    "noise_of_chains",
    "noise_of_longer_steps",
    "scales_of",
]

MOST_CHAINS, LONGEST_CHAIN = 80, 60
"""So many chains tell of noise, and so many reports of each."""
SAME_TIME = 1e-6
# How far the search may go from where it starts, as logarithms of factors.
FURTHEST = 12.0
# Where it starts: of a noise that is next to none, what objects do by themselves is far more.
STARTS = (-6.0, -2.0, 2.0, 6.0, 10.0)
# Noise is no less than this part of an object's usual step. Reports of a simulation may have none
# at all; a filter that believes so loses objects at the first digit that was rounded.
LEAST_OF_STEP = 1e-3
# Of reports, so many may be further off than one in a hundred should be.
FAR_SHARE = 0.014
MOST_DOUBLINGS, MOST_DOUBLINGS_IN_TURNS = 10, 20
# Noise is hidden in motion where its variance is less than this part of that beside curves.
HIDDEN = 0.25
# Of a chain whose reports are noisier than most, as far from a radar, noise is so many times the
# usual at most.
NOISIER = 2.2
# So many doublings leave half of them at most, but for so many standard deviations of a count.
TRIAL, BY_CHANCE = 3, 2.0
# A chain is lost where more reports seem to come from elsewhere than so many, and than this share
# of it; such a share of all chains may be two objects in one.
LOST_REPORTS, LOST_PART, LOST_CHAINS = 3.0, 0.1, 0.05
# Every so many-th report of a chain is looked at, where it has so many then.
STRIDE, FEWEST_IN_CHAIN, FEWEST_IN_ALL = 4, 6, 60
# What objects do by themselves does not come to so much less over longer steps.
CALMER = 4.0
# Noise that seemed to be motion would come to so much less, but for some motion beside it.
FAR_CALMER = STRIDE**3 / 4.0
# Noise grows no more than this to such steps, and no more than that to steps twice as long.
WIDER, LONGER = 1.7, 1.5


class _Chains(NamedTuple):
    """Chains that are long enough, without their gaps; NaN behind their ends."""

    step: FloatArray  # Time from report to report [s], shape (chains, reports − 1)
    places: FloatArray
    scale: FloatArray  # How many times the usual noise each report has, shape (chains, reports)


def arrays_of(
    chains: Iterable[tuple[FloatArray, FloatArray]],
) -> tuple[FloatArray, FloatArray]:
    """Return the longest chains' times and places as arrays of one row each, padded with NaN."""
    # Of each chain its times, of shape (reports,), and places, of shape (reports, dim); arrays
    # have the shapes (chains, reports) and (chains, reports, dim).
    longest = sorted(chains, key=lambda chain: chain[0].size, reverse=True)[:MOST_CHAINS]
    length = min(longest[0][0].size, LONGEST_CHAIN)
    time = np.full((len(longest), length), np.nan)
    place = np.full((len(longest), length, longest[0][1].shape[1]), np.nan)
    for row, (times, places) in enumerate(longest):
        # Two reports of one moment would tell of endless speed.
        kept = np.flatnonzero(np.diff(times[:length], prepend=-np.inf) > SAME_TIME)
        time[row, : kept.size], place[row, : kept.size] = times[kept], places[kept]
    return time, place


def scales_of(chains: Iterable[tuple[FloatArray, FloatArray]]) -> FloatArray:
    """Return how many times the usual noise each report has, as ``arrays_of`` lays chains out."""
    # Of each chain its times and the noise of its reports along each axis [m], shape (reports,
    # dim); those with NaN have the usual one.
    told = [(time, np.sqrt(np.mean(noise**2, axis=1, keepdims=True))) for time, noise in chains]
    known = np.log(np.concatenate([level for _, level in told]))
    usual = np.exp(np.nanmean(known)) if np.isfinite(known).any() else 1.0
    scale = arrays_of((time, np.nan_to_num(level / usual, nan=1.0)) for time, level in told)[1]
    return np.asarray(scale[..., 0])


def noise_of_chains(  # noqa: PLR0913 what is known of the chains, and how to take it
    time: FloatArray,
    position: FloatArray,
    sigma: float,
    density: float,
    *,
    fixed: bool = False,
    follows_turns: bool = True,
    scale: FloatArray | None = None,
) -> tuple[float, float]:
    """Return the noise under which a Kalman filter finds chains of reports least surprising."""
    # It is sigma along an axis [m] and the process noise [m²/s³]; it starts from ``sigma``, above
    # 0, which stays if it is fixed. Times have the shape (chains, scans), positions (chains,
    # scans, dim), NaN where there was none. The density is that of reports that came from
    # elsewhere, per unit of volume and scan. The process noise grows until sharp turns are
    # followed; not where some of what is far off is of other objects. ``scale`` is how many times
    # the noise each report has, of the shape of the times; None for once.
    chains = _gathered(time, position, scale)
    if chains.step.size == 0:
        return sigma, 0.0
    least = least_noise(position)
    sigma, process = _fitted(chains, sigma, density, fixed=fixed)
    if sigma < least and not fixed:
        sigma, process = _fitted(chains, least, density, fixed=True)
    if follows_turns:
        process = _grown(chains, (sigma**2, process, density))
    return sigma, process


def least_noise(position: FloatArray) -> float:
    """Return the least noise that reports along chains are believed to have [m]; 0 for any."""
    # A chain of shape (scans, dim), NaN where there was no report, in each row.
    steps = np.linalg.norm(np.diff(position, axis=1), axis=2)
    steps = steps[np.isfinite(steps)]
    return LEAST_OF_STEP * float(np.median(steps)) if steps.size else 0.0


def noise_in_turns(
    time: FloatArray,
    position: FloatArray,
    noise: tuple[float, float],
    density: float,
    scale: FloatArray | None = None,
) -> float:
    """Return the process noise with which a filter loses hardly any chain in a turn [m²/s³]."""
    # The chains are of tracks beyond doubt, as in ``noise_of_chains``; it starts from a noise
    # above 0.
    sigma, process = noise
    chains = _gathered(time, position, scale)
    # What is noisier all along is no turn, however far off it seems by the noise of most; beside
    # the curve through their neighbours reports of a turn are no farther off than others.
    own = noises_of_chains(_times(chains), chains.places)
    own /= np.sqrt(np.nanmean(chains.scale**2, axis=1))
    most = float(np.nanmedian(own)) if np.isfinite(own).any() else np.inf
    ratio = np.nan_to_num(own) / max(most, 1e-300)
    variances = (sigma * np.clip(ratio, 1.0, NOISIER)) ** 2
    for _ in range(MOST_DOUBLINGS_IN_TURNS):
        if _all_followed(chains, (variances, process, density)):
            return process
        process *= 2
    # What no process noise mends is no turn.
    return noise[1]


def calm_noise(
    time: FloatArray,
    position: FloatArray,
    sigma: float,
    density: float,
    scale: FloatArray | None = None,
) -> tuple[float, float] | None:
    """Return the noise of chains whose errors wander, as seen over several scans."""
    # Errors that are alike from scan to scan, as of boxes around people whose legs swing, look
    # like accelerations from one scan to the next. Over longer steps they are noise, and the
    # process noise is less; that of real accelerations is not. Manoeuvres to and fro average out
    # as well, but then the noise grows with each longer step, whereas that of wandering errors
    # soon stays. It is None where longer steps tell nothing else.
    scale = np.ones(time.shape) if scale is None else scale
    chains = _gathered(time, position, scale)
    if chains.step.size == 0:
        return None
    first = _fitted(chains, sigma, density)
    thinned = _thinned((time, position, scale), STRIDE)
    if thinned is None:
        return None
    found = _fitted(thinned, first[0], density)
    is_calmer = found[1] * CALMER < first[1] and first[0] < found[0] < WIDER * first[0]
    longer = _thinned((time, position, scale), 2 * STRIDE)
    # Where errors wander, what hardly moves by itself is followed; where objects turn, it is lost.
    variances = np.full(len(chains.step), found[0] ** 2)
    if not is_calmer or not _all_followed(chains, (variances, found[1], density)):
        return None
    if longer is None:
        return found
    # Noise of errors soon forgotten stays what it is; turns to and fro go on growing.
    last = _fitted(longer, found[0], density)
    return found if last[0] < LONGER * found[0] else None


def noise_of_longer_steps(
    chains: tuple[FloatArray, FloatArray, FloatArray],
    noise: tuple[float, float],
    density: float,
    *,
    fixed: bool = False,
) -> tuple[float, float]:
    """Return sigma and process noise over longer steps where these are of far calmer objects."""
    # Of reports whose errors have wide tails, and of chains that change from one object to
    # another, what seems to be acceleration falls with the cube of the step; that of an object
    # does not. Sigma stays that of all steps. ``noise`` is that; the rest as ``noise_of_chains``.
    # Of ``chains`` there are times, positions and scales.
    thinned = _thinned(chains, STRIDE)
    if thinned is None:
        return noise
    sigma, process = _fitted(thinned, noise[0], density, fixed=fixed)
    if process * FAR_CALMER >= noise[1]:
        return noise
    if not fixed:
        return (noise[0], process) if sigma < WIDER * noise[0] else noise
    # Noise that is kept out, and seems to be motion, leaves little motion where it is let in. Who
    # circles moves all the same, though longer steps bring it back to where it was.
    motion = _fitted(_gathered(*chains), noise[0], density)[1]
    return (noise[0], process) if motion * CALMER < noise[1] else noise


def _thinned(chains: tuple[FloatArray, FloatArray, FloatArray], stride: int) -> _Chains | None:
    """Return every so many-th report of chains, from each start; None where these are few."""
    # Of the chains times, positions and scales.
    width = chains[0].shape[1] // stride
    time, position, scale = (
        np.concatenate([each[:, start::stride][:, :width] for start in range(stride)])
        for each in chains
    )
    count = np.isfinite(time).sum(axis=1)
    kept = count >= FEWEST_IN_CHAIN
    if count[kept].sum() < FEWEST_IN_ALL:
        return None
    return _gathered(time[kept], position[kept], scale[kept])


def _gathered(time: FloatArray, position: FloatArray, scale: FloatArray | None) -> _Chains:
    """Return the chains that are long enough, without their gaps."""
    scale = np.ones(time.shape) if scale is None else scale
    chains = [
        (t[rows], p[rows], s[rows])
        for t, p, s in zip(time, position, scale, strict=True)
        if (rows := np.flatnonzero(np.isfinite(p[:, 0]))).size >= 4
    ]
    length = max((t.size for t, _, _ in chains), default=1)
    times, scales = np.full((2, len(chains), length), np.nan)
    places = np.full((len(chains), length, position.shape[2]), np.nan)
    for row, (t, p, s) in enumerate(chains):
        times[row, : t.size], places[row, : t.size], scales[row, : t.size] = t, p, s
    return _Chains(np.diff(times, axis=1), places, scales)


def _times(chains: _Chains) -> FloatArray:
    """Return the times of reports since the first of their chain [s]."""
    begin = np.zeros((len(chains.step), 1))
    return np.concatenate([begin, np.cumsum(chains.step, axis=1)], axis=1)


def _fitted(
    chains: _Chains, sigma: float, density: float, *, fixed: bool = False
) -> tuple[float, float]:
    """Return the likeliest sigma and process noise of chains."""
    unit = sigma**2 / float(np.nanmedian(chains.step)) ** 3

    def surprise(logs: FloatArray) -> float:
        if np.max(np.abs(logs)) > FURTHEST:
            return math.inf
        variance = sigma**2 if fixed else float(np.exp(logs[-1])) * sigma**2
        return _surprise(chains, (variance, float(np.exp(logs[0])) * unit, density))

    starts = [np.array([level] if fixed else [level, 0.0]) for level in STARTS]
    best = min(starts, key=surprise)
    found = least_by_simplex(surprise, best, rounds=80, within=1e-3)
    scale = 1.0 if fixed else float(np.exp(found[-1] / 2))
    return sigma * scale, float(np.exp(found[0])) * unit


def _surprise(chains: _Chains, noise: tuple[float, float, float]) -> float:
    """Return minus the log-likelihood of all chains, each report from its object or elsewhere."""
    variance, process, density = noise
    counted, elsewhere = _all(chains.places), WRONG * density
    return follow_chains(*chains, variance, process, elsewhere, np.inf, counted)[0]


def _grown(chains: _Chains, noise: tuple[float, float, float]) -> float:
    """Return the process noise with which hardly any report lies far off [m²/s³]."""
    # Sharp turns are rare, and yet no track should be lost in one. What is far off for another
    # reason, as reports are noisier far from a radar, stays where it is however much it grows.
    variance, process, density = noise
    before, counted = math.inf, _beside_curves(chains, variance)
    for number in range(MOST_DOUBLINGS):
        grown = process * 2.0**number
        far, all_own = _far_off(chains, (variance, grown, density), counted)
        # A single one of few reports tells nothing.
        if far <= max(FAR_SHARE * all_own, 1.0):
            return grown
        if number % TRIAL == 0:
            half = before / 2.0
            if far > half + BY_CHANCE * math.sqrt(half):
                return process
            before = far
    return process * 2.0**MOST_DOUBLINGS


def _far_off(
    chains: _Chains, noise: tuple[float, float, float], counted: NDArray[np.bool_]
) -> tuple[float, float]:
    """Return how many of the objects' own reports lie where one in a hundred does, and all."""
    variance, process, density = noise
    limit = quantile_of(chains.places.shape[2], 0.99)
    _, far, trusted = follow_chains(*chains, variance, process, WRONG * density, limit, counted)
    return far, trusted


def _beside_curves(chains: _Chains, variance: float) -> NDArray[np.bool_]:
    """Tell of each report whether it lies where its neighbours before and after say."""
    # Behind a turn a report is far from where the filter expects it, and not from there; one that
    # is wild is far from both, and those beside it may be.
    time, (_, places, scale) = _times(chains), chains
    # A fit that takes turns for motion alone leaves next to no noise, beside which all is wild.
    told = noise_beside_curves(time, places) ** 2
    variance = told if variance < HIDDEN * told else variance
    limit = quantile_of(places.shape[2], 0.99) * variance
    beside = np.zeros(places.shape[:2], dtype=np.bool_)
    for row, count in enumerate(np.isfinite(time).sum(axis=1)):
        if count > 4:
            curve, known = expected_of(time[row, :count], places[row, :count])[-1]
            off = np.sum((places[row, 2 : count - 2] - curve) ** 2, axis=1)
            own = scale[row, 2 : count - 2] ** 2
            beside[row, 2 : count - 2] = off < limit * own * (1.0 + known)
    return beside


def _all(places: FloatArray) -> NDArray[np.bool_]:
    return np.ones(places.shape[:2], dtype=np.bool_)


def _all_followed(chains: _Chains, noise: tuple[FloatArray, float, float]) -> bool:
    """Tell whether a filter follows all chains to their ends, but for few."""
    # Behind a turn that is too sharp for it, what an object reports seems to come from elsewhere.
    variances, process, density = noise
    n_lost = 0
    for row, variance in enumerate(variances):
        chain = _Chains(*(each[row : row + 1] for each in chains))
        own = follow_chains(
            *chain, variance, process, WRONG * density, np.inf, _all(chain.places)
        )[2]
        n_reports = int(np.count_nonzero(np.isfinite(chains.step[row]))) - 1
        n_lost += int(n_reports - own > max(LOST_REPORTS, LOST_PART * n_reports))
    return bool(n_lost <= LOST_CHAINS * len(chains.step))
