"""Strengths tell objects from false alarms only where they do, whatever their distribution."""

import numpy as np
import pytest

from trackweave.arrays import FloatArray
from trackweave.estimation.strengths import strength_model

RNG = np.random.default_rng(1)
LONE = RNG.normal(3.0, 2.0, 200)


def of_objects() -> list[FloatArray]:
    return [np.random.default_rng(seed).normal(12.0, 3.0, 20) for seed in range(10)]


def test_finds_the_distributions_that_strengths_came_from() -> None:
    found = strength_model(of_objects(), LONE)
    assert found is not None
    assert found.target_mean == pytest.approx(12.0, abs=0.7)
    assert found.target_sigma == pytest.approx(3.0, rel=0.2)
    assert found.clutter_mean == pytest.approx(3.0, abs=0.5)
    assert found.clutter_sigma == pytest.approx(2.0, rel=0.2)


def test_tracks_as_weak_as_false_alarms_count_as_false_alarms() -> None:
    weak = [np.random.default_rng(seed).normal(3.5, 2.0, 40) for seed in range(4)]
    found = strength_model([*of_objects(), *weak], LONE)
    assert found is not None
    assert found.target_mean == pytest.approx(12.0, abs=0.7)


def test_strengths_that_hardly_differ_tell_nothing() -> None:
    assert strength_model(of_objects(), LONE + 8.0) is None


def test_objects_weaker_than_false_alarms_tell_nothing() -> None:
    assert strength_model(of_objects(), LONE + 30.0) is None


@pytest.mark.parametrize("count", [0, 29])
def test_few_reports_tell_nothing(count: int) -> None:
    assert strength_model(of_objects(), LONE[:count]) is None
    assert strength_model([np.full(count, 12.0)], LONE) is None


def test_reports_without_strength_are_passed_over() -> None:
    missing = np.full(500, np.nan)
    with_gaps = [np.r_[own, missing] for own in of_objects()]
    assert strength_model(with_gaps, np.r_[LONE, missing]) == strength_model(of_objects(), LONE)


def test_a_long_tail_widens_what_is_believed() -> None:
    # Scores of a detector that end at 1, and of which some are poor.
    scores = 1 - RNG.exponential(0.03, 200) ** 1.5
    found = strength_model([scores], RNG.uniform(0.5, 0.8, 100))
    assert found is not None
    far = (found.target_mean - np.quantile(scores, 0.05)) / found.target_sigma
    assert far < 1.7


def test_constant_strengths_give_positive_sigmas() -> None:
    found = strength_model([np.ones(40)], np.zeros(40))
    assert found is not None
    assert found.target_sigma > 0
    assert found.clutter_sigma > 0


def test_weak_objects_are_none_the_less_objects_where_tracks_are_sure() -> None:
    weak = [RNG.normal(13.0, 2.0, 40) for _ in range(6)]
    strong = [RNG.normal(30.0, 2.0, 60) for _ in range(8)]
    false = RNG.normal(9.0, 3.0, 400)
    found = strength_model([*weak, *strong], false, are_sure=True)
    assert found is not None
    assert found.target_mean - found.target_spread == pytest.approx(13.0, abs=1.0)
    assert found.target_mean + found.target_spread == pytest.approx(30.0, abs=1.0)
    assert found.target_sigma == pytest.approx(2.0, abs=0.7)
    assert all(found.evidence(own).mean() > 0 for own in weak)
