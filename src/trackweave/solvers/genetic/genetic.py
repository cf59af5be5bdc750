"""Genetic search over orders of reports, after US patent 6,055,523."""

import copy
from dataclasses import dataclass, replace

import numpy as np

from trackweave.arrays import IntArray, int_array
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.solvers._kernels import Component, cheapest_first
from trackweave.solvers.components import TOLERANCE, Components
from trackweave.solvers.dual import Dual
from trackweave.solvers.genetic._decoding import Lookup
from trackweave.solvers.genetic.parameters import Parameters
from trackweave.solvers.genetic.search import Search, Start, make_lookup
from trackweave.solvers.protocol import Hint, Stop
from trackweave.solvers.reduction import Reduction

__all__ = ["Genetic", "GeneticState"]

CHUNK_WORK = 200_000
"""Places tried between two looks at the clock: a few milliseconds."""


@dataclass(frozen=True, slots=True, eq=False)
class GeneticState:
    """Where a search stands: a value that can be kept, pickled and gone on from.

    Parameters
    ----------
    whole
        The problem's components with the best known answer and bound of each.
    reduction
        What their bounds leave open; None where everything is searched.
    components
        The components that are searched: the reduction's, or the whole's.
    queue
        Components still to be searched; the first one is under way if ``search`` is there.
    search
        The search of the first component in the queue.
    seeds
        Selections known beforehand, over all families of ``components``.
    rng
        The source of the next random numbers.
    evaluations
        Individuals decoded so far, and the steps of the dual before.
    stop_reason
        Why a search stopped short of closing the gap, "" where none did yet.
    """

    whole: Components
    reduction: Reduction | None
    components: Components
    queue: tuple[int, ...]
    search: Search | None
    seeds: tuple[IntArray, ...]
    rng: np.random.Generator
    evaluations: int
    stop_reason: str

    @property
    def done(self) -> bool:
        """Whether nothing is left to search."""
        return not self.queue


@dataclass(frozen=True, slots=True)
class Genetic(Parameters):
    """Genetic search over the orders in which reports choose their tracks [1]_.

    An individual is a permutation of the reports. It is decoded by taking the reports in that
    order and giving each to the track, or to the new track, where it costs least. Individuals
    are selected, crossed and mutated; the best ever found is the answer. The '931 patent's
    individuals, lists of associations between reports, are the second genotype.

    Beyond the document, and each can be switched off: components are searched apart; Lagrangian
    prices bound the cost, answer what is easy and seed the rest; the best individual is improved
    locally; a new track that costs more than false alarms dissolves. The search ends when the
    bound proves its best.

    Parameters
    ----------
    population
        Number of individuals, at least 2.
    generations
        Stop rule one: the greatest number of generations per component.
    evaluations
        How many individuals are decoded per component, to whole generations.
    genotype
        What an individual is.
    selection
        By linear rank, or the better of two.
    crossover, mutation
        Probability that a pair is crossed, and that a child is mutated.
    elite
        How many of the best go on unchanged; 0 for non-overlapping generations.
    spread
        Stop rule two: the mean cost less the best of a generation is at most this [nats].
        Stop rule three, the arrival of the next scan, is the ``stop`` of a call.
    seeded
        Whether bounds and answers of the dual, a greedy order and the hint start the search.
    improvement
        Whether the best individual of a generation is improved locally.
    decompose
        Whether components are searched apart.
    settle
        Whether poor new tracks dissolve when all reports are placed.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range.

    References
    ----------
    .. [1] D. B. Hillis, *Method and apparatus for multi-sensor, multi-target tracking using a
       genetic algorithm*, US patent 6,055,523, 2000.
    """

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: np.random.Generator,
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
        rng: np.random.Generator,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> GeneticState:
        """Return the state before the first individual is decoded.

        Parameters
        ----------
        problem
            What to solve.
        rng
            Source of randomness. It is advanced, always by one child, and not kept.
        hint
            What is known beforehand.
        stop
            Asked every few milliseconds whether to cut the dual's part short.

        Returns
        -------
        Where the search stands then.
        """
        whole = Components.of(problem, hint, whole=not self.decompose)
        reduction, components, seeds, evaluations = None, whole, [], 0
        if self.seeded:
            evaluations, stopped = Dual().bound(whole, stop)
            last = None if hint is None else _nodes_of(hint, problem)
            if not stopped and whole.open().size:
                reduction = Reduction.of(whole)
                components = Components.of(reduction.problem, Hint(prices=reduction.prices))
                evaluations += Dual().bound(components, stop)[0]
                last = None if last is None else reduction.nodes_left(whole, last)
            seeds.append(components.taken.copy())
            if last is not None:
                seeds.append(components.selection_of(last))
        else:
            for index in range(len(whole)):
                scratch = whole.taken[whole.families(index)].copy()
                whole.lower[index] = cheapest_first(whole.component(index), scratch)[1]
        return GeneticState(
            whole=whole,
            reduction=reduction,
            components=components,
            queue=tuple(components.open().tolist()),
            search=None,
            seeds=tuple(seeds),
            rng=rng.spawn(1)[0],
            evaluations=evaluations,
            stop_reason="",
        )

    def advance(
        self, state: GeneticState, *, evaluations: int | None = None, stop: Stop | None = None
    ) -> GeneticState:
        """Return the state after so many more evaluations, or when the search is over.

        Parameters
        ----------
        state
            Where the search stands; it is left as it is.
        evaluations
            How many individuals to decode at most; None for as many as the search takes.
        stop
            Asked every few milliseconds whether to stop.

        Returns
        -------
        Where the search stands then. However often it is interrupted, it ends the same.
        """
        state = replace(state, components=state.components.copy())
        left = np.inf if evaluations is None else evaluations
        while state.queue and left > 0:
            before = state.evaluations
            state = self._search_first(state, left, stop)
            left -= state.evaluations - before
            if state.stop_reason == "stopped":
                break
        return state

    def _search_first(
        self, state: GeneticState, evaluations: float, stop: Stop | None
    ) -> GeneticState:
        """Return the state after the search of the queue's first component, or a part of it."""
        components, index = state.components, state.queue[0]
        component, lookup = self._view(components, index)
        families, lower = components.families(index), float(components.lower[index])
        search, rng = state.search, state.rng
        if search is None:
            rng = copy.deepcopy(rng)
            seeds = [seed[families] for seed in state.seeds]
            known = components.taken[families], float(components.cost[index])
            start = Start(seeds, *known, rng=rng.spawn(1)[0])
            search = Search.begin(component, lookup, self, start)
        chunk = max(1, CHUNK_WORK // max(1, component.parent.shape[0]))
        done, reason = 0, ""
        while done < evaluations and not reason:
            if stop is not None and stop():
                reason = "stopped"
                break
            before = search.generation * self.population + search.position
            step = int(min(chunk, evaluations - done))
            search = search.advance(component, lookup, self, step)
            done += search.generation * self.population + search.position - before
            reason = self._stop_reason(search, lower)
        if search.best < components.cost[index]:
            components.taken[families] = search.selection
            components.cost[index] = search.best
        over = bool(reason) and reason != "stopped"
        return replace(
            state,
            queue=state.queue[1:] if over else state.queue,
            search=None if over else search,
            rng=rng,
            evaluations=state.evaluations + done,
            stop_reason=reason if reason not in ("", "gap closed") else state.stop_reason,
        )

    def answer(self, state: GeneticState) -> Answer:
        """Return the best answer so far."""
        whole = state.whole.copy()
        if state.reduction is None:
            whole = state.components.copy()
        else:
            state.reduction.absorb(whole, state.components)
        for index in np.flatnonzero(np.isinf(whole.cost)):
            # A stop came before any individual.
            families = whole.families(int(index))
            component = whole.component(int(index))
            whole.cost[index], _ = cheapest_first(component, whole.taken[families])
        if whole.open().size == 0:
            reason = "gap closed"
        elif state.done or state.stop_reason == "stopped":
            reason = state.stop_reason or "bound stalled"
        else:
            reason = "paused"
        return whole.answer(state.evaluations, reason)

    def _view(self, components: Components, index: int) -> tuple[Component, Lookup]:
        component = components.component(index)
        nodes = components.parts.node[
            components.parts.node_start[index] : components.parts.node_start[index + 1]
        ]
        items = components.parts.item_of[components.items(index)]
        problem = components.problem
        return component, make_lookup(
            component, problem.cost[nodes], problem.instant[items], self.settle
        )

    def _stop_reason(self, search: Search, lower: float) -> str:
        """Return why the search of a component is over, "" while it is not."""
        # Asked at the end of a generation only, so that interruptions change nothing.
        if search.position or not search.generation:
            return ""
        if search.best - lower <= TOLERANCE * max(1.0, abs(search.best)):
            return "gap closed"
        if search.generation >= self.generations:
            return "generations"
        if search.generation * self.population >= self.evaluations:
            return "evaluations"
        return "converged" if search.spread() <= self.spread else ""


def _nodes_of(hint: Hint, problem: AssignmentProblem) -> IntArray | None:
    """Return the hint's nodes once they are found to be the problem's."""
    if hint.nodes is None:
        return None
    nodes = int_array(hint.nodes, "hint.nodes", (None,))
    if np.any((nodes < 0) | (nodes >= problem.n_nodes)):
        raise InvalidInputError(f"hint.nodes: expected numbers from 0 to {problem.n_nodes - 1}")
    return nodes
