"""The plain tracker that recordings are compared with does what it says."""

import sys
from pathlib import Path

import numpy as np
import pytest


@pytest.fixture
def benchmarks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(Path(__file__).parents[2] / "benchmarks"), *sys.path])


@pytest.mark.usefixtures("benchmarks")
def test_follows_two_objects_and_confirms_no_single_false_alarm() -> None:
    from nearest_neighbour import Habits, nearest_neighbour

    steps = np.arange(10.0)
    first = np.column_stack([steps, 5.0 * steps, np.zeros(10)])
    second = np.column_stack([steps, np.full(10, 20.0), 30.0 - 3.0 * steps])
    false = np.array([[4.0, 500.0, 500.0]])
    rows = np.concatenate([first, second, false])
    seen = list(nearest_neighbour(rows[:, 0], rows[:, 1:], Habits(0.1, 1.0, 10.0)))
    tracks = {}
    for one in seen:
        tracks.setdefault(one.track, []).append(one.report)
    assert sorted(tracks.values()) == [list(range(2, 10)), list(range(12, 20))]


@pytest.mark.usefixtures("benchmarks")
def test_a_missed_object_coasts_and_ends() -> None:
    from nearest_neighbour import Habits, nearest_neighbour

    time = np.concatenate([np.arange(4.0), np.arange(10.0)])
    place = np.zeros((14, 2))
    place[:4, 0], place[4:, 0] = np.arange(4.0), 1000.0
    habits = Habits(0.1, 1.0, 10.0, most_misses=3)
    own = [one for one in nearest_neighbour(time, place, habits) if one.position[0] < 500.0]
    assert [(one.time, one.report) for one in own] == [(2, 2), (3, 3), (4, -1), (5, -1)]
    assert own[-1].position[0] == pytest.approx(5.0, abs=0.1)
