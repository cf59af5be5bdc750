"""How what a tree may hold after a scan ranks, and how much of it each family keeps."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._nodes import Candidates, Families, Misses, Nodes
from trackweave.association._pruning import Cut, rank_bounds, rank_offer
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.living import log_weights

__all__ = ["Fate", "Offer", "bounds_of", "cut_of", "offered", "silence_beside"]


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


class Fate(NamedTuple):
    """What becomes of an offer: which stay, and whether each sequence's object may live on."""

    kept: NDArray[np.bool_]
    is_open: NDArray[np.bool_]


def offered(
    nodes: Nodes,
    candidates: Candidates,
    missed: Misses,
    is_new: NDArray[np.bool_],
    end_cost: float,
) -> Offer:
    """Return how sequences and the children that a scan offers them rank."""
    # A new family's object begins in the window, and so may not exist at all. Costs are in nats.
    return Offer(*rank_offer(nodes, candidates, missed.tail, is_new, end_cost))


def silence_beside(unseen: FloatArray) -> float:
    """Return what all sensors but one cost by their silence who cannot see an object [nats]."""
    # ``unseen`` is how probably each cannot. So much at most is told against an object that begins
    # where one sees alone, and may say that it is hidden from the others instead of nowhere.
    cost = -np.log(unseen)
    return float(cost.sum() - cost.min()) if cost.size else 0.0


def bounds_of(
    offer: Offer,
    group: IntArray,
    families: Families,
    limits: GrowthLimits,
    silence: float = 0.0,
) -> tuple[FloatArray, IntArray, NDArray[np.bool_]]:
    """Return the worst rank that each group keeps, how many sequences, and if it is new."""
    # What begins may lie above the price of its first report by ``silence`` more [nats].
    # A node's group, among which it has to hold its own, is its family, or a number behind all
    # families; those of the families come first.
    n_families = families.track.shape[0]
    family = np.arange(n_families)
    if group.max(initial=-1) >= n_families:
        family = np.zeros(group.max() + 1, dtype=np.int64)
        family[:n_families] = np.arange(n_families)
        family[group] = offer.family
    is_new = families.track[family] < 0
    keep = np.where(is_new, limits.new_keep, limits.keep)
    margin = np.where(is_new, limits.new_margin, limits.margin)
    most = limits.new_ceiling + silence
    ceiling = np.where(is_new, families.start_cost[family] + most, np.inf)
    return rank_bounds(group, offer.rank, margin, keep, ceiling), keep, is_new


def cut_of(
    nodes: Nodes, candidates: Candidates, missed: Misses, fate: Fate, end_cost: float
) -> Cut:
    """Return what of an offer is left out, for the tree in which the nodes kept come first."""
    # Nodes, candidates and misses are as in ``offered``, but with slots for reports.
    n_nodes, kept = missed.tail.shape[0], fate.kept
    gone, new = np.flatnonzero(~kept[:n_nodes]), np.flatnonzero(~kept[n_nodes:])
    stopped = np.flatnonzero(kept[:n_nodes] & ~fate.is_open & np.isfinite(missed.tail))
    # Nodes count from 0, what is left out from ~0.
    number = np.cumsum(kept[:n_nodes]) - 1
    number[gone] = ~np.arange(gone.shape[0])
    old = log_weights(nodes.cost[gone], missed.tail[gone], end_cost)[0]
    return Cut(
        family=nodes.family[np.concatenate([gone, candidates.node[new], stopped])],
        above=number[np.concatenate([nodes.parent[gone], candidates.node[new], stopped])],
        report=np.concatenate(
            [nodes.report[gone], candidates.report[new], np.full(stopped.shape[0], -1)]
        ),
        log_weight=np.concatenate([
            old,
            -candidates.cost[new],
            -nodes.cost[stopped] - missed.tail[stopped],
        ]),
    )  # fmt: skip
