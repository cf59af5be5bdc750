"""Decoding against its slow twin, and reports of one instant in any order."""

import itertools

import numpy as np
import pytest

from oracles.assignment import random_window
from oracles.decoding import Decoder, decode
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers import Exact
from trackweave.solvers.genetic._decoding import decode_associations
from trackweave.solvers.genetic._operators import random_association
from trackweave.solvers.genetic.report_genes import genes_of, in_time_order


def windows(n: int) -> list[AssignmentProblem]:
    return [
        random_window(np.random.default_rng([4, seed]), n_reports=8, max_nodes=45)
        for seed in range(n)
    ]


@pytest.mark.parametrize("settle", [True, False])
def test_decodes_as_the_slow_twin(settle: bool) -> None:
    rng = np.random.default_rng(1)
    for problem in windows(40):
        decoder = Decoder.of(problem, settle=settle)
        for _ in range(15):
            order = rng.permutation(decoder.items()).tolist()
            cost, tracks = decoder.decode(order)
            slow_cost, slow_tracks = decode(problem, order, settle=settle)
            assert tracks == slow_tracks
            assert cost == pytest.approx(slow_cost, abs=1e-9)


def test_shared_beginnings_change_nothing() -> None:
    rng = np.random.default_rng(2)
    for problem in windows(20):
        decoder = Decoder.of(problem, settle=True)
        order, trail = decoder.items(), decoder.trail()
        for _ in range(30):
            first = int(rng.integers(0, len(order)))
            order = order[:first] + rng.permutation(order[first:]).tolist()
            assert decoder.decode(order, trail) == decoder.decode(order)


def simultaneous(n_sensors: int, *, track: bool, n_scans: int = 1) -> AssignmentProblem:
    """Return all sequences of one report per sensor and scan, each report dearer alone.

    The cost belongs to the set: a report costs 1 less for each one that it is with.
    """
    n_reports = n_sensors * n_scans
    parent, item, cost = [], [], []

    def grow(above: int, first: int, size: int) -> None:
        for report in range(first, n_reports):
            parent.append(above)
            item.append(report)
            cost.append(3.0 - 1.01 * size * (size + 1) + 1e-3 * report)
            grow(len(parent) - 1, report + 1, size + 1)

    if track:
        parent.append(-1)
        item.append(n_reports)
        cost.append(0.0)
        grow(0, 0, 1)
    else:
        grow(-1, 0, 0)
    instant = np.append(np.arange(n_reports) // n_sensors, [-1] * track)
    must = np.arange(n_reports + track) >= n_reports
    return AssignmentProblem(parent, item, cost, cost, must, instant)


@pytest.mark.parametrize("track", [True, False])
@pytest.mark.parametrize("n_sensors", [2, 3, 4])
def test_reports_of_one_instant_join_in_any_order(n_sensors: int, track: bool) -> None:
    decoder = Decoder.of(simultaneous(n_sensors, track=track), settle=False)
    whole = tuple(range(n_sensors))
    for order in itertools.permutations(whole):
        _, tracks = decoder.decode(order)
        assert tracks == {((n_sensors, *whole) if track else whole)}


def test_reports_of_an_earlier_instant_do_not_join_afterwards() -> None:
    decoder = Decoder.of(simultaneous(2, track=False, n_scans=2), settle=False)
    assert decoder.decode([1, 0, 3, 2])[1] == {(0, 1, 2, 3)}
    assert decoder.decode([1, 3, 0, 2])[1] == {(1, 2, 3), (0,)}
    assert decoder.decode([3, 1, 0, 2])[1] == {(0, 1, 2), (3,)}


def test_taking_over_a_beginning_is_taken_back() -> None:
    decoder = Decoder.of(simultaneous(3, track=False), settle=False)
    trail = decoder.trail()
    for order in [(2, 1, 0), (2, 0, 1), (1, 2, 0), (1, 0, 2), (2, 1, 0), (2, 1, 0)]:
        assert decoder.decode(order, trail) == decoder.decode(order)


def test_a_sequence_that_may_not_end_is_cut_back_to_where_it_may() -> None:
    problem = AssignmentProblem(
        parent=[-1, 0, 1], item=[2, 0, 1], cost=[0.0, -1.0, -2.0],
        total=[0.5, -0.5, np.inf], must_cover=[0, 0, 1], instant=[0, 1, -1],
    )  # fmt: skip
    assert Decoder.of(problem, settle=True).decode([0, 1]) == (-0.5, {(2, 0)})


def test_a_poor_new_track_dissolves_unless_lone_reports_are_kept() -> None:
    problem = AssignmentProblem([-1], [0], [2.0], [2.0], [False], [0])
    assert Decoder.of(problem, settle=True).decode([0]) == (0.0, set())
    assert Decoder.of(problem, settle=False).decode([0]) == (2.0, {(0,)})


def link(decoder: Decoder, genes: np.ndarray) -> tuple[float, set[tuple[int, ...]]]:
    component = decoder.component
    n_families = component.must.shape[0]
    selection, current = np.empty(n_families, np.int64), np.empty(n_families, np.int64)
    ending = np.empty(component.n_items, np.int64)
    cost = decode_associations(component, decoder.lookup, genes, current, ending, selection)
    return cost, decoder.hypothesis(selection)


class TestAssociationList:
    @pytest.fixture
    def decoder(self) -> Decoder:
        return Decoder.of(simultaneous(1, track=False, n_scans=3), settle=False)

    @pytest.mark.parametrize(
        ("genes", "tracks"),
        [
            ([-1, 0, 1], {(0, 1, 2)}),
            ([-1, 0, 0], {(0, 1), (2,)}),
            ([-1, -1, 0], {(0, 2), (1,)}),
            ([-1, -1, -1], {(0,), (1,), (2,)}),
            ([-1, 2, 1], {(0,), (1, 2)}),
        ],
    )
    def test_links_each_report_to_the_one_it_names(self, decoder, genes, tracks) -> None:
        assert link(decoder, np.array(genes))[1] == tracks

    def test_an_answer_can_be_written_and_read(self) -> None:
        for problem in windows(30):
            decoder = Decoder.of(problem, settle=True)
            best = Exact()(problem, rng=np.random.default_rng(0))
            selection = decoder.parts.selection_of(best.nodes)
            genes = genes_of(decoder.component, decoder.lookup, False, selection)
            cost, _ = link(decoder, genes)
            assert cost + problem.base_cost == pytest.approx(best.cost, abs=1e-9)

    def test_a_random_gene_names_what_can_come_before(self) -> None:
        rng = np.random.default_rng(0)
        for problem in windows(10):
            decoder = Decoder.of(problem, settle=True)
            component, lookup = decoder.component, decoder.lookup
            for place, item in enumerate(lookup.gene_item.tolist()):
                above = component.parent[component.item == item]
                allowed = {int(component.item[node]) if node >= 0 else -1 for node in above}
                seen = {random_association(component, lookup, place, rng) for _ in range(60)}
                assert seen <= (allowed or {-1})

    def test_taking_reports_as_they_came_links_nothing(self, decoder: Decoder) -> None:
        assert in_time_order(decoder.component, decoder.lookup, False).tolist() == [-1] * 3
        assert in_time_order(decoder.component, decoder.lookup, True).tolist() == [0, 1, 2]


class TestGenesOf:
    def test_are_a_permutation_with_the_best_sequences_first(self) -> None:
        problem = AssignmentProblem.from_tuples([[1, 1], [2, 2], [3, 0]], [-1.0, -2.0, 0.0])
        decoder = Decoder.of(problem, settle=True)
        ends = np.flatnonzero(np.isfinite(problem.total))
        selection = decoder.parts.selection_of(ends)
        genes = genes_of(decoder.component, decoder.lookup, True, selection)
        items = decoder.parts.parts.item_of[genes].tolist()
        assert items[:4] == [1, 4, 0, 3]
        assert sorted(items) == sorted(decoder.items())

    def test_stay_a_permutation_where_sequences_overlap(self) -> None:
        for problem in windows(10):
            decoder = Decoder.of(problem, settle=True)
            selection = decoder.parts.selection_of(np.arange(problem.n_nodes))
            genes = genes_of(decoder.component, decoder.lookup, True, selection)
            assert sorted(genes.tolist()) == sorted(decoder.lookup.gene_item.tolist())
