"""Prices of items, reduced costs, and the bound that they prove.

Every item may be covered once; a price is charged for it instead. For prices π ≥ 0,
L(π) = Σ_family min(0, min_node total + Σ π) − Σ π is a lower bound of the optimum (no 0 where
the family must be covered). Nothing here checks or raises.
"""

import math

import numpy as np

from trackweave._loops import total_of
from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.solvers._kernels import Component, set_owner


@jit
def price_nodes(
    component: Component, price: FloatArray, priced: FloatArray, reduced: FloatArray
) -> None:
    """Write the prices along each sequence to ``priced`` and its reduced cost to ``reduced``."""
    for node in range(component.parent.shape[0]):
        above = component.parent[node]
        total = price[component.item[node]]
        if above >= 0:
            total += priced[above]
        priced[node] = total
        reduced[node] = component.total[node] + total


@jit
def choose(component: Component, reduced: FloatArray, choice: IntArray, best: FloatArray) -> None:
    """Write each family's node of least reduced cost, -1 where taking none is better."""
    n_families = choice.shape[0]
    for family in range(n_families):
        choice[family] = -1
        best[family] = math.inf if component.must[family] else 0.0
    for node in range(component.parent.shape[0]):
        family = component.family[node]
        if reduced[node] < best[family]:
            best[family] = reduced[node]
            choice[family] = node


@jit
def choices_at(component: Component, price: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
    """Return each node's reduced cost, and each family's choice by it and what that costs."""
    n_nodes, n_families = component.parent.shape[0], component.must.shape[0]
    priced, reduced = np.empty(n_nodes), np.empty(n_nodes)
    best, choice = np.empty(n_families), np.empty(n_families, dtype=np.int64)
    price_nodes(component, price, priced, reduced)
    choose(component, reduced, choice, best)
    return reduced, choice, best


@jit
def bound_at(component: Component, price: FloatArray) -> float:
    """Return the bound L(π) at these prices."""
    _, _, best = choices_at(component, price)
    return total_of(best) - total_of(price)


@jit
def excesses(component: Component, price: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Return the bound L(π), each node's excess, and each family's of taking none."""
    reduced, _, best = choices_at(component, price)
    none = np.full(best.shape[0], math.inf)
    for family in range(best.shape[0]):
        if not component.must[family]:
            none[family] = -best[family]
    for node in range(reduced.shape[0]):
        reduced[node] -= best[component.family[node]]
    return total_of(best) - total_of(price), reduced, none


@jit
def beyond(component: Component, prefix: IntArray) -> np.ndarray:
    """Tell which nodes are of later families than those of a prefix, and share no item with it."""
    is_beyond = np.zeros(component.parent.shape[0], dtype=np.bool_)
    owner = np.full(component.n_items, -1, dtype=np.int64)
    for family in range(prefix.shape[0]):
        set_owner(component, prefix[family], family, owner)
    for node in range(is_beyond.shape[0]):
        above = component.parent[node]
        is_later = component.family[node] >= prefix.shape[0] and owner[component.item[node]] < 0
        is_beyond[node] = is_later and (above < 0 or is_beyond[above])
    return is_beyond
