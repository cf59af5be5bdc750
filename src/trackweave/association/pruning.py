"""How what a tree may hold after a scan ranks, and how much of it each family keeps."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._nodes import Candidates, Families, Misses, Nodes
from trackweave.association._pruning import accumulate_prices, rank_bounds, second_gains
from trackweave.association.growth_limits import GrowthLimits

__all__ = ["Offer", "bounds_of", "offered"]


class Offer(NamedTuple):
    """The sequences of a tree, each without a report of a scan, and behind them their children.

    ``parent`` is -1 for none. ``rank`` is the cost of each and what its reports are worth to
    others, and ``alive`` that of each sequence whose object lives on unseen [nats]. ``price`` is
    what the report of each child is worth to others, as far as can be told yet [nats].
    """

    family: IntArray
    parent: IntArray
    alive: FloatArray
    rank: FloatArray
    price: FloatArray


def offered(
    nodes: Nodes,
    candidates: Candidates,
    missed: Misses,
    is_new: NDArray[np.bool_],
    end_cost: float,
) -> Offer:
    """Return how sequences and the children that a scan offers them rank.

    Parameters
    ----------
    nodes, candidates, missed
        The sequences, their children, and what a miss makes of each sequence.
    is_new
        For each family whether its object begins in the window, and so may not exist at all.
    end_cost
        What the end of an object costs [nats].

    Returns
    -------
    All of them.
    """
    n_nodes = missed.tail.shape[0]
    family, cost, priced = nodes.family[:n_nodes], nodes.cost[:n_nodes], np.empty(n_nodes)
    accumulate_prices(nodes, n_nodes, priced)
    ended = cost + np.minimum(missed.tail, end_cost) + priced
    grown = candidates.cost + priced[candidates.node]
    # No beliefs speak of the scan's own reports yet. Without a price two objects beside each
    # other both rank best with the same report, and forget how it is to go without.
    without = np.where(is_new, 0.0, np.inf)
    np.minimum.at(without, family, ended)
    own, n_reports = family[candidates.node], int(candidates.report.max(initial=-1)) + 1
    price = second_gains(own, candidates.report, grown, without, n_reports)[candidates.report]
    return Offer(
        family=np.concatenate([family, own]),
        parent=np.concatenate([nodes.parent[:n_nodes], candidates.node]),
        alive=cost + missed.tail + priced,
        rank=np.concatenate([ended, grown + price]),
        price=price,
    )


def bounds_of(
    offer: Offer, group: IntArray, families: Families, limits: GrowthLimits
) -> tuple[FloatArray, IntArray, NDArray[np.bool_]]:
    """Return the worst rank that each group keeps, how many sequences, and if it is new.

    Parameters
    ----------
    offer
        What there may be.
    group
        For each among which it has to hold its own: its family, or a number behind all families.
    families
        The families.
    limits
        What bounds them.

    Returns
    -------
    For each group, those of the families first.
    """
    n_families = families.track.shape[0]
    family = np.arange(n_families)
    if group.max(initial=-1) >= n_families:
        family = np.zeros(group.max() + 1, dtype=np.int64)
        family[:n_families] = np.arange(n_families)
        family[group] = offer.family
    is_new = families.track[family] < 0
    keep = np.where(is_new, limits.new_keep, limits.keep)
    margin = np.where(is_new, limits.new_margin, limits.margin)
    ceiling = np.where(is_new, families.start_cost[family] + limits.new_ceiling, np.inf)
    return rank_bounds(group, offer.rank, margin, keep, ceiling), keep, is_new
