"""Two tracks of two sensors tell the height of their object."""

from dataclasses import replace

import numpy as np
import pytest

from trackweave.estimation.height_pairs import Looks, candidates, fitted, moments_of
from trackweave.estimation.heights import heights_of
from trackweave.estimation.sightings import Sightings

PLACES = np.array([[0.0, 0.0], [40e3, 0.0]])
PERIOD, N_TURNS = 5.0, 40


def seen(heights: list[float], seed: int = 1, noise: float = 0.0) -> Sightings:
    """Return what two radars see of objects that fly past each other at these heights."""
    rng = np.random.default_rng(seed)
    parts = []
    for number, height in enumerate(heights):
        start = np.array([-10e3, 8e3 + 9e3 * number])
        for sensor, centre in enumerate(PLACES):
            time = PERIOD * np.arange(N_TURNS) + rng.uniform(0.0, PERIOD)
            away = start + time[:, None] * np.array([200.0, -5.0]) - centre
            slant = np.hypot(np.hypot(*away.T), height) + rng.normal(0.0, noise + 1e-3, time.size)
            azimuth = np.arctan2(away[:, 0], away[:, 1]) + rng.normal(0.0, 1e-6, time.size)
            own = np.full(time.size, 2 * number + sensor)
            parts.append((time, np.full(time.size, sensor), own, slant, azimuth))
    time, sensor, track, slant, azimuth = map(np.concatenate, zip(*parts, strict=True))
    return Sightings(
        time, sensor, track, PLACES[sensor], slant, slant, azimuth,
        np.ones(time.size), np.full(time.size, np.nan), np.ones(2, np.bool_), np.full(2, PERIOD),
    )  # fmt: skip


def looks(sightings: Sightings, level: float = 0.0) -> Looks:
    n = sightings.time.size
    return Looks(sightings, np.full(n, level), np.ones(n, np.bool_), 0.0)


@pytest.mark.parametrize("height", [2e3, 6e3, 11e3])
def test_a_pair_has_the_height_of_a_search_through_all(height: float) -> None:
    moments = moments_of(looks(seen([height])))
    fit = fitted(moments, (0, 1))
    assert fit is not None
    rows = [moments.tracks.track == number for number in (0, 1)]
    sides = [moments.tracks.of(np.flatnonzero(own)) for own in rows]
    common = np.intersect1d(sides[0].moment, sides[1].moment)
    sides = [side.of(np.flatnonzero(np.isin(side.moment, common))) for side in sides]
    levels = np.arange(0.0, 15e3, 20.0)
    apart = [
        np.sum((sides[0].places(each, 0.0)[0] - sides[1].places(each, 0.0)[0]) ** 2)
        for each in levels[:, None] + np.zeros(common.size)
    ]
    best = levels[np.argmin(apart)]
    assert best == pytest.approx(height, abs=150.0)
    assert np.median(fit.height) == pytest.approx(best, abs=150.0)


def test_slopes_of_heights_and_biases_are_those_of_small_changes() -> None:
    sightings = seen([7e3])
    moments = moments_of(looks(sightings))
    height = np.full(moments.tracks.slant.size, 7e3)
    at, slope = moments.tracks.places(height, 0.0)
    higher = moments.tracks.places(height + 1.0, 0.0)[0]
    np.testing.assert_allclose(slope, higher - at, atol=1e-3)
    slopes = moments.tracks.slopes(height)
    shorter = replace(sightings, slant=sightings.slant - 1.0, distance=sightings.distance - 1.0)
    moved = moments_of(looks(shorter)).tracks.places(height, 0.0)[0]
    np.testing.assert_allclose(slopes[:, :, 0], moved - at, atol=2e-2)
    turned = replace(sightings, azimuth=sightings.azimuth - 1e-4)
    moved = moments_of(looks(turned)).tracks.places(height, 0.0)[0]
    np.testing.assert_allclose(slopes[:, :, 2], (moved - at) / 1e-4, rtol=1e-2, atol=30.0)


def test_tracks_of_several_objects_find_their_partners() -> None:
    heights = [3e3, 9e3, 6e3, 11e3]
    sightings = seen(heights, noise=30.0)
    n = sightings.time.size
    found = heights_of(sightings, np.zeros(n), np.ones(n, np.bool_), 0.0)
    assert (found.n_objects, found.n_pairs) == (4, 4)
    for number, height in enumerate(heights):
        own = sightings.track // 2 == number
        assert np.median(found.height[own]) == pytest.approx(height, abs=300.0)


def test_ranges_on_the_ground_tell_of_no_height() -> None:
    sightings = seen([0.0] * 4, noise=30.0)
    n = sightings.time.size
    found = heights_of(sightings, np.zeros(n), np.ones(n, np.bool_), 0.0)
    assert found.n_objects == found.n_clear == 0
    assert np.isnan(found.height).all()


def test_what_flies_elsewhere_is_no_candidate() -> None:
    sightings = seen([5e3, 5e3])
    moments = moments_of(looks(sightings))
    pairs = candidates(moments).tolist()
    assert [0, 1] in pairs
    assert [2, 3] in pairs
    assert fitted(moments, (0, 3)) is None


def test_the_earth_curves_down() -> None:
    """At 100 km and a height of 10 km the place on the ground is by the law of cosines."""
    sightings = seen([5e3])
    moments = moments_of(looks(sightings))
    tracks = moments.tracks
    radius = 6.371e6
    height = np.full(tracks.slant.size, 10e3)
    at = tracks.places(height, 1.0 / radius)[0] - tracks.centre
    cosine = (radius**2 + (radius + height) ** 2 - tracks.slant**2) / (
        2 * radius * (radius + height)
    )
    usable = np.abs(height) < 0.9 * tracks.slant
    expected = radius * np.arccos(np.clip(cosine, -1.0, 1.0))
    np.testing.assert_allclose(np.hypot(*at.T)[usable], expected[usable], rtol=1e-3)


def test_years_between_objects_take_no_time() -> None:
    sightings = seen([3e3, 9e3, 6e3, 11e3], noise=30.0)
    later = np.where(sightings.track > 3, 3e8, 0.0)
    n = sightings.time.size
    apart = replace(sightings, time=sightings.time + later)
    found = heights_of(apart, np.zeros(n), np.ones(n, np.bool_), 0.0)
    assert found.n_objects == 4
