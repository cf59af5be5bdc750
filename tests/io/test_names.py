"""Columns that others call otherwise are understood, and said."""

import json

import polars as pl
import pytest

import trackweave as tw
from trackweave.errors import DataFormatError


@pytest.mark.parametrize("time", ["t", "frame", "timestamp", "Timestamp", "datetime", "FRAME"])
def test_times_by_other_names_are_understood_and_said(time):
    reports = tw.read_reports(pl.DataFrame({time: [0.0, 1.0], "x": [1, 2], "y": [3, 4]}))
    assert reports.time.tolist() == [0.0, 1.0]
    assert f"column {time}: taken for time, for there is no column time" in reports.notes


def test_places_by_other_names_are_understood_and_said():
    table = pl.DataFrame({"time": [0.0], "Latitude": [47.0], "LNG": [8.0]})
    reports = tw.read_reports(table)
    assert reports.frame is not None
    assert len(reports.notes) == 2
    particles = pl.DataFrame({"frame": [0], "position_x": [3.0], "POSITION_Y": [4.0]})
    assert tw.read_reports(particles).measurement.tolist() == [[3.0, 4.0]]


def test_a_message_calls_a_column_as_the_table_does():
    table = pl.DataFrame({"time": [0.0, 1.0], "Latitude": [47.0, 99.0], "lon": [8.0, 8.0]})
    with pytest.raises(DataFormatError, match=r"row 2, column Latitude: 99\.0"):
        tw.read_reports(table)


def test_our_own_name_goes_before_those_of_others():
    table = pl.DataFrame({"time": [5.0], "frame": [1], "x": [1], "y": [3], "latitude": [1]})
    reports = tw.read_reports(table.with_columns(lon=pl.lit(2.0)))
    assert reports.time.tolist() == [5.0]
    assert "frame" in reports.carried


def test_heights_that_are_all_0_are_none():
    table = {"time": [0.0, 1.0], "x": [1, 2], "y": [3, 4]}
    flat = tw.read_reports(pl.DataFrame({**table, "z": [0.0, 0.0]}))
    assert (flat.dim, flat.notes) == (2, ("z is 0 in every row: tracking is in two dimensions",))
    assert tw.read_reports(pl.DataFrame({**table, "z": [0.0, 1.0]})).dim == 3


def test_our_names_in_large_letters_are_understood_and_said():
    table = {"Time": [0.0, 1.0], "SENSOR": ["a", "b"], "X": [1, 2], "y": [3, 4], "Sigma_X": [5, 5]}
    reports = tw.read_reports(pl.DataFrame({**table, "sigma_y": [5, 5], "Target": ["q", "q"]}))
    assert reports.sensors == ("a", "b")
    assert reports.sigma.tolist() == [[5.0, 5.0]] * 2
    assert reports.carried["target"].tolist() == ["q", "q"]
    assert "column SENSOR: taken for sensor, for there is no column sensor" in reports.notes
    assert len(reports.notes) == 5
    places = pl.DataFrame({"Time": [0.0], "Lat": [47.0], "LON": [8.0], "Timestamp": [7.0]})
    assert tw.read_reports(places).time.tolist() == [0.0]


def test_a_name_in_large_letters_beside_ours_passes_through():
    table = pl.DataFrame({"time": [0.0], "Time": [9.0], "x": [1], "y": [3]})
    reports = tw.read_reports(table)
    assert reports.time.tolist() == [0.0]
    assert "Time" in reports.carried


def test_two_names_that_differ_in_letters_alone_are_refused():
    table = pl.DataFrame({"Time": [0.0], "TIME": [9.0], "x": [1], "y": [3]})
    with pytest.raises(
        DataFormatError, match="columns Time and TIME: both are time; expected one"
    ):
        tw.read_reports(table)


def test_which_of_two_positions_counts_is_said():
    both = {"time": [0.0, 1.0], "x": [1, 2], "y": [3, 4], "lat": [47.0] * 2, "lon": [8.0] * 2}
    told = (
        "x, y: used as positions, and lat, lon beside them are not; [frame] origin takes lat, lon"
    )
    plane = tw.read_reports(pl.DataFrame(both))
    assert (plane.notes, plane.frame) == ((told,), None)
    earth = tw.read_reports(pl.DataFrame(both), frame_origin=(47.0, 8.0))
    assert earth.frame is not None
    assert earth.notes[0].startswith("lat, lon: used as positions, and x, y beside them are not; ")
    empty = tw.read_reports(pl.DataFrame({**both, "lat": [None, None]}, strict=False))
    assert empty.notes == ()


def test_scans_that_are_one_throughout_are_left_out_and_said():
    table = {"time": [0.0, 1.0, 2.0], "x": [1, 2, 3], "y": [3, 4, 5], "scan": [7, 7, 7]}
    reports = tw.read_reports(pl.DataFrame(table))
    assert reports.scan is None
    assert [scan.time for scan in reports.scans()] == [0.0, 1.0, 2.0]
    assert any(note.startswith("column scan: 7 in every row") for note in reports.notes)
    two = tw.read_reports(pl.DataFrame({**table, "scan": [7, 7, 8]}))
    assert (two.scan is None, two.notes) == (False, ())
    one = tw.read_reports(pl.DataFrame({**table, "time": [0.0, 0.0, 0.1]}))
    assert (one.scan is None, one.notes) == (False, ())


def test_a_name_that_stands_twice_in_a_data_frame_is_named():
    pd = pytest.importorskip("pandas")
    table = pd.DataFrame([[0, 1, 2, 3]], columns=["time", "x", "y", "x"])
    with pytest.raises(
        DataFormatError, match=r"^table, column x: twice; expected each name once$"
    ):
        tw.read_reports(table)


def test_tabs_may_part_columns(tmp_path):
    path = tmp_path / "a.tsv"
    path.write_text("time\tsensor\tx\ty\n0\ta b\t1\t2\n1\ta b\t\t2\n")
    with pytest.raises(DataFormatError, match=r"a.tsv, row 2, column x: \(empty\)"):
        tw.read_reports(path)
    assert tw.read_reports(path, on_bad_row="skip").sensors == ("a b",)
    path.write_text("time\tx\ty\n0\t1,5,1\t2\n")
    with pytest.raises(DataFormatError, match=r"a.tsv, header: one column .*separated by commas"):
        tw.read_reports(path)


def test_answers_of_opensky_may_be_gathered_in_a_list(tmp_path):
    state = ["3c4591", "BOX", "UK", 10, 10, -0.44, 51.4, 9.0, False, 254.6, 99.6, 0.0, None, 9.0]
    path = tmp_path / "a.json"
    path.write_text(json.dumps([{"time": t, "states": [state]} for t in (11, 12)]))
    assert tw.read_reports(path).time.tolist() == [11.0, 12.0]


def test_the_corners_of_boxes_alone_are_no_positions():
    table = {"frame": [0], "left": [1.0], "top": [2.0], "right": [5.0], "bottom": [9.0]}
    with pytest.raises(
        DataFormatError, match=r"x and y: missing; .* of boxes, give their middle as"
    ):
        tw.read_reports(pl.DataFrame(table))


@pytest.mark.parametrize(
    ("column", "ours", "what"),
    [("Radar", "sensor", "which sensor reports"), ("mmsi", "identity", "whose report it is")],
)
def test_what_seems_to_be_meant_as_a_column_of_ours_is_asked_back(column, ours, what):
    table = pl.DataFrame({"time": [5.0], "x": [1], "y": [3], column: [7]})
    said = f"column {column}: carried along and not read; if it tells {what}, call it {ours}"
    assert said in tw.read_reports(table).notes
    told = table.with_columns(pl.lit("a").alias(ours))
    assert said not in tw.read_reports(told).notes


def test_titles_and_units_under_the_header_are_no_rows(tmp_path):
    path = tmp_path / "spots.csv"
    path.write_text(
        "ID,FRAME,POSITION_X,POSITION_Y\nSpot ID,Frame,X,Y\n,,(micron),(micron)\n"
        "7,0,1.5,2\n8,1,2.5,2\n"
    )
    reports = tw.read_reports(path)
    assert reports.time.tolist() == [0.0, 1.0]
    assert reports.row.tolist() == [3, 4]
    assert "2 more rows of headers under the first left out" in reports.notes


def test_a_first_row_in_which_only_a_number_is_wrong_is_refused(tmp_path):
    path = tmp_path / "reports.csv"
    path.write_text("time,x,y\n0,east,2\n1,2,3\n")
    with pytest.raises(DataFormatError, match="row 1, column x: east"):
        tw.read_reports(path)
