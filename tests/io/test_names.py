"""Columns that others call otherwise are understood, and said."""

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
