"""Two ways up the dual that do not stall where plain subgradients do.

Both write the prices of the best bound seen to ``price``. Nothing here checks or raises.
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave._loops import overwrite, total_of
from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.solvers._kernels import Component
from trackweave.solvers._pricing import choose, price_nodes

SMOOTHING = 0.1
"""Weight of the newest subgradient in the direction."""
PATIENCE, SHRINK = 20, 0.7
"""After so many bounds without a rise the step is multiplied by this."""
NEGLIGIBLE = 15.0
"""A sequence this many temperatures above its family's best counts as not taken."""


class Climb(NamedTuple):
    """Where an ascent stands.

    ``current`` are the prices of the next bound; ``other`` is the direction of the subgradients,
    or the last prices of the smoothed ascent. ``value`` holds the best bound, and the factor of
    the step or the momentum; ``steps`` how many bounds were computed in all and since a rise.
    ``is_inside`` tells of each item whether more than one family wants it: prices of the others
    are of no use, since a family takes one sequence anyway.
    """

    current: FloatArray
    other: FloatArray
    value: FloatArray
    steps: IntArray
    is_inside: np.ndarray


@jit
def begin_climb(component: Component, price: FloatArray, bound: float, factor: float) -> Climb:
    """Return an ascent from these prices before its first bound."""
    is_inside = np.zeros(component.n_items, dtype=np.bool_)
    is_root = np.zeros(component.n_items, dtype=np.bool_)
    for node in range(component.parent.shape[0]):
        item = component.item[node]
        is_inside[item] |= component.parent[node] >= 0 or is_root[item]
        is_root[item] |= component.parent[node] < 0
    return Climb(
        price.copy(),
        price.copy(),
        np.array([bound, factor]),
        np.zeros(2, dtype=np.int64),
        is_inside,
    )


@jit
def deflect(
    component: Component, price: FloatArray, climb: Climb, target: float, more: int, last: int
) -> bool:
    """Climb by deflected subgradients, up to ``more`` steps and ``last`` in all.

    The direction is a running mean of the subgradients, as in the volume algorithm (Barahona,
    Anbil 2000); the step is Polyak's with ``target`` as the value to reach. Returns whether the
    climb is over.
    """
    n_nodes, n_families = component.parent.shape[0], component.must.shape[0]
    priced, reduced = np.empty(n_nodes), np.empty(n_nodes)
    best, choice = np.empty(n_families), np.empty(n_families, dtype=np.int64)
    gradient, current, direction = np.empty(component.n_items), climb.current, climb.other
    if climb.steps[0] == 0:
        direction[:] = 0.0
    for _ in range(min(more, last - climb.steps[0])):
        price_nodes(component, current, priced, reduced)
        choose(component, reduced, choice, best)
        bound = total_of(best) - total_of(current)
        climb.steps[0] += 1
        if bound > climb.value[0] + 1e-9 * abs(climb.value[0]):
            climb.value[0] = bound
            climb.steps[1] = 0
            overwrite(price, current)
        else:
            climb.steps[1] += 1
        gradient[:] = -1.0
        for family in range(n_families):
            node = choice[family]
            while node >= 0:
                gradient[component.item[node]] += 1.0
                node = component.parent[node]
        restarted = False
        if climb.steps[1] >= PATIENCE:
            climb.value[1] *= SHRINK
            climb.steps[1] = 0
            overwrite(current, price)
            direction[:] = 0.0
            restarted = True
        norm = 0.0
        for item in range(component.n_items):
            if climb.is_inside[item]:
                direction[item] += SMOOTHING * (gradient[item] - direction[item])
                if current[item] > 0.0 or direction[item] > 0.0:
                    norm += direction[item] * direction[item]
        if climb.value[1] < 1e-4 or target - climb.value[0] <= 0.0:
            return True
        if norm < 1e-12:
            # Nowhere to go: best already, unless the subgradient is that of prices given up.
            if restarted:
                continue
            return True
        step = climb.value[1] * (target - bound) / norm
        for item in range(component.n_items):
            if climb.is_inside[item]:
                current[item] = max(0.0, current[item] + step * direction[item])
    return bool(climb.steps[0] >= last)


@jit
def smooth(
    component: Component,
    price: FloatArray,
    climb: Climb,
    hot: float,
    cold: float,
    more: int,
    last: int,
) -> bool:
    """Climb the dual smoothed by a temperature that falls from ``hot`` to ``cold``.

    With a temperature each family spreads over its sequences as exp(−reduced cost), and every
    item's expected cover says how to change its price: by the temperature times its logarithm,
    damped by the longest sequence, with Nesterov's momentum, given up when it points down.
    Returns whether the climb is over.
    """
    n_nodes = component.parent.shape[0]
    priced, reduced, weight = np.empty(n_nodes), np.empty(n_nodes), np.empty(n_nodes)
    cover = np.empty(component.n_items)
    current, before = climb.current, climb.other
    depth = max(1, _longest(component) - 1)
    for _ in range(min(more, last - climb.steps[0])):
        temperature = hot * (cold / hot) ** (climb.steps[0] / max(1, last - 1))
        bound = _expect(component, current, temperature, priced, reduced, weight, cover)
        climb.steps[0] += 1
        if bound > climb.value[0]:
            climb.value[0] = bound
            overwrite(price, current)
        momentum = climb.value[1]
        following = 0.5 * (1.0 + math.sqrt(1.0 + 4.0 * momentum * momentum))
        agreement = 0.0
        for item in range(component.n_items):
            if climb.is_inside[item]:
                step = temperature * math.log(max(cover[item], 1e-12)) / depth
                cover[item] = max(0.0, current[item] + step)
                agreement += (cover[item] - current[item]) * (cover[item] - before[item])
        if agreement < 0.0:
            momentum = following = 1.0
        pull = (momentum - 1.0) / following
        for item in range(component.n_items):
            if climb.is_inside[item]:
                current[item] = max(0.0, cover[item] + pull * (cover[item] - before[item]))
                before[item] = cover[item]
        climb.value[1] = following
    return bool(climb.steps[0] >= last)


@jit
def _longest(component: Component) -> int:
    """Return the number of items of the longest sequence."""
    depth = np.empty(component.parent.shape[0], dtype=np.int64)
    longest = 0
    for node in range(component.parent.shape[0]):
        above = component.parent[node]
        depth[node] = 1 if above < 0 else depth[above] + 1
        longest = max(longest, depth[node])
    return longest


@jit
def _expect(
    component: Component,
    price: FloatArray,
    temperature: float,
    priced: FloatArray,
    reduced: FloatArray,
    weight: FloatArray,
    cover: FloatArray,
) -> float:
    """Write how often each item is expected to be covered; return the bound at these prices."""
    n_nodes, n_families = component.parent.shape[0], component.must.shape[0]
    parent, item, family_of = component.parent, component.item, component.family
    best = np.zeros(n_families)
    for family in range(n_families):
        if component.must[family]:
            best[family] = math.inf
    price_nodes(component, price, priced, reduced)
    for node in range(n_nodes):
        if reduced[node] < best[family_of[node]]:
            best[family_of[node]] = reduced[node]
    total = np.zeros(n_families)
    for family in range(n_families):
        if not component.must[family]:
            total[family] = math.exp(best[family] / temperature)
    limit = NEGLIGIBLE * temperature
    for node in range(n_nodes):
        excess = reduced[node] - best[family_of[node]]
        weight[node] = 0.0
        if excess < limit:
            weight[node] = math.exp(-excess / temperature)
            total[family_of[node]] += weight[node]
    cover[:] = 0.0
    # What a node is taken with counts for its parent's item too: children hand theirs up.
    for node in range(n_nodes - 1, -1, -1):
        if weight[node] > 0.0:
            cover[item[node]] += weight[node] / total[family_of[node]]
            if parent[node] >= 0:
                weight[parent[node]] += weight[node]
    return total_of(best) - total_of(price)
