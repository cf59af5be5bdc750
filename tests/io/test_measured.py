"""What each row of a table measures, by its filled cells."""

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from trackweave.domain.frames import LocalFrame
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.errors import DataFormatError
from trackweave.formats.reading import read_reports
from trackweave.io.frames_out import reports_frame


def read(text: str, **options):
    lines = [line.split(",") for line in text.split()]
    columns = {
        name: [line[place] or None for line in lines[1:]] for place, name in enumerate(lines[0])
    }
    return read_reports(pl.DataFrame(columns, strict=False), **options)


def test_reads_ranges_and_azimuths_in_radians():
    reports = read("time,range_m,azimuth_deg\n0,1000,90\n1,2000,-90")
    assert reports.kinds == (Kind.RANGE_AZIMUTH,)
    assert reports.dim == 2
    np.testing.assert_allclose(
        reports.measurement, [[1000.0, np.pi / 2], [2000.0, 1.5 * np.pi]], rtol=1e-15
    )


def test_reads_everything_that_a_radar_may_tell():
    reports = read(
        "time,range_m,azimuth_deg,elevation_deg,range_rate_mps,sigma_range_m,sigma_azimuth_deg,"
        "sigma_elevation_deg,sigma_range_rate_mps\n0,1000,10,30,-5,20,0.1,0.2,1"
    )
    assert reports.kinds == (Kind.RANGE_AZIMUTH_ELEVATION_RATE,)
    assert reports.dim == 3
    expected = [1000.0, np.radians(10), np.radians(30), -5.0]
    np.testing.assert_allclose(reports.measurement[0], expected)
    np.testing.assert_allclose(reports.sigma[0], [20.0, np.radians(0.1), np.radians(0.2), 1.0])
    (scan,) = reports.scans()
    assert scan.measurement.shape == (1, 4)


def test_one_file_may_hold_sensors_of_every_kind():
    reports = read(
        "time,sensor,x,y,range_m,azimuth_deg,bearing_deg,sigma_bearing_deg,sigma_x,sigma_y\n"
        "0,camera,,,,,350,0.5,,\n0,lidar,1,2,,,,,3,4\n0,radar,,,100,180,,,,"
    )
    assert reports.sensors == ("camera", "lidar", "radar")
    assert reports.kinds == (Kind.BEARING, Kind.POSITION, Kind.RANGE_AZIMUTH)
    nan = np.nan
    np.testing.assert_allclose(
        reports.measurement, [[np.radians(350), nan], [1.0, 2.0], [100.0, np.pi]]
    )
    np.testing.assert_allclose(reports.sigma, [[np.radians(0.5), nan], [3.0, 4.0], [nan, nan]])
    assert [scan.measurement.shape[1] for scan in reports.scans()] == [1, 2, 2]


def test_a_position_counts_before_what_else_a_row_holds():
    reports = read("time,x,y,bearing_deg\n0,1,2,30\n1,2,3,40")
    assert reports.kinds == ()
    assert reports.carried["bearing_deg"].to_list() == ["30", "40"]


def test_heights_need_every_sensor():
    rows = "time,sensor,x,y,z,range_m,azimuth_deg,elevation_deg,range_rate_mps\n0,a,1,2,3,,,,\n"
    solid = read(rows + "0,b,,,,1000,0,60,-4")
    assert (solid.dim, solid.measurement.shape) == (3, (2, 4))
    flat = read(rows + "0,b,,,,1000,0,60,-4\n0,c,,,,1000,0,,")
    assert flat.dim == 2
    assert flat.kinds == (Kind.POSITION, Kind.RANGE_AZIMUTH_RATE, Kind.RANGE_AZIMUTH)
    np.testing.assert_allclose(flat.measurement[1], [500.0, 0.0, -8.0], atol=1e-9)
    assert len(flat.notes) == 2
    assert "heights of positions are not used" in flat.notes[0]
    assert "sensor b: its ranges become distances on the ground" in flat.notes[1]


def test_bearings_do_not_take_the_third_dimension_away():
    assert read("time,sensor,x,y,z,bearing_deg\n0,a,1,2,3,\n0,b,,,,9").dim == 3


def test_a_rate_that_some_rows_lack_is_not_used_and_noted():
    reports = read("time,range_m,azimuth_deg,range_rate_mps\n0,9,9,9\n1,9,9,")
    assert reports.kinds == (Kind.RANGE_AZIMUTH,)
    (note,) = reports.notes
    assert note.startswith("sensor default: range_rate_mps is not used")


def test_an_elevation_beside_a_bearing_is_said_to_be_of_no_use():
    with_it = read("time,sensor_x,sensor_y,bearing_deg,elevation_deg\n0,0,0,10,3\n1,0,0,11,4")
    assert any("elevations beside bearings" in note for note in with_it.notes)
    assert not read("time,sensor_x,sensor_y,bearing_deg\n0,0,0,10\n1,0,0,11").notes


def test_headings_turn_azimuths_and_bearings():
    reports = read(
        "time,sensor,range_m,azimuth_deg,bearing_deg,sensor_heading_deg\n"
        "0,a,9,350,,20\n0,b,,,10,-30"
    )
    np.testing.assert_allclose(reports.measurement[0, 1], np.radians(10))
    np.testing.assert_allclose(reports.measurement[1, 0], np.radians(340))


def test_a_moving_sensor_tells_where_it_was():
    reports = read("time,bearing_deg,sensor_x,sensor_y,sensor_vx\n0,9,1,2,3\n1,9,4,5,\n2,9,,,")
    nan = np.nan
    np.testing.assert_array_equal(
        reports.platform, [[1, 2, 0, 3, 0, 0], [4, 5, 0, 0, 0, 0], [nan] * 6]
    )


def test_sensors_on_the_earth_lie_on_the_plane_of_the_reports():
    reports = read(
        "time,sensor,lat,lon,bearing_deg,sensor_lat,sensor_lon,sensor_alt_m\n"
        "0,a,47,8,,,,\n0,b,,,9,47.1,8,30"
    )
    assert reports.frame == LocalFrame(47.0, 8.0)
    assert reports.platform[1, :3] == pytest.approx([0.0, 11_117.0, 30.0], abs=1.0)
    alone = read("time,bearing_deg,sensor_lat,sensor_lon\n0,9,47.1,8")
    assert alone.frame == LocalFrame(47.1, 8.0)
    assert alone.platform[0, :3] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)


def test_reads_identity_strength_and_height_and_still_carries_them():
    reports = read("time,x,y,identity,strength,height_m\n0,1,2,4CA2,30,\n1,1,2,,,1000\n2,1,2,3,,")
    assert reports.identities == ("3", "4CA2")
    assert reports.identity.tolist() == [1, -1, 0]
    np.testing.assert_array_equal(reports.strength, [30.0, np.nan, np.nan])
    np.testing.assert_array_equal(reports.height, [np.nan, 1000.0, np.nan])
    assert list(reports.carried) == ["identity", "strength", "height_m"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "time,range_m,azimuth_deg\n0,9,400",
            "row 1, column azimuth_deg: 400; expected a number from -180 to 360",
        ),
        (
            "time,bearing_deg\n0,9\n1,-200",
            "row 2, column bearing_deg: -200; expected a number from -180 to 360",
        ),
        ("time,range_m,azimuth_deg\n0,-1,4", "row 1, column range_m: -1; expected a number from"),
        ("time,range_m,azimuth_deg\n0,,4", "row 1, column range_m: (empty); expected a finite"),
        ("time,range_m,azimuth_deg\n0,9,x", "row 1, column azimuth_deg: x; expected a finite"),
        (
            "time,range_m,azimuth_deg,elevation_deg\n0,9,9,91",
            "row 1, column elevation_deg: 91; expected a number from -90 to 90",
        ),
        ("time,range_m\n0,9", "column azimuth_deg: missing; expected an azimuth [degrees] beside"),
        ("time,azimuth_deg\n0,9", "column range_m: missing; expected a range [m] beside"),
        (
            "time,bearing_deg,sigma_bearing_deg\n0,9,0",
            "row 1, column sigma_bearing_deg: 0; expected a positive number",
        ),
        (
            "time,range_m,azimuth_deg,sigma_range_m\n0,9,9,-3",
            "row 1, column sigma_range_m: -3; expected a positive number",
        ),
        (
            "time,x,y,bearing_deg\n0,1,2,\n0,,,3",
            "row 2, column bearing_deg: 3; expected a position, as in the rows of sensor default",
        ),
        (
            "time,sensor,range_m,azimuth_deg,bearing_deg\n0,a,,,1\n0,a,1,2,",
            "row 2, column range_m: 1; expected a bearing, as in the rows of sensor a before",
        ),
        (
            "time,range_m,azimuth_deg,bearing_deg\n0,1,1,\n0,,,",
            "row 2, column range_m: (empty); expected a measurement: a position, a range",
        ),
        (
            "time,bearing_deg,sensor_heading_deg\n0,1,5\n0,1,",
            "row 2, column sensor_heading_deg: (empty); expected a number, as in other rows",
        ),
        ("time,bearing_deg,sensor_x\n0,1,5", "column sensor_y: missing; expected where"),
        (
            "time,bearing_deg,sensor_x,sensor_y\n0,1,5,",
            "row 1, column sensor_y: (empty); expected a finite number",
        ),
        (
            "time,sensor,x,y,bearing_deg,sensor_lat,sensor_lon\n0,a,1,5,,,\n0,b,,,1,5,5",
            "column sensor_lat: beside x and y; expected sensor_x,sensor_y, or reports in lat,lon",
        ),
        ("time,x,y,strength\n0,1,2,loud", "row 1, column strength: loud; expected a finite"),
    ],
)
def test_says_what_is_wrong(text, message):
    with pytest.raises(DataFormatError) as caught:
        read(text)
    assert str(caught.value).startswith(f"table, {message}")


def test_bad_rows_of_any_kind_can_be_skipped():
    text = "time,sensor,range_m,azimuth_deg,bearing_deg\n0,a,9,9,\n1,a,,,4\n2,b,,,999\n3,b,,,9"
    reports = read(text, on_bad_row="skip")
    assert [bad.row for bad in reports.skipped] == [2, 3]
    assert reports.kinds == (Kind.RANGE_AZIMUTH, Kind.BEARING)


@pytest.mark.parametrize(
    "text",
    [
        "time,sensor,x,y,range_m,azimuth_deg,range_rate_mps,sigma_azimuth_deg,bearing_deg\n"
        "0,a,1,2,,,,,\n0,b,,,9,8,-7,6,\n0,c,,,,,,,5",
        "time,range_m,azimuth_deg,elevation_deg,identity\n0,9,8,7,abc\n1,9,8,7,",
        "time,bearing_deg,sensor_x,sensor_y,sensor_z,sensor_vx,sensor_vy,sensor_vz\n"
        "0,9,1,2,3,4,5,6",
        "time,sensor,lat,lon,alt_m,bearing_deg,sensor_lat,sensor_lon,sensor_alt_m\n"
        "0,a,47,8,30,,,,\n0,b,,,,9,47.1,8,30",
    ],
)
def test_written_reports_are_read_back(text):
    reports = read(text)
    origin = reports.frame and (reports.frame.latitude_deg, reports.frame.longitude_deg)
    again = read_reports(reports_frame(replace(reports, carried={})), frame_origin=origin)
    assert again.kinds == reports.kinds
    np.testing.assert_allclose(again.measurement, reports.measurement, atol=1e-6)
    np.testing.assert_allclose(again.sigma, reports.sigma)
    if reports.platform is not None:
        np.testing.assert_allclose(again.platform, reports.platform, atol=1e-6)


def test_a_wide_area_is_laid_on_a_stereographic_plane():
    text = "time,lat,lon\n0,47,8\n0,49,8\n0,200,8"
    wide = read(text, frame_projection="stereographic", on_bad_row="skip")
    assert wide.frame == LocalFrame(48.0, 8.0, "stereographic")
    given = read(text, frame_projection="stereographic", frame_origin=(47, 8), on_bad_row="skip")
    assert given.frame == LocalFrame(47.0, 8.0, "stereographic")
    assert (
        given.measurement[1, 1]
        > read(text, frame_origin=(47, 8), on_bad_row="skip").measurement[1, 1]
    )


def test_flight_levels_are_heights_where_nothing_else_tells_any():
    text = "time,range_m,azimuth_deg,flight_level\n0,9000,1,100\n1,9000,2,\n2,9000,3,ground\n"
    reports = read(text)
    assert reports.height is not None
    np.testing.assert_allclose(reports.height, [3048.0, np.nan, np.nan])
    assert list(reports.carried) == ["flight_level"]
    (note,) = [note for note in reports.notes if "flight_level" in note]
    assert "hundreds of feet" in note


def test_flight_levels_give_way_to_heights_and_say_nothing_of_positions():
    both = read("time,range_m,azimuth_deg,flight_level,height_m\n0,9000,1,100,2500\n")
    assert both.height.tolist() == [2500.0]
    for text in ("time,x,y,flight_level\n0,1,2,100\n", "time,lat,lon,flight_level\n0,1,2,100\n"):
        reports = read(text)
        assert reports.height is None
        assert not any("flight_level" in note for note in reports.notes)
