"""Reports that tell a position are placed on the plane."""

import numpy as np
import pytest

from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.reports import ReportTable
from trackweave.models.rotation import Rotation
from trackweave.run.polar_to_cartesian import in_turns, placed, platforms_of

NAN = np.nan


def mixed() -> ReportTable:
    return ReportTable(
        time=np.arange(4.0),
        sensor=np.array([1, 0, 2, 1]),
        sensors=("camera", "radar", "lidar"),
        measurement=np.array([[10.0, np.pi / 2], [1.0, NAN], [3.0, 4.0], [20.0, 0.0]]),
        sigma=np.array([[1.0, 0.1], [0.1, NAN], [0.5, 0.6], [NAN, NAN]]),
        report=np.array(["a", "b", "c", "d"], dtype=object),
        kinds=(Kind.BEARING, Kind.RANGE_AZIMUTH, Kind.POSITION),
        space=2,
        platform=np.array([[100.0, 0, 0, 0, 0, 0], *[[NAN] * 6] * 3]),
        identity=np.array([0, 1, 2, 3]),
        identities=("p", "q", "r", "s"),
    )


def test_ranges_and_azimuths_become_positions_and_bearings_are_left_out():
    table = placed(mixed(), {"radar": (0.0, 5.0)})
    assert table.sensors == ("radar", "lidar")
    assert table.sensor.tolist() == [0, 1, 0]
    expected = [[110.0, 0.0], [3.0, 4.0], [0.0, 25.0]]
    np.testing.assert_allclose(table.measurement, expected, atol=1e-12)
    np.testing.assert_array_equal(table.sigma, [[NAN, NAN], [0.5, 0.6], [NAN, NAN]])
    assert table.report.tolist() == ["a", "c", "d"]
    assert table.identity.tolist() == [0, 2, 3]
    assert (table.kinds, table.dim) == ((), 2)


def test_positions_are_placed_already():
    table = placed(mixed())
    assert placed(table) is table


def test_a_row_tells_where_its_sensor_was_before_the_configuration_does():
    platform = platforms_of(mixed(), {"radar": (1.0, 2.0, 3.0)})
    assert platform[0, 0] == 100.0
    assert platform[3].tolist() == [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]
    assert platform[2] == pytest.approx(np.zeros(6))


def test_reports_in_turns_have_the_times_of_their_scans():
    table = in_turns(placed(mixed()), {"radar": Rotation(2.0)})
    assert table.report.tolist() == ["a", "c", "d"]
    assert table.time[0] > 0.0
    assert table.time[1] == 2.0
    assert table.time.tolist() == sorted(table.time)
    assert table.scan is not None
    assert in_turns(table, {}) is table
