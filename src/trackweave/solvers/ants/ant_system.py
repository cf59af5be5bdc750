"""Ant System, after Wiranto & Bonok (2018)."""

import copy
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray, is_whole
from trackweave.fields import settle
from trackweave.solvers._kernels import Component
from trackweave.solvers._pricing import price_nodes
from trackweave.solvers.ants._tours import (
    Points,
    accumulate,
    are_one_route,
    draw_starts,
    lay_trails,
    make_tours,
)
from trackweave.solvers.metaheuristic import Metaheuristic, chunk_of, owner_of
from trackweave.solvers.protocol import refuse_parameters
from trackweave.solvers.resumable import Start, View

__all__ = ["AntSearch", "AntSystem", "make_points", "most_visited", "tour_of"]

MARGIN = 0.01
"""Least shifted cost per item, as a share of the spread of costs per item."""
LEAST_MARGIN = 1e-12
"""No shifted cost may be less [nats], or visibility is beyond numbers."""


def make_points(view: View, *, priced: bool) -> Points:
    """Return the points of a component, nodes that may end first, with costs c′ all above 0."""
    # A tour covers every item once: by a sequence, or by the point that leaves it alone. So a
    # shift by κ for each item, c′ = c + κ·(number of items), adds the same to all tours and keeps
    # their order; κ is the least that leaves every c′ above 0, and a margin. Leaving an item alone
    # costs 0, hence c′ = κ. By prices π the shift of item i is π_i + κ. The margin is the median
    # cost per item less the least, times a small number: the best point's visibility stays finite,
    # in any unit and whatever is added to the cost of each item.
    component = view.component
    ones, price = np.ones(component.n_items), np.zeros(component.n_items)
    if priced:
        price = view.price
    shape = component.total.shape
    depth, reduced, unused = np.empty(shape), np.empty(shape), np.empty(shape)
    price_nodes(component, ones, depth, unused)
    price_nodes(component, price, unused, reduced)
    node = np.flatnonzero(np.isfinite(component.total))
    may_be_left = np.ones(component.n_items, dtype=np.bool_)
    roots = component.members[component.start[:-1]]
    may_be_left[component.item[roots[component.must]]] = False
    alone = np.flatnonzero(may_be_left)
    per_item = reduced[node] / depth[node]
    least = float(min(per_item.min(initial=0.0), price[alone].min(initial=np.inf)))
    spread = float(np.median(per_item)) - least if node.size else 0.0
    # Where all cost the same, any margin does.
    margin = MARGIN * (spread or abs(least) or float(price.max(initial=0.0)) or 1.0)
    shift = max(0.0, -least) + max(margin, LEAST_MARGIN)
    return Points(
        node=np.concatenate([node, np.full(alone.shape[0], -1)]),
        item=np.concatenate([component.item[node], alone]),
        cost=np.concatenate([reduced[node] + shift * depth[node], price[alone] + shift]),
    )


def most_visited(n_items: int) -> int:
    """Return N = 1 + Σ n_i, the document's number of points that an ant visits in a cycle."""
    # A tour covers every plot once, so that it visits Σ n_i points where all plots stay alone, and
    # fewer where points are tuples of several. One more is the tuple of dummies alone, which
    # covers no plot and costs every tour the same: it is counted here, and left out of the points.
    return 1 + n_items


def tour_of(component: Component, points: Points, selection: IntArray) -> IntArray:
    """Return the tour that takes a disjoint selection and leaves the other items alone."""
    n_nodes = int(np.count_nonzero(points.node >= 0))
    is_left = owner_of(component, selection)[points.item[n_nodes:]] < 0
    taken = np.searchsorted(points.node[:n_nodes], selection[selection >= 0])
    return np.concatenate([taken, n_nodes + np.flatnonzero(is_left)])


ANTS_PER_POINT = 3


@dataclass(frozen=True, slots=True, eq=False)
class AntSearch:
    """Where a search stands; it is replaced, never changed.

    ``position`` ants of the present cycle have made their ``tours``. ``attraction`` is the
    logarithm of τ^α η^β at the cycle's beginning, ``cumulative`` the running sum of its
    exponentials; in the first cycle ants follow ``order``, falling visibility, instead.
    """

    points: Points
    order: IntArray
    pheromone: FloatArray
    attraction: FloatArray
    cumulative: FloatArray
    starts: IntArray
    tours: IntArray
    lengths: FloatArray
    position: int
    cycle: int
    is_one_route: bool
    selection: IntArray
    best: float
    rng: np.random.Generator

    @classmethod
    def begin(cls, points: Points, n_items: int, ants: int, start: Start) -> Self:
        """Return a search before its first ant, with ants on different random points."""
        # On different ones as far as there are as many.
        # Visibility is 1 / c′, so the pheromone at first, too (eq. 3).
        visibility = 1.0 / points.cost
        return cls(
            points=points,
            order=np.argsort(points.cost, kind="stable"),
            pheromone=visibility,
            attraction=np.empty(0),
            cumulative=np.empty(0),
            starts=np.resize(start.rng.permutation(points.cost.shape[0]), ants),
            tours=np.full((ants, n_items), -1, dtype=np.int64),
            lengths=np.full(ants, np.inf),
            position=0,
            cycle=0,
            is_one_route=False,
            selection=start.selection.copy(),
            best=start.cost,
            rng=start.rng,
        )

    @property
    def evaluations(self) -> int:
        """How many tours were made."""
        return self.cycle * int(self.starts.shape[0]) + self.position

    @property
    def at_rest(self) -> bool:
        """Whether a cycle is complete."""
        return self.position == 0 and self.cycle > 0


@dataclass(frozen=True, slots=True)
class AntSystem(Metaheuristic):
    """Ant System on the multidimensional assignment [1]_.

    A point is a tuple, and an ant's tour visits points until every item is covered once. In the
    first cycle ants start on different random points and go to the open point of greatest
    visibility η = 1 / c. Pheromone is laid on the points of each tour in proportion to 1 / L, L
    the tour's cost. Ants die, and as many new ones start, each on a point that the one before
    it visited, and go to open points with probability in proportion to τ^α η^β. The search ends
    when all ants have the same route.

    Leaving an item alone is a point too. Costs are shifted by the same for each item, so that
    all points cost more than 0 and tours keep their order; see ``make_points``. Sequences that
    cost more than their items left alone are points like others, as in the document.

    Parameters
    ----------
    ants
        Number of ants, at least 1; None for 3 N, N = 1 + Σ n_i being the document's number of
        points that a tour visits, so that they grow with the problem: of fewer, all soon follow
        the best of the first. Here N counts the items of the component: those that no sequence
        joins stay alone in every tour, and are in none.
    pheromone_weight, visibility_weight
        α and β, at least 0. With α = 1 trails fix a route that is seldom the best; with less,
        ants seldom come to agree.
    persistence
        ρ: the share of pheromone that does not evaporate in a cycle, from 0 to 1.
    cycles
        The greatest number of cycles per component, at least 1; None for N.
    evaluations
        How many tours are made per component, to whole cycles; None for no limit but cycles.
    seeded
        Beyond the document: whether bounds and answers of the dual come before, and visibility
        is that of reduced costs.
    decompose
        Beyond the document: whether components are searched apart.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range.

    References
    ----------
    .. [1] I. Wiranto, Z. Bonok, *Application of ant system and nearest neighbor Kalman filter
       for multi target tracking in multi sensor radar system*, ARPN, 2018, eqs. (3)–(7).

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> answer = tw.solve(problem, tw.AntSystem(cycles=20), rng=np.random.default_rng(1))
    >>> answer.cost, answer.lower_bound
    (-7.0, -9.0)
    >>> answer.tuples
    array([[1, 1],
           [2, 2]])
    """

    ants: int | None = None
    pheromone_weight: float = 1.0
    visibility_weight: float = 5.0
    persistence: float = 0.8
    cycles: int | None = None
    evaluations: int | None = None
    seeded: bool = False
    decompose: bool = True

    def __post_init__(self) -> None:
        settle(self)
        wrong = [
            (not _is_count(self.ants), "ants", "a whole number ≥ 1, or None"),
            (not 0 <= self.pheromone_weight < np.inf, "pheromone_weight", "a number ≥ 0"),
            (not 0 <= self.visibility_weight < np.inf, "visibility_weight", "a number ≥ 0"),
            (not 0 <= self.persistence <= 1, "persistence", "a number from 0 to 1"),
            (not _is_count(self.cycles), "cycles", "a whole number ≥ 1, or None"),
            (not _is_count(self.evaluations), "evaluations", "a whole number ≥ 1, or None"),
        ]
        refuse_parameters(self, wrong)

    def _begin(self, view: View, start: Start) -> AntSearch:
        points = make_points(view, priced=self.seeded)
        ants = self.colony(view.component.n_items)
        return AntSearch.begin(points, view.component.n_items, ants, start)

    def colony(self, n_items: int) -> int:
        """Return how many ants search a component of so many items."""
        return self.ants or ANTS_PER_POINT * most_visited(n_items)

    def _go_on(self, view: View, search: AntSearch, evaluations: int) -> AntSearch:
        n_ants = search.starts.shape[0]
        last = min(search.position + evaluations, n_ants)
        selection, rng = search.selection.copy(), copy.deepcopy(search.rng)
        tours, lengths = search.tours.copy(), search.lengths.copy()
        best = make_tours(
            view.component, search.points, (search.order, search.attraction, search.cumulative),
            search.cycle == 0, np.arange(search.position, last), search.starts, rng, tours,
            lengths, selection, search.best,
        )  # fmt: skip
        moved = replace(
            search, tours=tours, lengths=lengths, position=last, selection=selection, best=best,
            rng=rng,
        )  # fmt: skip
        return self._next_cycle(moved) if last == n_ants else moved

    def admit(self, view: View, search: AntSearch, selection: IntArray, cost: float) -> AntSearch:
        """Return the search with another's answer taken in; see ``Metaheuristic``."""
        if cost >= search.best:
            return search
        # As though one ant more had made this tour in the cycle before.
        tour = tour_of(view.component, search.points, selection)
        pheromone, length = search.pheromone.copy(), search.points.cost[tour].sum()
        lay_trails(pheromone, tour[None], np.array([length]), 1.0)
        return self._attracted(replace(search, selection=selection, best=cost), pheromone)

    def _next_cycle(self, search: AntSearch) -> AntSearch:
        """Return the search at the next cycle's beginning; its own generator is drawn from."""
        pheromone, starts = search.pheromone.copy(), np.empty_like(search.starts)
        lay_trails(pheromone, search.tours, search.lengths, self.persistence)
        draw_starts(search.tours, search.rng, starts)
        moved = replace(
            search,
            starts=starts,
            position=0,
            cycle=search.cycle + 1,
            is_one_route=are_one_route(search.tours, search.points.cost.shape[0]),
        )
        return self._attracted(moved, pheromone)

    def _attracted(self, search: AntSearch, pheromone: FloatArray) -> AntSearch:
        """Return the search with other pheromone, and what follows from it."""
        attraction = self.pheromone_weight * np.log(np.maximum(pheromone, np.finfo(float).tiny))
        attraction -= self.visibility_weight * np.log(search.points.cost)
        cumulative = np.empty_like(attraction)
        accumulate(attraction, np.arange(attraction.shape[0]), cumulative)
        return replace(search, pheromone=pheromone, attraction=attraction, cumulative=cumulative)

    def _chunk(self, view: View) -> int:
        return chunk_of(view, self.colony(view.component.n_items))

    def _why_over(self, search: AntSearch) -> str:
        if search.is_one_route:
            return "converged"
        cycles = self.cycles or most_visited(search.tours.shape[1])
        if search.cycle >= cycles:
            return "cycles"
        limit = np.inf if self.evaluations is None else self.evaluations
        return "evaluations" if search.evaluations >= limit else ""


def _is_count(value: int | None) -> bool:
    return value is None or (is_whole(value) and value >= 1)
