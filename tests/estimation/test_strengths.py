"""Strengths tell objects from false alarms only where they do, whatever their distribution."""

from dataclasses import replace

import numpy as np
import pytest

from estimation.test_estimate import table
from trackweave.arrays import FloatArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimate import estimate
from trackweave.estimation.estimates import Estimates
from trackweave.estimation.refine import Followed
from trackweave.estimation.strengths import strength_model, with_strengths

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


def test_where_many_objects_that_go_their_way_are_weak_weak_ones_count() -> None:
    boats = [RNG.normal(25.0, 6.0, 140) for _ in range(4)]
    buoys = [RNG.normal(22.0, 6.0, 140) for _ in range(5)]
    ships = [RNG.normal(60.0, 6.0, 200) for _ in range(9)]
    move = [True] * 4 + [False] * 5 + [True] * 9
    found = strength_model([*boats, *buoys, *ships], RNG.normal(15.0, 7.0, 500), move=move)
    assert found is not None
    assert all(found.evidence(own).mean() > -0.5 for own in (*boats, *buoys))
    # One alone may be a car that passes by a false alarm.
    few = strength_model([*boats[:1], *buoys, *ships], RNG.normal(15.0, 7.0, 500), move=move[3:])
    assert few is not None
    assert few.target_spread == 0.0


def test_weak_tracks_that_wander_are_objects_where_few_reports_are_alone() -> None:
    bright = [RNG.normal(60.0, 6.0, 30) for _ in range(12)]
    dim = [RNG.normal(22.0, 6.0, 30) for _ in range(20)]
    wander = [True] * 32
    found = strength_model([*bright, *dim], RNG.normal(15.0, 5.0, 300), wander=wander)
    assert found is not None
    assert all(found.evidence(own).mean() > -0.5 for own in dim)
    # Those that stay may be false alarms, and so may those be beside many that are alone.
    for wander, alone in (([False] * 32, 300), ([True] * 32, 900)):
        found = strength_model([*bright, *dim], RNG.normal(15.0, 5.0, alone), wander=wander)
        assert found is not None
        assert all(found.evidence(own).mean() < -1.0 for own in dim)


def dim_cells(*, stay: bool) -> tuple[ReportTable, Followed, Estimates]:
    """Return bright and dim cells and debris of 80 frames; dim ones wander, or all stay."""
    rng = np.random.default_rng(1)
    time, place, level, track = [], [], [], []
    for each in range(12):
        begin, speed = rng.uniform(0, 100, 2), rng.normal(0, 0 if stay and each > 7 else 0.5, 2)
        for frame in range(80):
            time.append(float(frame))
            place.append(begin + frame * speed + rng.normal(0, 0.3, 2))
            level.append(rng.normal(60.0 if each > 7 else 100.0, 5.0))
            track.append(each)
    for frame in range(80):
        for _ in range(3):
            time.append(float(frame))
            place.append(rng.uniform(0, 100, 2))
            level.append(rng.uniform(20.0, 70.0))
            track.append(-1)
    order = np.argsort(time, kind="stable")
    reports = table(np.array(time)[order], np.array(place)[order])
    reports = replace(reports, strength=np.array(level)[order])
    followed = Followed(np.array(track)[order], {"A": np.arange(80.0)})
    return reports, followed, estimate(reports)


@pytest.mark.parametrize("stay", [False, True])
def test_what_is_dim_and_wanders_far_is_an_object_and_what_stays_is_none(stay: bool) -> None:
    reports, followed, estimates = dim_cells(stay=stay)
    model = with_strengths(estimates, reports, followed).sensors["A"].strength
    assert model is not None
    dim = model.evidence(np.full(1, 60.0))[0]
    assert dim < -3.0 if stay else dim > -2.0
