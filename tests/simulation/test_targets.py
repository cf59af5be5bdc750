"""Tests of targets and their patterns."""

import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.simulation._paths import course
from trackweave.simulation.targets import Crossing, Manoeuvre, Parallel, Target


def test_a_crossing_meets_at_its_point_and_time() -> None:
    crossing = Crossing((300, 200), time=30.0, speed=10.0, count=3, angle_deg=40.0)
    for target in crossing.targets():
        position, _ = course(target, np.array([30.0]))
        assert position[0] == pytest.approx([300, 200])


def test_a_crossings_headings_are_the_angle_apart_around_the_middle() -> None:
    crossing = Crossing((0, 0), time=1.0, speed=10.0, count=3, angle_deg=40.0, heading_deg=90.0)
    velocity = np.array([target.velocity for target in crossing.targets()])
    headings = np.degrees(np.arctan2(velocity[:, 0], velocity[:, 1]))
    assert headings == pytest.approx([50.0, 90.0, 130.0])
    assert np.linalg.norm(velocity, axis=1) == pytest.approx(10.0)


def test_a_crossing_in_space_is_level() -> None:
    assert all(target.velocity[2] == 0 for target in Crossing((0, 0, 9), 1.0, 5.0).targets())


def test_parallel_targets_keep_their_spacing_across_the_course() -> None:
    row = Parallel((10, 20), (3, 4), spacing=50.0, count=3).targets()
    places = np.array([target.position for target in row])
    assert places[1] == pytest.approx([10, 20])
    steps = np.diff(places, axis=0)
    assert np.linalg.norm(steps, axis=1) == pytest.approx(50.0)
    assert steps @ np.array([3, 4]) == pytest.approx(0.0)


def test_sorts_manoeuvres_by_start() -> None:
    late, early = Manoeuvre(9.0, 1.0, 3.0), Manoeuvre(1.0, 1.0, 3.0)
    assert Target((0, 0), (1, 0), manoeuvres=(late, early)).manoeuvres == (early, late)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Target((0,), (1, 0)), "position"),
        (lambda: Target((0, 0), (1, 0, 0)), "velocity: .* expected two finite numbers"),
        (lambda: Target((0, float("nan")), (1, 0)), "position"),
        (lambda: Target((0, 0), (1, 0), start=-1.0), "start: -1.0; expected .* at least 0"),
        (lambda: Target((0, 0), (1, 0), start=5.0, end=5.0), "end: 5.0; expected .* above 5"),
        (lambda: Target((0, 0), (1, 0), name=" "), "name"),
        (
            lambda: Target(
                (0, 0), (1, 0), manoeuvres=(Manoeuvre(0.0, 5.0, 1.0), Manoeuvre(4.0, 5.0, 1.0))
            ),
            "overlap",
        ),
        (
            lambda: Target((0, 0), (1, 0), manoeuvres=(Manoeuvre(0.0, 5.0, None, (1, 1, 1)),)),
            "acceleration",
        ),
        (lambda: Manoeuvre(0.0, 0.0, 1.0), "duration: 0.0"),
        (lambda: Manoeuvre(0.0, 1.0), "expected one of the two"),
        (lambda: Manoeuvre(0.0, 1.0, 1.0, (1, 1)), "expected one of the two"),
        (lambda: Manoeuvre(0.0, 1.0, 400.0), "turn_rate_deg_s: 400.0"),
        (lambda: Crossing((0, 0), 1.0, 5.0, count=1), "count: 1"),
        (lambda: Crossing((0, 0), 1.0, 5.0, count=True), "count: True"),
        (lambda: Crossing((0, 0), 1.0, 0.0), "speed: 0.0"),
        (lambda: Crossing((0, 0), 1.0, 5.0, angle_deg=181), "angle_deg: 181"),
        (lambda: Parallel((0, 0, 0), (0, 0, 1), 5.0), "not zero in the plane"),
        (lambda: Parallel((0, 0), (1, 0), -5.0), "spacing: -5.0"),
    ],
)
def test_refuses_what_cannot_move(make: object, words: str) -> None:
    assert callable(make)
    with pytest.raises(InvalidInputError, match=words):
        make()
