"""Belief propagation over the sequences of an association tree.

Families choose among their sequences, reports admit at most one family: a factor graph with
one edge for each family and report that meet. Messages are those of Williams and Lau (2014,
doi:10.1109/TAES.2014.120568, eqs. 32-33) with whole sequences in the place of single
associations. Nothing here checks or raises.
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._nodes import Nodes, State
from trackweave.association._predicting import move_state
from trackweave.jit import jit
from trackweave.models.motion import MotionRule


class Edges(NamedTuple):
    """Meetings of families and reports: ``of_node`` is -1 for a node without a report."""

    of_node: IntArray
    report: IntArray


@jit
def find_edges(
    family_of: IntArray, place: IntArray, n_nodes: int, n_reports: int, n_families: int
) -> Edges:
    """Give a number to each pair of family and report that some sequence has.

    ``place`` is each node's report among those that some node has, -1 for none.
    """
    start = np.zeros(n_reports + 1, dtype=np.int64)
    for node in range(n_nodes):
        if place[node] >= 0:
            start[place[node] + 1] += 1
    for report in range(n_reports):
        start[report + 1] += start[report]
    fill = start[:-1].copy()
    by_report = np.empty(start[n_reports], dtype=np.int64)
    for node in range(n_nodes):
        if place[node] >= 0:
            by_report[fill[place[node]]] = node
            fill[place[node]] += 1
    of_node = np.full(n_nodes, -1, dtype=np.int64)
    edge_report = np.empty(by_report.shape[0], dtype=np.int64)
    seen_at = np.full(n_families, -1, dtype=np.int64)
    edge_of = np.empty(n_families, dtype=np.int64)
    n_edges = 0
    for node in by_report:
        family, report = family_of[node], place[node]
        if seen_at[family] != report:
            seen_at[family] = report
            edge_of[family] = n_edges
            edge_report[n_edges] = report
            n_edges += 1
        of_node[node] = edge_of[family]
    return Edges(of_node, edge_report[:n_edges])


@jit
def propagate(
    nodes: Nodes,
    n_nodes: int,
    is_new: np.ndarray,
    edges: Edges,
    n_reports: int,
    log_weight: FloatArray,
    max_iterations: int,
    probability_out: FloatArray,
    edge_out: FloatArray,
) -> int:
    """Write each sequence's probability and each edge's; leave the edges' prices in the nodes.

    A new family may also be none of its sequences, with weight 1. Starts from the prices that
    the nodes hold. Returns the number of iterations.
    """
    n_edges = edges.report.shape[0]
    log_message = np.zeros(n_edges)
    for node in range(n_nodes):
        if edges.of_node[node] >= 0:
            log_message[edges.of_node[node]] = -nodes.price[node]
    odds, claims = np.empty(n_edges), np.empty(n_reports)
    n_done = 0
    for _ in range(max_iterations):
        n_done += 1
        _sequence_probabilities(
            nodes, n_nodes, is_new, edges, log_weight, log_message, probability_out, edge_out
        )
        claims[:] = 0.0
        for edge in range(n_edges):
            share = min(edge_out[edge], 1.0 - 1e-9)
            odds[edge] = share / (1.0 - share) * math.exp(-log_message[edge])
            claims[edges.report[edge]] += odds[edge]
        change = 0.0
        for edge in range(n_edges):
            others = max(claims[edges.report[edge]] - odds[edge], 0.0)
            # A little damping: loops of close tracks oscillate without it.
            value = 0.3 * log_message[edge] - 0.7 * math.log(1.0 + others)
            change = max(change, abs(value - log_message[edge]))
            log_message[edge] = value
        if change < 1e-3:
            break
    for node in range(n_nodes):
        edge = edges.of_node[node]
        nodes.price[node] = -log_message[edge] if edge >= 0 else 0.0
    return n_done


@jit
def _sequence_probabilities(
    nodes: Nodes,
    n_nodes: int,
    is_new: np.ndarray,
    edges: Edges,
    log_weight: FloatArray,
    log_message: FloatArray,
    probability_out: FloatArray,
    edge_out: FloatArray,
) -> None:
    """Write the probabilities that the messages give each sequence and each edge."""
    n_families = is_new.shape[0]
    largest, norm = np.empty(n_families), np.empty(n_families)
    along = np.empty(n_nodes)
    for family in range(n_families):
        largest[family] = 0.0 if is_new[family] else -math.inf
    for node in range(n_nodes):
        above = nodes.parent[node]
        value = along[above] if above >= 0 else 0.0
        if edges.of_node[node] >= 0:
            value += log_message[edges.of_node[node]]
        along[node] = value
        family = nodes.family[node]
        largest[family] = max(largest[family], log_weight[node] + value)
    for family in range(n_families):
        norm[family] = math.exp(-largest[family]) if is_new[family] else 0.0
    for node in range(n_nodes):
        family = nodes.family[node]
        probability_out[node] = math.exp(log_weight[node] + along[node] - largest[family])
        norm[family] += probability_out[node]
    for node in range(n_nodes):
        probability_out[node] /= norm[nodes.family[node]]
    sum_edges(nodes, n_nodes, edges, probability_out, edge_out)


@jit
def sum_edges(
    nodes: Nodes, n_nodes: int, edges: Edges, probability: FloatArray, edge_out: FloatArray
) -> None:
    """Write the probability of each edge: that of all sequences with its family and report."""
    along = probability[:n_nodes].copy()
    edge_out[:] = 0.0
    for node in range(n_nodes - 1, -1, -1):
        if edges.of_node[node] >= 0:
            edge_out[edges.of_node[node]] += along[node]
        if nodes.parent[node] >= 0:
            along[nodes.parent[node]] += along[node]


@jit
def average_states(
    nodes: Nodes,
    n_nodes: int,
    n_families: int,
    weight: FloatArray,
    time: float,
    motion: MotionRule,
    existence_out: FloatArray,
    mean_out: FloatArray,
    covariance_out: FloatArray,
    general: State | None,
) -> None:
    """Write each family's probability to live and the mean and covariance of its state.

    The moments of the mixture of its sequences, each predicted to ``time``, by their weights.
    Without any weight the state is NaN.
    """
    size = nodes.mean.shape[2]
    existence_out[:] = 0.0
    mean_out[:] = 0.0
    covariance_out[:] = 0.0
    largest, kept = np.zeros(n_families), np.zeros(n_families)
    for node in range(n_nodes):
        if nodes.is_line[node] == 0:
            family = nodes.family[node]
            existence_out[family] += weight[node]
            largest[family] = max(largest[family], weight[node])
    moved, predicted = np.empty(size), np.empty((size, size))
    for node in range(n_nodes):
        family = nodes.family[node]
        # Sequences of less than a ten-thousandth of the best cannot be seen in the average.
        share = weight[node] if weight[node] > 1e-4 * largest[family] else 0.0
        if share > 0.0 and nodes.is_line[node] == 0:
            move_state(nodes, node, time, motion, general, moved, predicted)
            # Moments about the average so far, which moves: West, 1979.
            before = kept[family]
            kept[family] += share
            pull = share / kept[family]
            for row in range(size):
                moved[row] -= mean_out[family, row]
            for row in range(size):
                mean_out[family, row] += pull * moved[row]
                for column in range(size):
                    covariance_out[family, row, column] += share * predicted[
                        row, column
                    ] + pull * before * (moved[row] * moved[column])
    for family in range(n_families):
        if existence_out[family] <= 0.0:
            mean_out[family, :] = math.nan
            covariance_out[family, :, :] = math.nan
        else:
            for row in range(size):
                for column in range(size):
                    covariance_out[family, row, column] /= kept[family]


@jit
def move_states(
    nodes: Nodes,
    chosen: IntArray,
    time: FloatArray,
    motion: MotionRule,
    mean_out: FloatArray,
    covariance_out: FloatArray,
    general: State | None,
) -> None:
    """Write the state of each chosen node at its time, averaged over modes."""
    for row in range(chosen.shape[0]):
        node = chosen[row]
        if general is not None and nodes.is_line[node] == 1:
            mean_out[row] = math.nan
            covariance_out[row] = math.nan
        else:
            move_state(nodes, node, time[row], motion, general, mean_out[row], covariance_out[row])
