"""Islands: the same answer on any number of threads; who sends what to whom, and when."""

import threading
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest

from oracles.assignment import hard_tuples
from trackweave.association.problem import Answer
from trackweave.errors import InvalidInputError
from trackweave.solvers import (
    Annealing,
    AntSystem,
    Genetic,
    Islands,
    ListGenetic,
    TabuSearch,
)
from trackweave.solvers.islands import (
    Archipelago,
    Island,
    _n_processors,
    _shares,
    run_together,
)
from trackweave.solvers.resumable import Start, View, _view

HARD = hard_tuples(4, 1500, 20)
MIXED = Islands(
    (Annealing(), Genetic(population=10), ListGenetic(population=10), TabuSearch()),
    islands=5,
    epoch=3,
    epochs=3,
)


def told(answer: Answer) -> tuple[object, ...]:
    return (
        answer.nodes.tolist(), answer.certificate, answer.evaluations, answer.stop_reason,
        answer.prices.tolist(),
    )  # fmt: skip


def begun(solver: Islands) -> tuple[View, Archipelago]:
    """Return the islands of the hard problem's first open component, and what they search."""
    state = solver.start(HARD, rng=np.random.default_rng(5))
    rest, index = state.relaxation.rest, state.queue[0]
    families = rest.families(index)
    start = Start(
        [seed[families] for seed in state.seeds], rest.taken[families],
        float(rest.cost[index]), np.random.default_rng(6),
    )  # fmt: skip
    view = _view(rest, index)
    return view, solver._begin(view, start)


def after_epochs(solver: Islands, epochs: int) -> tuple[View, Archipelago]:
    view, search = begun(solver)
    for _ in range(epochs):
        search, was_stopped = solver._proceed(view, search, np.inf, None)
        assert search.at_rest
        assert not was_stopped
    return view, search


class TestThreads:
    @pytest.mark.parametrize(
        "solver", [MIXED, Islands(epochs=3, epoch=5), replace(MIXED, neighbours=3)]
    )
    def test_change_nothing_in_the_answer(self, solver: Islands) -> None:
        answers = {
            threads: replace(solver, threads=threads)(HARD, rng=np.random.default_rng(3))
            for threads in (1, 2, 4, None)
        }
        assert answers[1].stop_reason == "epochs"
        for threads in (2, 4, None):
            assert told(answers[threads]) == told(answers[1])

    def test_are_at_most_as_many_as_islands(self) -> None:
        assert Islands(islands=3, threads=8)._n_threads() == 3
        assert Islands(islands=3, threads=2)._n_threads() == 2
        assert Islands(islands=1000)._n_threads() == _n_processors() >= 1

    def test_are_those_that_the_search_runs_on(self) -> None:
        seen = set()

        @dataclass(frozen=True, slots=True)
        class Watched(Annealing):
            def _go_on(self, view, search, evaluations):
                seen.add(threading.get_ident())
                return Annealing._go_on(self, view, search, evaluations)

        for threads, is_here in ((1, True), (3, False)):
            seen.clear()
            solver = Islands((Watched(),), islands=3, threads=threads, epochs=2)
            solver(HARD, rng=np.random.default_rng(1))
            assert (threading.get_ident() in seen) is is_here
            assert len(seen) >= 1


class TestMigration:
    def test_goes_round_the_ring_with_the_best_before_it(self) -> None:
        taken: list[tuple[int, float]] = []

        @dataclass(frozen=True, slots=True)
        class Host(Annealing):
            number: int = 0

            def admit(self, view, search, selection, cost):
                assert view.component.total[selection[selection >= 0]].sum() == pytest.approx(cost)
                taken.append((self.number, cost))
                return Annealing.admit(self, view, search, selection, cost)

        hosts = tuple(Host(number=number) for number in range(4))
        view, search = begun(Islands(hosts, islands=4, neighbours=2, epoch=3))
        islands = [
            island.advance(view, 12 * number + 12, np.inf, lambda: False)
            for number, island in enumerate(search.islands)
        ]
        bests = [island.best for island in islands]
        assert len(set(bests)) > 1
        moved = replace(search, islands=tuple(islands)).migrated(view, 2)
        assert taken == [
            (number, bests[(number - back) % 4]) for number in range(4) for back in (1, 2)
        ]
        assert [island.best for island in moved.islands] == pytest.approx(
            [min(bests[number], bests[number - 1], bests[number - 2]) for number in range(4)]
        )

    def test_spreads_the_best_to_all_in_as_many_epochs_as_there_are_others(self) -> None:
        solver = Islands((Annealing(), Genetic(population=10)), islands=4, epoch=2)
        view, search = after_epochs(solver, 1)
        best = search.best
        for _ in range(3):
            search, _ = solver._proceed(view, search, np.inf, None)
        assert all(island.best <= best + 1e-9 for island in search.islands)

    def test_none_leaves_each_island_to_itself(self) -> None:
        solver = Islands((TabuSearch(), Genetic(population=10)), islands=2, epoch=2, neighbours=0)
        view, search = after_epochs(solver, 3)
        for island, alone in zip(search.islands, begun(solver)[1].islands, strict=True):
            there = alone.advance(view, 6, np.inf, lambda: False)
            assert there.evaluations == island.evaluations
            assert there.best == island.best
            assert there.place.selection.tolist() == island.place.selection.tolist()

    def test_comes_after_the_same_evaluations_however_it_was_interrupted(self) -> None:
        whole = after_epochs(MIXED, 2)[1]
        view, search = begun(MIXED)
        for _ in range(10_000):
            search, _ = MIXED._proceed(view, search, 17, None)
            if search.epoch == 2:
                break
        assert search.evaluations == whole.evaluations
        assert [i.best for i in search.islands] == [i.best for i in whole.islands]

    def test_islands_of_one_method_draw_numbers_of_their_own(self) -> None:
        solver = Islands((Annealing(),), islands=3, neighbours=0, epoch=4)
        islands = after_epochs(solver, 1)[1].islands
        for one, other in pairwise(islands):
            assert one.place.holder.tolist() != other.place.holder.tolist()

    def test_gains_on_islands_that_know_nothing_of_each_other(self) -> None:
        together, apart = [], []
        for seed in range(3):
            rng = np.random.default_rng(seed)
            solver = replace(MIXED, islands=4, epochs=4)
            together.append(solver(HARD, rng=rng).cost)
            rng = np.random.default_rng(seed)
            apart.append(replace(solver, neighbours=0)(HARD, rng=rng).cost)
        assert np.mean(together) <= np.mean(apart)


class TestEnd:
    def test_is_that_of_the_archipelago_not_of_a_method(self) -> None:
        solver = Islands((Genetic(population=10, generations=1, evaluations=10),), epochs=3)
        answer = solver(HARD, rng=np.random.default_rng(1))
        assert answer.stop_reason == "epochs"
        search = after_epochs(solver, 3)[1]
        assert all(island.place.generation == 30 for island in search.islands)

    def test_comes_when_no_island_finds_better(self) -> None:
        solver = Islands((Genetic(population=4, mutation=0.0, improvement=False),), patience=2)
        answer = replace(solver, epochs=1000)(HARD, rng=np.random.default_rng(1))
        assert answer.stop_reason == "converged"

    def test_a_stop_reaches_every_thread(self) -> None:
        for threads in (1, 3):
            asked = []

            def stop(asked=asked) -> bool:
                asked.append(threading.get_ident())
                return len(asked) > 40

            solver = Islands(islands=3, threads=threads, epoch=10**6)
            answer = solver(HARD, rng=np.random.default_rng(1), stop=stop)
            assert answer.stop_reason == "stopped"
            assert set(asked) == {threading.get_ident()}
            assert len(asked) == 41

    @pytest.mark.parametrize("threads", [1, 3])
    def test_a_stop_that_fails_is_told_and_ends_the_search(self, threads: int) -> None:
        asked = []

        def stop() -> bool:
            asked.append(1)
            if len(asked) > 30:
                raise ZeroDivisionError
            return False

        solver = Islands(islands=3, threads=threads, epoch=10**6)
        with pytest.raises(ZeroDivisionError):
            solver(HARD, rng=np.random.default_rng(1), stop=stop)


@pytest.fixture(scope="module")
def known() -> tuple[View, np.ndarray, float]:
    """Return a far better answer than a short search finds."""
    view, search = after_epochs(Islands(epoch=60), 1)
    return view, search.selection, search.best


class TestAdmission:
    METHODS = (
        Annealing(), TabuSearch(), AntSystem(ants=6), AntSystem(ants=6, seeded=True),
        Genetic(population=10), Genetic(population=10, genotype="association-list"),
        ListGenetic(population=10),
    )  # fmt: skip

    @staticmethod
    def island(method, view: View) -> Island:
        nothing = np.full(view.component.must.shape[0], -1)
        start = Start([], nothing, np.inf, np.random.default_rng(3))
        return Island(method, start).advance(view, 1, np.inf, lambda: False)

    @pytest.mark.parametrize("method", METHODS, ids=lambda m: type(m).__name__)
    def test_of_a_better_answer_makes_it_the_best(self, method, known) -> None:
        view, selection, cost = known
        before = self.island(method, view)
        assert cost < before.best
        after = method.admit(view, before.place, selection, cost)
        assert after.best == pytest.approx(cost)
        assert after.selection.tolist() == selection.tolist()
        assert after.evaluations == before.evaluations
        assert after.at_rest

    @pytest.mark.parametrize("method", METHODS, ids=lambda m: type(m).__name__)
    def test_leaves_the_search_before_as_it_was(self, method, known) -> None:
        view, selection, cost = known
        before = self.island(method, view)
        kept = selection.copy()
        on = [before.advance(view, 4, np.inf, lambda: False).best]
        later = Island(method, method.admit(view, before.place, selection, cost))
        later = later.advance(view, 4, np.inf, lambda: False)
        on.append(before.advance(view, 4, np.inf, lambda: False).best)
        assert on[0] == on[1]
        assert later.best <= cost + 1e-9
        assert selection.tolist() == kept.tolist()

    @pytest.mark.parametrize("method", METHODS, ids=lambda m: type(m).__name__)
    def test_of_a_worse_answer_never_makes_it_worse(self, method, known) -> None:
        view, selection, cost = known
        island = Island(
            method, method.admit(view, self.island(method, view).place, selection, cost)
        )
        nothing = np.full_like(selection, -1)
        after = method.admit(view, island.place, nothing, 0.0)
        assert after.best == island.best
        assert after.selection.tolist() == selection.tolist()

    def test_puts_genes_in_the_place_of_the_worst_once(self, known) -> None:
        view, selection, cost = known
        method = Genetic(population=10, elite=1)
        before = self.island(method, view).place
        after = method.admit(view, before, selection, cost)
        worst = int(np.argmax(before.cost))
        others = np.arange(10) != worst
        assert after.cost[worst] == cost
        assert (after.population[others] == before.population[others]).all()
        assert (after.bred.genes[0] == after.population[worst]).all()
        assert method.admit(view, after, selection, cost) is after

    def test_lays_pheromone_as_one_ant_more(self, known) -> None:
        view, selection, cost = known
        method = AntSystem(ants=6)
        before = self.island(method, view).place
        after = method.admit(view, before, selection, cost)
        points, more = before.points, after.pheromone - before.pheromone
        taken = set(selection[selection >= 0].tolist())
        on_tour = np.flatnonzero(more > 0.0)
        assert {int(n) for n in points.node[on_tour] if n >= 0} == taken
        covered = [int(i) for i in points.item[on_tour][points.node[on_tour] < 0]]
        for node in taken:
            while node >= 0:
                covered.append(int(view.component.item[node]))
                node = int(view.component.parent[node])
        assert sorted(covered) == list(range(view.component.n_items))
        assert more[on_tour] == pytest.approx(1.0 / points.cost[on_tour].sum())
        assert (after.attraction != before.attraction).sum() == on_tour.size


def test_an_unseeded_method_begins_with_nothing_beside_a_seeded_one() -> None:
    solver = Islands((Annealing(), AntSystem(seeded=False)), islands=2)
    assert solver.seeded
    _, search = begun(solver)
    seeded, unseeded = (island.place for island in search.islands)
    assert seeded.seeds
    assert np.isfinite(seeded.cost)
    assert unseeded.seeds == []
    assert unseeded.cost == np.inf
    assert (unseeded.selection == -1).all()
    assert not Islands((AntSystem(),)).seeded
    assert not Islands((Annealing(), Genetic(decompose=False))).decompose


def test_shares_of_evaluations_are_whole_and_add_up() -> None:
    assert _shares(11, 4) == [3, 3, 3, 2]
    assert _shares(2, 4) == [1, 1, 0, 0]
    assert _shares(np.inf, 2) == [np.inf, np.inf]
    assert _shares(5, 0) == []


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"methods": ()}, r"methods: \(\); expected searches"),
        ({"methods": Annealing()}, "methods: Annealing.*; expected a sequence"),
        ({"methods": (Islands(),)}, "methods: .*; expected a sequence, each entry a Meta"),
        ({"methods": (Annealing,)}, "methods: .*; expected a sequence, each entry a Meta"),
        ({"islands": 1}, "islands: 1; expected at least one for each method"),
        ({"islands": 2.0}, "islands: 2.0; expected a whole number"),
        ({"threads": 0}, "threads: 0; expected a whole number ≥ 1, or None"),
        ({"threads": True}, "threads: True; expected"),
        ({"epoch": 0}, "epoch: 0; expected"),
        ({"neighbours": 4}, "neighbours: 4; expected fewer than islands"),
        ({"neighbours": -1}, "neighbours: -1; expected"),
        ({"epochs": 0}, "epochs: 0; expected"),
        ({"patience": 0}, "patience: 0; expected"),
    ],
)
def test_refuses_parameters_out_of_range(wrong: dict[str, object], said: str) -> None:
    with pytest.raises(InvalidInputError, match=said):
        Islands(**wrong)


class TestTogether:
    @pytest.mark.parametrize("threads", [1, 3])
    def test_results_come_in_the_order_of_tasks(self, threads: int) -> None:
        tasks = [lambda stop, number=number: number**2 for number in range(10)]
        assert run_together(tasks, threads, None) == ([n**2 for n in range(10)], False)

    @pytest.mark.parametrize("threads", [1, 2])
    def test_a_stop_once_said_is_not_asked_again(self, threads: int) -> None:
        asked = []

        def task(stop) -> bool:
            while not stop():
                pass
            return stop()

        def stop() -> bool:
            asked.append(1)
            return True

        assert run_together([task, task], threads, stop) == ([True, True], True)
        assert len(asked) == 1

    @pytest.mark.parametrize("threads", [1, 2])
    def test_what_a_task_raises_is_raised(self, threads: int) -> None:
        def task(stop) -> None:
            raise KeyError("lost")

        with pytest.raises(KeyError, match="lost"):
            run_together([task, task], threads, None)


def test_ends_by_the_islands_own_limits_where_asked_for() -> None:
    one = Genetic(population=10, generations=7, seeded=False, improvement=False, decompose=False)
    # Epochs of one chunk, which is a generation here.
    several = Islands((one,), islands=2, threads=1, epoch=1, epochs=2, own_limits=True)
    answer = several(HARD, rng=np.random.default_rng(1))
    assert answer.stop_reason == "generations"
    assert answer.evaluations == 2 * 7 * 10
    threaded = replace(several, threads=2)(HARD, rng=np.random.default_rng(1))
    assert told(threaded) == told(answer)
