"""Which items never share a sequence. Nothing here checks or raises."""

import numpy as np

from trackweave._loops import ascending
from trackweave.arrays import IntArray
from trackweave.jit import jit
from trackweave.solvers._kernels import Component


@jit
def layers(component: Component, instant: IntArray) -> IntArray:
    """Return for each item one more than the most of any item of its instant before it.

    Before it: one of a lower number with which it shares a sequence. So items of one layer and
    instant share none.
    """
    item, parent = component.item, component.parent
    n_pairs = 0
    for node in range(item.shape[0]):
        climb = parent[node]
        while climb >= 0:
            n_pairs += instant[item[climb]] == instant[item[node]]
            climb = parent[climb]
    lower, higher = np.empty(n_pairs, dtype=np.int64), np.empty(n_pairs, dtype=np.int64)
    fill = 0
    for node in range(item.shape[0]):
        climb = parent[node]
        while climb >= 0:
            if instant[item[climb]] == instant[item[node]]:
                lower[fill] = min(item[climb], item[node])
                higher[fill] = max(item[climb], item[node])
                fill += 1
            climb = parent[climb]
    layer = np.zeros(component.n_items, dtype=np.int64)
    for pair in ascending(higher):
        layer[higher[pair]] = max(layer[higher[pair]], layer[lower[pair]] + 1)
    return layer
