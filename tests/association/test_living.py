"""Whether the object of a sequence still lives."""

import math

import numpy as np
import pytest

from trackweave.association.living import log_weights

SURVIVAL = 0.9
END_COST = -math.log(1.0 - SURVIVAL)


def alive(*tail):
    """Return how probable it is that objects live whose tails cost so much."""
    return log_weights(np.zeros(len(tail)), np.array(tail), END_COST)[1]


def test_an_object_lives_when_it_is_reported():
    weight, share = log_weights(np.array([2.0]), np.zeros(1), END_COST)

    assert share == 1.0
    assert weight == -2.0


def test_before_the_next_look_an_object_lives_as_probably_as_it_survives():
    # A tail of nothing but survival, over a part of a period and over a whole one.
    eighth = -math.log(SURVIVAL) / 8

    assert alive(eighth, 8 * eighth) == pytest.approx([SURVIVAL**0.125, SURVIVAL])


def test_a_miss_speaks_for_an_end():
    missed = SURVIVAL * (1.0 - 0.8)

    assert alive(-math.log(missed)) == pytest.approx(missed / (missed + 1.0 - SURVIVAL))


def test_an_object_whose_end_is_known_does_not_live():
    weight, share = log_weights(np.array([2.0]), np.array([math.inf]), END_COST)

    assert share == 0.0
    assert weight == pytest.approx(-2.0 - END_COST)
