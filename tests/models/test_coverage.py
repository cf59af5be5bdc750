import numpy as np
import pytest
from matplotlib.path import Path as Outline

from trackweave.errors import InvalidInputError
from trackweave.models._kernels import covered_share, is_covered
from trackweave.models.coverage import FieldOfView, everywhere


def sees(view, x, y):
    return bool(is_covered(float(x), float(y), view.coverage()))


def place(range_m, azimuth_deg):
    """Return the point at a distance and a direction clockwise from north."""
    angle = np.radians(azimuth_deg)
    return range_m * np.sin(angle), range_m * np.cos(angle)


def test_without_bounds_it_sees_everything():
    assert sees(FieldOfView(), 1e9, -1e9)
    assert is_covered(1e9, -1e9, everywhere())


def test_sees_between_its_ranges_only():
    view = FieldOfView(position=(100.0, 0.0), min_range=10.0, max_range=50.0)
    seen = [sees(view, 100.0 + distance, 0.0) for distance in (5.0, 10.0, 30.0, 50.0, 51.0)]
    assert seen == [False, True, True, True, False]


@pytest.mark.parametrize(
    ("sector", "inside", "outside"),
    [
        ((0, 90), (1, 45, 89), (91, 180, 359)),
        ((350, 20), (351, 0, 19), (21, 180, 349)),
        ((-10, 20), (351, 0, 19), (21, 180, 349)),
        ((350, 380), (351, 0, 19), (21, 180, 349)),
        ((90, 270), (91, 180, 269), (0, 89, 271)),
        ((0, 360), (0, 90, 180, 270, 359), ()),
        ((-180, 180), (0, 90, 180, 270, 359), ()),
        ((30, 30), (0, 30, 180, 359), ()),
    ],
)
def test_sectors_turn_clockwise_and_may_pass_north(sector, inside, outside):
    view = FieldOfView(azimuth_deg=sector)
    assert all(sees(view, *place(1000.0, azimuth)) for azimuth in inside)
    assert not any(sees(view, *place(1000.0, azimuth)) for azimuth in outside)


def test_a_polygon_is_seen_inside_only_whatever_its_shape():
    corners = [(0.0, 0.0), (100.0, 10.0), (60.0, 50.0), (110.0, 120.0), (20.0, 90.0)]
    rng = np.random.default_rng(1)
    points = rng.uniform(-20.0, 130.0, size=(2000, 2))
    expected = Outline(corners).contains_points(points)
    for order in (corners, corners[::-1], corners[2:] + corners[:2]):
        view = FieldOfView(polygon=order)
        assert [sees(view, *point) for point in points] == expected.tolist()


def test_a_polygon_and_a_sector_share_what_they_see():
    view = FieldOfView(azimuth_deg=(0, 90), polygon=[(-9, -9), (9, -9), (9, 9), (-9, 9)])
    assert sees(view, 5.0, 5.0)
    assert not sees(view, -5.0, 5.0)
    assert not sees(view, 15.0, 5.0)


def test_the_share_of_a_far_point_is_one_or_nothing():
    coverage = FieldOfView(max_range=1000.0).coverage()
    covariance = np.diag([25.0, 25.0])
    assert covered_share(np.array([100.0, 0.0]), covariance, coverage) == 1.0
    assert covered_share(np.array([2000.0, 0.0]), covariance, coverage) == 0.0
    assert covered_share(np.array([2000.0, 0.0]), covariance, everywhere()) == 1.0


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("width", [3.0, 45.0, 359.0])
def test_the_share_across_an_edge_is_the_true_one_of_what_is_reported(seed, width):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(2, 2)) * 30.0
    azimuth = rng.uniform(0, 360)
    start = azimuth + rng.normal()
    view = FieldOfView(max_range=1000.0, azimuth_deg=(start, start + width))
    blur = np.array([np.radians(rng.uniform(0.0, 2.0)), *rng.uniform(0.0, 20.0, 2)])
    coverage = view.coverage()._replace(blur=blur)
    mean = np.array(place(1000.0 + rng.normal() * 30.0, azimuth))
    samples = rng.multivariate_normal(mean, root @ root.T, size=20_000)
    far = np.hypot(*samples.T) + rng.normal(0.0, blur[1], 20_000)
    turn = np.degrees(np.arctan2(*samples.T) + rng.normal(0.0, blur[0], 20_000))
    turn += np.degrees(rng.normal(0.0, blur[2], 20_000) / np.hypot(*mean))
    true = np.mean((far <= 1000.0) & ((turn - start) % 360.0 <= width))
    # Range and azimuth are taken as independent, which at a corner they need not be.
    assert covered_share(mean, root @ root.T, coverage) == pytest.approx(true, abs=0.2)


def test_sectors_beside_one_another_share_an_object_at_their_border():
    blur = np.array([np.radians(0.15), 15.0, 0.0])
    parts = [
        FieldOfView(azimuth_deg=(start, start + 45)).coverage()._replace(blur=blur)
        for start in (45, 90)
    ]
    covariance = np.diag([25.0, 25.0])
    for azimuth in np.linspace(89.0, 91.0, 21):
        mean = np.array(place(14_000.0, azimuth))
        shares = [covered_share(mean, covariance, part) for part in parts]
        assert sum(shares) == pytest.approx(1.0, abs=1e-4)
        # Two deviations of the report's azimuth beyond the border it is seen all the same.
        if abs(azimuth - 90.0) < 0.3:
            assert min(shares) > 0.02


def test_the_share_has_no_bias_over_many_places():
    rng = np.random.default_rng(5)
    covariance = np.array([[900.0, 300.0], [300.0, 400.0]])
    coverage = FieldOfView(polygon=[(0, -1e4), (1e4, -1e4), (1e4, 1e4), (0, 1e4)]).coverage()
    offsets = rng.uniform(-150.0, 150.0, size=4000)
    shares = [covered_share(np.array([x, 0.0]), covariance, coverage) for x in offsets]
    assert np.mean(shares) == pytest.approx(np.mean(offsets > 0.0), abs=0.02)


def test_the_share_of_a_certain_place_is_one_or_nothing():
    coverage = FieldOfView(max_range=10.0).coverage()
    assert covered_share(np.array([9.0, 0.0]), np.zeros((2, 2)), coverage) == 1.0
    assert covered_share(np.array([11.0, 0.0]), np.zeros((2, 2)), coverage) == 0.0


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"min_range": -1.0}, "0 ≤ min < max"),
        ({"min_range": 5.0, "max_range": 5.0}, "0 ≤ min < max"),
        ({"max_range": np.nan}, "max_range: nan; expected a number"),
        ({"azimuth_deg": (0.0, 1000.0)}, "degrees"),
        ({"azimuth_deg": (np.nan, 90.0)}, "azimuth_deg: .* expected .a finite number"),
        ({"position": (0.0, np.inf)}, "position"),
        ({"position": (0.0, 0.0, 0.0)}, "position"),
        ({"polygon": [(0, 0), (1, 1)]}, "at least 3"),
        ({"polygon": [(0, 0), (1, np.nan), (2, 0)]}, "polygon"),
    ],
)
def test_refuses_a_view_that_is_none(changed, message):
    with pytest.raises(InvalidInputError, match=message):
        FieldOfView(**changed)
