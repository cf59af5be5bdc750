"""How probable bearings are as those of one object that flies nearly straight."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from trackweave.estimation.bearing_flights import Bearings, flight_of

SPEED, REACH = 60.0, 4000.0


def bearings(rng: np.random.Generator, process_noise: float = 0.0, size: int = 60) -> Bearings:
    """Return bearings from two sensors of one object."""
    time = np.sort(rng.uniform(0.0, 100.0, size))
    place = np.array([[0.0, 0.0], [2000.0, 300.0]])[rng.integers(0, 2, size)]
    gaps = np.diff(time, prepend=time[0])
    change = rng.normal(size=(size, 2)) * np.sqrt(process_noise * gaps)[:, None]
    velocity = rng.uniform(-15.0, 15.0, 2) + np.cumsum(change, axis=0)
    path = rng.uniform([300.0, 800.0], [1700.0, 2500.0]) + np.cumsum(
        velocity * gaps[:, None], axis=0
    )
    seen = path - place
    sigma = rng.uniform(0.002, 0.006, size)
    return Bearings(time, place, np.arctan2(*seen.T) + rng.normal(0.0, sigma), sigma)


@pytest.mark.parametrize("seed", range(5))
def test_straight_flights_cost_what_laplace_says(seed):
    own = bearings(np.random.default_rng(seed))
    middle, mid = own.place.mean(axis=0), own.time - own.time.mean()
    spread = np.array([REACH, REACH, SPEED / 3.0, SPEED / 3.0])

    def off(scaled):
        # Four numbers tell a straight path; all are standard normal beforehand.
        state = scaled * spread
        east, north = (middle + state[:2] + mid[:, None] * state[2:] - own.place).T
        turn = own.angle - np.arctan2(east, north)
        turn = (turn + np.pi) % (2.0 * np.pi) - np.pi
        return np.concatenate([turn / own.sigma, scaled])

    best = least_squares(off, [0.0, 0.3, 0.0, 0.0], xtol=1e-14, ftol=1e-14, gtol=1e-14)
    _, volume = np.linalg.slogdet(best.jac.T @ best.jac)
    expected = best.cost + 0.5 * volume
    expected += np.log(own.sigma).sum() + 0.5 * own.time.size * np.log(2.0 * np.pi)
    assert flight_of(own, 0.0, SPEED, REACH).cost == pytest.approx(expected, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_a_process_noise_is_likeliest_near_the_true_one(seed):
    own = bearings(np.random.default_rng(seed), process_noise=0.3, size=200)
    costs = [flight_of(own, noise, SPEED, REACH).cost for noise in (0.003, 0.3, 30.0)]
    assert np.argmin(costs) == 1


def test_neither_order_nor_where_the_plane_begins_matters():
    rng = np.random.default_rng(7)
    own = bearings(rng, process_noise=0.05)
    cost = flight_of(own, 0.05, SPEED, REACH).cost
    mixed = own.at(rng.permutation(own.time.size))
    assert flight_of(mixed, 0.05, SPEED, REACH).cost == pytest.approx(cost)
    turned = np.array([[0.0, -1.0], [1.0, 0.0]])
    # A quarter turn to the left takes a quarter from what counts clockwise.
    other = own._replace(
        time=own.time + 1e6, place=own.place @ turned.T - 5e5, angle=own.angle - np.pi / 2
    )
    assert flight_of(other, 0.05, SPEED, REACH).cost == pytest.approx(cost, abs=1e-3)
