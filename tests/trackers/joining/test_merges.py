"""Silences that a merge explains."""

import numpy as np

from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.trackers.joining.merges import merge_pairs
from trackweave.trackers.joining.segments import Paths, segments_of

Course = tuple[int, int, float, float]
"""From when to when an object is seen [s], where first [m], and how fast it is [m/s]."""


def pairs(courses: list[Course], within: float = 8.0) -> list[tuple[int, int]]:
    """Return which tracks on a line may go on as which."""
    rows = [
        (float(t), number, x + v * (t - first), 0.0, v, 0.0)
        for number, (first, last, x, v) in enumerate(courses)
        for t in range(first, last + 1)
    ]
    table = np.array(sorted(rows))
    time, track = table[:, 0], table[:, 1].astype(np.int64)
    segments, of = segments_of(track, time, range(len(courses)))
    n, one = len(table), np.tile(np.eye(4), (len(table), 1, 1))
    states = TrackTable(
        time, of, np.full(n, CONFIRMED), table[:, 2:], one, np.zeros(n), np.ones(n, np.int64), time
    )
    found = np.argwhere(merge_pairs(Paths(states), segments, within))
    return [(int(early), int(late)) for early, late in found]


STAYS = (0, 60, 100.0, 0.0)


def test_who_ends_beside_another_may_be_who_begins_beside_it():
    assert pairs([STAYS, (0, 20, 70.0, 1.2), (30, 60, 95.0, -1.0)]) == [(1, 2)]


def test_who_ends_or_begins_far_from_all_was_in_no_merge():
    assert pairs([STAYS, (0, 20, 30.0, 1.2), (30, 60, 95.0, -1.0)]) == []
    assert pairs([STAYS, (0, 20, 70.0, 1.2), (30, 60, 70.0, -1.0)]) == []


def test_who_begins_without_that_another_ended_is_nobody():
    assert pairs([STAYS, (30, 60, 95.0, -1.0)]) == []


def test_the_track_of_a_spot_that_parts_goes_on_as_one_of_both():
    spot = (0, 30, 100.0, 0.0)
    one, other = (31, 60, 95.0, -1.0), (31, 60, 105.0, 1.0)
    assert pairs([spot, (0, 20, 70.0, 1.2), one, other]) == [(0, 2), (0, 3), (1, 2), (1, 3)]
    assert pairs([spot, one, other]) == []


def test_what_is_near_is_told_by_the_distance_of_a_merge():
    scene = [STAYS, (0, 20, 70.0, 1.2), (30, 60, 95.0, -1.0)]
    assert pairs(scene, within=2.0) == []
