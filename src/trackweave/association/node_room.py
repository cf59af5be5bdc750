"""Room for a tree's nodes, which can be left as it is while a step goes on in another."""

import copy
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from trackweave.association._moving import copy_nodes
from trackweave.association._nodes import Nodes, allocate, larger, sizes_of

__all__ = ["NodeRoom"]


class NodeRoom:
    """Nodes in arrays that grow by doubling.

    What drops nodes copies the others in any case. So a step that may have to be taken back costs
    no copy of its own: the first time that it drops nodes it moves to a spare room, and leaves the
    old one as it was.
    """

    def __init__(self, modes: int, size: int, columns: int = 0) -> None:
        self.n_nodes = 0
        self.nodes = allocate(256, modes, size, columns)
        self._spare: Nodes | None = None
        self._is_shared = False
        """Whether the nodes are also another's, who must find them as they are."""

    def __getstate__(self) -> dict[str, Any]:
        # The spare room is nobody's past and no part of a copy.
        return {**self.__dict__, "_spare": None, "_is_shared": False}

    def at_rest(self) -> dict[str, Any]:
        """Return what a checkpoint holds: nodes without the room that none is in."""
        nodes = larger(self.nodes, self.n_nodes, self.n_nodes)
        return {**self.__getstate__(), "nodes": nodes}

    def saved(self) -> Self:
        """Return all as it is now; it stays so whatever is done here until ``settled``."""
        self._is_shared = True
        return copy.copy(self)

    def settled(self, old: Self) -> None:
        """Take it that nobody goes back to what was saved: its room becomes the spare one."""
        if old.nodes is not self.nodes:
            self._spare = old.nodes
        self._is_shared = False

    def _own(self) -> None:
        """See to it that nodes can be changed in place."""
        if self._is_shared:
            self._compact(np.ones(self.n_nodes, dtype=np.bool_))

    def _reserve(self, count: int) -> None:
        capacity = self.nodes.parent.shape[0]
        if self.n_nodes + count <= capacity:
            return
        self.nodes = larger(self.nodes, self.n_nodes, max(2 * capacity, self.n_nodes + count))
        self._is_shared = False

    def _compact(self, keep: NDArray[np.bool_]) -> None:
        """Drop the nodes that are not kept; order stays."""
        rows = np.flatnonzero(keep)
        if rows.shape[0] == self.n_nodes and not self._is_shared:
            return
        number = np.cumsum(keep) - 1
        # In place each node goes to where it is or before, and what no gap precedes stays.
        is_shared = self._is_shared
        room, first = (self._other_room(), 0) if is_shared else (self.nodes, int(np.argmin(keep)))
        copy_nodes(self.nodes, rows[first:], room, first)
        parent = room.parent[first : rows.shape[0]]
        parent[parent >= 0] = number[parent[parent >= 0]]
        self.nodes, self.n_nodes, self._is_shared = room, rows.shape[0], False

    def _other_room(self) -> Nodes:
        """Return room for as many nodes as there is here."""
        capacity, room = self.nodes.parent.shape[0], self._spare
        self._spare = None
        if room is None or room.parent.shape[0] < capacity:
            return allocate(capacity, *sizes_of(self.nodes))
        return room
