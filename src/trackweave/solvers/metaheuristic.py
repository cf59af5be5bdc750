"""What genes, ants, tabu lists and annealing share: evaluations counted, answers polished."""

import copy
from abc import abstractmethod
from typing import Any

import numpy as np

from trackweave.arrays import IntArray
from trackweave.solvers._kernels import Component, set_owner
from trackweave.solvers._list_reassignment import local_search
from trackweave.solvers.lists import Lists
from trackweave.solvers.protocol import Stop
from trackweave.solvers.resumable import Resumable, Search, Start, View

__all__ = ["Metaheuristic", "chunk_of", "owner_of", "polish"]

LARGE = 20_000
"""More sequences than this may be too many for one improvement."""
STRIDE = 61
"""How many families further on the next improvement begins in a large component."""


def polish(component: Component, lists: Lists, selection: IntArray, turn: int = 0) -> float:
    """Improve a selection in place: eject, insert, repair; assign lists anew; return its cost."""
    # ``turn`` is how often a selection of this component was improved before.
    first = 0
    if component.parent.shape[0] > LARGE:
        # One improvement does not come round there: each begins elsewhere.
        first = turn * STRIDE % selection.shape[0]
    return local_search(component, lists, selection, owner_of(component, selection), first)


def owner_of(component: Component, selection: IntArray) -> IntArray:
    """Return the family that covers each item in a disjoint selection; -1 for none."""
    # A family that must be covered has its root's item in any case.
    owner = np.full(component.n_items, -1, dtype=np.int64)
    roots = component.members[component.start[:-1]]
    owner[component.item[roots[component.must]]] = np.flatnonzero(component.must)
    for family in np.flatnonzero(selection >= 0).tolist():
        set_owner(component, int(selection[family]), family, owner)
    return owner


CHUNK_WORK = 200_000
"""Places tried between two looks at the clock: a few milliseconds."""


def chunk_of(view: View, step: int) -> int:
    """Return how many evaluations, each of which reads all nodes, take a few milliseconds."""
    # At least 1, and no more than a whole step has.
    n_nodes = int(view.component.parent.shape[0])
    return max(1, min(step, CHUNK_WORK // max(1, n_nodes)))


class Metaheuristic(Resumable):
    """A search of one component at a time, for a number of evaluations.

    A method says how the search of a component begins, goes on, ends, and what it makes of an
    answer that another search found.
    """

    __slots__ = ()

    @abstractmethod
    def _go_on(self, view: View, search: Any, evaluations: int) -> Search:
        """Return the search after so many more evaluations, or at the end of its present step."""

    @abstractmethod
    def admit(self, view: View, search: Any, selection: IntArray, cost: float) -> Search:
        """Return a search at rest with another's answer taken in, where that is worth anything."""

    def why_over(self, search: Any) -> str:
        """Return why a search at rest is over by the method's own limits, "" while it is not."""
        return self._why_over(search)

    @abstractmethod
    def _chunk(self, view: View) -> int:
        """Return how many evaluations of a step take a few milliseconds, at least 1."""

    def go_through(
        self, view: View, search: Any, chunks: int, *, evaluations: float, stop: Stop
    ) -> Any:
        """Return the search so many chunks of evaluations after its start, to whole steps."""
        left, chunk = evaluations, self._chunk(view)
        while left > 0 and not self.is_through(view, search, chunks) and not stop():
            if isinstance(search, Start):
                search = self._begin(view, search._replace(rng=copy.deepcopy(search.rng)))
            before = search.evaluations
            search = self._go_on(view, search, int(min(chunk, left)))
            left -= search.evaluations - before
        return search

    def is_through(self, view: View, search: Any, chunks: int) -> bool:
        """Tell whether a search is at rest with so many chunks of evaluations behind it."""
        if isinstance(search, Start):
            return False
        return bool(search.at_rest and search.evaluations >= chunks * self._chunk(view))

    def _proceed(
        self, view: View, search: Any, evaluations: float, stop: Stop | None
    ) -> tuple[Any, bool]:
        if stop is not None and stop():
            return search, True
        return self._go_on(view, search, int(min(self._chunk(view), evaluations))), False
