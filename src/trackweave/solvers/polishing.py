"""Better answers nearby, for any search that has one."""

import numpy as np

from trackweave.arrays import IntArray
from trackweave.solvers._kernels import Component, set_owner
from trackweave.solvers._list_reassignment import local_search
from trackweave.solvers.lists import Lists

__all__ = ["owner_of", "polish"]

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
