"""Values come back as they were, and bytes that are none say so."""

import collections
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

import trackweave as tw
from oracles.checkpoints import CASES, CLASSES, advance
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.randomness import generator_of
from trackweave.trackers.packing import packed
from trackweave.trackers.unpacking import unpacked

PLAIN = (
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary()
)  # fmt: skip
KINDS = st.sampled_from(["?", "<i1", "<i8", "<u2", "<f4", "<f8", "<c16", "<U3", "S2", "<M8[s]"])
ARRAYS = KINDS.flatmap(lambda kind: npst.arrays(kind, npst.array_shapes(min_dims=0, min_side=0)))
VALUES = st.recursive(
    PLAIN | ARRAYS | st.sets(PLAIN) | st.frozensets(PLAIN),
    lambda inner: (
        st.lists(inner)
        | st.lists(inner).map(tuple)
        | st.dictionaries(PLAIN, inner)
        | st.lists(inner).map(collections.deque)
    ),
    max_leaves=20,
)


def is_same(one, other):
    """Tell whether values are alike in kind, order and bits."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        facts = [(a.dtype, a.shape, a.flags.writeable, a.tobytes()) for a in (one, other)]
        return facts[0] == facts[1]
    if isinstance(one, float):
        return math.copysign(1, one) == math.copysign(1, other) and (
            one == other or (one != one and other != other)
        )
    if isinstance(one, set | frozenset):
        return sorted(map(repr, one)) == sorted(map(repr, other))
    if isinstance(one, dict):
        return len(one) == len(other) and all(
            is_same(*pair) for pair in zip(one.items(), other.items(), strict=True)
        )
    if isinstance(one, list | tuple | collections.deque):
        return len(one) == len(other) and all(map(is_same, one, other))
    return bool(one == other)


@given(VALUES)
def test_a_value_comes_back_as_it_was(value):
    content = packed(value)
    found = unpacked(content)
    assert is_same(found, value)
    assert packed(found) == content


@pytest.mark.parametrize("order", ["C", "F"])
def test_arrays_keep_layout_and_whether_they_may_be_written(order):
    given = np.asarray(np.arange(12.0).reshape(3, 4), order=order)
    given.flags.writeable = order == "C"
    found = unpacked(packed(given))
    assert found.flags.c_contiguous is given.flags.c_contiguous
    assert found.flags.writeable is given.flags.writeable
    assert found.flags.owndata
    assert found.flags.aligned
    np.testing.assert_array_equal(found, given)


def test_a_part_of_an_array_is_an_array_of_its_own():
    found = unpacked(packed(np.arange(20.0).reshape(4, 5)[:, ::2]))
    np.testing.assert_array_equal(found, np.arange(20.0).reshape(4, 5)[:, ::2])
    assert found.flags.c_contiguous


def test_numbers_of_numpy_stay_its():
    given = [np.float64(0.1), np.int64(3), np.bool_(True)]
    assert [type(each) for each in unpacked(packed(given))] == [type(each) for each in given]


def test_what_is_one_object_stays_one():
    shared, itself = [1.5], []
    itself.append(itself)
    column = np.zeros(3)
    found = unpacked(packed({"a": shared, "b": (shared, column), "c": column, "d": itself}))
    assert found["a"] is found["b"][0]
    assert found["b"][1] is found["c"]
    assert found["d"][0] is found["d"]
    apart = unpacked(packed([[1.5], [1.5]]))
    assert apart[0] is not apart[1]


def test_sets_give_the_same_bytes_in_whatever_order_they_grew():
    names = [f"name {number}" for number in range(100)]
    assert packed(set(names)) == packed(set(reversed(names)))


@pytest.mark.parametrize("name", ["PCG64", "PCG64DXSM", "MT19937", "Philox", "SFC64"])
def test_generators_go_on_and_have_the_children_that_they_would_have_had(name):
    given = np.random.Generator(getattr(np.random, name)(5))
    given.random(7, dtype=np.float32)
    given.spawn(2)
    found = unpacked(packed(given))
    np.testing.assert_array_equal(found.random(50), given.random(50))
    (mine,), (other,) = found.spawn(1), given.spawn(1)
    assert mine.integers(2**62) == other.integers(2**62)


@pytest.mark.parametrize(
    ("value", "where"),
    [
        (print, "value: a builtins.builtin"),
        ([1, {"a": lambda: 3}], r"\[1\]\['a'\]: a builtins.function"),
        (int, "value: a builtins.type"),
        ({(1, 2)}, "value: a set of more than numbers and texts"),
        (np.zeros(2, dtype=[("a", "f8")]), "value: a numpy.ndarray"),
        (collections.Counter("ab"), "value: a collections.Counter"),
        (tw.MultiHypothesisTracker, "value: a abc.ABCMeta"),
        (np.random.RandomState(1), "value: a numpy.random.mtrand.RandomState"),
    ],
)
def test_says_where_what_it_cannot_hold_is(value, where):
    with pytest.raises(InvalidInputError, match=f"^{where}.*; a checkpoint holds numbers"):
        packed(value)


@given(st.binary(max_size=40))
def test_bytes_of_no_value_are_refused(content):
    try:
        value = unpacked(content)
    except DataFormatError as err:
        assert str(err)
    else:
        assert is_same(unpacked(packed(value)), value)


@pytest.fixture(scope="module")
def of_trackers():
    found = []
    for name in ("two halves", "boxes", "nearest"):
        case = CASES[name]()
        for step in case.steps[:4]:
            advance(case.tracker, step)
        found.append(packed(case.tracker, CLASSES))
    return found


DAMAGE = st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), min_size=1, max_size=4)


@given(st.integers(0, 2), DAMAGE)
def test_a_damaged_value_is_refused_or_another_value(of_trackers, which, damage):
    content = bytearray(of_trackers[which])
    for place, byte in damage:
        content[place % len(content)] = byte
    try:
        unpacked(bytes(content), CLASSES)
    except DataFormatError as err:
        assert str(err)


def test_names_lead_only_to_classes_of_trackers():
    genuine = packed(tw.Window(3))
    assert b"trackers.window:Window" in genuine
    for name in (b"trackers.window:cached", b"cli.app:__main__Window", b"trackers.window:XXXXXX",
                 b"trackers.live:ABCXXXXX", b"trackers.xindow:Window"):  # fmt: skip
        assert len(name) == len(b"trackers.window:Window")
        with pytest.raises(DataFormatError):
            unpacked(genuine.replace(b"trackers.window:Window", name))


def test_an_object_with_other_attributes_is_of_another_version():
    genuine = packed(tw.Window(3))
    with pytest.raises(DataFormatError, match="Window of depth, max_scant; expected depth"):
        unpacked(genuine.replace(b"max_scans", b"max_scant"))


def test_a_seed_is_the_generator_that_it_makes():
    assert unpacked(packed(generator_of(5))).random() == generator_of(5).random()


def test_what_nests_too_deep_is_refused():
    deep = b"l" + (1).to_bytes(8, "little")
    with pytest.raises(DataFormatError, match="no value"):
        unpacked(deep * 100_000 + b"N")
