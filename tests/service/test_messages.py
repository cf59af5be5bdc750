"""Rows of tracks as objects of JSON."""

import json
import math

import numpy as np
import polars as pl

from oracles.serving import FRAME, tracks_table
from trackweave.service.desk import Picture
from trackweave.service.messages import as_text, full_message, track_messages


def test_a_track_says_where_it_is_and_goes_on_the_earth() -> None:
    table = tracks_table(3).with_columns(
        vx=pl.lit(0.0), vy=pl.Series([1.0, -1.0, 0.0]), sensors=pl.Series([["a"], ["b", "c"], []])
    )
    found = track_messages(table, FRAME)
    assert [each["track"] for each in found] == ["1", "2", "3"]
    assert found[0]["time"] == 1_700_000_000.25
    assert found[0]["covariance"] == [100.0, 0.0, 400.0]
    assert found[1]["sensors"] == ["b", "c"]
    # North of the plane is not quite north where the track is.
    away = [min(each["course_deg"] % 180, 180 - each["course_deg"] % 180) for each in found[:2]]
    assert all(0 < each < 1 for each in away)
    assert [each["speed"] for each in found] == [1.0, 1.0, 0.0]
    assert abs(found[0]["latitude"] - table["lat"][0]) < 1e-8


def test_courses_on_a_plane_are_clockwise_from_north() -> None:
    table = tracks_table(4, is_on_earth=False).with_columns(
        vx=pl.Series([0.0, 1.0, 0.0, -1.0]), vy=pl.Series([1.0, 0.0, -1.0, 0.0])
    )
    assert [each["course_deg"] for each in track_messages(table)] == [0, 90, 180, 270]


def test_what_is_not_known_is_left_out() -> None:
    table = tracks_table(2).with_columns(
        vx=pl.lit(math.nan), p_x_x=pl.lit(math.inf), identity=pl.Series(["abc", None])
    )
    found = track_messages(table, FRAME)
    assert not {"vx", "speed", "course_deg", "covariance"} & set(found[0])
    assert ("identity" in found[0], "identity" in found[1]) == (True, False)
    json.loads(as_text({"tracks": found}))
    assert track_messages(pl.DataFrame()) == []


def test_times_without_dates_are_seconds() -> None:
    table = tracks_table(2, is_on_earth=False).with_columns(time=pl.Series([1.5, 2]))
    assert [each["time"] for each in track_messages(table)] == [1.5, 2.0]
    full = full_message(Picture(2.0, table, None))
    assert (full["time"], full["geographic"]) == (2.0, False)


def test_texts_are_json_whatever_is_in_them() -> None:
    value = {"a": math.nan, "b": [math.inf, {"c": -math.inf}], "d": (1, "\n\u2028")}
    found = json.loads(as_text(value))
    assert found == {"a": None, "b": [None, {"c": None}], "d": [1, "\n\u2028"]}
    assert np.isfinite(json.loads(as_text({"x": 1e308}))["x"])
