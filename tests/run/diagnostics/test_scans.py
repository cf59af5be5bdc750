"""What is said where lone reports are those of a turning beam."""

import numpy as np
import polars as pl
import pytest

from trackweave import track

pytestmark = pytest.mark.slow


def passes(east: float = 0.0) -> pl.DataFrame:
    """Return what a beam of four seconds a turn, at ``east``, sees of eight standing objects."""
    rng = np.random.default_rng(1)
    azimuth = np.tile([0.1, 0.6, 1.9, 2.3, 3.6, 4.1, 5.3, 5.9], 40)
    distance = np.tile(np.linspace(3e3, 9e3, 8), 40)
    time = 4.0 * (np.repeat(np.arange(40), 8) + azimuth / (2 * np.pi))
    x, y = east + distance * np.sin(azimuth), distance * np.cos(azimuth)
    noise = rng.normal(0, 20.0, (2, x.size))
    return pl.DataFrame({"time": time, "x": x + noise[0], "y": y + noise[1]}).sort("time")


@pytest.mark.parametrize("told", [{}, {"rotation": "clockwise", "scan_period": 4.0}])
def test_a_beam_that_turns_elsewhere_is_placed_there(told: dict) -> None:
    run = track(passes(40e3), {"sensors": {"default": told}}).run
    place = run["configuration"]["sensors"]["default"]["position"]
    assert np.hypot(place[0] - 40e3, place[1]) < 50.0
    assert run["diagnostics"] == []


def test_names_a_turn_of_which_is_told_that_there_is_none() -> None:
    run = track(passes(), {"sensors": {"default": {"rotation": "none"}}}).run
    assert run["diagnostics"][0]["cause"] == "turn"
    assert 'leave rotation = "none" out' in run["diagnostics"][0]["sentence"]


def test_says_nothing_of_a_turn_that_is_followed() -> None:
    assert track(passes()).run["diagnostics"] == []


def test_names_scans_where_objects_that_report_by_themselves_are_told_to_be_scanned() -> None:
    rng = np.random.default_rng(1)
    rows = []
    for number in range(8):
        heading, pause = rng.uniform(0, 2 * np.pi), rng.choice([7.0, 10.0, 30.0])
        for time in np.arange(rng.uniform(0, pause), 600.0, pause):
            seen = 900.0 * number + 5.0 * time * np.array([np.cos(heading), np.sin(heading)])
            rows.append((np.floor(time), *(seen + rng.normal(0, 8.0, 2)).tolist()))
    reports = pl.DataFrame(rows, schema=["time", "x", "y"], orient="row").sort("time")
    told = {"sensors": {"default": {"sigma": 8.0, "scans": True}}}
    first = track(reports, told).run["diagnostics"][0]
    assert first["cause"] == "scans"
    assert "give scans = false" in first["sentence"]


def test_false_alarms_beside_good_tracks_are_no_question() -> None:
    rng = np.random.default_rng(1)
    time = np.repeat(np.arange(60.0), 5)
    way = np.stack([10.0 * time, np.tile(np.arange(5) * 400.0, 60)], axis=1)
    false = np.column_stack([rng.uniform(-200, 1800, (480, 2))])
    place = np.concatenate([way + rng.normal(0, 5.0, way.shape), false])
    times = np.concatenate([time, np.repeat(np.arange(60.0), 8)])
    reports = pl.DataFrame({"time": times, "x": place[:, 0], "y": place[:, 1]}).sort("time")
    result = track(reports)
    assert result.assignments["track"].count() < 0.5 * len(reports)
    assert result.run["diagnostics"] == []
