import numpy as np
import pytest

from trackweave.arrays import (
    float_array,
    int_array,
    is_number,
    is_whole,
    name_text,
    require_finite,
    require_instance,
)
from trackweave.errors import InvalidInputError


def test_casts_what_can_be_read_as_numbers():
    array = float_array([[1, 2], [3, 4]], "points", (None, 2))
    assert array.dtype == np.float64
    assert array.flags.c_contiguous


def test_takes_an_array_that_fits_as_it_is():
    array = np.zeros((3, 2))
    assert float_array(array, "points", (None, 2)) is array


def test_straightens_an_array_that_lies_otherwise_in_memory():
    array = np.asfortranarray(np.arange(6.0).reshape(3, 2))
    came = float_array(array, "points", (3, 2))
    assert came.flags.c_contiguous
    np.testing.assert_array_equal(came, array)


@pytest.mark.parametrize("cast", [float_array, int_array])
@pytest.mark.parametrize(
    ("values", "shape"),
    [(3, (None,)), ([1, 2], ()), ([1, 2], (3,)), ([[1, 2]], (None,)), ([1, 2], (None, None))],
)
def test_refuses_another_shape_and_says_both(cast, values, shape):
    with pytest.raises(InvalidInputError, match=r"points: an array of shape .*; expected shape"):
        cast(values, "points", shape)


@pytest.mark.parametrize("values", [["a", "b"], [[1], [1, 2]], [None, object()]])
def test_refuses_what_is_no_number(values):
    with pytest.raises(InvalidInputError, match=r"points: .*; expected numbers"):
        float_array(values, "points", (None,))


@pytest.mark.parametrize("values", [[1.5], [np.nan], [np.inf], ["a"]])
def test_refuses_what_is_no_whole_number(values):
    with pytest.raises(InvalidInputError, match=r"count: .*; expected whole numbers"):
        int_array(values, "count", (None,))


@pytest.mark.parametrize("values", [[1e30], [2**63]])
def test_refuses_a_whole_number_too_large_to_keep(values):
    with pytest.raises(InvalidInputError, match=r"count: .*; expected whole numbers"):
        int_array(values, "count", (None,))


def test_takes_whole_numbers_however_they_are_stored():
    for values in ([1, 2], [1.0, 2.0], np.array([1, 2], dtype=np.uint8)):
        array = int_array(values, "count", (2,))
        assert array.dtype == np.int64
        assert array.tolist() == [1, 2]
    assert int_array([], "count", (None,)).dtype == np.int64


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_names_the_first_place_that_is_not_finite(value):
    array = np.zeros((3, 2))
    array[1, 0] = array[2, 1] = value
    with pytest.raises(InvalidInputError, match=r"points\[1, 0\]: .*; expected a finite number"):
        require_finite(array, "points")
    require_finite(np.zeros((0, 2)), "points")


def test_refuses_rows_of_different_lengths_among_whole_numbers():
    with pytest.raises(InvalidInputError, match=r"tuples: .*; expected whole numbers, and rows"):
        int_array([(1, 1), (1,)], "tuples", (None, None))


@pytest.mark.parametrize("value", [True, "1", None, np.nan, np.inf, 10**400, [1.0], 1j])
def test_takes_for_a_number_only_a_finite_one(value):
    assert not is_number(value)
    assert all(is_number(number) for number in (1, 2.5, np.float32(1), np.int64(3)))


@pytest.mark.parametrize("value", [True, "1", None, 1.0, np.float64(2), [1]])
def test_takes_for_a_whole_number_only_an_integer(value):
    assert not is_whole(value)
    assert is_whole(3)
    assert is_whole(np.int32(3))


def test_takes_a_name_as_text_or_whole_number():
    assert name_text(0, "sensor") == name_text(np.int64(0), "sensor") == name_text("0", "sensor")
    for value in (None, 1.5, True, b"0"):
        with pytest.raises(InvalidInputError, match=r"sensor: .*; expected a text"):
            name_text(value, "sensor")


def test_refuses_a_class_in_the_place_of_its_instance():
    require_instance(1.5, float, "speed")
    for value in (float, "fast"):
        with pytest.raises(InvalidInputError, match=r"speed: .*; expected an instance of float"):
            require_instance(value, float, "speed")
