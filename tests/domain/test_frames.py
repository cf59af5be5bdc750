"""Planes on the Earth."""

import numpy as np
import pymap3d
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackweave.domain.frames import LocalFrame


@given(
    origin=st.tuples(st.floats(-89, 89), st.floats(-180, 360)),
    east=st.floats(-2e6, 2e6),
    north=st.floats(-2e6, 2e6),
    altitude=st.floats(-500, 50_000),
    projection=st.sampled_from(["tangent", "stereographic"]),
)
def test_positions_come_back(origin, east, north, altitude, projection):
    frame = LocalFrame(*origin, projection)
    position = np.array([[east, north, altitude]])
    again = frame.to_plane(*frame.to_geodetic(position))
    np.testing.assert_allclose(again, position, atol=1e-3)


def test_is_the_tangent_plane_for_points_of_the_ellipsoid():
    frame = LocalFrame(47.0, 8.0)
    latitude, longitude = np.array([47.5, 46.0]), np.array([8.5, 7.0])
    east, north, _ = pymap3d.geodetic2enu(latitude, longitude, 0.0, 47.0, 8.0, 0.0)
    position = frame.to_plane(latitude, longitude, np.zeros(2))
    np.testing.assert_allclose(position[:, :2], np.stack([east, north], -1), atol=1e-6)


def test_the_horizontal_position_does_not_depend_on_altitude():
    frame = LocalFrame(47.0, 8.0)
    low, high = frame.to_plane(np.full(2, 49.0), np.full(2, 9.0), np.array([0.0, 12_000.0]))
    assert low[:2].tolist() == high[:2].tolist()
    assert (low[2], high[2]) == (0.0, 12_000.0)


def test_two_dimensional_positions_lie_on_the_ellipsoid():
    latitude, longitude, altitude = LocalFrame(47.0, 8.0).to_geodetic(np.array([[3e5, 4e5]]))
    _, _, up = pymap3d.geodetic2enu(latitude, longitude, altitude, 47.0, 8.0, 0.0)
    assert altitude.tolist() == [0.0]
    assert up[0] == pytest.approx(-(5e5**2) / 2 / 6.37e6, rel=0.01)


def test_a_position_beyond_the_horizon_is_still_finite():
    assert np.isfinite(LocalFrame(0.0, 0.0).to_geodetic(np.array([[1e9, -1e9, 5.0]]))).all()


def test_takes_no_positions():
    assert all(part.shape == (0,) for part in LocalFrame(0.0, 0.0).to_geodetic(np.empty((0, 2))))


def test_the_stereographic_plane_is_that_of_the_textbook():
    # Snyder 1987, page 313, on the ellipsoid of Clarke (1866) and with a scale of 0.9999.
    x, y = LocalFrame(40.0, -100.0, "stereographic").to_plane(
        np.array([30.0]), np.array([-90.0]), np.zeros(1)
    )[0, :2]
    scale = 0.9999 * 6_378_206.4 / 6_378_137.0
    assert (scale * x, scale * y) == pytest.approx((971_630.8, -1_063_049.3), abs=60.0)


@pytest.mark.parametrize("projection", ["tangent", "stereographic"])
def test_only_the_stereographic_plane_is_true_to_angles(projection):
    frame = LocalFrame(50.0, 10.0, projection)
    north, east, _ = pymap3d.enu2geodetic(
        np.array([0.0, 10.0, 0.0]), np.array([10.0, 0.0, 0.0]), 0.0, 57.0, 22.0, 0.0
    )
    there = frame.to_plane(north, east, np.zeros(3))[:, :2]
    up, right = there[0] - there[2], there[1] - there[2]
    cosine = up @ right / np.linalg.norm(up) / np.linalg.norm(right)
    is_true = abs(cosine) < 1e-4 and abs(np.linalg.norm(up) / np.linalg.norm(right) - 1) < 1e-4
    assert is_true == (projection == "stereographic")


def test_a_stereographic_plane_may_touch_at_a_pole():
    frame = LocalFrame(90.0, 0.0, "stereographic")
    position = frame.to_plane(np.array([80.0]), np.array([90.0]), np.zeros(1))
    assert position[0, :2] == pytest.approx([1.12e6, 0.0], rel=1e-2, abs=200.0)
