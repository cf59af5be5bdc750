"""The tabu search of one component, as a value."""

import copy
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from trackweave.arrays import IntArray
from trackweave.solvers._kernels import Component
from trackweave.solvers.local._moves import begin_holding, cost_of, selection_of
from trackweave.solvers.local._tabu import seek
from trackweave.solvers.local.starts import Ground
from trackweave.solvers.polishing import polish

__all__ = ["Habits", "Seeking"]

WINDOWS = (0.02, 0.3)
"""Narrowest and widest window of a move, in typical excesses."""
STEP = 1_000
"""Moves tried between two looks at whether the search got stuck, to whole iterations."""
ELITE = 5
"""How many answers, each the best of a start, later starts may begin with."""
SENT_OFF = 0.2
"""Share of an elite answer's sequences that a start from it is without."""


@dataclass(frozen=True, slots=True)
class Habits:
    """How a component is searched: see ``TabuSearch``, whose parameters these are."""

    sample: int
    tenure: int
    links: int
    moves_per_item: int
    improvement: bool

    @property
    def iterations(self) -> int:
        """Iterations of one step."""
        return -(-STEP // self.sample)


@dataclass(frozen=True, slots=True, eq=False)
class Seeking:
    """Where a tabu search stands; ``advance`` returns where it stands later.

    ``holder`` tells which candidate holds each item at present, ``until`` up to which iteration
    each candidate has to stay as it is. The best answer since the last start is ``own_holder``
    at a cost of ``own``, found in the step that ends with iteration ``found``; the best of all
    is ``selection`` at a cost of ``best``. So many starts as ``unchanged`` counts, in a row,
    found nothing better; -1 when the present one did.
    """

    ground: Ground
    holder: IntArray
    current: float
    until: IntArray
    own_holder: IntArray
    own: float
    iteration: int
    found: int
    elite: tuple[IntArray, ...]
    selection: IntArray
    best: float
    starts: int
    unchanged: int
    evaluations: int
    at_rest: bool
    rng: np.random.Generator

    @classmethod
    def begin(cls, component: Component, ground: Ground, rng: np.random.Generator) -> Self:
        """Return a tabu search before its first evaluation.

        Parameters
        ----------
        component, ground
            What is searched, and what is known of it.
        rng
            The search's own.

        Returns
        -------
        The search at its first start.
        """
        nothing = np.full(component.must.shape[0], -1, dtype=np.int64)
        holder = begin_holding(ground.moves, component, nothing)
        selection = nothing.copy()
        selection_of(ground.moves, component, ground.holder, selection)
        cost = cost_of(ground.moves, holder)
        return cls(
            ground=ground,
            holder=holder,
            current=cost,
            until=np.zeros(ground.moves.node.shape[0], dtype=np.int64),
            own_holder=holder,
            own=cost,
            iteration=0,
            found=0,
            elite=(ground.holder,),
            selection=selection,
            best=ground.cost,
            starts=1,
            unchanged=0,
            evaluations=0,
            at_rest=False,
            rng=rng,
        )

    def advance(self, component: Component, habits: Habits, evaluations: int) -> "Seeking":
        """Return the search after so many more moves to whole iterations, or at its step's end.

        Parameters
        ----------
        component
            What is searched.
        habits
            How.
        evaluations
            How many moves to try at least, to whole iterations.

        Returns
        -------
        The search then; this one stays as it is.
        """
        ground, length = self.ground, habits.iterations
        step_end = (self.iteration // length + 1) * length
        last = min(step_end, self.iteration + -(-evaluations // habits.sample))
        holder, own_holder, until = self.holder.copy(), self.own_holder.copy(), self.until.copy()
        rng = copy.deepcopy(self.rng)
        current, own = seek(
            ground.moves, ground.scale * np.array(WINDOWS), habits.links, habits.sample,
            habits.tenure, (self.iteration, last), rng, until, holder, self.current, own_holder,
            self.own,
        )  # fmt: skip
        moved = replace(
            self,
            holder=holder,
            current=current,
            until=until,
            own_holder=own_holder,
            own=own,
            iteration=last,
            found=step_end if own < self.own else self.found,
            evaluations=self.evaluations + (last - self.iteration) * habits.sample,
            at_rest=last == step_end,
            rng=rng,
        )
        if own < self.best:
            moved = _with_best(moved, component, own_holder)
        if not moved.at_rest:
            return moved
        stuck = (last - moved.found) * habits.sample
        moved = replace(moved, current=cost_of(ground.moves, holder))
        if stuck < habits.moves_per_item * component.n_items:
            return moved
        return _restarted(moved, component, habits)

    def admit(self, component: Component, selection: IntArray, cost: float) -> "Seeking":
        """Return the search with another's answer taken in, if it is better than its best.

        Parameters
        ----------
        component
            What is searched.
        selection, cost
            The other's answer.

        Returns
        -------
        The search at that answer, as though it had come there by a move.
        """
        held = self.ground.held(component, selection, cost, self.best)
        if held is None:
            return self
        holder, cost = held
        moved = replace(
            self, holder=holder, current=cost, own_holder=holder, own=cost, found=self.iteration
        )
        return _with_best(moved, component, holder)


def _with_best(search: Seeking, component: Component, holder: IntArray) -> Seeking:
    """Return the search with this answer as its best."""
    moves, selection = search.ground.moves, np.empty_like(search.selection)
    selection_of(moves, component, holder, selection)
    return replace(search, selection=selection, best=cost_of(moves, holder), unchanged=-1)


def _restarted(search: Seeking, component: Component, habits: Habits) -> Seeking:
    """Return the search at its next start: nothing, the best, and a part of an elite in turn."""
    moves, own_holder, own = search.ground.moves, search.own_holder, search.own
    if habits.improvement:
        selection = np.empty_like(search.selection)
        selection_of(moves, component, own_holder, selection)
        polish(component, search.ground.lists, selection, search.starts)
        own_holder = begin_holding(moves, component, selection)
        own = cost_of(moves, own_holder)
    ended = _with_best(search, component, own_holder) if own < search.best else search
    pool = [own_holder, *(old for old in search.elite if not np.array_equal(old, own_holder))]
    pool.sort(key=lambda holder: cost_of(moves, holder))
    elite, rng = tuple(pool[:ELITE]), copy.deepcopy(search.rng)
    selection = np.full_like(search.selection, -1)
    if search.starts % 3 == 1:
        selection = ended.selection
    elif search.starts % 3 == 2:
        selection_of(moves, component, elite[int(rng.integers(len(elite)))], selection)
        selection[rng.random(selection.shape[0]) < SENT_OFF] = -1
    holder = begin_holding(moves, component, selection)
    return replace(
        ended,
        holder=holder,
        current=cost_of(moves, holder),
        until=np.zeros_like(search.until),
        own_holder=holder,
        own=cost_of(moves, holder),
        found=search.iteration,
        elite=elite,
        starts=search.starts + 1,
        unchanged=ended.unchanged + 1,
        rng=rng,
    )
