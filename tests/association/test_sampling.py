"""Drawn answers against the enumeration of all of them."""

import itertools
from typing import Any

import numpy as np
import pytest

from trackweave.association.plots_rule import PlotsRule, ScoredTuples, scene_plots
from trackweave.association.sampling import Sampling
from trackweave.errors import InvalidInputError
from trackweave.simulation.scenes import BearingKind, PositionKind, draw_scene

NONE = np.empty(0, dtype=np.int64)


def scored_tuples(tuples: Any, costs: Any) -> ScoredTuples:
    """Return tuples all of which are at one place."""
    n = len(costs)
    return ScoredTuples(np.array(tuples), np.array(costs), np.zeros((n, 2)), np.zeros((n, 2, 2)))


def random_tuples(
    rng: np.random.Generator, sizes: tuple[int, ...], *, with_lone: bool
) -> ScoredTuples:
    """Return most of the tuples of so many plots of each sensor, at random costs."""
    found = [
        tuple_
        for tuple_ in itertools.product(*(range(size + 1) for size in sizes))
        if np.count_nonzero(tuple_) >= (1 if with_lone else 2) and rng.random() < 0.8
    ]
    return scored_tuples(found, rng.normal(-0.3, 1.5, len(found)))


def exact_probabilities(scored: ScoredTuples) -> np.ndarray:
    """Return the share of all answers' weight that has each tuple."""
    plots = [{(s, n) for s, n in enumerate(row) if n} for row in scored.tuples.tolist()]
    weight = np.zeros(len(scored))

    def descend(row: int, used: set[tuple[int, int]], chosen: list[int], cost: float) -> float:
        if row == len(scored):
            weight[chosen] += np.exp(-cost)
            return float(np.exp(-cost))
        total = descend(row + 1, used, chosen, cost)
        if not plots[row] & used:
            cost += float(scored.costs[row])
            total += descend(row + 1, used | plots[row], [*chosen, row], cost)
        return total

    return weight / descend(0, set(), [], 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("with_lone", [False, True])
@pytest.mark.parametrize(("seed", "sizes"), [(1, (3, 2, 2)), (2, (2, 1, 2, 1)), (3, (4, 3))])
def test_tuples_are_drawn_as_often_as_they_are_probable(
    seed: int, sizes: tuple[int, ...], with_lone: bool
) -> None:
    scored = random_tuples(np.random.default_rng(seed), sizes, with_lone=with_lone)
    exact = exact_probabilities(scored)
    assert exact.max() > 0.1
    draws = Sampling(10_000, margin=np.ptp(scored.costs))(
        scored, NONE, rng=np.random.default_rng(4)
    )
    # Draws depend on each other: three standard deviations of a third of their number.
    assert np.abs(draws.probability - exact) == pytest.approx(0.0, abs=0.026)


@pytest.mark.parametrize("kind", [PositionKind(3, 12, 4.0), PositionKind(9, 3), BearingKind(4, 8)])
def test_no_answer_uses_a_plot_twice(kind: PositionKind | BearingKind) -> None:
    scene = draw_scene(kind, np.random.default_rng(5))
    rule = PlotsRule(scene.object_density, area=scene.area, negative_only=kind.n_sensors > 4)
    scored = rule(scene_plots(scene))
    draws = Sampling(60)(scored, NONE, rng=np.random.default_rng(6))
    assert len(draws.answers) == 60
    assert len({tuple(answer.tolist()) for answer in draws.answers}) > 1
    for answer in draws.answers:
        assert (np.diff(answer) > 0).all()
        for chosen in scored.tuples[answer].T:
            assert (np.bincount(chosen[chosen > 0]) <= 1).all()
    told = np.bincount(np.concatenate(draws.answers), minlength=len(scored))
    assert draws.probability == pytest.approx(told / 60)


def test_a_good_answer_found_beforehand_is_where_drawing_begins() -> None:
    pairs = scored_tuples([[1, 1], [1, 2], [2, 1], [2, 2]], [-60.0, 50.0, 50.0, -60.0])
    (answer,) = Sampling(1, 0)(pairs, [0, 3], rng=np.random.default_rng(7)).answers
    assert answer.tolist() == [0, 3]


def test_tuples_beyond_the_margin_are_left_out() -> None:
    pairs = scored_tuples([[1, 1], [2, 2]], [1.0, 0.9])
    draws = Sampling(2000, margin=0.95)(pairs, NONE, rng=np.random.default_rng(8))
    assert draws.probability[0] == 0.0
    assert draws.probability[1] == pytest.approx(1.0 / (1.0 + np.exp(0.9)), abs=0.04)


def test_the_same_seed_draws_the_same() -> None:
    scored = random_tuples(np.random.default_rng(9), (4, 4, 4), with_lone=True)
    first, second = (Sampling(50)(scored, NONE, rng=np.random.default_rng(10)) for _ in range(2))
    assert [a.tolist() for a in first.answers] == [a.tolist() for a in second.answers]


def test_a_stop_leaves_one_answer_at_least() -> None:
    scored = random_tuples(np.random.default_rng(9), (4, 4, 4), with_lone=False)
    asked = iter([False] * 12)
    draws = Sampling(50, 10)(
        scored, NONE, rng=np.random.default_rng(1), stop=lambda: next(asked, True)
    )
    assert len(draws.answers) == 3
    draws = Sampling(50)(scored, NONE, rng=np.random.default_rng(1), stop=lambda: True)
    assert len(draws.answers) == 1


def test_nothing_to_draw_from_is_an_empty_answer() -> None:
    draws = Sampling(3)(
        scored_tuples(np.empty((0, 3), dtype=np.int64), []), NONE, rng=np.random.default_rng(1)
    )
    assert [answer.size for answer in draws.answers] == [0, 0, 0]
    assert draws.probability.shape == (0,)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"sweeps": 0}, "sweeps: 0; expected a whole number ≥ 1"),
        ({"sweeps": 2.5}, "sweeps: 2.5; expected a whole number"),
        ({"warm_up": -1}, "warm_up: -1; expected a whole number ≥ 0"),
        ({"margin": float("nan")}, "margin: nan; expected a finite number"),
    ],
)
def test_parameters_out_of_range_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        Sampling(**options)


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ([2], "expected rows of 2 tuples"),
        ([-1], "expected rows of 2 tuples"),
        ([0, 1], "start: tuples that share a plot"),
        ([0.5], "start"),
    ],
)
def test_a_start_that_is_no_answer_is_refused(start: list[Any], message: str) -> None:
    pairs = scored_tuples([[1, 1], [1, 2]], [-1.0, -1.0])
    with pytest.raises(InvalidInputError, match=message):
        Sampling()(pairs, start, rng=np.random.default_rng(1))


def test_what_are_no_tuples_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="scored"):
        Sampling()("tuples", NONE, rng=np.random.default_rng(1))  # type: ignore[arg-type]
