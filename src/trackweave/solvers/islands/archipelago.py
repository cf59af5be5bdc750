"""Islands in a component, as a value."""

from dataclasses import dataclass, replace
from typing import Any

from trackweave.arrays import IntArray
from trackweave.solvers.metaheuristic import Metaheuristic
from trackweave.solvers.protocol import Stop
from trackweave.solvers.resumable import Start, View

__all__ = ["Archipelago", "Island"]


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
