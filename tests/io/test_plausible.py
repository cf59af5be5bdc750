"""What looks like another unit is asked back with the column's name, and never converted."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.errors import DataFormatError

N = 30


def refusal(table: dict) -> str:
    with pytest.raises(DataFormatError) as caught:
        tw.read_reports(pl.DataFrame(table))
    return str(caught.value)


@pytest.mark.parametrize(
    ("factor", "unit"), [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")]
)
def test_times_in_finer_units_are_asked_back(factor, unit):
    time = [1.7e9 * factor, 1.7e9 * factor + factor]
    told = refusal({"timestamp": time, "x": [1, 2], "y": [1, 2]})
    assert "column timestamp: " in told
    assert told.endswith(f"expected seconds; these look like {unit} from 1970")


def test_swapped_latitudes_and_longitudes_are_asked_back():
    told = refusal({"time": [0.0, 1.0], "lat": [120.5, 120.6], "lon": [30.1, 30.2]})
    assert told.endswith(
        "column lat: 120.5; expected latitudes from -90 to 90; lat and lon look swapped"
    )


def test_angles_that_may_be_radians_are_asked_about_and_kept():
    reports = tw.read_reports(
        pl.DataFrame({"time": np.arange(N) * 1.0, "lat": [0.82] * N, "lon": [0.14] * N})
    )
    assert any("are they radians?" in note for note in reports.notes)
    assert reports.frame.latitude_deg == 0.82


def test_ranges_shorter_than_heights_are_asked_about():
    table = {
        "time": np.arange(N) * 1.0, "range_m": [80.0] * N, "azimuth_deg": [10.0] * N,
        "height_m": [9000.0] * N,
    }  # fmt: skip
    assert any("are they kilometres?" in n for n in tw.read_reports(pl.DataFrame(table)).notes)


def test_a_column_of_another_unit_is_named():
    told = refusal({"time": [0.0], "range_km": [80.0], "azimuth_deg": [10.0]})
    assert "only range_km, which may be of another unit" in told
    assert "column time: only time_ms, which may be of another unit" in refusal(
        {"time_ms": [0.0], "x": [1.0], "y": [2.0]}
    )


def polar(azimuth, far=8000.0, **further):
    table = {"time": np.arange(80) * 1.0, "range_m": np.full(80, far), "azimuth_deg": azimuth}
    return tw.read_reports(pl.DataFrame({**table, **further})).notes


def test_directions_within_a_turn_of_radians_are_asked_about_and_kept():
    (asked,) = [note for note in polar(np.linspace(0.4, 1.9, 80)) if "radians" in note]
    assert (
        asked == "azimuth_deg: all from 0.4 to 1.9; are they radians? They are taken for degrees"
    )
    table = {"time": np.arange(80) * 1.0, "bearing_deg": np.linspace(-3.0, 3.0, 80)}
    notes = tw.read_reports(pl.DataFrame(table)).notes
    assert any(note.startswith("bearing_deg: all from -3 to 3; are they") for note in notes)


@pytest.mark.parametrize(
    ("first", "last"), [(0.4, 1.2), (0.0, 40.0), (-30.0, 30.0), (355.0, 359.0)]
)
def test_directions_of_a_beam_or_a_sector_are_not_asked_about(first, last):
    assert not [note for note in polar(np.linspace(first, last, 80)) if "radians" in note]


@pytest.mark.parametrize(
    ("other", "value", "is_asked"),
    [
        ("sigma_range_m", 120.0, True), ("sigma_range_m", 5.0, False),
        ("range_rate_mps", -220.0, True), ("range_rate_mps", 15.0, False),
        ("speed_mps", 220.0, True), ("speed_mps", 15.0, False),
        ("flight_level", 330.0, True), ("flight_level", 2.0, False),
    ],
)  # fmt: skip
def test_ranges_too_short_beside_what_else_is_told_are_asked_about(other, value, is_asked):
    notes = polar(np.linspace(0.0, 90.0, 80), 80.0, **{other: np.full(80, value)})
    assert any("are they kilometres?" in note for note in notes) == is_asked


@pytest.mark.parametrize(("zones", "count"), [(("Z", ""), 1), (("Z", "Z"), 0), (("", ""), 0)])
def test_times_of_which_some_tell_no_zone_are_asked_about(zones, count):
    time = [f"2024-05-01T00:00:0{k}{zone}" for k, zone in enumerate(zones)]
    reports = tw.read_reports(pl.DataFrame({"time": time, "x": [1.0, 2.0], "y": [1.0, 2.0]}))
    asked = [note for note in reports.notes if "zone" in note]
    assert asked == ["time: 1 of 2 tell no zone; they are taken for UTC"] * count
