"""Tours of ants over points, and their trails. Nothing here checks or raises.

A point is a sequence that may end, or an item that is left alone; a tour visits points until
every item is covered once. Numbers of equations are those of Wiranto & Bonok (2018).
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave._loops import overwrite
from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.solvers._kernels import Component, selection_cost


class Points(NamedTuple):
    """What ants visit.

    ``node`` is the node that each point stands for, -1 where it stands for an item left alone;
    ``item`` is its last item, and ``cost`` its shifted cost c′, above 0.
    """

    node: IntArray
    item: IntArray
    cost: FloatArray


# These two take plain arrays: with tuples of arrays they are not compiled into the loops that
# call them, and each call then costs some 100 ns for counting references.
@jit
def is_open(
    parent: IntArray, item: IntArray, node: int, last_item: int, covered: np.ndarray
) -> bool:
    """Tell whether a tour may still visit a point: none of its items is covered.

    ``node`` is the point's, -1 where it leaves ``last_item`` alone.
    """
    if node < 0:
        return not covered[last_item]
    while node >= 0:
        if covered[item[node]]:
            return False
        node = parent[node]
    return True


@jit
def visit(parent: IntArray, item: IntArray, node: int, last_item: int, covered: np.ndarray) -> int:
    """Mark a point's items as covered, so that points in conflict are tabu; count them."""
    if node < 0:
        covered[last_item] = True
        return 1
    count = 0
    while node >= 0:
        covered[item[node]] = True
        count += 1
        node = parent[node]
    return count


@jit
def nearest_tour(
    component: Component, points: Points, order: IntArray, start: int, tour: IntArray
) -> float:
    """Write the tour that goes on to the most visible open point; return its length L (eq. 3).

    ``order`` lists the points by falling visibility.
    """
    parent, item, node, last = component.parent, component.item, points.node, points.item
    covered = np.zeros(component.n_items, dtype=np.bool_)
    tour[:] = -1
    tour[0], steps = start, 1
    length = float(points.cost[start])
    done = visit(parent, item, node[start], last[start], covered)
    for point in order:
        if done == component.n_items:
            break
        if is_open(parent, item, node[point], last[point], covered):
            done += visit(parent, item, node[point], last[point], covered)
            length += points.cost[point]
            tour[steps] = point
            steps += 1
    return length


@jit
def accumulate(attraction: FloatArray, chosen: IntArray, cumulative: FloatArray) -> None:
    """Write the running sum of the chosen points' weights, in units of the greatest of them.

    ``attraction`` is the logarithm of τ^α η^β.
    """
    greatest = -math.inf
    for point in chosen:
        greatest = max(greatest, attraction[point])
    running = 0.0
    for place in range(chosen.shape[0]):
        running += math.exp(attraction[chosen[place]] - greatest)
        cumulative[place] = running


@jit
def draw(cumulative: FloatArray, rng: np.random.Generator) -> int:
    """Return a place with the probability that its weight has in the running sum."""
    low, high = 0, cumulative.shape[0] - 1
    wanted = rng.random() * cumulative[high]
    while low < high:
        middle = (low + high) // 2
        if cumulative[middle] > wanted:
            high = middle
        else:
            low = middle + 1
    return low


@jit
def chance_tour(
    component: Component,
    points: Points,
    attraction: FloatArray,
    cumulative: FloatArray,
    start: int,
    rng: np.random.Generator,
    tour: IntArray,
) -> float:
    """Write a tour whose steps are drawn by eq. 4; return its length L.

    ``cumulative`` is the running sum over all points. A point drawn in vain, for it is tabu, is
    drawn again, which leaves the chances of the open ones as they are; when that happens often,
    what is still open is listed anew.
    """
    parent, item, node, last = component.parent, component.item, points.node, points.item
    covered = np.zeros(component.n_items, dtype=np.bool_)
    tour[:] = -1
    tour[0], steps = start, 1
    length = float(points.cost[start])
    done = visit(parent, item, node[start], last[start], covered)
    n_left = points.node.shape[0]
    left, sums, is_listed, vain = np.empty(0, dtype=np.int64), cumulative, False, 0
    while done < component.n_items:
        if vain > 4 + n_left // 16:
            if not is_listed:
                left, sums = np.arange(n_left), np.empty(n_left)
                is_listed = True
            kept = 0
            for place in range(n_left):
                point = left[place]
                if is_open(parent, item, node[point], last[point], covered):
                    left[kept] = point
                    kept += 1
            n_left, vain = kept, 0
            accumulate(attraction, left[:n_left], sums[:n_left])
        point = draw(sums[:n_left], rng)
        if is_listed:
            point = left[point]
        if is_open(parent, item, node[point], last[point], covered):
            done += visit(parent, item, node[point], last[point], covered)
            length += points.cost[point]
            tour[steps] = point
            steps += 1
        else:
            vain += 1
    return length


@jit
def selection_of(
    component: Component, points: Points, tour: IntArray, selection: IntArray
) -> float:
    """Write the sequences that a tour visits; return what they cost."""
    selection[:] = -1
    for point in tour:
        if point < 0:
            break
        node = points.node[point]
        if node >= 0:
            selection[component.family[node]] = node
    return selection_cost(component, selection)


@jit
def make_tours(
    component: Component,
    points: Points,
    guide: tuple[IntArray, FloatArray, FloatArray],
    is_first: bool,
    ants: IntArray,
    starts: IntArray,
    rng: np.random.Generator,
    tours: IntArray,
    lengths: FloatArray,
    best_selection: IntArray,
    best_cost: float,
) -> float:
    """Send these ants out; write their tours, lengths and the best selection.

    ``guide`` holds the points by falling visibility for the first cycle, and for later ones the
    attraction and its running sum. Returns the least cost, ``best_cost`` where none is less.
    """
    order, attraction, cumulative = guide
    selection = np.empty(component.must.shape[0], dtype=np.int64)
    for ant in ants:
        tour = tours[ant]
        if is_first:
            lengths[ant] = nearest_tour(component, points, order, starts[ant], tour)
        else:
            lengths[ant] = chance_tour(
                component, points, attraction, cumulative, starts[ant], rng, tour
            )
        cost = selection_of(component, points, tour, selection)
        if cost < best_cost:
            best_cost = cost
            overwrite(best_selection, selection)
    return best_cost


@jit
def lay_trails(
    pheromone: FloatArray, tours: IntArray, lengths: FloatArray, persistence: float
) -> None:
    """Let pheromone evaporate and add 1/L on the points of each tour, in place (eqs. 5–7)."""
    for point in range(pheromone.shape[0]):
        pheromone[point] *= persistence
    for ant in range(tours.shape[0]):
        for point in tours[ant]:
            if point < 0:
                break
            pheromone[point] += 1.0 / lengths[ant]


@jit
def are_one_route(tours: IntArray, n_points: int) -> bool:
    """Tell whether all tours visit the same points, in whatever order."""
    in_first = np.zeros(n_points, dtype=np.bool_)
    steps = 0
    for point in tours[0]:
        if point >= 0:
            in_first[point] = True
            steps += 1
    for ant in range(1, tours.shape[0]):
        own = 0
        for point in tours[ant]:
            if point >= 0:
                own += 1
                if not in_first[point]:
                    return False
        if own != steps:
            return False
    return True


@jit
def draw_starts(tours: IntArray, rng: np.random.Generator, starts: IntArray) -> None:
    """Write for each ant one of the points that the ant before it visited."""
    for ant in range(tours.shape[0]):
        steps = 0
        while steps < tours.shape[1] and tours[ant, steps] >= 0:
            steps += 1
        starts[ant] = tours[ant, rng.integers(0, steps)]
