"""The points that ants visit: sequences that may end, and items left alone."""

import numpy as np

from trackweave.arrays import IntArray
from trackweave.solvers._kernels import Component
from trackweave.solvers._pricing import price_nodes
from trackweave.solvers.ants._tours import Points
from trackweave.solvers.polishing import owner_of
from trackweave.solvers.resumable import View

__all__ = ["make_points", "most_visited", "tour_of"]

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
