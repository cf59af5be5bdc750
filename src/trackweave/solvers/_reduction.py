"""Leaving out what the prices exclude. Nothing here checks or raises."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.solvers._kernels import Component
from trackweave.solvers._pricing import excesses

DROPPED, PREFIX, OPEN, FORCED = 0, 1, 2, 3


@jit
def classify(component: Component, price: FloatArray, upper: float) -> IntArray:
    """Tell of each node whether an answer better than ``upper`` can take it.

    A node whose reduced cost exceeds its family's least by more than the gap is DROPPED, or
    PREFIX where an OPEN node stands below it. The only open node of a family that has to take
    one is FORCED, and then whatever shares an item with it is out too.
    """
    bound, excess, none = excesses(component, price)
    n_nodes, n_families = excess.shape[0], none.shape[0]
    gap = upper - bound + 1e-9 * max(1.0, abs(upper))
    state = np.zeros(n_nodes, dtype=np.int64)
    for node in range(n_nodes):
        if excess[node] <= gap:
            state[node] = OPEN
    holder = np.full(component.n_items, -1, dtype=np.int64)
    forced = np.zeros(n_families, dtype=np.bool_)
    changed = True
    while changed:
        changed = False
        count, only = np.zeros(n_families, dtype=np.int64), np.empty(n_families, dtype=np.int64)
        for node in range(n_nodes):
            if state[node] == OPEN:
                count[component.family[node]] += 1
                only[component.family[node]] = node
        for family in range(n_families):
            has_to = component.must[family] or none[family] > gap
            if has_to and count[family] == 1 and not forced[family]:
                forced[family] = changed = True
                climb = only[family]
                while climb >= 0:
                    holder[component.item[climb]] = family
                    climb = component.parent[climb]
        if changed:
            for node in range(n_nodes):
                if state[node] == OPEN:
                    climb = node
                    while climb >= 0:
                        other = holder[component.item[climb]]
                        if other >= 0 and other != component.family[node]:
                            state[node] = DROPPED
                            break
                        climb = component.parent[climb]
    for node in range(n_nodes - 1, -1, -1):
        above = component.parent[node]
        if state[node] != DROPPED and above >= 0 and state[above] == DROPPED:
            state[above] = PREFIX
    for node in range(n_nodes):
        if forced[component.family[node]]:
            state[node] = FORCED if state[node] == OPEN else DROPPED
    return state
