"""Where chance comes from."""

import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.randomness import generator_of, seed_of


def test_takes_a_generator_as_it_is() -> None:
    rng = np.random.default_rng(3)
    assert generator_of(rng) is rng
    assert seed_of(rng) is None


@pytest.mark.parametrize("seed", [0, 7, 10**40, np.int64(7), np.uint8(7)])
def test_takes_a_whole_number_for_a_seed(seed: int) -> None:
    drawn = np.random.default_rng(int(seed)).random(4)
    assert generator_of(seed).random(4).tolist() == drawn.tolist()
    assert generator_of(seed).random(4).tolist() == drawn.tolist()
    assert seed_of(seed) == seed


@pytest.mark.parametrize(
    "wrong", [None, True, np.True_, 1.0, -1, "1", [1], np.random.RandomState(1), np.random]
)
def test_refuses_what_is_neither(wrong: object) -> None:
    with pytest.raises(InvalidInputError, match=r"rng: .*; expected a numpy\.random\.Generator"):
        generator_of(wrong)
