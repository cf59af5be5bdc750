"""Tests of how much of what a sensor measures its field of view holds."""

import math

import numpy as np
import pytest

from trackweave.domain.measurements import MeasurementKind
from trackweave.models._kernels import is_covered
from trackweave.models.coverage import FieldOfView, everywhere
from trackweave.models.extent import extent

POSITION, POLAR, BEARING = (
    MeasurementKind.POSITION,
    MeasurementKind.RANGE_AZIMUTH,
    MeasurementKind.BEARING,
)
BAY = ((-40.0, -30.0), (60.0, -20.0), (10.0, 5.0), (70.0, 50.0), (-30.0, 60.0))
"""Not convex, and the sensor at the origin is inside."""


def size(kind, **view):
    return extent(FieldOfView(**view).coverage(), kind)


def test_a_ring_sectors_sizes_are_those_of_the_book():
    view = {"position": (5.0, 7.0), "min_range": 10.0, "max_range": 50.0}
    view |= {"azimuth_deg": (350.0, 20.0)}
    width = math.radians(30.0)
    assert size(POSITION, **view) == pytest.approx(width * (50.0**2 - 10.0**2) / 2)
    assert size(POLAR, **view) == pytest.approx(width * 40.0)
    assert size(BEARING, **view) == pytest.approx(width)


def test_what_has_no_bound_has_no_size_but_directions_always_have():
    for kind in (POSITION, POLAR):
        assert extent(everywhere(), kind) is None
        assert size(kind, azimuth_deg=(0.0, 90.0)) is None
    assert extent(everywhere(), BEARING) == pytest.approx(2 * math.pi)
    assert size(BEARING, azimuth_deg=(0.0, 90.0)) == pytest.approx(math.pi / 2)


def test_a_polygons_area_is_that_of_the_shoelace_wherever_the_sensor_stands():
    corners = np.array(BAY)
    after = np.roll(corners, -1, axis=0)
    area = abs(np.sum(corners[:, 0] * after[:, 1] - corners[:, 1] * after[:, 0])) / 2
    for position in ((0.0, 0.0), (-300.0, 40.0), (10.0, 5.0), (60.0, 10.0)):
        assert size(POSITION, position=position, polygon=BAY) == pytest.approx(area, rel=1e-4)


@pytest.mark.parametrize(
    "view",
    [
        {"polygon": BAY},
        {"polygon": BAY, "min_range": 20.0, "max_range": 45.0},
        {"polygon": BAY, "position": (-90.0, 10.0), "max_range": 120.0},
        {"polygon": BAY, "position": (55.0, 10.0), "azimuth_deg": (200.0, 30.0)},
    ],
)
def test_sizes_are_those_counted_on_a_fine_grid(view):
    coverage = FieldOfView(**view).coverage()
    n_azimuths, n_ranges, reach = 240, 1000, 210.0
    turn, step = 2 * math.pi / n_azimuths, reach / n_ranges
    ranges = (np.arange(n_ranges) + 0.5) * step
    counted = dict.fromkeys((POSITION, POLAR, BEARING), 0.0)
    for azimuth in (np.arange(n_azimuths) + 0.5) * turn:
        east = coverage.position[0] + ranges * math.sin(azimuth)
        north = coverage.position[1] + ranges * math.cos(azimuth)
        seen = np.array([is_covered(*point, coverage) for point in zip(east, north, strict=True)])
        counted[POSITION] += float(ranges @ seen) * step * turn
        counted[POLAR] += float(np.sum(seen)) * step * turn
        counted[BEARING] += float(np.any(seen)) * turn
    for kind, total in counted.items():
        assert extent(coverage, kind) == pytest.approx(total, rel=0.01)
