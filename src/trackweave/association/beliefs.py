"""How probable each sequence of a tree is, all tracks and reports considered together."""

from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._beliefs import Edges, find_edges, propagate, sum_edges
from trackweave.association.living import log_weights
from trackweave.association.tree import AssociationTree

__all__ = ["Beliefs", "believe"]


@dataclass(frozen=True, slots=True, eq=False)
class Beliefs:
    """Probabilities over a tree's sequences."""

    probability: FloatArray  # Of each sequence, shape (nodes,)
    # For each node the edge of its family and last report, shape (nodes,); -1 without report.
    edge: IntArray
    # That the edge's report belongs to the edge's family, shape (edges,).
    edge_probability: FloatArray
    # Odds of all families together for each report that some sequence has, shape (reports,).
    claims: FloatArray
    # That the family's object lives, shape (families,). An object on a line, seen by a bearing
    # alone, counts for nothing.
    existence: FloatArray


def believe(
    tree: AssociationTree, known: FloatArray | None = None, max_iterations: int = 15
) -> Beliefs:
    """Return the beliefs after the last scan; leave prices and beliefs in the tree's nodes."""
    # With loops in the graph they are approximate. Where ``known`` tells how probable the search
    # found each sequence to be, shape (nodes,), the probabilities of associations are summed from
    # it; all else is propagated, which mostly converges in fewer iterations.
    nodes, n, n_families = tree.nodes, tree.n_nodes, tree.n_families
    slots, place = tree.slots()
    n_reports = slots.shape[0]
    edges: Edges = find_edges(nodes.family, place, n, n_reports, n_families)
    weight, alive = log_weights(nodes.cost[:n], nodes.tail[:n], tree.rule.end_cost)
    probability, edge_probability = np.empty(n), np.empty(edges.report.shape[0])
    propagate(
        nodes, n, tree.track < 0, edges, n_reports, weight, max_iterations,
        probability, edge_probability,
    )  # fmt: skip
    claims = _claims(nodes.price[:n], edges, edge_probability, n_reports)
    if known is not None:
        sum_edges(nodes, n, edges, known, edge_probability)
    np.multiply(probability, alive, out=nodes.belief[:n])
    in_place = np.where(nodes.is_line[:n] == 0, nodes.belief[:n], 0.0)
    existence = np.bincount(nodes.family[:n], in_place, n_families).astype(np.float64, copy=False)
    # Sums of many shares of one can come out above it by rounding.
    for chance in (probability, edge_probability, existence):
        np.minimum(chance, 1.0, out=chance)
    return Beliefs(probability, edges.of_node, edge_probability, claims, existence)


def _claims(
    price: FloatArray, edges: Edges, edge_probability: FloatArray, n_reports: int
) -> FloatArray:
    """Return what all families together would give for each report, as odds."""
    own = np.zeros(edges.report.shape[0])
    has = edges.of_node >= 0
    own[edges.of_node[has]] = price[has]
    share = np.minimum(edge_probability, 1.0 - 1e-9)
    claims = np.zeros(n_reports)
    np.add.at(claims, edges.report, share / (1.0 - share) * np.exp(own))
    return claims
