"""Which points of a sweep are tried: all different, the same again, and soon the good ones."""

import sys
from typing import Any

import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.experiments.sampling import proposals
from trackweave.experiments.sweeps import Point, Sweep

GRID = Sweep({("one",): tuple(range(40)), ("in", "two"): tuple(np.geomspace(1e-3, 1e3, 40))})


def worth(point: Point) -> float:
    """Be best, 0, at 30 and about 10."""
    return -abs(point["one",] - 30) - 3.0 * abs(np.log10(point["in", "two"]) - 1.0)


def tried(sampler: str, sweep: Sweep, count: int, seed: int, of: Any = worth) -> list[Point]:
    asked = proposals(sampler, sweep, count, np.random.default_rng(seed))
    points = new = next(asked)
    while True:
        try:
            new = asked.send([of(point) for point in new])
        except StopIteration:
            return points
        points = points + new


@pytest.mark.parametrize("sampler", ["random", "tpe"])
def test_points_differ_and_are_the_same_again(sampler: str) -> None:
    if sampler == "tpe":
        pytest.importorskip("optuna")
    first, again, other = (tried(sampler, GRID, 30, seed) for seed in (1, 1, 2))
    assert len({tuple(point.values()) for point in first}) == len(first) == 30
    assert first == again != other


@pytest.mark.parametrize("sampler", ["random", "tpe"])
@pytest.mark.parametrize("count", [6, 7])
def test_all_points_are_tried_where_there_are_few(sampler: str, count: int) -> None:
    if sampler == "tpe":
        pytest.importorskip("optuna")
    few = Sweep({("a",): (1, 2, 3), ("b",): ("x", "y")})
    assert tried(sampler, few, count, 1, len) == list(few.points())


def test_the_estimator_comes_nearer_to_the_best_than_chance() -> None:
    pytest.importorskip("optuna")
    best = {
        sampler: np.mean([max(map(worth, tried(sampler, GRID, 60, seed))) for seed in range(6)])
        for sampler in ("random", "tpe")
    }
    assert best["tpe"] > 0.5 * best["random"]


def test_the_estimator_takes_words_and_what_failed() -> None:
    pytest.importorskip("optuna")
    sweep = Sweep({("kind",): ("a", "b", "c"), ("n",): tuple(range(30))})

    def failing(point: Point) -> float:
        return -np.inf if point["kind",] == "a" else float(point["n",])

    points = tried("tpe", sweep, 40, 3, failing)
    assert max(map(failing, points)) >= 28.0
    late = points[20:]
    assert sum(point["kind",] == "a" for point in late) < len(late) / 3


def test_optuna_missing_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "optuna", None)
    with pytest.raises(InvalidInputError, match=r"tune.sampler: 'tpe' needs Optuna, .*\[tune\]"):
        proposals("tpe", GRID, 5, np.random.default_rng(1))
