"""Noise between the places where it is known."""

import numpy as np
import pytest

import trackweave as tw
from trackweave.models.local_noise import BLOCK, local_noise

PLACES = [(0.0, 0.0, 0.1, 0.2), (50.0, 0.0, 1.0, 0.5), (50.0, 50.0, 2.0, 0.5)]


def test_noise_at_a_place_is_its_own_and_far_away_that_of_all() -> None:
    found = local_noise(PLACES, np.array([[0.0, 0.0], [50.0, 50.0], [1e6, -1e6]]))
    np.testing.assert_allclose(found[0], [0.1, 0.2], rtol=0.25)
    np.testing.assert_allclose(found[1], [2.0, 0.5], rtol=0.25)
    geometric = np.exp(np.log(np.array(PLACES)[:, 2:]).mean(axis=0))
    np.testing.assert_allclose(found[2], geometric, rtol=1e-3)


def test_noise_is_never_beyond_that_of_the_places() -> None:
    position = np.random.default_rng(1).uniform(-100.0, 150.0, (500, 2))
    found, known = local_noise(PLACES, position), np.array(PLACES)[:, 2:]
    assert np.all(found >= known.min(axis=0) * (1 - 1e-12))
    assert np.all(found <= known.max(axis=0) * (1 + 1e-12))


def test_one_place_holds_everywhere_and_blocks_change_nothing() -> None:
    position = np.random.default_rng(2).uniform(-10.0, 10.0, (BLOCK + 7, 3))
    one = local_noise([(1.0, 2.0, 3.0, 4.0, 5.0)], position)
    np.testing.assert_allclose(one, np.broadcast_to([3.0, 4.0, 5.0], one.shape))
    many = local_noise(PLACES, position[:, :2])
    np.testing.assert_array_equal(many[-9:], local_noise(PLACES, position[-9:, :2]))


def test_a_reports_own_noise_comes_first() -> None:
    sensor = tw.Sensor("camera", sigma=9.0, sigma_at=tuple(PLACES))
    told = np.array([[np.nan, np.nan], [7.0, np.nan]])
    found = sensor.noise(told, np.array([[0.0, 0.0], [0.0, 0.0]]), 2)
    np.testing.assert_allclose(found, [[0.1, 0.2], [7.0, 0.2]], rtol=0.25)
    plain = tw.Sensor("camera", sigma=(9.0, 8.0)).noise(told, np.zeros((2, 2)), 2)
    np.testing.assert_array_equal(plain, [[9.0, 8.0], [7.0, 8.0]])


@pytest.mark.parametrize(
    "places",
    [
        ((0.0, 0.0, 1.0),),
        ((0.0, 0.0, 1.0, -1.0),),
        ((0.0, 0.0, 1.0, 0.0),),
        ((0.0, 0.0, 1.0, 1.0), (1.0, 1.0, 1.0, 1.0, 1.0)),
        ((0.0, np.nan, 1.0, 1.0),),
        5.0,
    ],
)
def test_places_that_tell_no_noise_are_refused(places: object) -> None:
    with pytest.raises(tw.InvalidInputError, match="sigma_at"):
        tw.Sensor("camera", sigma_at=places)  # type: ignore[arg-type]


def test_only_positions_have_noise_at_places() -> None:
    with pytest.raises(tw.InvalidInputError, match="range-azimuth; expected one of positions"):
        tw.Sensor(
            "radar",
            measurement=tw.MeasurementKind.RANGE_AZIMUTH,
            sigma=(10.0, 0.01),
            sigma_at=tuple(PLACES),
        )


def test_places_of_a_plane_are_refused_in_space() -> None:
    sensor = tw.Sensor("camera", sigma_at=tuple(PLACES))
    with pytest.raises(tw.InvalidInputError, match="sigma_at for 2 axes; expected 3"):
        sensor.noise(np.full((1, 3), np.nan), np.zeros((1, 3)), 3)
