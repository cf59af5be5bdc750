"""What the time of a report costs, against the oracle."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from oracles.rhythms import rhythm_costs
from trackweave.association._rhythm import SIZE, begin_rhythm, hear, rhythm_cost


class Heard(NamedTuple):
    sensor: int
    moment: np.ndarray
    detection_probability: float


# In ten seconds one is heard once.
OFTEN = -math.expm1(-0.1)


def costs(times, often=OFTEN, sensor=0):
    rhythm = np.empty((1, SIZE))
    begin_rhythm(rhythm, 0, sensor, times[0])
    found = [0.0]
    for time in times[1:]:
        found.append(rhythm_cost(rhythm, 0, Heard(sensor, np.array([time]), often), 0))
        hear(rhythm, 0, sensor, time)
    return found


@pytest.mark.parametrize("seed", range(10))
def test_costs_are_those_of_the_whole_history(seed):
    rng = np.random.default_rng(seed)
    usual = rng.choice([0.1, 2.0, 10.0, 180.0, 900.0], size=4).repeat(15)
    lost = rng.geometric(0.7, size=usual.size)
    waits = usual * lost * rng.uniform(0.8, 1.2, usual.size) * (rng.random(usual.size) > 0.05)
    times = np.cumsum(waits).tolist()
    np.testing.assert_allclose(costs(times), rhythm_costs(times, OFTEN), atol=1e-9)


def test_two_objects_cost_more_as_one():
    one = 30.0 * np.arange(24.0)
    other = one + 13.0
    both = np.sort(np.concatenate([one, other]))
    assert sum(costs(both.tolist())) > sum(costs(one.tolist())) + sum(costs(other.tolist())) + 10.0


def test_one_object_costs_more_as_two():
    one = 10.0 * np.arange(24.0)
    mixed = np.random.default_rng(1).permutation(24) % 2 == 0
    parts = sum(costs(one[mixed].tolist())) + sum(costs(one[~mixed].tolist()))
    assert parts > sum(costs(one.tolist())) + 10.0


@pytest.mark.parametrize("seed", range(5))
def test_taking_turns_on_one_that_reports_at_odd_times_is_worth_nothing(seed):
    times = np.cumsum(np.random.default_rng(seed).uniform(1.0, 5.0, 400))
    parts = sum(costs(times[::2].tolist())) + sum(costs(times[1::2].tolist()))
    assert parts > sum(costs(times.tolist()))


@pytest.mark.parametrize("seed", range(5))
def test_who_reports_whenever_it_likes_is_soon_known_to(seed):
    found = costs(np.cumsum(np.random.default_rng(seed).exponential(10.0, 60)).tolist())
    assert sum(found) < 12.0
    assert sum(found[20:]) < 4.0


def test_another_sensor_says_nothing_of_the_intervals():
    rhythm = np.empty((1, SIZE))
    begin_rhythm(rhythm, 0, 0, 0.0)
    for time in (10.0, 20.0):
        hear(rhythm, 0, 0, time)
    before = rhythm.copy()
    assert rhythm_cost(rhythm, 0, Heard(1, np.array([21.0]), OFTEN), 0) == 0.0
    hear(rhythm, 0, 1, 21.0)
    np.testing.assert_array_equal(rhythm, before)


@pytest.mark.parametrize("heard", [60.0, 600.0, 3600.0])
def test_what_a_wait_tells_hangs_on_how_usual_it_is(heard):
    times = np.cumsum(np.random.default_rng(1).uniform(0.5, 1.5, 40))
    found = costs((heard * times).tolist(), -math.expm1(-1.0 / heard))
    np.testing.assert_allclose(found, costs((1e4 * times).tolist(), -math.expm1(-1e-4)))
