"""What a tracker learns of a detector."""

import numpy as np
import pytest

from trackweave.trackers.boxes.habits import UNKNOWN, Habits
from trackweave.trackers.boxes.states import Tracks, born

KIND = np.zeros(1, dtype=np.int64)


@pytest.fixture
def habits() -> Habits:
    one = Habits(4)
    one.know(2)
    return one


def lost(score: float, kind: int = 0) -> Tracks:
    """Return a track of one box that nothing followed."""
    one = np.ones(1)
    others = {
        "visible": one, "hidden": one, "kind": np.array([kind]), "name": -np.ones(1, dtype=int),
        "hits": one, "evidence": one, "score_sum": score * one, "last_seen": one,
        "row": np.zeros(1, dtype=int), "score": one, "data": np.full(1, None, dtype=object),
    }  # fmt: skip
    return born(np.zeros((1, 4)), np.ones((1, 4)), others)


def test_at_the_start_a_score_says_what_it_claims(habits: Habits) -> None:
    odds = np.array([-3.0, 0.0, 2.5])
    assert np.allclose(habits.evidence(odds, np.zeros(3, dtype=np.int64)), odds)


def test_a_box_without_a_score_says_a_little_for_an_object(habits: Habits) -> None:
    assert habits.evidence(np.array([np.nan]), KIND).tolist() == [UNKNOWN]


def test_scores_that_nothing_follows_speak_against_objects_of_their_class(habits: Habits) -> None:
    for _ in range(300):
        habits.note_lost(lost(3.0))
    mine, other = habits.evidence(np.array([3.0, 3.0]), np.array([0, 1]))
    assert mine < 0.0 < other


def test_errors_are_learned_from_links_class_by_class(habits: Habits) -> None:
    for _ in range(500):
        ratio = np.tile([4.0, 4.0, 0.25, 0.25], (5, 1)) / habits.factor[0]
        habits.note_links(ratio, np.zeros(5, dtype=np.int64))
    assert np.allclose(habits.factor[0], [4.0, 4.0, 0.25, 0.25], rtol=0.05)
    assert np.array_equal(habits.factor[1], np.ones(4))


def test_false_boxes_are_counted_class_by_class(habits: Habits) -> None:
    for _ in range(300):
        habits.note_alone(np.ones(3), np.zeros(3, dtype=np.int64))
    assert habits.false[0] == pytest.approx(3.0, rel=0.15)
    assert habits.false[1] < 0.1
