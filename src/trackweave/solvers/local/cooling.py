"""The annealing of one component, as a value."""

import copy
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from trackweave.arrays import IntArray
from trackweave.solvers._kernels import Component
from trackweave.solvers.local._annealing import anneal
from trackweave.solvers.local._moves import begin_holding, cost_of, selection_of
from trackweave.solvers.local.starts import Ground
from trackweave.solvers.polishing import polish

__all__ = ["Cooling", "Schedule"]

LEVELS = 50
"""Temperatures of one cooling."""
SHORTEST = 100
"""Moves at one temperature at least, so that small components are not all overhead."""


@dataclass(frozen=True, slots=True)
class Schedule:
    """How a component is cooled: see ``Annealing``, whose parameters these are."""

    moves_per_item: int
    evaluations: int
    hot: float
    cold: float
    links: int
    improvement: bool

    def length(self, n_items: int) -> int:
        """Return the moves at each temperature: all coolings but the last end in the budget."""
        moves = min(self.moves_per_item * n_items, self.evaluations)
        return max(SHORTEST, -(-moves // LEVELS))

    def temperature(self, level: int, scale: float) -> float:
        """Return the temperature of a level, the first of which is 0 [nats]."""
        return float(scale * self.hot * (self.cold / self.hot) ** (level / (LEVELS - 1)))


@dataclass(frozen=True, slots=True, eq=False)
class Cooling:
    """Where an annealing stands; ``advance`` returns where it stands later.

    ``holder`` tells which candidate holds each item at present, and ``best_holder`` in the best
    answer, which is ``selection`` at a cost of ``best``. ``position`` moves were tried at the
    temperature number ``level`` of the cooling. So many coolings as ``unchanged`` counts, in a
    row, found nothing better; the best before the present one cost ``before``.
    """

    ground: Ground
    holder: IntArray
    current: float
    best_holder: IntArray
    best: float
    selection: IntArray
    level: int
    position: int
    cooling: int
    unchanged: int
    before: float
    evaluations: int
    rng: np.random.Generator

    @classmethod
    def begin(cls, component: Component, ground: Ground, rng: np.random.Generator) -> Self:
        """Return an annealing before its first evaluation.

        Parameters
        ----------
        component, ground
            What is searched, and what is known of it.
        rng
            The search's own.

        Returns
        -------
        The annealing at the beginning of its first cooling.
        """
        nothing = np.full(component.must.shape[0], -1, dtype=np.int64)
        holder = begin_holding(ground.moves, component, nothing)
        selection = nothing.copy()
        selection_of(ground.moves, component, ground.holder, selection)
        return cls(
            ground=ground,
            holder=holder,
            current=cost_of(ground.moves, holder),
            best_holder=ground.holder,
            best=ground.cost,
            selection=selection,
            level=0,
            position=0,
            cooling=0,
            unchanged=0,
            before=ground.cost,
            evaluations=0,
            rng=rng,
        )

    @property
    def at_rest(self) -> bool:
        """Whether a temperature is complete."""
        return self.position == 0 and self.evaluations > 0

    def advance(self, component: Component, schedule: Schedule, evaluations: int) -> "Cooling":
        """Return the annealing after so many more moves, or at the end of its temperature.

        Parameters
        ----------
        component
            What is searched.
        schedule
            How.
        evaluations
            How many moves to try at most.

        Returns
        -------
        The annealing then; this one stays as it is.
        """
        length = schedule.length(component.n_items)
        count = min(evaluations, length - self.position)
        holder, best_holder = self.holder.copy(), self.best_holder.copy()
        rng = copy.deepcopy(self.rng)
        current, best = anneal(
            self.ground.moves, schedule.temperature(self.level, self.ground.scale),
            schedule.links, count, rng, holder, self.current, best_holder, self.best,
        )  # fmt: skip
        selection = self.selection
        if best < self.best:
            selection = np.empty_like(selection)
            selection_of(self.ground.moves, component, best_holder, selection)
        moved = replace(
            self,
            holder=holder,
            current=current,
            best_holder=best_holder,
            best=best,
            selection=selection,
            position=self.position + count,
            evaluations=self.evaluations + count,
            rng=rng,
        )
        return moved if moved.position < length else _colder(moved, component, schedule)

    def admit(self, component: Component, selection: IntArray, cost: float) -> "Cooling":
        """Return the annealing with another's answer taken in, if it is better than its best.

        Parameters
        ----------
        component
            What is searched.
        selection, cost
            The other's answer.

        Returns
        -------
        The annealing with that as its best, with which a later cooling begins, and as its present
        answer.
        """
        held = self.ground.held(component, selection, cost, self.best)
        if held is None:
            return self
        holder, cost = held
        known = np.empty_like(selection)
        selection_of(self.ground.moves, component, holder, known)
        return replace(
            self, holder=holder, current=cost, best_holder=holder, best=cost, selection=known
        )


def _colder(cooling: Cooling, component: Component, schedule: Schedule) -> Cooling:
    """Return the annealing at the beginning of the next temperature, or of the next cooling."""
    moves = cooling.ground.moves
    if cooling.level + 1 < LEVELS:
        current = cost_of(moves, cooling.holder)
        return replace(cooling, level=cooling.level + 1, position=0, current=current)
    selection, best_holder, best = cooling.selection, cooling.best_holder, cooling.best
    if schedule.improvement:
        trial = selection.copy()
        polish(component, cooling.ground.lists, trial, cooling.cooling)
        polished = begin_holding(moves, component, trial)
        if cost_of(moves, polished) < best:
            selection, best_holder, best = trial, polished, cost_of(moves, polished)
    holder = best_holder
    if cooling.cooling % 2:
        holder = begin_holding(moves, component, np.full_like(selection, -1))
    gained = best < cooling.before - 1e-9 * abs(cooling.before)
    return replace(
        cooling,
        holder=holder,
        current=cost_of(moves, holder),
        best_holder=best_holder,
        best=best,
        selection=selection,
        level=0,
        position=0,
        cooling=cooling.cooling + 1,
        unchanged=0 if gained else cooling.unchanged + 1,
        before=best,
    )
