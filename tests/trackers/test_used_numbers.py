"""Numbers as runs, held against a plain set."""

import copy

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from trackweave.trackers import used_numbers
from trackweave.trackers.used_numbers import UsedNumbers

GROUPS = st.lists(st.lists(st.integers(0, 60), max_size=4), max_size=20)


def array(numbers):
    return np.array(numbers, dtype=np.int64)


@given(GROUPS)
def test_knows_what_a_set_knows(groups):
    used, known = UsedNumbers(), set()
    for group in groups:
        is_new = len(group) == len(set(group)) and not known & set(group)
        assert used.add(array(group)) is is_new
        known |= set(group) if is_new else set()
        assert used.following == max(known, default=-1) + 1
    assert {number for number in range(70) if not copy.copy(used).add(array([number]))} == known


def test_counts_on_above_all_others():
    used = UsedNumbers()
    assert used.count_on(2).tolist() == [0, 1]
    used.add(array([7, 5]))
    assert used.count_on(3).tolist() == [8, 9, 10]
    assert used.count_on(0).tolist() == []


def test_numbers_that_count_up_take_no_room_however_many_they_are():
    used, rng = UsedNumbers(), np.random.default_rng(1)
    for start in range(0, 100_000, 50):
        numbers = start + rng.permutation(50)
        used.add(numbers[:20])
        used.add(numbers[20:])
    assert len(pickled(used)["_first"]) == 1


def test_gaps_without_end_are_bounded_and_the_lowest_numbers_forgotten(monkeypatch):
    monkeypatch.setattr(used_numbers, "MOST_RUNS", 10)
    used = UsedNumbers()
    for number in range(0, 100, 2):
        used.add(array([number]))
    assert len(pickled(used)["_first"]) == 10
    assert not used.add(array([98]))
    assert used.add(array([0]))


def test_a_copy_goes_its_own_way():
    used = UsedNumbers()
    used.add(array([1, 2]))
    other = copy.copy(used)
    other.add(array([3]))
    assert not other.add(array([3]))
    assert used.add(array([3]))


def pickled(used):
    return used.__getstate__()
