"""Ranges and directions are brought onto the tracking plane."""

import numpy as np
import pymap3d
import pytest

from trackweave.domain.frames import LocalFrame
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.reports import ReportTable
from trackweave.run.polar_to_cartesian import laid

NAN = np.nan


def table(kind: Kind, measurement: list[list[float]], dim: int = 2, **columns) -> ReportTable:
    n = len(measurement)
    return ReportTable(
        time=np.arange(n, dtype=float),
        sensor=np.zeros(n, np.int64),
        sensors=("A",),
        measurement=np.array(measurement, float),
        sigma=np.full((n, len(measurement[0])), NAN),
        report=np.arange(n).astype(str).astype(object),
        kinds=(kind,),
        space=dim,
        **columns,
    )


def test_a_slant_range_with_a_height_becomes_a_distance_on_the_ground():
    reports = table(
        Kind.RANGE_AZIMUTH_RATE,
        [[5000.0, 1.0, -40.0], [5000.0, 1.0, -40.0]],
        height=np.array([3100.0, NAN]),
    )
    flat, notes = laid(reports, {"A": (0.0, 0.0, 100.0)})
    np.testing.assert_allclose(flat.measurement, [[4000.0, 1.0, -50.0], [5000.0, 1.0, -40.0]])
    assert notes == [
        "sensor A: 1 of 2 rows have no height (height_m); their ranges are taken for "
        "distances on the ground; an object that tells its height at times jumps by 1077 m "
        "(median) between both: leave height_m out where many do"
    ]


def test_without_heights_ranges_are_taken_for_distances_and_a_note_says_so():
    reports = table(Kind.RANGE_AZIMUTH, [[5000.0, 1.0]])
    flat, (note,) = laid(reports, {})
    np.testing.assert_array_equal(flat.measurement, reports.measurement)
    assert note.startswith("sensor A: no height_m, so that its ranges are taken")


def test_heights_in_feet_are_noted():
    reports = table(
        Kind.RANGE_AZIMUTH, [[9000.0, 1.0], [60e3, 1.0]], height=np.array([33000.0, 35000.0])
    )
    flat, notes = laid(reports, {})
    assert "look like feet" in notes[0]
    assert "1 of 2 rows have a height_m beyond their range" in notes[1]
    assert np.all(flat.measurement[:, 0] > 0)


@pytest.mark.parametrize("projection", ["tangent", "stereographic"])
@pytest.mark.parametrize(
    ("kind", "dim"), [(Kind.RANGE_AZIMUTH, 2), (Kind.RANGE_AZIMUTH_ELEVATION, 3)]
)
def test_on_the_earth_a_radar_puts_an_aircraft_where_it_is(kind: Kind, dim: int, projection: str):
    frame = LocalFrame(47.0, 8.0, projection)
    radar, aircraft = (49.0, 11.0, 300.0), (49.9, 12.4, 11_000.0)
    azimuth, elevation, slant = pymap3d.geodetic2aer(*aircraft, *radar)
    measured = [slant, np.radians(azimuth), np.radians(elevation)]
    reports = table(kind, [measured[:dim]], dim, frame=frame, height=np.array([aircraft[2]]))
    place = frame.to_plane(*(np.array([part]) for part in radar))[0]
    flat, _ = laid(reports, {"A": tuple(place)})
    truth = frame.to_plane(*(np.array([part]) for part in aircraft))[0]
    distance, direction = flat.measurement[0, :2]
    if dim == 3:
        angle = flat.measurement[0, 2]
        assert place[2] + distance * np.sin(angle) == pytest.approx(truth[2], abs=0.1)
        distance *= np.cos(angle)
    found = place[:2] + distance * np.array([np.sin(direction), np.cos(direction)])
    np.testing.assert_allclose(found, truth[:2], atol=0.1 if dim == 3 else 20.0)


def test_on_the_earth_a_bearing_counts_from_the_planes_north():
    frame = LocalFrame(47.0, 8.0, "stereographic")
    camera, ship = (54.0, 12.0, 0.0), (54.05, 12.1, 0.0)
    azimuth, _, _ = pymap3d.geodetic2aer(*ship, *camera)
    reports = table(Kind.BEARING, [[np.radians(azimuth)]], frame=frame)
    here, there = (
        frame.to_plane(*(np.array([part]) for part in who))[0] for who in (camera, ship)
    )
    flat, _ = laid(reports, {"A": tuple(here)})
    east, north = (there - here)[:2]
    assert flat.measurement[0, 0] == pytest.approx(np.arctan2(east, north), abs=1e-4)
    assert abs(flat.measurement[0, 0] - np.radians(azimuth)) > 0.03
