"""What genes, ants, tabu lists and annealing share: a search counted in evaluations."""

import copy
from abc import abstractmethod
from typing import Any

from trackweave.arrays import IntArray
from trackweave.solvers.protocol import Stop
from trackweave.solvers.resumable import Resumable, Search, Start, View

__all__ = ["Metaheuristic", "chunk_of"]

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
