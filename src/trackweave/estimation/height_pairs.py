"""Two tracks of two sensors, taken for one object: the heights at which their places meet."""

from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.sightings import (
    AZIMUTH,
    CLOCK,
    N_BIASES,
    RANGE,
    SCALE,
    Sightings,
)
from trackweave.estimation.trees import all_within, tree_of

__all__ = [
    "GATE",
    "ROUGH_GATE",
    "STEEPEST",
    "USUAL",
    "WORST",
    "Fit",
    "Looks",
    "Moments",
    "OnGround",
    "candidates",
    "fitted",
    "held_at",
    "moments_of",
    "on_ground",
]

# Nothing flies higher or lower [m]; heights are looked for at such steps first.
LOWEST, HIGHEST, STEP = -500.0, 15_000.0, 500.0
WORST = 25.0
"""One place that is far off counts as so many variances."""
STEEPEST = 0.95
"""Of heights above a sensor no more than this share of the range."""
# No report within so many periods on both sides, and a track is not there.
LONGEST_GAP = 3.6
# Beside their noise places differ by biases that nobody knows yet, along [m] and across [rad].
UNKNOWN_ALONG, UNKNOWN_ACROSS = 100.0, float(np.radians(0.1))
# Tracks of one object agree within so much (mean square, in variances of what is not known) at
# the end and before heights change, at so many times; candidates within so many deviations.
GATE, ROUGH_GATE, FEWEST_TIMES, WIDE = 3.0, 12.0, 4, 5.0
# How sure heights are beforehand [m], how fast objects climb [m/s], and how exact told ones are.
USUAL, SPREAD, CLIMB, TOLD = 5_000.0, 4_000.0, 4.0, 60.0
# Heights are straight lines between times so far apart [s].
KNOT = 60.0
HUBER, MOST_STEPS = 2.5, 6


@dataclass(frozen=True, eq=False)
class Looks:
    """What several sensors saw, and what is known of its heights."""

    sightings: Sightings
    level: FloatArray  # Height of each report's sensor [m]
    is_slant: NDArray[np.bool_]  # Which reports tell a range whose height nobody knows
    curve: float  # One by the Earth's radius [1/m], 0 on a plane


class _Tracks(NamedTuple):
    """Tracks at common times, a row for each track and time, ascending."""

    track: IntArray
    moment: IntArray
    centre: FloatArray  # Of the sensor, or the place where its height does not count, (rows, 2)
    outward: FloatArray  # From there to the object, as long as the range on the plane, (rows, 2)
    velocity: FloatArray  # Of the object, were it on the ground [m/s], (rows, 2)
    slant: FloatArray  # [m]; infinite where heights do not count
    level: FloatArray  # Height of the sensor [m]
    told: FloatArray  # Height that was told [m], NaN for none
    spread: FloatArray  # Variance of the place along an axis [m²]

    def of(self, rows: IntArray) -> "_Tracks":
        return _Tracks(
            self.track[rows], self.moment[rows], self.centre[rows], self.outward[rows],
            self.velocity[rows], self.slant[rows], self.level[rows], self.told[rows],
            self.spread[rows],
        )  # fmt: skip

    def places(self, height: FloatArray, curve: float) -> tuple[FloatArray, FloatArray]:
        """Return places at heights [m], and how a metre of height moves them, (rows, 2)."""
        # By the law of cosines on a sphere.
        above, ratio = self._ratio(height)
        flat = 1.0 - curve * (height - self.level) / 2.0
        slope = -above / self.slant**2 / ratio * flat - ratio * curve / 2.0
        return self.centre + (ratio * flat)[:, None] * self.outward, slope[:, None] * self.outward

    def _ratio(self, height: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how far heights are above the sensor, and the distance by the range."""
        most = STEEPEST * self.slant
        above = np.clip(height - self.level, -most, most)
        return above, np.sqrt(1.0 - (above / self.slant) ** 2)

    def slopes(self, height: FloatArray) -> FloatArray:
        """Return how a unit of each bias moves places, (rows, 2, biases)."""
        length = np.maximum(np.linalg.norm(self.outward, axis=1), 1e-9)
        unit = self.outward / length[:, None]
        _, ratio = self._ratio(height)
        slope = np.zeros((length.size, 2, N_BIASES))
        slope[:, :, RANGE] = -unit / ratio[:, None]
        slope[:, :, SCALE] = slope[:, :, RANGE] * length[:, None]
        slope[:, 0, AZIMUTH] = -(ratio * length) * unit[:, 1]
        slope[:, 1, AZIMUTH] = (ratio * length) * unit[:, 0]
        # What a clock that is ahead tells as of now was so much earlier.
        slope[:, :, CLOCK] = self.velocity
        # Beside a place that does not depend on heights no bias is looked for here.
        slope[length <= 1e-6] = 0.0
        return slope


class Moments(NamedTuple):
    """Tracks at common times."""

    tracks: _Tracks
    starts: IntArray  # First row of each track, and the end of the last
    begin: float  # Time of the first moment [s]
    step: float  # From moment to moment, a slowest period [s]
    sensor: IntArray  # Of each track
    n_sensors: int
    curve: float


@dataclass(frozen=True, eq=False)
class Fit:
    """A pair of tracks, taken for one object."""

    pair: tuple[int, int]
    moment: IntArray
    height: FloatArray  # [m], at each moment
    precision: FloatArray  # Of each [1/m²]
    cost: float  # Squared distance that is left, in variances
    bias_matrix: FloatArray  # Normal equations of all sensors' biases beside its heights
    bias_vector: FloatArray


class OnGround(NamedTuple):
    """Two tracks, taken for one object on the ground, at the moments that they have in common."""

    moment: IntArray
    off: FloatArray  # How far apart they are [m], (times, 2)
    slope: FloatArray  # How a unit of each sensor's biases changes that, (times, 2, all biases)
    variance: FloatArray  # Of how far apart they are along an axis [m²]


def moments_of(looks: Looks) -> Moments:
    """Return tracks at common times."""
    sightings = looks.sightings
    begin, step = float(sightings.time.min()), float(sightings.period.max())
    place = sightings.corrected(np.zeros((sightings.n_sensors, N_BIASES)))[1]
    parts = [_at((begin, step), looks, place, number) for number in range(len(sightings.rows))]
    tracks = _Tracks(*(np.concatenate(each) for each in zip(*parts, strict=True)))
    starts = np.searchsorted(tracks.track, np.arange(len(sightings.rows) + 1))
    of = sightings.track_sensor, sightings.n_sensors, looks.curve
    return Moments(tracks, starts, begin, step, *of)


def _at(grid: tuple[float, float], looks: Looks, places: FloatArray, number: int) -> _Tracks:
    """Return a track at the moments, from a time on and so far apart [s], at which it is there."""
    sightings, (begin, step) = looks.sightings, grid
    rows = sightings.rows[number]
    own = sightings.time[rows]
    first, end = np.ceil((own[[0, -1]] - begin) / step).astype(np.int64)
    there = np.arange(first, end)
    after = np.clip(np.searchsorted(own, begin + step * there), 1, own.size - 1)
    one, other = rows[after - 1], rows[after]
    gap = sightings.time[other] - sightings.time[one]
    longest = LONGEST_GAP * sightings.period[sightings.track_sensor[number]]
    # Between a place and a range without a height there is nothing.
    keep = (gap < longest) & (gap > 0) & (looks.is_slant[one] == looks.is_slant[other])
    there, one, other, gap = there[keep], one[keep], other[keep], gap[keep]
    share = (begin + step * there - sightings.time[one]) / gap

    def between(values: FloatArray) -> FloatArray:
        weight = share.reshape(-1, *(1,) * (values.ndim - 1))
        return np.asarray(values[one] + weight * (values[other] - values[one]))

    is_slant = looks.is_slant[one]
    place = between(places)
    centre = np.where(is_slant[:, None], between(sightings.centre), place)
    along, across = sightings.track_sigma[number]
    far = between(sightings.distance)
    unknown = np.where(sightings.is_polar[sightings.track_sensor[number]], UNKNOWN_ACROSS, 0.0)
    spread = along**2 + UNKNOWN_ALONG**2 + (across**2 + unknown**2) * far**2
    slant = np.where(is_slant, between(sightings.slant), np.inf)
    return _Tracks(
        np.full(there.size, number), there, centre, place - centre,
        (places[other] - places[one]) / gap[:, None], slant, looks.level[one],
        between(sightings.height), spread,
    )  # fmt: skip


def candidates(moments: Moments) -> IntArray:
    """Return pairs of tracks of two sensors that meet at some height often enough."""
    order = np.argsort(moments.tracks.moment, kind="stable")
    cuts = np.flatnonzero(np.diff(moments.tracks.moment[order])) + 1
    found = [np.empty((0, 2), dtype=np.int64)]
    for rows in np.split(order, cuts):
        here = moments.tracks.of(rows)
        sensor = moments.sensor[here.track]
        for first, second in combinations(np.unique(sensor).tolist(), 2):
            sides = [here.of(np.flatnonzero(sensor == each)) for each in (first, second)]
            found.append(_meeting(sides[0], sides[1], moments.curve))
    pairs, times = np.unique(np.concatenate(found), axis=0, return_counts=True)
    return np.asarray(pairs[times >= FEWEST_TIMES])


def _meeting(first: _Tracks, second: _Tracks, curve: float) -> IntArray:
    """Return which tracks of one moment meet at some height, as pairs of their numbers."""
    reach = _farthest(first, curve) + _farthest(second, curve)
    near = all_within(
        tree_of(second.centre + second.outward), first.centre + first.outward, reach
    )  # fmt: skip
    left = first.of(np.repeat(np.arange(first.track.size), [each.size for each in near]))
    right = second.of(np.concatenate([np.empty(0, dtype=np.int64), *near]).astype(np.int64))
    least = np.full(left.track.size, np.inf)
    for height in np.arange(0.0, HIGHEST, STEP):
        level = np.full(left.track.size, height)
        apart = left.places(level, curve)[0] - right.places(level, curve)[0]
        least = np.minimum(least, np.sum(apart**2, axis=1))
    close = least < WIDE**2 * 2.0 * (left.spread + right.spread)
    return np.stack([left.track[close], right.track[close]], axis=1)


def _farthest(tracks: _Tracks, curve: float) -> float:
    """Return how far a height or noise may move any place [m]."""
    highest = np.full(tracks.slant.size, HIGHEST)
    moved = tracks.places(highest, curve)[0] - tracks.centre - tracks.outward
    return float(np.max(np.linalg.norm(moved, axis=1) + WIDE * np.sqrt(tracks.spread)))


class _Pair:
    """Two tracks at the times that they have in common."""

    def __init__(self, moments: Moments, pair: tuple[int, int]) -> None:
        rows = [np.arange(moments.starts[each], moments.starts[each + 1]) for each in pair]
        own = moments.tracks.moment
        self.moment, one, other = np.intersect1d(
            own[rows[0]], own[rows[1]], assume_unique=True, return_indices=True
        )
        self.sides = moments.tracks.of(rows[0][one]), moments.tracks.of(rows[1][other])
        self.variance = self.sides[0].spread + self.sides[1].spread
        self.curve = moments.curve
        # Between knots heights are straight lines.
        apart = KNOT / moments.step
        last = self.moment[-1] + apart if self.moment.size else 0.0
        knots = np.arange(self.moment[0], last, apart) if self.moment.size else np.zeros(1)
        self.basis = np.array(
            [np.interp(self.moment, knots, each) for each in np.eye(knots.size)]
        ).T
        steps = np.diff(np.eye(knots.size), axis=0)
        self.prior = steps.T @ steps / (CLIMB * KNOT) ** 2
        self.prior += np.eye(knots.size) / SPREAD**2 / knots.size

    def apart(self, height: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how far apart the places are, and how a metre of height changes that."""
        (at, slope), (there, other) = (side.places(height, self.curve) for side in self.sides)
        return at - there, slope - other

    def cost(self, height: FloatArray) -> float:
        """Return the squared distance in variances, in which none counts without end."""
        squared = np.sum(self.apart(height)[0] ** 2, axis=1) / self.variance
        return float(np.sum(np.minimum(squared, WORST)))

    def weighed(self, height: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return distances, slopes and how much each moment counts [1/m²]."""
        off, slope = self.apart(height)
        far = np.sqrt(np.sum(off**2, axis=1) / self.variance)
        return off, slope, 1.0 / self.variance / np.maximum(1.0, far / HUBER)

    def equations(self, height: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the normal equations of the knots' heights without what is known beforehand."""
        off, slope, weight = self.weighed(height)
        data = weight * np.sum(slope**2, axis=1)
        pull = -weight * np.sum(slope * off, axis=1)
        for side in self.sides:
            is_told = np.isfinite(side.told)
            data = data + is_told / TOLD**2
            pull = pull + np.where(is_told, side.told - height, 0.0) / TOLD**2
        return self.basis.T @ (data[:, None] * self.basis), self.basis.T @ pull


def fitted(
    moments: Moments, tracks: tuple[int, int], start: float | None = None, *, gate: float = GATE
) -> Fit | None:
    """Return the heights at which two tracks are of one object, None where they are of two."""
    # It sets out from a height ``start``, or from the best that is as high all along; places may
    # be apart by ``gate`` variances in the mean.
    pair = _Pair(moments, tracks)
    n_moments = pair.moment.size
    if n_moments < FEWEST_TIMES:
        return None
    if start is None:
        flat, levels = np.ones(n_moments), np.arange(0.0, HIGHEST, STEP)
        least, start = min((pair.cost(flat * level), float(level)) for level in levels)
        if least > ROUGH_GATE * n_moments:
            return None
    knot = np.full(pair.prior.shape[0], start)
    for _ in range(MOST_STEPS):
        data, pull = pair.equations(pair.basis @ knot)
        matrix = data + pair.prior
        knot = knot + np.linalg.solve(matrix, pull - pair.prior @ (knot - USUAL))
        knot = np.clip(knot, LOWEST, HIGHEST)
    height = pair.basis @ knot
    left = pair.cost(height)
    if left > gate * n_moments:
        return None
    inverse = np.asarray(np.linalg.inv(matrix), dtype=np.float64)
    return Fit(
        tracks,
        pair.moment,
        height,
        1.0 / np.einsum("tk,kl,tl->t", pair.basis, inverse, pair.basis),
        left,
        *_of_biases(pair, height, inverse, (moments, tracks)),
    )


def held_at(
    moments: Moments, tracks: tuple[int, int], above: float
) -> tuple[float, FloatArray, FloatArray]:
    """Return the squared distance of two tracks so far above ground, and biases' equations."""
    pair = _Pair(moments, tracks)
    ground = np.minimum(pair.sides[0].level, pair.sides[1].level) + above
    return pair.cost(ground), *_of_biases(pair, ground, None, (moments, tracks))


def on_ground(moments: Moments, tracks: tuple[int, int]) -> OnGround:
    """Return two tracks as they lie on the ground."""
    pair = _Pair(moments, tracks)
    ground = np.minimum(pair.sides[0].level, pair.sides[1].level)
    slope = _bias_slopes(pair, ground, (moments, tracks))
    return OnGround(pair.moment, pair.apart(ground)[0], slope, pair.variance)


def _bias_slopes(
    pair: _Pair, height: FloatArray, of: tuple[Moments, tuple[int, int]]
) -> FloatArray:
    """Return how a unit of each sensor's biases moves two tracks apart, (times, 2, all biases)."""
    moments, tracks = of
    slope = np.zeros((height.size, 2, moments.n_sensors * N_BIASES))
    for side, track, sign in zip(pair.sides, tracks, (1.0, -1.0), strict=True):
        first = int(moments.sensor[track]) * N_BIASES
        slope[:, :, first : first + N_BIASES] += sign * side.slopes(height)
    return slope


def _of_biases(
    pair: _Pair,
    height: FloatArray,
    inverse: FloatArray | None,
    of: tuple[Moments, tuple[int, int]],
) -> tuple[FloatArray, FloatArray]:
    """Return the normal equations of all sensors' biases, beside the heights of a pair."""
    # ``inverse`` is that of the heights' own equations, None where heights stay as they are.
    slope = _bias_slopes(pair, height, of)
    off, rising, weight = pair.weighed(height)
    weighed = weight[:, None, None] * slope
    matrix = np.einsum("tin,tim->nm", weighed, slope)
    vector = -np.einsum("tin,ti->n", weighed, off)
    if inverse is None:
        return matrix, vector
    # What heights can do as well tells of no bias (Schur's complement).
    beside = pair.basis.T @ np.einsum("ti,tin->tn", rising, weighed)
    pull = pair.basis.T @ -(weight * np.sum(rising * off, axis=1))
    return matrix - beside.T @ inverse @ beside, vector - beside.T @ inverse @ pull
