"""A recording is judged by its own order: gaps are no fault, a lone stamp is."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.formats.reading import read_reports
from trackweave.run.doubles import is_lone

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
