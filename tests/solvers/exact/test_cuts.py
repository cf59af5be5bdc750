"""Columns, weights of pairs and cuts against their definitions."""

from itertools import combinations

import numpy as np
import pytest

from oracles.assignment import hard_tuples, in_ones, random_problem, random_required, sequence
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers._kernels import Component
from trackweave.solvers.components import Components
from trackweave.solvers.exact._cuts import (
    bound_of,
    columns_of,
    pair_weights,
    reduced_costs,
    violated_triples,
)

PROBLEMS = [random_problem(np.random.default_rng([14, seed])) for seed in range(30)]
PROBLEMS += [hard_tuples(seed, 24, 4) for seed in range(6)]
PROBLEMS += [random_required(np.random.default_rng([4, seed])) for seed in range(12)]


def wholes() -> list[tuple[AssignmentProblem, Components, Component]]:
    found = [(problem, Components.of(in_ones(problem), None, whole=True)) for problem in PROBLEMS]
    return [(problem, parts, parts.component(0)) for problem, parts in found if len(parts)]


def fractional(n_columns: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return some columns and how much of each is taken."""
    column = np.flatnonzero(rng.random(n_columns) < 0.6)
    return column, rng.uniform(0.0, 1.0, column.shape[0])


def test_columns_are_the_sequences_that_may_end() -> None:
    for problem, parts, component in wholes():
        node, start, items = columns_of(component)
        of_problem = parts.parts.node[node]
        assert sorted(of_problem.tolist()) == np.flatnonzero(np.isfinite(problem.total)).tolist()
        for column, whole in enumerate(of_problem.tolist()):
            own = items[start[column] : start[column + 1]]
            assert sorted(parts.parts.item_of[own].tolist()) == sorted(sequence(problem, whole))
            assert (np.diff(own) > 0).all()


def test_pairs_weigh_what_the_sequences_with_both_are_taken() -> None:
    rng = np.random.default_rng(1)
    for _, _, component in wholes():
        node, start, items = columns_of(component)
        column, value = fractional(node.shape[0], rng)
        weight = pair_weights(start, items, column, value, component.n_items)
        wanted = np.zeros_like(weight)
        for index, share in zip(column.tolist(), value.tolist(), strict=True):
            for one, other in combinations(items[start[index] : start[index + 1]].tolist(), 2):
                wanted[one, other] += share
        assert weight == pytest.approx(wanted + wanted.T)


def test_cuts_are_all_that_are_broken_by_more_than_asked() -> None:
    rng = np.random.default_rng(2)
    n_found = 0
    for _, _, component in wholes():
        node, start, items = columns_of(component)
        column, value = fractional(node.shape[0], rng)
        weight = pair_weights(start, items, column, value, component.n_items)
        triples, excess = violated_triples(start, items, column, value, weight, 0.05)
        found = {tuple(sorted(row)): by for row, by in zip(triples.tolist(), excess, strict=True)}
        assert len(found) == triples.shape[0]
        own = [set(items[start[index] : start[index + 1]].tolist()) for index in column.tolist()]
        for triple in combinations(range(component.n_items), 3):
            taken = sum(
                share for s, share in zip(own, value, strict=True) if len(s & {*triple}) > 1
            )
            # Three items that are not wanted together pairwise make no cut of use.
            linked = all(weight[one, other] > 1e-6 for one, other in combinations(triple, 2))
            if triple in found:
                assert found[triple] == pytest.approx(taken - 1.0)
            elif linked:
                assert taken - 1.0 <= 0.05 + 1e-9
        n_found += len(found)
    assert n_found > 20


def test_no_answer_breaks_a_cut() -> None:
    # Of the sequences with two or three of three items, any two share one.
    for _, _, component in wholes():
        node, start, items = columns_of(component)
        own = [set(items[start[c] : start[c + 1]].tolist()) for c in range(node.shape[0])]
        for triple in combinations(range(min(component.n_items, 8)), 3):
            inside = [s for s in own if len(s & {*triple}) > 1]
            assert all(one & other for one, other in combinations(inside, 2))


def test_bound_is_what_the_families_cost_at_least() -> None:
    rng = np.random.default_rng(3)
    for _, _, component in wholes():
        node, start, items = columns_of(component)
        price = rng.exponential(1.0, component.n_items)
        total, family = component.total[node], component.family[node]
        reduced = reduced_costs(start, items, total, price)
        for column in range(node.shape[0]):
            own = price[items[start[column] : start[column + 1]]].sum()
            assert reduced[column] == pytest.approx(total[column] + own)
        allowed = rng.random(node.shape[0]) < 0.7
        least, best = bound_of(reduced, family, component.must, allowed)
        for number, must in enumerate(component.must.tolist()):
            options = reduced[(family == number) & allowed].tolist()
            assert best[number] == min(options + ([] if must else [0.0]), default=np.inf)
        assert least == pytest.approx(best.sum())
