"""The search as a value: stop rules, interruption, what goes on from generation to generation."""

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.solvers import Genetic, Hint, ListGenetic, SearchState
from trackweave.solvers.components import Components
from trackweave.solvers.genetic._operators import RANK, TOURNAMENT, breed, pick
from trackweave.solvers.genetic.report_genes import ReportGenes, make_lookup
from trackweave.solvers.genetic.search import Evolution
from trackweave.solvers.resumable import Start, _view

UNSEEDED = Genetic(
    population=20, generations=6, seeded=False, improvement=False, decompose=False, elite=0,
    selection="rank",
)  # fmt: skip
VARIANTS = {
    "default": Genetic(population=20, generations=6),
    "to the letter": UNSEEDED,
    "lone reports kept": replace(UNSEEDED, settle=False),
    "association list": replace(UNSEEDED, genotype="association-list"),
    "components, improved": replace(UNSEEDED, decompose=True, improvement=True, elite=2),
    "lists": ListGenetic(population=20, generations=6),
    "lists to the letter": ListGenetic(
        population=20, generations=6, seeded=False, improvement=False, decompose=False
    ),
}


def hard(seed: int = 0, n_rows: int = 300, n_parts: int = 2) -> AssignmentProblem:
    """Return dense problems side by side, whose bounds leave a gap."""
    rng = np.random.default_rng(seed)
    part = rng.integers(0, n_parts, (n_rows, 1))
    rows = rng.integers(1, 11, (n_rows, 4)) + 10 * part
    return AssignmentProblem.from_tuples(rows, rng.normal(-5.0, 1.0, n_rows))


def rng() -> np.random.Generator:
    return np.random.default_rng(9)


def outcome(answer: Answer) -> tuple[Any, ...]:
    return (answer.nodes.tolist(), answer.certificate, answer.evaluations, answer.stop_reason)


@pytest.fixture(params=VARIANTS.values(), ids=VARIANTS.keys())
def genetic(request: pytest.FixtureRequest) -> Genetic | ListGenetic:
    return request.param


class TestSizes:
    def test_grow_with_what_genes_decide_and_have_a_least(self) -> None:
        by_size = replace(UNSEEDED, population="by-size", generations="by-size", per_item=5)
        assert by_size.sizes(40) == (200, 80)
        assert by_size.sizes(1) == (20, 20)
        assert UNSEEDED.sizes(40) == (20, 6)
        assert replace(by_size, population=30).sizes(40) == (30, 80)

    def test_by_size_are_those_of_the_search(self) -> None:
        problem = hard(n_parts=1)
        by_size = replace(UNSEEDED, population="by-size", per_item=3, generations=2)
        assert by_size(problem, rng=rng()).evaluations == 2 * 3 * problem.n_items

    @pytest.mark.parametrize(
        "wrong",
        [{"population": "by-sise"}, {"generations": 0}, {"per_item": 0}, {"first": "sorted"}],
    )
    def test_refuses_other_words_and_too_few(self, wrong: dict[str, Any]) -> None:
        with pytest.raises(InvalidInputError, match=next(iter(wrong))):
            replace(UNSEEDED, **wrong)

    def test_elite_is_less_than_the_least_population(self) -> None:
        with pytest.raises(InvalidInputError, match="elite"):
            replace(UNSEEDED, population="by-size", elite=20)


class TestFirstIndividuals:
    def test_in_time_order_half_of_them_take_the_instants_in_order(self) -> None:
        search = begun(replace(UNSEEDED, first="in-time-order"), hard(n_parts=1))
        view = _view(Components.of(hard(n_parts=1), None, whole=True), 0)
        ranks = view.instant[search.bred.genes]
        in_order = (np.diff(ranks, axis=1) >= 0).all(axis=1)
        assert in_order[:10].all()
        assert not in_order[10:].any()
        # Within an instant they differ.
        assert len({tuple(genes) for genes in search.bred.genes[:10].tolist()}) == 10
        assert np.array_equal(np.sort(search.bred.genes, axis=1)[0], np.arange(view.instant.size))

    def test_are_random_otherwise(self) -> None:
        search = begun(UNSEEDED, hard(n_parts=1))
        assert len({tuple(genes) for genes in search.bred.genes.tolist()}) == 20


def begun(genetic: Genetic, problem: AssignmentProblem) -> Evolution:
    """Return the search of a problem as one, before its first evaluation."""
    view = _view(Components.of(problem, None, whole=True), 0)
    nothing = np.full(view.component.must.shape[0], -1, dtype=np.int64)
    return genetic._begin(view, Start([], nothing, np.inf, rng()))


class TestStopRules:
    def test_after_a_number_of_generations(self) -> None:
        answer = replace(UNSEEDED, generations=3)(hard(), rng=rng())
        assert (answer.evaluations, answer.stop_reason) == (3 * 20, "generations")

    def test_when_best_and_mean_are_close(self) -> None:
        wide = replace(UNSEEDED, spread=1e9)(hard(), rng=rng())
        assert (wide.evaluations, wide.stop_reason) == (20, "converged")
        start = UNSEEDED.start(hard(), rng=rng())
        first = UNSEEDED.advance(start, evaluations=20).search
        assert first is not None
        between = replace(UNSEEDED, spread=first.spread() * 0.9)(hard(), rng=rng())
        assert between.evaluations > 20

    def test_when_the_next_scan_arrives(self) -> None:
        asked = []

        def arrived() -> bool:
            asked.append(1)
            return len(asked) > 3

        problem = hard(n_rows=4000, n_parts=1)
        answer = UNSEEDED(problem, rng=rng(), stop=arrived)
        assert answer.stop_reason == "stopped"
        assert 0 < answer.evaluations < 6 * 20
        assert answer.nodes.size > 0

    def test_when_so_many_are_decoded_to_whole_generations(self) -> None:
        answer = replace(UNSEEDED, evaluations=50)(hard(), rng=rng())
        assert (answer.evaluations, answer.stop_reason) == (60, "evaluations")

    def test_when_the_bound_proves_the_best(self) -> None:
        easy = AssignmentProblem.from_tuples([[1, 1], [2, 2]], [-1.0, -1.0])
        answer = replace(UNSEEDED, generations=50)(easy, rng=rng())
        assert (answer.stop_reason, answer.status) == ("gap closed", "optimal")
        assert answer.evaluations == 20


class TestState:
    @pytest.mark.parametrize("chunk", [1, 7, 33])
    def test_in_chunks_saved_between_ends_as_uninterrupted(self, genetic, chunk: int) -> None:
        whole = genetic(hard(), rng=rng())
        state = genetic.start(hard(), rng=rng())
        chunks = 0
        while not state.done:
            state = pickle.loads(pickle.dumps(state))
            state = genetic.advance(state, evaluations=chunk)
            chunks += 1
        assert chunks > 1
        assert outcome(genetic.answer(state)) == outcome(whole)

    def test_stopped_and_resumed_ends_as_uninterrupted(self, genetic) -> None:
        asked = []

        def now_and_then() -> bool:
            asked.append(1)
            return len(asked) % 2 == 0

        whole = genetic(hard(), rng=rng())
        state = genetic.start(hard(), rng=rng())
        while not state.done:
            state = genetic.advance(state, stop=now_and_then)
        answer = genetic.answer(state)
        assert outcome(answer)[:3] == outcome(whole)[:3]

    def test_advancing_leaves_the_state_it_came_from(self, genetic) -> None:
        state = genetic.advance(genetic.start(hard(), rng=rng()), evaluations=25)
        before = pickle.dumps(state)
        first, second = genetic.advance(state), genetic.advance(state)
        genetic.answer(first)
        assert pickle.dumps(state) == before
        assert outcome(genetic.answer(first)) == outcome(genetic.answer(second))

    def test_answering_does_not_end_a_search(self, genetic) -> None:
        state = genetic.advance(genetic.start(hard(), rng=rng()), evaluations=25)
        assert genetic.answer(state).stop_reason == "paused"
        before = pickle.dumps(state)
        genetic.answer(state)
        assert pickle.dumps(state) == before

    def test_no_more_is_decoded_than_was_asked_for(self, genetic) -> None:
        state = genetic.start(hard(), rng=rng())
        for chunk in (0, 1, 13, 40):
            later = genetic.advance(state, evaluations=chunk)
            assert later.evaluations - state.evaluations == chunk
            state = later

    def test_the_generator_of_the_caller_is_not_kept(self, genetic) -> None:
        generator = rng()
        state = genetic.start(hard(), rng=generator)
        generator.random(100)
        generator.spawn(3)
        assert outcome(genetic.answer(genetic.advance(state))) == outcome(
            genetic(hard(), rng=rng())
        )


def search_of(problem: AssignmentProblem, parameters: Genetic) -> tuple[Evolution, ReportGenes]:
    """Return the search of the first component of a problem, and what it advances with."""
    state: SearchState = Genetic(seeded=False).start(problem, rng=rng())
    parts = state.relaxation.rest
    component = parts.component(0)
    node, item = parts.parts.node[: component.parent.shape[0]], parts.parts.item_of[parts.items(0)]
    lookup = make_lookup(component, problem.cost[node], problem.instant[item], True)
    nothing = np.full(component.must.shape[0], -1)
    start = Start([], nothing, np.inf, rng())
    coding = ReportGenes(component, lookup, parameters)
    return Evolution.begin(coding, problem.instant[item], start), coding


class TestGenerations:
    def test_elitism_keeps_the_best(self) -> None:
        search, coding = search_of(hard(), Genetic(population=12, elite=2, improvement=False))
        best = []
        for _ in range(12):
            ranking = np.argsort(search.cost, kind="stable")[:2]
            old = search.population[ranking].tolist()
            if search.generation:
                assert search.bred.genes[:2].tolist() == old
            search = search.advance(coding, 12)
            best.append(search.cost.min())
        assert (np.diff(best) <= 1e-12).all()
        assert best[-1] == pytest.approx(search.best)

    def test_without_elitism_the_best_found_is_kept_all_the_same(self) -> None:
        search, coding = search_of(hard(), Genetic(population=6, elite=0, improvement=False))
        lost, best = False, []
        for _ in range(25):
            search = search.advance(coding, 6)
            best.append(search.best)
            lost = lost or search.cost.min() > search.best
        assert lost
        assert (np.diff(best) <= 0).all()

    def test_the_first_generation_is_of_different_permutations(self) -> None:
        search, coding = search_of(hard(), Genetic(population=30, seeded=False))
        genes = sorted(coding.reads.gene_item.tolist())
        assert all(sorted(row) == genes for row in search.bred.genes.tolist())
        assert len({tuple(row) for row in search.bred.genes.tolist()}) == 30

    def test_children_are_permutations(self) -> None:
        search, coding = search_of(hard(), Genetic(population=30, seeded=False))
        genes = sorted(coding.reads.gene_item.tolist())
        for _ in range(5):
            search = search.advance(coding, 30)
            assert all(sorted(row) == genes for row in search.bred.genes.tolist())

    def test_without_crossover_and_mutation_children_are_their_parents(self) -> None:
        search, coding = search_of(hard(), Genetic(population=20))
        offspring, key = np.empty_like(search.population), np.empty(20, dtype=np.int64)
        breed(
            coding.component, coding.reads, True, search.population, np.arange(20.0),
            np.zeros(2), RANK, 0, rng(), offspring, key,
        )  # fmt: skip
        parents = {tuple(row) for row in search.population.tolist()}
        assert {tuple(row) for row in offspring.tolist()} <= parents

    def test_local_improvement_never_hurts(self) -> None:
        for seed in range(5):
            plain = replace(UNSEEDED, elite=1)(hard(seed), rng=rng())
            better = replace(UNSEEDED, elite=1, improvement=True)(hard(seed), rng=rng())
            assert better.cost < plain.cost

    def test_seeds_are_at_least_as_good_as_what_they_came_from(self) -> None:
        for seed in range(3):
            problem = hard(seed)
            long = Genetic(population=40, generations=60)(problem, rng=rng())
            short = Genetic(population=4, generations=1)
            assert short(problem, rng=rng(), hint=Hint(nodes=long.nodes)).cost <= (
                short(problem, rng=rng()).cost + 1e-9
            )


@pytest.mark.parametrize("selection", [RANK, TOURNAMENT])
def test_the_fitter_are_parents_more_often(selection: int) -> None:
    source, ranking = np.random.default_rng(0), np.array([3, 1, 4, 0, 2])
    picks = [pick(ranking, selection, source) for _ in range(5000)]
    share = np.bincount(picks, minlength=5)[ranking] / 5000
    # The better of two, or the density 2 (1 − u): the same, (9, 7, 5, 3, 1) in 25.
    assert share == pytest.approx(np.array([9, 7, 5, 3, 1]) / 25, abs=0.03)


@pytest.mark.parametrize(
    "wrong",
    [
        {"population": 1}, {"generations": 0}, {"evaluations": 0}, {"genotype": "tree"},
        {"selection": "best"}, {"crossover": 1.5}, {"mutation": -0.1}, {"elite": -1},
        {"elite": 50}, {"spread": -1.0}, {"spread": np.nan}, {"crossover": np.nan},
    ],
    ids=str,
)  # fmt: skip
def test_refuses_parameters_out_of_range(wrong: dict[str, Any]) -> None:
    name = next(iter(wrong))
    with pytest.raises(InvalidInputError, match=f"^{name}: "):
        Genetic(**wrong)
