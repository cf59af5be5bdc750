"""Tests of courses: exact manoeuvres and integrated random acceleration."""

import numpy as np
import pytest

from trackweave.simulation._paths import course, random_walk
from trackweave.simulation.targets import Manoeuvre, Target

TIMES = np.linspace(-5.0, 40.0, 91)


def test_goes_straight_without_manoeuvres() -> None:
    position, velocity = course(Target((1, 2), (3, -4), start=2.0), TIMES)
    assert position == pytest.approx(np.array([1, 2]) + (TIMES[:, None] - 2) * [3, -4])
    assert velocity == pytest.approx(np.tile([3.0, -4.0], (TIMES.size, 1)))


def test_turns_left_by_rate_times_duration_at_constant_speed() -> None:
    turn = Manoeuvre(start=10.0, duration=9.0, turn_rate_deg_s=10.0)
    position, velocity = course(Target((0, 0), (5, 0), manoeuvres=(turn,)), TIMES)
    assert np.linalg.norm(velocity, axis=1) == pytest.approx(5.0)
    assert velocity[-1] == pytest.approx([0.0, 5.0])
    # A quarter of a circle of radius v / rate to the left of the course.
    radius = 5 / np.radians(10.0)
    at_end = int(np.flatnonzero(TIMES == 19.0)[0])
    assert position[at_end] == pytest.approx([50 + radius, radius])


def test_climbs_on_while_it_turns_in_three_dimensions() -> None:
    turn = Manoeuvre(start=0.0, duration=60.0, turn_rate_deg_s=-6.0)
    position, velocity = course(Target((0, 0, 100), (5, 0, 2), manoeuvres=(turn,)), TIMES)
    assert position[:, 2] == pytest.approx(100 + 2 * TIMES)
    assert velocity[:, 2] == pytest.approx(2.0)


def test_accelerates_by_the_closed_form() -> None:
    push = Manoeuvre(start=0.0, duration=10.0, acceleration=(1.0, 0.5))
    position, velocity = course(Target((0, 0), (2, 0), manoeuvres=(push,)), np.array([10.0, 12.0]))
    assert position[0] == pytest.approx([20 + 50, 25])
    assert velocity[1] == pytest.approx([12, 5])
    assert position[1] == pytest.approx([70 + 24, 25 + 10])


def test_velocity_is_the_slope_of_position_everywhere() -> None:
    target = Target(
        (0, 0),
        (8, 1),
        at=17.0,
        manoeuvres=(
            Manoeuvre(start=5.0, duration=6.0, turn_rate_deg_s=12.0),
            Manoeuvre(start=11.0, duration=4.0, acceleration=(-0.5, 0.2)),
            Manoeuvre(start=20.0, duration=8.0, turn_rate_deg_s=-9.0),
        ),
    )
    step = 1e-4
    before, _ = course(target, TIMES - step)
    after, _ = course(target, TIMES + step)
    _, velocity = course(target, TIMES)
    assert (after - before) / (2 * step) == pytest.approx(velocity, abs=2e-4)


def test_passes_its_position_at_its_time_also_amid_a_manoeuvre() -> None:
    turn = Manoeuvre(start=5.0, duration=20.0, turn_rate_deg_s=7.0)
    target = Target((100, 50), (3, 4), at=12.0, manoeuvres=(turn,))
    position, velocity = course(target, np.array([12.0]))
    assert position[0] == pytest.approx([100, 50])
    assert velocity[0] == pytest.approx([3, 4])


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_random_walk_has_the_covariance_of_integrated_white_noise(direction: float) -> None:
    rng = np.random.default_rng(3)
    density, n_runs = 0.4, 4000
    times = direction * np.array([0.0, 1.0, 1.5, 4.0])
    runs = [random_walk(times, 2, density, rng) for _ in range(n_runs)]
    last = np.array([[position[-1, 0], velocity[-1, 0]] for position, velocity in runs])
    span = 4.0
    expected = density * np.array(
        [[span**3 / 3, direction * span**2 / 2], [direction * span**2 / 2, span]]
    )
    assert np.cov(last.T) == pytest.approx(expected, rel=0.12)


def test_random_walk_adds_nothing_at_its_first_time() -> None:
    position, velocity = random_walk(np.array([2.0, 3.0]), 3, 1.0, np.random.default_rng(0))
    assert not position[0].any()
    assert not velocity[0].any()
    assert position[1].all()
