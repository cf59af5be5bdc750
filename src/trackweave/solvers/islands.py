"""The island model: searches side by side, on threads or workers, that exchange answers."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from functools import partial
from threading import Event
from typing import Any, TypeVar

import numpy as np

from trackweave.arrays import IntArray
from trackweave.engine import EngineError, is_worker, kept_engine, require_engine
from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.solvers.local import Annealing, TabuSearch
from trackweave.solvers.metaheuristic import Metaheuristic
from trackweave.solvers.protocol import Stop, refuse_parameters
from trackweave.solvers.resumable import Resumable, Start, View

__all__ = ["Archipelago", "Island", "Islands", "run_together"]


@dataclass(frozen=True, slots=True, eq=False)
class Island:
    """A method and where its search stands; ``place`` is its start before it has begun."""

    method: Metaheuristic
    place: Any

    @property
    def evaluations(self) -> int:
        """How many answers were tried."""
        return 0 if isinstance(self.place, Start) else int(self.place.evaluations)

    @property
    def best(self) -> float:
        """The least cost so far."""
        return float(self.place.cost if isinstance(self.place, Start) else self.place.best)

    def is_through(self, view: View, chunks: int) -> bool:
        """Tell whether so many chunks of evaluations lie behind."""
        return self.method.is_through(view, self.place, chunks)

    def advance(self, view: View, chunks: int, evaluations: float, stop: Stop) -> "Island":
        """Return the island after so many chunks; see ``Metaheuristic.go_through``."""
        place = self.method.go_through(
            view, self.place, chunks, evaluations=evaluations, stop=stop
        )
        return replace(self, place=place)

    def admit(self, view: View, other: "Island") -> "Island":
        """Return the island with another's best answer taken in."""
        place = self.method.admit(view, self.place, other.place.selection, other.best)
        return replace(self, place=place)


@dataclass(frozen=True, slots=True, eq=False)
class Archipelago:
    """Where the search of a component stands; it is replaced, never changed.

    So many epochs as ``idle`` counts, in a row, found nothing better; ``known`` is the least cost
    before the present one. Islands are ``at_rest`` when an epoch is complete.
    """

    islands: tuple[Island, ...]
    epoch: int
    idle: int
    known: float
    at_rest: bool

    @property
    def evaluations(self) -> int:
        """How many answers were tried."""
        return sum(island.evaluations for island in self.islands)

    @property
    def best(self) -> float:
        """The least cost so far."""
        return self._first.best

    @property
    def selection(self) -> IntArray:
        """What costs that."""
        found: IntArray = self._first.place.selection
        return found

    @property
    def _first(self) -> Island:
        return min(self.islands, key=lambda island: island.best)

    def migrated(self, view: View, neighbours: int) -> "Archipelago":
        """Return the islands at the next epoch, each's best sent to so many after it on a ring."""
        # What was their best before any of them took something in.
        count, best = len(self.islands), self.best
        islands = []
        for number, island in enumerate(self.islands):
            for back in range(1, neighbours + 1):
                island = island.admit(view, self.islands[(number - back) % count])
            islands.append(island)
        gained = best < self.known - 1e-9 * abs(self.known)
        return Archipelago(
            islands=tuple(islands),
            epoch=self.epoch + 1,
            idle=0 if gained else self.idle + 1,
            known=best,
            at_rest=True,
        )


LOOK = 0.002
"""Time between two looks at the clock while others work [s]."""

Result = TypeVar("Result")


def run_together(
    tasks: Sequence[Callable[[Stop], Result]], n_threads: int, stop: Stop | None
) -> tuple[list[Result], bool]:
    """Run tasks on so many threads; return what they return, and if a stop was asked for."""
    # Each task takes a stop of its own. The given one is asked in the caller's thread alone, and
    # never again when it has said to stop.
    halt = Event()
    if n_threads == 1:

        def asked() -> bool:
            if stop is not None and not halt.is_set() and stop():
                halt.set()
            return halt.is_set()

        return [task(asked) for task in tasks], halt.is_set()
    with ThreadPoolExecutor(n_threads) as pool:
        try:
            running = [pool.submit(task, halt.is_set) for task in tasks]
            look = None if stop is None else LOOK
            while wait(running, look, FIRST_EXCEPTION).not_done and not halt.is_set():
                # With nothing to ask, only a failure wakes before all are done.
                if stop is None or stop() or _has_failed(running):
                    halt.set()
        except BaseException:
            # Not to wait for the end of all tasks when the stop fails, or the user breaks off.
            halt.set()
            raise
    return [task.result() for task in running], halt.is_set()


def _has_failed(running: Sequence[Future[Result]]) -> bool:
    """Tell whether a task ended by an error."""
    return any(task.done() and task.exception() is not None for task in running)


def _run_by_workers(
    islands: Sequence[Island], shares: Sequence[float], to: tuple[View, int], engine: str,
    workers: int | None,
) -> list[Island]:  # fmt: skip
    """Return islands advanced by the workers of an engine, each by its share of evaluations."""
    # ``to`` is what they search, and the chunks to go through.
    with kept_engine(engine, workers) as pool:
        for island, share in zip(islands, shares, strict=True):
            pool.submit(_advanced, island, *to, share)
        outcomes = list(pool.gather())
    for outcome in outcomes:
        if outcome.error is not None:
            raise EngineError(f"islands: an island's worker: {outcome.error}")
    return [outcome.value for outcome in outcomes]


def _advanced(island: Island, view: View, chunks: int, share: float) -> Island:
    """Return an island after so many chunks: what a worker does."""
    return island.advance(view, chunks, share, lambda: False)


@dataclass(frozen=True, slots=True)
class Islands(Resumable):
    """Searches on islands that send each other their best answers [1]_ [2]_.

    Islands search the same component, each by its method and with random numbers of its own.
    When all have come to the end of an epoch, each sends the best answer that it has found to
    its neighbours on a ring, who take it in as their method does: genes in the place of the worst
    individual; ants lay pheromone on it; annealing and tabu search go on from it if it is better
    than their best. Prices, bounds and reduction come before, once for all islands.

    Islands are searched on threads, or by the workers of an engine. The answer is the same on any
    number of either: who sends what to whom, and when, is counted in evaluations.

    The islands' own limits (evaluations, generations, cycles, patience) end no island; an
    archipelago ends as a whole, or where asked for when all its islands have come to theirs.

    Parameters
    ----------
    methods
        What lives on the islands: the first on the first island, and round again.
    islands
        Number of islands, at least one for each method.
    threads
        How many islands are searched at a time; None for as many as there are processors.
    epoch
        Length of an epoch, in chunks of evaluations that take each method some milliseconds, to
        whole generations, cycles or temperatures.
    neighbours
        To how many islands after it each sends its best answer: 1 for a ring, all the others at
        most; 0 for islands that know nothing of each other. One island has nobody to send to.
    epochs
        The greatest number of epochs per component, at least 1.
    patience
        Epochs without a better answer on any island after which the search ends, at least 1.
    own_limits
        Whether the search ends when every island has come to its own limits, whatever ``epochs``
        and ``patience`` say.
    engine
        Whose workers search islands instead of threads: ``local``, ``ray`` or ``ray://HOST``;
        None for threads. Workers are processes that stay until this one ends. Each epoch sends
        them the component and the islands, and a stop is heeded at its end. Where the search
        itself is a worker's, it is on threads.
    workers
        How many islands the engine searches at a time; None for as many as there are processors.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range.

    References
    ----------
    .. [1] D. B. Hillis, *Method and apparatus for multi-sensor, multi-target tracking using a
       genetic algorithm*, US patent 6,055,523, 2000.
    .. [2] E. Alba, M. Tomassini, *Parallelism and evolutionary algorithms*, 2002.
       doi:10.1109/TEVC.2002.800880

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> answer = tw.solve(problem, tw.Islands(islands=2, epochs=3), rng=np.random.default_rng(1))
    >>> answer.cost, answer.lower_bound
    (-7.0, -7.0)
    >>> answer.tuples
    array([[1, 1],
           [2, 2]])
    """

    methods: tuple[Metaheuristic, ...] = (Annealing(), TabuSearch())
    islands: int = 4
    threads: int | None = None
    epoch: int = 10
    neighbours: int = 1
    epochs: int = 25
    patience: int = 10
    own_limits: bool = False
    engine: str | None = None
    workers: int | None = None

    def __post_init__(self) -> None:
        settle(self)
        n_methods = len(self.methods)
        wrong = [
            (n_methods == 0, "methods", "searches, such as (Annealing(), Genetic())"),
            (not self.islands >= max(1, n_methods), "islands", "at least one for each method"),
            (
                self.threads is not None and not self.threads >= 1,
                "threads",
                "a whole number ≥ 1, or None",
            ),
            (not self.epoch >= 1, "epoch", "a whole number ≥ 1"),
            (
                not 0 <= self.neighbours < max(2, self.islands),
                "neighbours",
                "fewer than islands",
            ),
            (not self.epochs >= 1, "epochs", "a whole number ≥ 1"),
            (not self.patience >= 1, "patience", "a whole number ≥ 1"),
        ]
        refuse_parameters(self, wrong)
        if self.engine is not None:
            require_engine(self.engine, self.workers)
        elif self.workers is not None:
            raise InvalidInputError(f"workers: {self.workers}; expected an engine as well")

    @property
    def seeded(self) -> bool:
        """Whether the dual comes before, for those islands whose method asks for it."""
        return any(method.seeded for method in self.methods)

    @property
    def decompose(self) -> bool:
        """Whether components are searched apart, as all methods have to ask for."""
        return all(method.decompose for method in self.methods)

    def _begin(self, view: View, start: Start) -> Archipelago:
        nothing = Start([], np.full_like(start.selection, -1), np.inf, start.rng)
        islands = []
        for number, rng in enumerate(start.rng.spawn(self.islands)):
            method = self.methods[number % len(self.methods)]
            own = start if method.seeded else nothing
            islands.append(Island(method, own._replace(rng=rng)))
        return Archipelago(tuple(islands), epoch=0, idle=0, known=start.cost, at_rest=False)

    def _proceed(
        self, view: View, search: Archipelago, evaluations: float, stop: Stop | None
    ) -> tuple[Archipelago, bool]:
        if stop is not None and stop():
            return search, True
        chunks = (search.epoch + 1) * self.epoch
        islands = list(search.islands)
        under_way = [i for i, island in enumerate(islands) if not island.is_through(view, chunks)]
        shares = _shares(evaluations, len(under_way))
        to_move = [islands[i] for i in under_way]
        if self.engine is not None and not is_worker():
            # Whatever worker dies is replaced; a stop waits for the end of the epoch.
            to = view, chunks
            moved = _run_by_workers(to_move, shares, to, self.engine, self.workers)
            was_stopped = False
        else:
            tasks = [
                partial(island.advance, view, chunks, share)
                for island, share in zip(to_move, shares, strict=True)
            ]
            moved, was_stopped = run_together(tasks, self._n_threads(), stop)
        for i, island in zip(under_way, moved, strict=True):
            islands[i] = island
        search = replace(search, islands=tuple(islands), at_rest=False)
        if all(island.is_through(view, chunks) for island in islands):
            # An epoch that is complete counts, whether or not a stop came at its very end.
            return search.migrated(view, min(self.neighbours, self.islands - 1)), False
        return search, was_stopped

    def _why_over(self, search: Archipelago) -> str:
        if self.own_limits:
            whys = [island.method.why_over(island.place) for island in search.islands]
            return whys[0] if all(whys) else ""
        if search.epoch >= self.epochs:
            return "epochs"
        return "converged" if search.idle >= self.patience else ""

    def _n_threads(self) -> int:
        return min(self.islands, self.threads or _n_processors())


def _n_processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _shares(evaluations: float, count: int) -> list[float]:
    """Return whole shares of so many evaluations."""
    if not np.isfinite(evaluations):
        return [evaluations] * count
    share, more = divmod(int(evaluations), max(1, count))
    return [share + (number < more) for number in range(count)]
