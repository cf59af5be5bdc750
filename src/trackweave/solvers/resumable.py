"""A search of the components that prices leave open, which can be interrupted."""

import copy
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from trackweave.arrays import FloatArray, IntArray, is_whole
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.randomness import RandomSource
from trackweave.solvers._kernels import Component, cheapest_first
from trackweave.solvers.components import Components
from trackweave.solvers.dual import Dual
from trackweave.solvers.protocol import Hint, Stop, child_of, require_stop
from trackweave.solvers.relaxation import Relaxation

__all__ = ["Resumable", "Search", "SearchState", "Start", "View"]


class View(NamedTuple):
    """What a search reads of one component.

    ``cost`` holds what each node costs while it grows, ``instant`` each item's rank in time,
    ``price`` what each item is worth (zero where nothing is known), and ``lower`` a bound.
    """

    component: Component
    cost: FloatArray
    instant: IntArray
    price: FloatArray
    lower: float


class Start(NamedTuple):
    """What a search begins with.

    ``seeds`` are selections known beforehand; ``selection`` is the best of them and ``cost``
    what it costs, infinite where there is none. ``rng`` is the search's own.
    """

    seeds: list[IntArray]
    selection: IntArray
    cost: float
    rng: np.random.Generator


class Search(Protocol):
    """Where the search of one component stands: a value that is replaced, never changed."""

    @property
    def selection(self) -> IntArray:
        """The best selection so far."""
        ...

    @property
    def best(self) -> float:
        """What it costs, infinite while there is none."""
        ...

    @property
    def evaluations(self) -> int:
        """How many answers were tried."""
        ...

    @property
    def at_rest(self) -> bool:
        """Whether a step is complete: the search may end here, however it was interrupted."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class SearchState:
    """Where a search stands: a value that can be kept, pickled and gone on from.

    ``queue`` are the components of the relaxation's rest that are still to be searched; the first
    is under way if ``search`` is there. ``seeds`` are selections known beforehand, ``rng`` the
    source of the next random numbers; ``evaluations`` counts the steps of the dual before, too,
    and ``stop_reason`` says why a search stopped short of closing the gap, "" where none did yet.
    """

    relaxation: Relaxation
    queue: tuple[int, ...]
    search: Any
    seeds: tuple[IntArray, ...]
    rng: np.random.Generator
    evaluations: int
    stop_reason: str

    @property
    def done(self) -> bool:
        """Whether nothing is left to search."""
        return not self.queue


class Resumable(ABC):
    """A solver that searches each component which prices leave open, and can be interrupted.

    It is told how the search of one component begins, goes on and ends; taking the problem
    apart, prices and bounds before, and stopping are the same for all.
    """

    __slots__ = ()

    @property
    @abstractmethod
    def seeded(self) -> bool:
        """Whether the dual's bounds, answers and reduction, and the hint, come before."""

    @property
    @abstractmethod
    def decompose(self) -> bool:
        """Whether components are searched one by one."""

    @abstractmethod
    def _begin(self, view: View, start: Start) -> Search:
        """Return the search of a component before its first evaluation."""

    @abstractmethod
    def _proceed(
        self, view: View, search: Any, evaluations: float, stop: Stop | None
    ) -> tuple[Any, bool]:
        """Return the search some milliseconds later, and whether a stop was asked for.

        It goes no further than the end of its present step, nor than so many more evaluations.
        """

    @abstractmethod
    def _why_over(self, search: Any) -> str:
        """Return why the search of a component that is at rest is over, "" while it is not."""

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: RandomSource = 0,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Answer:
        """Return the best answer found; see ``Solver``."""
        state = self.start(problem, rng=rng, hint=hint, stop=stop)
        return self.answer(self.advance(state, stop=stop))

    def start(
        self,
        problem: AssignmentProblem,
        *,
        rng: RandomSource = 0,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> SearchState:
        """Return the state before the first evaluation.

        Parameters
        ----------
        problem
            What to solve.
        rng
            Source of randomness: a generator, which is advanced, always by one child, and not
            kept, or a seed.
        hint
            What is known beforehand.
        stop
            Asked every few milliseconds whether to cut the dual's part short.

        Returns
        -------
        Where the search stands then.
        """
        relaxation = Relaxation.of(problem, hint, whole=not self.decompose)
        seeds, evaluations = [], 0
        if self.seeded:
            relaxation, evaluations, _ = Dual().relax(relaxation, stop)
            last = relaxation.left_of(hint)
            seeds = [relaxation.rest.taken.copy(), *([] if last is None else [last])]
        else:
            whole = relaxation.rest
            for index in range(len(whole)):
                scratch = whole.taken[whole.families(index)].copy()
                whole.lower[index] = cheapest_first(whole.component(index), scratch)[1]
        return self.start_at(relaxation, seeds, rng=rng, evaluations=evaluations)

    def start_at(
        self,
        relaxation: Relaxation,
        seeds: Sequence[IntArray],
        *,
        rng: RandomSource = 0,
        evaluations: int = 0,
    ) -> SearchState:
        """Return the state before the first evaluation, where others have prepared it."""
        # The relaxation is not changed; a generator is advanced, always by one child, and not
        # kept.
        return SearchState(
            relaxation=relaxation,
            queue=tuple(relaxation.rest.open().tolist()),
            search=None,
            seeds=tuple(seeds),
            rng=child_of(rng),
            evaluations=evaluations,
            stop_reason="",
        )

    def advance(
        self, state: SearchState, *, evaluations: int | None = None, stop: Stop | None = None
    ) -> SearchState:
        """Return the state after so many more evaluations, or when the search is over.

        Parameters
        ----------
        state
            Where the search stands; it is left as it is.
        evaluations
            How many further answers to try at most, and what completes a move of tabu search;
            None for as many as the search takes.
        stop
            Asked every few milliseconds whether to stop.

        Returns
        -------
        Where the search stands then. However often it is interrupted, it ends the same.

        Raises
        ------
        InvalidInputError
            If the number of evaluations is none.
        """
        if evaluations is not None and not (is_whole(evaluations) and evaluations >= 0):
            raise InvalidInputError(
                f"evaluations: {evaluations!r:.80}; expected a whole number ≥ 0, or None"
            )
        require_stop(stop)
        rest = state.relaxation.rest.copy()
        state = replace(state, relaxation=state.relaxation.with_rest(rest))
        left = np.inf if evaluations is None else evaluations
        while state.queue and left > 0:
            before = state.evaluations
            state = self._search_first(state, left, stop)
            left -= state.evaluations - before
            if state.stop_reason == "stopped":
                break
        return state

    def answer(self, state: SearchState) -> Answer:
        """Return the best answer so far.

        Parameters
        ----------
        state
            Where the search stands.

        Returns
        -------
        The answer, greedy where the search of a component has not begun.
        """
        rest = state.relaxation.rest.copy()
        for index in np.flatnonzero(np.isinf(rest.cost)):
            # A stop came before any evaluation.
            families = rest.families(int(index))
            component = rest.component(int(index))
            rest.cost[index], _ = cheapest_first(component, rest.taken[families])
        over = state.done or state.stop_reason == "stopped"
        reason = (state.stop_reason or "bound stalled") if over else "paused"
        return state.relaxation.with_rest(rest).answer(state.evaluations, reason)

    def _search_first(
        self, state: SearchState, evaluations: float, stop: Stop | None
    ) -> SearchState:
        """Return the state after the search of the queue's first component, or a part of it."""
        components, index = state.relaxation.rest, state.queue[0]
        families, view = components.families(index), _view(components, index)
        search, rng = state.search, state.rng
        if search is None:
            rng = copy.deepcopy(rng)
            seeds = [seed[families] for seed in state.seeds]
            known = components.taken[families], float(components.cost[index])
            search = self._begin(view, Start(seeds, *known, rng=child_of(rng)))
        begun, reason = search.evaluations, ""
        while search.evaluations - begun < evaluations and not reason:
            left = evaluations - (search.evaluations - begun)
            search, was_stopped = self._proceed(view, search, left, stop)
            if was_stopped:
                reason = "stopped"
            elif search.at_rest:
                is_closed = components.is_closed(index, search.best)
                reason = "gap closed" if is_closed else self._why_over(search)
        if search.best < components.cost[index]:
            components.taken[families] = search.selection
            components.cost[index] = search.best
        over = bool(reason) and reason != "stopped"
        return replace(
            state,
            queue=state.queue[1:] if over else state.queue,
            search=None if over else search,
            rng=rng,
            evaluations=state.evaluations + search.evaluations - begun,
            stop_reason=reason if reason not in ("", "gap closed") else state.stop_reason,
        )


def _view(components: Components, index: int) -> View:
    """Return what a search reads of a component."""
    parts, problem = components.parts, components.problem
    nodes = parts.node[parts.node_start[index] : parts.node_start[index + 1]]
    items = components.items(index)
    return View(
        components.component(index),
        problem.cost[nodes] * components.scale,
        problem.instant[parts.item_of[items]],
        components.price[items],
        float(components.lower[index]),
    )
