"""The genetic search of one component, as a value, whatever its individuals are."""

import copy
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.solvers._kernels import Component
from trackweave.solvers.lists import Lists, lists_of
from trackweave.solvers.metaheuristic import polish
from trackweave.solvers.resumable import Start

__all__ = ["Coding", "Evolution", "Offspring", "items_of"]


class Offspring(NamedTuple):
    """Individuals, the costs of those that are known, and the others in order of decoding."""

    genes: IntArray
    cost: FloatArray
    order: IntArray

    @classmethod
    def unknown(cls, genes: IntArray, order: IntArray) -> Self:
        """Return individuals none of which has a cost yet."""
        return cls(genes, np.full(genes.shape[0], np.inf), order)


@dataclass(frozen=True, slots=True, eq=False)
class Coding(ABC):
    """What tells one kind of individual from another: making, reading and breeding them.

    ``reads`` is what decoding reads besides the component.
    """

    component: Component
    reads: Any
    parameters: Any

    @property
    def tolerance(self) -> float:
        """The greatest change of a generation's best cost that counts as none [nats]."""
        return 0.0

    @abstractmethod
    def first(self, start: Start) -> IntArray:
        """Return the first individuals, random but for what is known beforehand."""

    @abstractmethod
    def individual(self, selection: IntArray, length: int) -> IntArray:
        """Return the individual, of so many genes a row, that stands for a selection."""

    @abstractmethod
    def evaluate(
        self, bred: Offspring, rows: IntArray, cost: FloatArray, selection: IntArray, best: float
    ) -> float:
        """Write the costs of some individuals, and the best selection; return its cost."""

    @abstractmethod
    def breed(self, population: IntArray, cost: FloatArray, rng: np.random.Generator) -> Offspring:
        """Return the next generation."""


@dataclass(frozen=True, slots=True, eq=False)
class Evolution:
    """Where a search stands; ``advance`` returns where it stands later and leaves this one be.

    ``position`` individuals of the offspring's order are evaluated; when all are, the offspring
    become the population. The best cost of so many generations as ``unchanged`` counts was, in
    a row, that of the one before.
    """

    lists: Lists
    reads: Any
    population: IntArray
    cost: FloatArray
    bred: Offspring
    position: int
    generation: int
    unchanged: int
    evaluations: int
    selection: IntArray
    best: float
    rng: np.random.Generator

    @classmethod
    def begin(cls, coding: Coding, instant: IntArray, start: Start) -> Self:
        """Return a search before its first evaluation; ``instant`` ranks the items in time."""
        genes = coding.first(start)
        size = genes.shape[0]
        return cls(
            lists=lists_of(coding.component, instant),
            reads=coding.reads,
            population=genes,
            cost=np.full(size, np.inf),
            bred=Offspring.unknown(genes, np.arange(size)),
            position=0,
            generation=0,
            unchanged=0,
            evaluations=0,
            selection=start.selection.copy(),
            best=start.cost,
            rng=start.rng,
        )

    @property
    def at_rest(self) -> bool:
        """Whether a generation is complete."""
        return self.position == 0 and self.generation > 0

    def spread(self) -> float:
        """Return the mean cost of the last whole generation less its best."""
        return float(self.cost.mean() - self.cost.min())

    def advance(self, coding: Coding, evaluations: int) -> "Evolution":
        """Return the search after so many more evaluations, or at the generation's end."""
        rows = self.bred.order[self.position : self.position + evaluations]
        cost, selection = self.bred.cost.copy(), self.selection.copy()
        best = coding.evaluate(self.bred, rows, cost, selection, self.best)
        moved = replace(
            self,
            bred=self.bred._replace(cost=cost),
            selection=selection,
            best=best,
            position=self.position + rows.shape[0],
            evaluations=self.evaluations + rows.shape[0],
        )
        is_whole = moved.position == self.bred.order.shape[0]
        return _next_generation(moved, coding) if is_whole else moved

    def admit(self, coding: Coding, selection: IntArray, cost: float) -> "Evolution":
        """Return the search with another's answer in the place of its worst, and bred anew."""
        # Itself where the answer is no better than the worst, or among the individuals already.
        genes = coding.individual(selection, self.population.shape[-1])
        worst, size = int(np.argmax(self.cost)), self.cost.shape[0]
        is_known = (self.population == genes).reshape(size, -1).all(axis=1).any()
        if cost >= self.cost[worst] or is_known:
            return self
        population, costs = self.population.copy(), self.cost.copy()
        population[worst], costs[worst] = genes, cost
        moved = replace(self, population=population, cost=costs)
        if cost < self.best:
            moved = replace(moved, selection=selection, best=cost)
        return _bred(moved, coding)


def _next_generation(search: Evolution, coding: Coding) -> Evolution:
    """Return the search at the beginning of its next generation."""
    population, cost = search.bred.genes.copy(), search.bred.cost.copy()
    selection, best = search.selection.copy(), search.best
    if coding.parameters.improvement:
        improved = polish(coding.component, search.lists, selection, search.generation)
        if improved < best - 1e-12 or not np.any(cost <= best):
            best = min(best, improved)
            worst = int(np.argmax(cost))
            population[worst] = coding.individual(selection, population.shape[-1])
            cost[worst] = best
    change = abs(float(cost.min()) - float(search.cost.min()))
    moved = replace(
        search,
        population=population,
        cost=cost,
        generation=search.generation + 1,
        unchanged=search.unchanged + 1 if change <= coding.tolerance else 0,
        selection=selection,
        best=best,
    )
    return _bred(moved, coding)


def _bred(search: Evolution, coding: Coding) -> Evolution:
    """Return the search with offspring of its population."""
    rng = copy.deepcopy(search.rng)
    return replace(
        search, bred=coding.breed(search.population, search.cost, rng), position=0, rng=rng
    )


def items_of(component: Component, node: int) -> list[int]:
    """Return the items of a node's sequence, the last first."""
    items = []
    while node >= 0:
        items.append(int(component.item[node]))
        node = int(component.parent[node])
    return items
