"""Numbers as runs, held against a plain set."""

import copy

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from trackweave.trackers import used_numbers
from trackweave.trackers.used_numbers import UsedNumbers

GROUPS = st.lists(st.lists(st.integers(0, 60), unique=True, max_size=8), max_size=20)


def array(numbers):
    return np.array(numbers, dtype=np.int64)


@given(GROUPS)
def test_knows_what_a_set_knows(groups):
    used, known = UsedNumbers(), set()
    for group in groups:
        assert used.meets(array(group)) == bool(known & set(group))
        fresh = [number for number in group if number not in known]
        used.add(array(fresh))
        known |= set(fresh)
        assert used.following == max(known, default=-1) + 1
    assert [number for number in range(70) if used.meets(array([number]))] == sorted(known)


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
    assert used.meets(array([98]))
    assert not used.meets(array([0]))


def test_a_copy_goes_its_own_way():
    used = UsedNumbers()
    used.add(array([1, 2]))
    other = copy.copy(used)
    other.add(array([3]))
    assert other.meets(array([3]))
    assert not used.meets(array([3]))


def pickled(used):
    return used.__getstate__()
