"""Which tracks of different sensors are of one object, as far as their biases are known."""

from itertools import combinations
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.sightings import CLOCK, N_BIASES, Sightings
from trackweave.estimation.trees import all_within, tree_of

__all__ = ["Courses", "courses_of", "objects_of"]

# Tracks are compared at times a slowest period apart, and at so many of them at least.
FEWEST_TIMES = 3
# No report within so many periods on both sides, and a track is not there.
LONGEST_GAP = 3.6
# Squared distance of tracks, by all that is not known of them, and of their heights [m].
GATE, SAME_HEIGHT = 16.0, 100.0
# Standard deviations of what is not known that are looked at around a track.
WIDE = 4.0
# Velocities differ by this share of the greatest speed where tracks turn.
OTHER_VELOCITY = 0.01


class Courses(NamedTuple):
    """Tracks at common times, shape (tracks, times, …)."""

    time: FloatArray
    place: FloatArray  # NaN where a track is not there
    height: FloatArray  # The same
    slope: FloatArray  # By each bias, (tracks, times, 2, 6), 0 there
    spread: FloatArray  # Variance of a place along an axis [m²], (tracks,)


def objects_of(
    sightings: Sightings, bias: FloatArray, covariance: FloatArray, fastest: float
) -> IntArray:
    """Return the object of each track, numbered from 0."""
    # Only networks of sensors wait for these imports.
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    # Two tracks are of one object where each is the other's nearest by what is not known of them:
    # their noise and the biases, whose covariance comes in the order of ``bias`` raveled. The
    # difference of their places, that of their velocities and that of their heights count.
    # ``fastest`` is the greatest speed [m/s].
    courses = courses_of(sightings, bias)
    n_tracks = courses.place.shape[0]
    pairs = [np.empty((0, 2), dtype=np.int64)]
    for first, second in combinations(range(sightings.n_sensors), 2):
        own = np.r_[:N_BIASES] + N_BIASES * np.array([[first], [second]])
        unknown = covariance[np.ix_(own.ravel(), own.ravel())]
        sides = [np.flatnonzero(sightings.track_sensor == each) for each in (first, second)]
        found = _candidates(courses, sides, unknown)
        pairs.append(_mutual(found, _costs(courses, found, unknown, OTHER_VELOCITY * fastest)))
    joined = np.concatenate(pairs)
    links = coo_matrix((np.ones(len(joined)), tuple(joined.T)), shape=(n_tracks, n_tracks))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def courses_of(sightings: Sightings, bias: FloatArray) -> Courses:
    """Return the tracks at common times, without biases, shape (sensors, 6)."""
    time, place = sightings.corrected(bias)
    slopes = sightings.slopes(bias)
    # A sensor without any track does not set the pace.
    step = float(sightings.period[np.unique(sightings.track_sensor)].max())
    grid = np.arange(time.min(), time.max() + step, step)
    n_tracks = len(sightings.rows)
    at = np.full((n_tracks, grid.size, 2), np.nan)
    height = np.full((n_tracks, grid.size), np.nan)
    slope = np.zeros((n_tracks, grid.size, 2, N_BIASES))
    spread = np.zeros(n_tracks)
    for number, rows in enumerate(sightings.rows):
        own = time[rows]
        far = float(np.median(sightings.distance[rows]))
        along, across = sightings.track_sigma[number]
        spread[number] = along**2 + (across * far) ** 2
        after = np.searchsorted(own, grid)
        there = np.flatnonzero((after > 0) & (after < own.size))
        right = after[there]
        gap = own[right] - own[right - 1]
        longest = LONGEST_GAP * sightings.period[sightings.track_sensor[number]]
        keep = (gap < longest) & (gap > 0)
        there, right, gap = there[keep], right[keep], gap[keep]
        share = ((grid[there] - own[right - 1]) / gap)[:, None]
        one, other = place[rows[right - 1]], place[rows[right]]
        at[number, there] = one + share * (other - one)
        near = rows[np.where(share[:, 0] < 0.5, right - 1, right)]
        height[number, there] = sightings.height[near]
        slope[number, there, :, :CLOCK] = slopes[near]
        slope[number, there, :, CLOCK] = -(other - one) / gap[:, None]
    return Courses(grid, at, height, slope, spread)


def _candidates(courses: Courses, sides: list[IntArray], unknown: FloatArray) -> IntArray:
    """Return pairs of tracks that come near each other often enough, shape (pairs, 2)."""
    none = np.empty((0, 2), dtype=np.int64)
    if not all(side.size for side in sides):
        return none
    steepest = [np.abs(courses.slope[side]).max(axis=(0, 1, 2)) for side in sides]
    reach = np.concatenate(steepest) ** 2 @ np.diagonal(unknown)
    wide = reach + sum(2.0 * float(np.quantile(courses.spread[side], 0.9)) for side in sides)
    found = [none]
    for moment in range(courses.time.size):
        here = [side[np.isfinite(courses.place[side, moment, 0])] for side in sides]
        if not all(each.size for each in here):
            continue
        tree = tree_of(courses.place[here[1], moment])
        near = all_within(tree, courses.place[here[0], moment], WIDE * float(np.sqrt(wide)))
        count = [each.size for each in near]
        second = np.concatenate([none[:, 0], *near])
        found.append(np.stack([np.repeat(here[0], count), here[1][second]], axis=1))
    pairs, times = np.unique(np.concatenate(found), axis=0, return_counts=True)
    return pairs[times >= FEWEST_TIMES]


def _costs(
    courses: Courses, pairs: IntArray, unknown: FloatArray, other_velocity: float
) -> FloatArray:
    """Return minus twice the logarithm of how well tracks of pairs agree; infinite beyond."""
    if not len(pairs):
        return np.empty(0)
    first, second = pairs.T
    apart = courses.place[second] - courses.place[first]
    both = np.isfinite(apart[:, :, 0])
    count = both.sum(axis=1)
    weight = both / count[:, None]
    apart = np.nan_to_num(apart)
    middle = np.einsum("pt,pti->pi", weight, apart)
    of_both = [_means(courses.slope, each, weight) for each in (first, second)]
    slope = np.concatenate([-of_both[0], of_both[1]], axis=2)
    # How the difference changes: velocities that differ.
    when = np.where(both, courses.time - (weight @ courses.time)[:, None], 0.0)
    lasting = np.maximum((when**2).sum(axis=1), 1e-9)
    drift = np.einsum("pt,pti->pi", when, apart) / lasting[:, None]
    noise = courses.spread[first] + courses.spread[second]
    spread = slope @ unknown @ slope.swapaxes(1, 2) + noise[:, None, None] * np.eye(2)
    squared = np.einsum("pi,pi->p", middle, np.linalg.solve(spread, middle[:, :, None])[:, :, 0])
    squared += (drift**2).sum(axis=1) / (noise / lasting + other_velocity**2)
    climbing = np.abs(courses.height[first] - courses.height[second])
    told = np.isfinite(climbing)
    higher = np.where(told, climbing, 0.0).sum(axis=1) / np.maximum(told.sum(axis=1), 1)
    cost = squared + np.linalg.slogdet(spread)[1] - 2.0 * np.log(count)
    return np.where((squared < GATE) & (higher < SAME_HEIGHT), cost, np.inf)


def _means(of_tracks: FloatArray, tracks: IntArray, weight: FloatArray) -> FloatArray:
    """Return a mean over times of some tracks, shape (pairs, 2, 6), by weights (pairs, times)."""
    # Track by track, as copies of all times for each pair would be most of the work in a crowd.
    found = np.empty((tracks.size, *of_tracks.shape[2:]))
    order = np.argsort(tracks, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(tracks[order])) + 1):
        found[rows] = np.tensordot(weight[rows], of_tracks[tracks[rows[0]]], axes=1)
    return found


def _mutual(pairs: IntArray, cost: FloatArray) -> IntArray:
    """Return the pairs in which each track is the best of the other."""
    pairs, cost = pairs[np.isfinite(cost)], cost[np.isfinite(cost)]
    order = np.argsort(cost, kind="stable")
    pairs = pairs[order]
    best = [np.unique(pairs[:, side], return_index=True)[1] for side in (0, 1)]
    return pairs[np.intersect1d(best[0], best[1])]
