"""A recording is judged by its own order: gaps are no fault, a lone stamp is."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.formats.reading import read_reports
from trackweave.run.doubles import is_astray, is_lone

DAY = 86_400.0
CONFIG = {
    "motion": {"process_noise": 0.05, "max_speed": 30.0},
    "sensors": {
        "default": {
            "sigma": 5.0,
            "detection_probability": 0.95,
            "clutter_density": 1e-7,
            "scan_period": 1.0,
        }
    },
    "lifecycle": {"new_target_density": 1e-6},
}


def frame(times, **columns):
    times = np.asarray(times, dtype=float)
    rng = np.random.default_rng(1)
    x = 10.0 * (times % 1000.0) + rng.normal(size=times.size)
    return pl.DataFrame({"time": times, "x": x, "y": np.zeros(times.size), **columns})


def lone(times, max_ahead=60.0, **columns):
    table = read_reports(frame(times, **columns))
    return sorted(set(table.time[is_lone(table, max_ahead)].tolist()))


REGULAR = [float(time) for time in range(30)]


@pytest.mark.parametrize("wrong", [DAY, -DAY, 200.0])
def test_a_scan_far_from_all_others_stands_alone(wrong):
    assert lone([*REGULAR, wrong]) == [wrong]
    assert lone([*REGULAR, wrong, *(2 * DAY + time for time in REGULAR)]) == [wrong]


@pytest.mark.parametrize(
    "times",
    [
        [*REGULAR, *(DAY + time for time in REGULAR)],
        [*REGULAR, DAY, DAY + 1.0],
        [600.0 * time for time in range(30)],
        [0.0],
        [0.0, DAY],
        [0.0, 1.0, 2.0, DAY],
        [*REGULAR, 80.0],
    ],
    ids=["hours", "two", "slow", "one", "a pair", "too few", "near"],
)
def test_gaps_are_no_fault(times):
    assert lone(times) == []


def test_a_scan_of_several_times_can_stand_alone():
    times = [*REGULAR, DAY, DAY + 0.2]
    scan = [*range(30), 30, 30]
    assert lone(times, scan=scan) == [DAY, DAY + 0.2]


def test_a_lone_scan_changes_nothing_else_and_is_told():
    plain = tw.track(frame(REGULAR), CONFIG, rng=np.random.default_rng(1))
    table = pl.concat([frame(REGULAR), pl.DataFrame({"time": [-DAY], "x": [0.0], "y": [0.0]})])
    found = tw.track(table, CONFIG, rng=np.random.default_rng(1))
    assert found.tracks.equals(plain.tracks)
    assert found.history.equals(plain.history)
    assert len(found.assignments) == 31
    assert found.assignments.filter(pl.col("time") == -DAY)["track"].to_list() == [None]
    (note,) = [note for note in found.run["notes"] if "stand alone" in note]
    assert "1 reports at -86400 s" in note
    assert not any("stand alone" in note for note in plain.run["notes"])


def scattered(*wild):
    """Two objects over a hundred scans, and positions that are none."""
    rng = np.random.default_rng(2)
    time = np.repeat(np.arange(100.0), 2)
    way = np.array([[9.0, 2.0], [-7.0, 5.0]])[np.arange(200) % 2]
    place = 5e5 + time[:, None] * way + rng.normal(0.0, 8.0, (200, 2))
    place[7 : 7 + len(wild)] = wild
    return pl.DataFrame({"time": time, "x": place[:, 0], "y": place[:, 1]})


@pytest.mark.slow
@pytest.mark.parametrize("wild", [(1e9, 5e5), (0.0, 0.0)])
def test_a_position_from_nowhere_is_set_aside_and_told(wild):
    result = tw.track(scattered(wild))
    assert result.run["configuration"]["sensors"]["default"]["clutter_density"] > 1e-10
    number = result.assignments["track"].to_list()
    assert number[7] is None
    assert len({each for each in number if each is not None}) == 2
    (note,) = [each for each in result.run["notes"] if each.startswith("position: ")]
    assert note.startswith("position: 1 of 200 reports set aside")
    assert f"(report 8 at ({wild[0]:.6g}, {wild[1]:.6g}) m" in note


@pytest.mark.parametrize("share", [0.02, 0.045])
def test_more_from_nowhere_are_set_aside_unless_they_are_an_objects(share):
    reports = scattered((5e5, 5e5))
    rng, number = np.random.default_rng(5), round(share * 200)
    rows = rng.choice(np.arange(20, 180), number, replace=False)
    angle = rng.uniform(0, 2 * np.pi, number)
    wild = 5e5 + 1e5 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    far = np.array([6e5, 6e5]) + 5.0 * reports["time"].to_numpy()[rows, None]
    for place, is_wild in ((wild, True), (far, False)):
        moved = reports.select("x", "y").to_numpy().copy()
        moved[rows] = place
        table = reports.with_columns(x=pl.Series(moved[:, 0]), y=pl.Series(moved[:, 1]))
        found = is_astray(read_reports(table))
        assert np.flatnonzero(found).tolist() == (sorted(rows.tolist()) if is_wild else [])


def test_positions_that_are_many_or_not_that_far_are_of_the_recording():
    assert not is_astray(read_reports(scattered((5.2e5, 5e5)))).any()
    assert not is_astray(read_reports(scattered(*[(0.0, 0.0)] * 3))).any()
    assert not is_astray(read_reports(scattered((1e9, 5e5))[:30])).any()
    still = pl.DataFrame({"time": np.arange(50.0), "x": np.zeros(50), "y": np.zeros(50)})
    assert not is_astray(read_reports(still)).any()
