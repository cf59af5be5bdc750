"""Whether objects are there and seen, and how probable links are."""

import numpy as np
import pytest

from trackweave.trackers.boxes.frames import Seen
from trackweave.trackers.boxes.habits import Habits
from trackweave.trackers.boxes.linking import (
    CLEAR,
    DETECTED,
    Linker,
    Links,
    clearly,
    lasting,
    missed,
)
from trackweave.trackers.boxes.shapes import parts_of


def seen(boxes: list[list[float]], odds: float = 3.0, kind: int = 0) -> Seen:
    array, count = np.array(boxes), len(boxes)
    scores = np.full(count, odds)
    kinds, data = np.full(count, kind), np.full(count, None, dtype=object)
    return Seen(array, parts_of(array), kinds, scores, scores, data, 0.0, None)


def linker(*, by_overlap: bool = False) -> Linker:
    habits = Habits(4)
    habits.know(2)
    return Linker(habits, 1.0, by_overlap=by_overlap)


BOX = [0.0, 0.0, 20.0, 40.0]


def test_objects_hide_and_leave_but_none_comes_of_waiting() -> None:
    visible, hidden = lasting(np.array([1.0]), np.array([0.0]), 1.0)
    assert 0.0 < hidden[0] < visible[0] < 1.0
    assert visible[0] + hidden[0] < 1.0
    long_after = lasting(np.array([1.0]), np.array([0.0]), 1e3)
    assert sum(long_after)[0] < 1e-9


def test_what_is_missed_is_rather_hidden_or_gone() -> None:
    visible, hidden = missed(np.array([0.8]), np.array([0.1]))
    assert np.isclose(visible[0], 0.8 * (1 - DETECTED) / (1 - 0.8 * DETECTED))
    assert hidden[0] > 0.1
    assert visible[0] + hidden[0] < 0.9


def test_a_nearer_box_and_a_surer_one_are_likelier_the_tracks() -> None:
    one = linker()
    one.look(seen([BOX, [500.0, 300.0, 520.0, 340.0]]))
    tracks = one.born(seen([BOX]), None)
    near, far = one.odds(tracks, seen([BOX, [9.0, 0.0, 29.0, 40.0]]), 0.04)[0]
    weak = one.odds(tracks, seen([BOX], odds=-3.0), 0.04)[0, 0]
    other = one.odds(tracks, seen([BOX], kind=1), 0.04)[0, 0]
    assert near > max(far, weak)
    assert other == -np.inf


def test_an_overlap_counts_where_that_is_asked_for() -> None:
    one = linker(by_overlap=True)
    one.look(seen([BOX, [500.0, 300.0, 520.0, 340.0]]))
    tracks = one.born(seen([BOX]), None)
    same, half, none = one.odds(
        tracks, seen([BOX, [7.0, 0.0, 27.0, 40.0], [21.0, 0.0, 41.0, 40.0]]), 0.04
    )[0]
    assert same > half > none == -np.inf


def test_a_sure_box_makes_an_object_visible() -> None:
    one = linker()
    tracks = one.born(seen([BOX]), None)
    tracks.visible[:], tracks.hidden[:] = 0.1, 0.8
    one.miss(tracks, tracks, np.array([False]))
    zero = np.zeros(1, dtype=np.int64)
    one.hit(tracks, seen([BOX]), Links(zero, zero, np.array([20.0])))
    assert tracks.visible[0] > 0.99
    assert tracks.hidden[0] < 0.01
    assert tracks.hits.tolist() == [2.0]


def test_beyond_a_moment_silence_says_nothing() -> None:
    one = linker()
    tracks = one.born(seen([BOX]), None)
    tracks.visible[:], tracks.hidden[:] = 0.1, 0.5
    before = tracks.of(np.array([0]))
    for rests, present in ((True, 0.6), (False, 0.1 * 0.1 / 0.91 + 0.5 / 0.91)):
        later = before.of(np.array([0]))
        one.miss(later, before, np.array([rests]))
        assert later.present == pytest.approx(present)


def test_after_a_long_silence_a_box_has_to_be_clear_the_more_so_among_false_ones() -> None:
    odds = np.array([[0.1, CLEAR + 0.1, CLEAR + 0.1], [0.1, CLEAR + 0.1, CLEAR + 0.1]])
    found = clearly(odds, np.array([False, True]), np.array([0.0, 0.0, 1.0]))
    assert found.tolist() == [[True, True, True], [False, True, False]]
