"""Whether a position of two numbers is compared as any report is."""

import math

import numpy as np
import pytest

from trackweave.association._nodes import Expectation, State
from trackweave.association._scoring import POSITION, expect
from trackweave.association._tails import compare_either, compare_in_plane

DIM, SCALE = 2, 8.0


def _state(rng: np.random.Generator, modes: int) -> State:
    roots = rng.normal(size=(modes, 4, 4))
    weight = rng.dirichlet(np.ones(modes))
    return State(
        rng.normal(size=(modes, 4)) * 3.0, np.einsum("kij,klj->kil", roots, roots), weight
    )


def _expectation(modes: int) -> Expectation:
    return Expectation(
        np.empty((modes, 2)), np.empty((modes, 2, 2)), np.empty(modes), np.empty((modes, 4, 2)),
        np.empty((modes, 2, 2)), np.empty(2),
    )  # fmt: skip


def _either(
    state: State, measurement: np.ndarray, noise: np.ndarray, share: float
) -> tuple[float, float]:
    expected = _expectation(state.weight.size)
    expect(POSITION, noise, np.zeros(6), state, DIM, False, expected)
    return compare_either(POSITION, measurement, 0, state.weight, expected, noise, share, SCALE)


def _in_plane(
    state: State, measurement: np.ndarray, noise: np.ndarray, share: float
) -> tuple[float, float]:
    # The second setting is the report's own; the first is there to be mistaken for it.
    noises = np.stack([np.eye(2) * 1e6, noise])
    return compare_in_plane(measurement, 0, noises, 1, *state, share, SCALE)


@pytest.mark.parametrize("share", [0.0, 0.05])
@pytest.mark.parametrize("modes", [1, 2, 3])
def test_a_position_in_the_plane_is_compared_to_the_byte_as_any_report(
    modes: int, share: float
) -> None:
    rng = np.random.default_rng(11)
    for _ in range(50):
        state, root = _state(rng, modes), rng.normal(size=(2, 2))
        measurement, noise = rng.normal(size=(1, 2)) * 5.0, root @ root.T
        assert _in_plane(state, measurement, noise, share) == _either(
            state, measurement, noise, share
        )


@pytest.mark.parametrize("share", [0.0, 0.05])
def test_a_mode_of_no_probability_tells_nothing(share: float) -> None:
    rng = np.random.default_rng(12)
    state, measurement = _state(rng, 2), rng.normal(size=(1, 2))
    state.weight[:] = 1.0, 0.0
    found = _in_plane(state, measurement, np.eye(2), share)
    assert found == _either(state, measurement, np.eye(2), share)
    alone = State(state.mean[:1], state.covariance[:1], state.weight[:1])
    assert found[1] == _in_plane(alone, measurement, np.eye(2), share)[1]


@pytest.mark.parametrize("share", [0.0, 0.05])
def test_what_cannot_be_inverted_lets_no_report_through(share: float) -> None:
    state = State(np.zeros((1, 4)), np.zeros((1, 4, 4)), np.ones(1))
    nothing = np.zeros((2, 2))
    assert _in_plane(state, np.zeros((1, 2)), nothing, share) == (math.inf, -math.inf)
