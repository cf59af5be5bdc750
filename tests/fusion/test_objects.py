"""Objects keep their numbers."""

import numpy as np

from trackweave.fusion.objects import Renumbering, renumber

NONE = np.empty(0, dtype=np.int64)


def numbers(label: list[int], held: list[int], before: list[int]) -> Renumbering:
    return renumber(np.array(label), np.array(held), np.array(before, dtype=np.int64), 10)


def test_new_tracks_begin_objects() -> None:
    new = numbers([0, 0, 1], [-1, -1, -1], [])
    assert new.object.tolist() == [10, 10, 11]
    assert new.begun == (10, 11)
    assert new.next_number == 12


def test_a_group_keeps_the_number_of_most_of_its_tracks() -> None:
    new = numbers([0, 0, 0, 1], [3, 4, 4, 3], [3, 4])
    assert new.object.tolist() == [4, 4, 4, 3]
    assert new.merged == {4: (3,)}
    assert new.split == {3: (4,)}
    assert new.begun == new.ended == ()


def test_an_object_that_splits_leaves_its_number_to_the_larger_part() -> None:
    new = numbers([0, 1, 1], [3, 3, 3], [3])
    assert new.object.tolist() == [10, 3, 3]
    assert new.split == {3: (10,)}
    assert new.begun == ()


def test_objects_that_merge_keep_the_older_number() -> None:
    new = numbers([0, 0], [5, 4], [4, 5])
    assert new.object.tolist() == [4, 4]
    assert new.merged == {4: (5,)}
    assert new.split == {}


def test_a_new_track_joins_without_a_change() -> None:
    new = numbers([0, 0], [4, -1], [4])
    assert new.object.tolist() == [4, 4]
    assert (new.begun, new.merged, new.split) == ((), {}, {})


def test_objects_without_tracks_end_and_return() -> None:
    assert numbers([0], [4], [4, 5]).ended == (5,)
    assert numbers([0, 1], [4, 5], [4]).returned == (5,)


def test_no_tracks_are_no_objects() -> None:
    new = renumber(NONE, NONE, np.array([2]), 3)
    assert new.object.tolist() == []
    assert new.ended == (2,)
