"""The cheapest hypotheses against all of them, and their probabilities."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from oracles.assignment import all_hypotheses, random_problem, random_window
from trackweave.association.problem import AssignmentProblem, Status
from trackweave.errors import InvalidInputError
from trackweave.solvers import Greedy, Hint, MBest, Ranking

PROBLEMS = [random_problem(np.random.default_rng([5, seed])) for seed in range(40)]
ALL = [all_hypotheses(problem) for problem in PROBLEMS]
EVERY = MBest(hypotheses=5_000, visits=10**7)


def rng() -> np.random.Generator:
    return np.random.default_rng(2)


def after(asked: int) -> Callable[[], bool]:
    """Return a stop that comes when it was asked for so many times."""
    calls = iter(range(asked))
    return lambda: next(calls, None) is None


def side_by_side(*problems: AssignmentProblem) -> AssignmentProblem:
    """Return problems that share nothing as one."""
    nodes = np.cumsum([0, *(problem.n_nodes for problem in problems)])
    items = np.cumsum([0, *(problem.n_items for problem in problems)])
    pairs = list(zip(problems, nodes, items, strict=False))
    return AssignmentProblem(
        parent=np.concatenate([np.where(p.parent < 0, -1, p.parent + n) for p, n, _ in pairs]),
        item=np.concatenate([p.item + i for p, _, i in pairs]),
        cost=np.concatenate([p.cost for p in problems]),
        total=np.concatenate([p.total for p in problems]),
        must_cover=np.concatenate([p.must_cover for p in problems]),
        instant=np.concatenate([p.instant for p in problems]),
        base_cost=sum(p.base_cost for p in problems),
    )


def require_sound(
    ranking: Ranking, problem: AssignmentProblem, hypotheses: list[tuple[float, tuple[int, ...]]]
) -> None:
    """Refuse a ranking of anything but different hypotheses, rightly priced, in order."""
    cost_of = {nodes: cost for cost, nodes in hypotheses}
    found = [tuple(nodes.tolist()) for nodes in ranking.hypotheses]
    assert len(set(found)) == len(found) == ranking.cost.shape[0]
    assert ranking.cost == pytest.approx([cost_of[nodes] for nodes in found])
    assert (np.diff(ranking.cost) >= 0).all()
    assert 0 <= ranking.n_proven <= len(found)
    best = [cost for cost, _ in hypotheses[: ranking.n_proven]]
    assert ranking.cost[: ranking.n_proven] == pytest.approx(best)
    if ranking.is_complete:
        assert len(found) == ranking.n_proven == len(hypotheses)
    probability = ranking.probability
    assert probability.shape == (problem.n_nodes,)
    assert ((probability >= 0) & (probability <= 1)).all()
    if found:
        assert ranking.answer.nodes.tolist() == list(found[0])
        assert ranking.answer.cost == ranking.cost[0]


def probability_of(
    problem: AssignmentProblem, hypotheses: list[tuple[float, tuple[int, ...]]]
) -> np.ndarray:
    weight = np.exp([hypotheses[0][0] - cost for cost, _ in hypotheses])
    probability = np.zeros(problem.n_nodes)
    for share, (_, nodes) in zip(weight / weight.sum(), hypotheses, strict=True):
        probability[list(nodes)] += share
    return probability


class TestRanking:
    def test_all_hypotheses_are_found_and_weighed_where_more_are_asked_for(self) -> None:
        for problem, hypotheses in zip(PROBLEMS, ALL, strict=True):
            ranking = EVERY.rank(problem, rng=rng())
            require_sound(ranking, problem, hypotheses)
            assert ranking.is_complete
            wanted = probability_of(problem, hypotheses)
            assert ranking.probability == pytest.approx(wanted, abs=1e-12)

    @pytest.mark.parametrize("count", [1, 2, 7, 40])
    def test_the_cheapest_are_found_and_proven(self, count: int) -> None:
        for problem, hypotheses in zip(PROBLEMS, ALL, strict=True):
            ranking = MBest(hypotheses=count).rank(problem, rng=rng())
            require_sound(ranking, problem, hypotheses)
            assert ranking.n_proven == len(ranking.hypotheses) == min(count, len(hypotheses))
            assert ranking.is_complete == (count >= len(hypotheses)) or count == len(hypotheses)

    @pytest.mark.parametrize("margin", [1e-3, 1.0, 1e3])
    def test_the_margin_changes_no_ranking(self, margin: float) -> None:
        for problem, hypotheses in zip(PROBLEMS, ALL, strict=True):
            ranking = MBest(hypotheses=20, margin=margin).rank(problem, rng=rng())
            require_sound(ranking, problem, hypotheses)
            assert ranking.n_proven == min(20, len(hypotheses))

    def test_problems_that_share_nothing_combine(self) -> None:
        for seed in range(10):
            parts = [PROBLEMS[3 * seed + offset] for offset in range(3)]
            whole = side_by_side(*parts)
            singles = [ALL[3 * seed + offset][:60] for offset in range(3)]
            costs = [np.array([cost for cost, _ in single]) for single in singles]
            sums = costs[0][:, None, None] + costs[1][:, None] + costs[2]
            ranking = MBest(hypotheses=60).rank(whole, rng=rng())
            wanted = np.sort(sums, axis=None)[:60]
            assert ranking.cost == pytest.approx(wanted)
            assert ranking.n_proven == wanted.shape[0]

    def test_probabilities_of_problems_that_share_nothing_are_their_own(self) -> None:
        whole = EVERY.rank(side_by_side(PROBLEMS[1], PROBLEMS[2]), rng=rng()).probability
        apart = [EVERY.rank(problem, rng=rng()).probability for problem in PROBLEMS[1:3]]
        assert whole == pytest.approx(np.concatenate(apart))

    def test_ties_are_all_there(self) -> None:
        rows = [[a, b] for a in (1, 2, 3) for b in (1, 2, 3)]
        problem = AssignmentProblem.from_tuples(rows, np.full(9, -1.0))
        hypotheses = all_hypotheses(problem)
        ranking = EVERY.rank(problem, rng=rng())
        require_sound(ranking, problem, hypotheses)
        assert ranking.is_complete
        assert ranking.cost.tolist() == [-3.0] * 6 + [-2.0] * 18 + [-1.0] * 9 + [0.0]
        some = MBest(hypotheses=4).rank(problem, rng=rng())
        assert (some.cost.tolist(), some.n_proven, some.is_complete) == ([-3.0] * 4, 4, False)

    def test_items_that_have_to_be_covered_are_in_every_hypothesis(self) -> None:
        maker = np.random.default_rng(6)
        for _ in range(10):
            costs = maker.normal(0.0, 4.0, (3, 3, 3))
            costs[maker.random((3, 3, 3)) < 0.2] = np.inf
            problem = AssignmentProblem.from_array(costs)
            hypotheses = all_hypotheses(problem)
            ranking = EVERY.rank(problem, rng=rng())
            require_sound(ranking, problem, hypotheses)
            if hypotheses:
                assert ranking.is_complete
                wanted = probability_of(problem, hypotheses)
                assert ranking.probability == pytest.approx(wanted, abs=1e-9)
            else:
                assert ranking.answer.status is Status.INFEASIBLE
                assert (len(ranking.hypotheses), ranking.n_proven) == (0, 0)
                assert not ranking.probability.any()

    def test_an_empty_problem_has_one_hypothesis(self) -> None:
        ranking = MBest().rank(AssignmentProblem([], [], [], [], [], [], 3.0), rng=rng())
        assert [nodes.tolist() for nodes in ranking.hypotheses] == [[]]
        assert (ranking.cost.tolist(), ranking.n_proven, ranking.is_complete) == ([3.0], 1, True)

    def test_the_best_alone_is_certain(self) -> None:
        for problem in PROBLEMS[:10]:
            ranking = MBest(hypotheses=1).rank(problem, rng=rng())
            chosen = np.zeros(problem.n_nodes)
            chosen[ranking.answer.nodes] = 1.0
            assert ranking.probability.tolist() == chosen.tolist()

    def test_a_call_tells_the_best_and_the_probabilities(self) -> None:
        for problem in PROBLEMS:
            answer, ranking = EVERY(problem, rng=rng()), EVERY.rank(problem, rng=rng())
            assert answer.nodes.tolist() == ranking.answer.nodes.tolist()
            assert answer.certificate == ranking.answer.certificate
            # A call leaves out hundreds of hypotheses that are 10 nats dearer.
            assert answer.node_probability == pytest.approx(ranking.probability, abs=5e-3)

    @pytest.mark.parametrize("factor", [2.0**-30, 2.0**20])
    def test_ranks_in_any_unit(self, factor: float) -> None:
        for problem, hypotheses in zip(PROBLEMS[:20], ALL, strict=False):
            scaled = replace(
                problem,
                cost=problem.cost * factor,
                total=problem.total * factor,
                base_cost=problem.base_cost * factor,
            )
            ranking = MBest(hypotheses=15).rank(scaled, rng=rng())
            wanted = [cost * factor for cost, _ in hypotheses[:15]]
            assert ranking.cost == pytest.approx(wanted, rel=1e-6, abs=1e-6)


class TestShortOfTime:
    @pytest.mark.parametrize(("visits", "solves"), [(1, 0), (1, 3), (1, 10_000), (30, 2), (30, 0)])
    def test_what_is_not_enumerated_is_partitioned_and_nothing_is_claimed(
        self, visits: int, solves: int
    ) -> None:
        short = 0
        for problem, hypotheses in zip(PROBLEMS, ALL, strict=True):
            solver = MBest(hypotheses=9, visits=visits, solves=solves)
            ranking = solver.rank(problem, rng=rng())
            require_sound(ranking, problem, hypotheses)
            assert len(ranking.hypotheses) >= 1
            short += ranking.n_proven < min(9, len(hypotheses))
        assert (short > 0) == (solves < 10_000)

    def test_partitioning_by_a_solver_that_proves_nothing_claims_nothing_wrong(self) -> None:
        for problem, hypotheses in zip(PROBLEMS, ALL, strict=True):
            solver = MBest(hypotheses=9, visits=1, solves=20, solver=Greedy())
            require_sound(solver.rank(problem, rng=rng()), problem, hypotheses)

    def test_partitioning_knows_what_has_to_be_covered(self) -> None:
        problem = AssignmentProblem.from_array(np.random.default_rng(3).uniform(0, 9, (3, 3, 3)))
        ranking = MBest(hypotheses=50, visits=1, solves=10_000).rank(problem, rng=rng())
        require_sound(ranking, problem, all_hypotheses(problem))
        assert ranking.n_proven == len(ranking.hypotheses) == 36

    def test_stopped_at_once_there_is_one_hypothesis(self) -> None:
        for problem, hypotheses in zip(PROBLEMS, ALL, strict=True):
            ranking = MBest().rank(problem, rng=rng(), stop=lambda: True)
            require_sound(ranking, problem, hypotheses)
            assert len(ranking.hypotheses) == 1

    @pytest.mark.parametrize("asked", [2, 5, 12, 30])
    def test_stopped_midway_claims_nothing_wrong(self, asked: int) -> None:
        for problem, hypotheses in zip(PROBLEMS, ALL, strict=True):
            solver = MBest(hypotheses=30, visits=60)
            ranking = solver.rank(problem, rng=rng(), stop=after(asked))
            require_sound(ranking, problem, hypotheses)

    def test_little_is_done_between_two_looks_at_the_clock(self) -> None:
        maker = np.random.default_rng(1)
        dense = AssignmentProblem.from_array(maker.uniform(0, 9, (12, 12, 12)))
        window = random_window(maker, n_tracks=30, n_reports=100, max_nodes=2_000)
        solver = MBest(visits=1_500_000, solves=3)
        for problem in (dense, window):
            tried = []
            for asked in range(60):
                ranking = solver.rank(problem, rng=rng(), stop=after(asked))
                tried.append(ranking.answer.evaluations)
            assert max(tried) > 10**6
            assert np.diff(tried).max() < 300_000

    def test_a_hint_of_prices_proves_as_much(self) -> None:
        for problem, hypotheses in zip(PROBLEMS[:10], ALL, strict=False):
            prices = MBest()(problem, rng=rng()).prices
            ranking = MBest(hypotheses=5).rank(problem, rng=rng(), hint=Hint(prices=prices))
            require_sound(ranking, problem, hypotheses)
            assert ranking.n_proven == min(5, len(hypotheses))


@pytest.mark.parametrize(
    "wrong",
    [
        {"hypotheses": 0}, {"hypotheses": 100_001}, {"margin": 0.0}, {"margin": np.inf},
        {"margin": np.nan}, {"visits": 0}, {"solves": -1}, {"solver": 3}, {"solver": Greedy},
    ],
    ids=str,
)  # fmt: skip
def test_refuses_parameters_out_of_range(wrong: dict[str, Any]) -> None:
    with pytest.raises(InvalidInputError, match=f"^{next(iter(wrong))}: "):
        MBest(**wrong)
