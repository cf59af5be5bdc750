"""The preset is what the document says."""

import numpy as np
import pytest

from trackweave.association.problem import AssignmentProblem
from trackweave.config.fusion import order_of, settle_fusion
from trackweave.presets.huo_2008 import CONFIGURATION
from trackweave.solvers import ListGenetic


def test_is_the_documents_problem_search_and_rule() -> None:
    settings = settle_fusion(order_of(None), preset="huo-2008", process_noise=None)
    associator = settings.associator(["A", "B", "C"])
    assert associator.complete
    assert (associator.statistic.kind, associator.statistic.memory) == ("chain", "full")
    assert associator.statistic.correlation == "none"
    assert associator.confirm == "3/4"
    search = associator.search
    assert isinstance(search, ListGenetic)
    assert search.mutate == "swap"
    assert not (search.seeded)
    assert not (search.improvement)
    assert not (search.decompose)
    assert {key for key, value in settings.sources.items() if value == "preset"} >= {
        "complete", "confirm", "method", "search.population", "statistic.kind"
    }  # fmt: skip


def test_the_rates_make_up_the_population() -> None:
    search = CONFIGURATION["search"]
    assert search["reproduction"] + search["mutation"] < 1.0
    kept, mutants = round(200 * search["reproduction"]), round(200 * search["mutation"])
    options = {key: value for key, value in search.items() if key != "method"}
    assert ListGenetic(**options).shares == (kept, mutants)


@pytest.mark.slow
def test_finds_the_pairs_of_a_plain_problem() -> None:
    costs = np.full((6, 6), 10.0) - 9.0 * np.eye(6)
    table = np.argwhere(costs > 0) + 1
    problem = AssignmentProblem.from_tuples(table, costs.reshape(-1), alone=np.inf)
    options = {key: value for key, value in CONFIGURATION["search"].items() if key != "method"}
    assert ListGenetic(**options)(problem, rng=np.random.default_rng(1)).cost == 6.0
