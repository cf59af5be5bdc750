"""What genetic searches do with the best individual of a generation."""

import numpy as np

from trackweave.arrays import IntArray
from trackweave.solvers._kernels import Component, improve, set_owner

__all__ = ["improve_selection"]

LARGE = 20_000
"""More sequences than this may be too many for one improvement."""
STRIDE = 61
"""How many families further on the next generation's improvement begins in a large component."""


def improve_selection(component: Component, selection: IntArray, generation: int) -> float:
    """Improve a selection in place by eject, insert and repair.

    Parameters
    ----------
    component
        What is searched.
    selection
        Each family's node, -1 for none; disjoint.
    generation
        Which generation it is the best of.

    Returns
    -------
    What the selection costs then.
    """
    owner = np.full(component.n_items, -1, dtype=np.int64)
    roots = component.members[component.start[:-1]]
    owner[component.item[roots[component.must]]] = np.flatnonzero(component.must)
    for family in np.flatnonzero(selection >= 0):
        set_owner(component, int(selection[family]), int(family), owner)
    first = 0
    if component.parent.shape[0] > LARGE:
        # One improvement does not come round there: each generation's begins elsewhere.
        first = generation * STRIDE % selection.shape[0]
    return improve(component, selection, owner, 10, first)
