"""Times in seconds and as ISO 8601."""

from datetime import date, datetime

import numpy as np
import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

import trackweave as tw
from trackweave.io.columns import (
    datetime_column,
    iso_text,
    read_times,
    times_of_day,
    with_common_times,
)

NOON = 1714564800.0  # 2024-05-01T12:00:00Z


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("2024-05-01T12:00:00Z", NOON),
        ("2024-05-01T12:00:00z", NOON),
        ("2024-05-01 12:00", NOON),
        ("2024-05-01T14:00:00+02:00", NOON),
        ("20240501T120000Z", NOON),
        ("2024-05-01T12:00:00.25", NOON + 0.25),
        ("2024-05-01T12:00:00.123456789Z", NOON + 0.123456),
        ("2024-05-01", NOON - 43_200),
        (" 2024-05-01T12:00:00Z ", NOON),
    ],
)
def test_reads_iso_times_as_seconds_from_1970(text, seconds):
    times = read_times(pl.Series([text]))
    assert times.iso
    assert times.numbers.values.tolist() == [seconds]


def test_the_first_cell_decides_how_times_are_written():
    iso = read_times(pl.Series([None, "2024-05-01", "17", "20240501"]))
    assert iso.iso
    assert iso.numbers.unreadable.tolist() == [False, False, True, True]
    seconds = read_times(pl.Series(["17", "2024-05-01"]))
    assert not seconds.iso
    assert seconds.numbers.unreadable.tolist() == [False, True]


@pytest.mark.parametrize("text", ["noon", "2024-13-01", "2024-05-01T12:00:60Z", "1:30"])
def test_does_not_read_what_is_no_time(text):
    times = read_times(pl.Series([text]))
    assert times.numbers.unreadable.tolist() == [True]
    assert times.expected == "seconds or an ISO 8601 time"


def test_reads_times_of_the_day_over_midnight():
    cells = [" 23:59", "23:59:59.5", "0:00:01", "23:59:58", None, "24:00:00", "12:61"]
    times = times_of_day(pl.Series(cells))
    assert not times.iso
    assert times.numbers.values[:4].tolist() == [86340.0, 86399.5, 86401.0, 86398.0]
    assert times.numbers.missing.tolist() == [False] * 4 + [True, False, False]
    assert times.numbers.unreadable.tolist() == [False] * 5 + [True, True]


def test_a_pause_or_sensors_one_below_the_other_are_no_midnight():
    times = times_of_day(pl.Series(["08:00", "22:00", "08:00", "22:30"]))
    assert times.numbers.values.tolist() == [28800.0, 79200.0, 28800.0, 81000.0]


@pytest.mark.parametrize("text", ["noon", "2024-05-01T12:00:00", "12", "1200"])
def test_what_begins_otherwise_is_no_time_of_the_day(text):
    assert times_of_day(pl.Series([text, "12:00"])) is None


@pytest.mark.parametrize("unit", ["ms", "us", "ns"])
@pytest.mark.parametrize("zone", [None, "UTC", "Europe/Berlin"])
def test_reads_types_of_dates(unit, zone):
    column = pl.Series([datetime(2024, 5, 1, 12), None]).dt.cast_time_unit(unit)
    if zone:
        column = column.dt.replace_time_zone("UTC").dt.convert_time_zone(zone)
    times = read_times(column)
    assert times.iso
    assert times.numbers.values[0] == NOON
    assert times.numbers.missing.tolist() == [False, True]


def test_reads_days():
    assert read_times(pl.Series([date(1970, 1, 2)])).numbers.values.tolist() == [86_400.0]


@given(st.lists(st.floats(-6e9, 6e9), min_size=1, max_size=5))
def test_times_come_back_to_the_microsecond(seconds):
    wanted = np.rint(np.array(seconds) * 1e6) / 1e6
    text = iso_text(datetime_column("time", wanted))
    again = read_times(text)
    assert again.iso
    np.testing.assert_allclose(again.numbers.values, wanted, rtol=0, atol=1.1e-6)


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        ([NOON], "2024-05-01T12:00:00Z"),
        ([NOON, NOON + 0.5], "2024-05-01T12:00:00.000Z"),
        ([NOON, NOON + 1e-6], "2024-05-01T12:00:00.000000Z"),
    ],
)
def test_writes_as_many_decimals_as_the_finest_time_needs(seconds, text):
    assert iso_text(datetime_column("time", np.array(seconds)))[0] == text


def test_times_that_differ_by_rounding_are_one():
    scans = np.repeat(np.arange(20) * 6.0, 17)
    jitter = np.random.default_rng(1).uniform(0, 1e-12, scans.size)
    common, notes = with_common_times(scans + jitter)
    assert np.unique(common).size == 20
    assert np.all(np.abs(common - scans) <= 1.1e-12)
    assert len(notes) == 1
    assert notes[0].endswith("count as one; the next are 6 s away")


@pytest.mark.parametrize(
    "time",
    [
        [0.0, 1.0, 2.0],
        [5.0],
        [],
        # Reports one by one, moved by a tenth of a millisecond each.
        (np.repeat(np.arange(30.0), 5) + np.tile(np.arange(5) * 1e-4, 30)).tolist(),
        # A camera of a million pictures a second, twice.
        np.concatenate([np.arange(100) * 1e-6, 100.0 + np.arange(100) * 1e-6]).tolist(),
    ],
)
def test_times_that_differ_by_more_stay(time):
    common, notes = with_common_times(np.array(time))
    assert common.tolist() == time
    assert notes == []


def test_seconds_of_the_day_go_on_after_midnight():
    time = [86_390.0, 86_395.0, 86_394.0, 2.0, 5.0]
    reports = tw.read_reports(pl.DataFrame({"time": time, "x": range(5), "y": [0] * 5}))
    assert reports.time.tolist() == [86_390.0, 86_394.0, 86_395.0, 86_402.0, 86_405.0]
    assert "time: seconds of the day, which go on after midnight" in reports.notes


@pytest.mark.parametrize(
    "time",
    [
        [0.0, 43_000.0, 86_399.0, 0.0, 43_000.0, 86_399.0],  # a day of one sensor, then of another
        [86_390.0, 2.0, 50_000.0, 30_000.0, 40_000.0, 1.0],  # in no order
        [100_000.0, 5.0, 6.0, 7.0, 8.0, 9.0],  # no seconds of a day
    ],
)
def test_other_times_are_sorted_and_nothing_more(time):
    reports = tw.read_reports(pl.DataFrame({"time": time, "x": range(6), "y": [0] * 6}))
    assert reports.time.tolist() == sorted(time)


def _falling(fall: float, *, times: int = 1) -> list[str]:
    """Return what is said of times that fall back so far, so often."""
    time, now = [], 0.0
    for row in range(60):
        now += 4.0
        if row % (60 // (times + 1)) == 0 and 0 < row < 60 - times:
            now -= fall
        time.append(now)
    table = pl.DataFrame({"time": time, "x": np.arange(60.0), "y": np.arange(60.0)})
    return [note for note in tw.read_reports(table).notes if "before the row above" in note]


@pytest.mark.parametrize(("fall", "times", "count"), [(3600.0, 1, 1), (8.0, 1, 0), (900.0, 9, 0)])
def test_a_clock_that_is_set_back_is_told_and_rows_in_no_order_are_not(fall, times, count):
    notes = _falling(fall, times=times)
    assert len(notes) == count
    assert all("row 31 is 3596 s before" in note for note in notes)


def test_a_file_of_tracks_is_asked_about():
    table = {"time": [0.0, 1.0], "x": [1.0, 2.0], "y": [1.0, 2.0], "track": [1, 1]}
    asked = tw.read_reports(pl.DataFrame({**table, "status": ["confirmed"] * 2})).notes
    assert any("looks like a file of tracks" in note for note in asked)
    assert not tw.read_reports(pl.DataFrame(table)).notes
