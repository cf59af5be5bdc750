"""Growing a forest of sequences by one scan. Nothing here checks or raises."""

import math
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.filters._kernels import (
    invert_innovation,
    predict,
    squared_distance,
    update,
)
from trackweave.jit import jit
from trackweave.models._kernels import covered_share
from trackweave.models.coverage import Coverage


class Nodes(NamedTuple):
    """Sequences that share prefixes; a parent always stands before its children.

    ``report`` is the last report's slot in the window, -1 where a track from before the window
    starts. ``chosen`` is 1 for the last hypothesis's sequences. ``cost`` is what the sequence
    costs up to its last report and ``tail`` what the scans since then add while the object lives
    [nats]. ``misses`` counts the chances to be seen since the last report, where all sensors of
    one instant give one chance, of which ``counted`` is the share already counted at this
    instant; ``chances`` counts those up to and with the last report, from the object's first.
    ``price`` is what holding the last report against others is worth [nats], as far as they were
    known. ``mean`` and ``covariance`` are the state at ``time``, the last report's.
    """

    parent: IntArray
    report: IntArray
    family: IntArray
    hits: IntArray
    chosen: IntArray
    cost: FloatArray
    tail: FloatArray
    misses: FloatArray
    counted: FloatArray
    chances: FloatArray
    price: FloatArray
    time: FloatArray
    mean: FloatArray
    covariance: FloatArray


class ScanInput(NamedTuple):
    """A scan as the kernels read it; reports are sorted along the first axis.

    ``is_silence_telling`` says whether the scan tells anything of objects that it does not report.
    """

    time: float
    new_instant: bool
    is_silence_telling: bool
    position: FloatArray
    sigma: FloatArray
    slot: IntArray
    detection_probability: float
    log_clutter: float
    survival_cost: float
    coverage: Coverage


class WindowRule(NamedTuple):
    """What it costs to extend a sequence; see ``association.window_rule``."""

    process_noise: float
    velocity_variance: float
    max_speed: float
    gate: float
    end_cost: float
    max_misses: float
    max_unseen: float


class Misses(NamedTuple):
    """What each sequence becomes if the scan has no report of it."""

    tail: FloatArray
    misses: FloatArray
    counted: FloatArray


class Candidates(NamedTuple):
    """Children that a scan offers: parent node, index in the scan, cost."""

    node: IntArray
    report: IntArray
    cost: FloatArray


@jit
def propose(
    nodes: Nodes,
    n_nodes: int,
    scan: ScanInput,
    rule: WindowRule,
    candidates: Candidates,
    missed: Misses,
) -> int:
    """Write every gated child to ``candidates`` and what a miss makes of each to ``missed``.

    A node with an infinite tail does not grow. Returns how many candidates there are; more than
    fit are counted but not written, so that the caller can make room and call again.
    """
    dim = scan.position.shape[1]
    n_reports = scan.position.shape[0]
    mean = np.empty(2 * dim)
    covariance = np.empty((2 * dim, 2 * dim))
    inverse = np.empty((dim, dim))
    largest_sigma = np.zeros(dim)
    for index in range(n_reports):
        for axis in range(dim):
            largest_sigma[axis] = max(largest_sigma[axis], scan.sigma[index, axis])
    log_volume = dim * math.log(2.0 * math.pi)
    count = 0
    for node in range(n_nodes):
        missed.tail[node] = nodes.tail[node]
        missed.misses[node] = nodes.misses[node]
        missed.counted[node] = 0.0 if scan.new_instant else nodes.counted[node]
        if nodes.tail[node] == math.inf:
            continue
        interval = scan.time - nodes.time[node]
        predict(
            nodes.mean[node],
            nodes.covariance[node],
            interval,
            rule.process_noise,
            mean,
            covariance,
        )
        seen = scan.detection_probability * covered_share(mean, covariance, scan.coverage)
        if seen > 0.0:
            reach = math.sqrt(rule.gate * (covariance[0, 0] + largest_sigma[0] ** 2))
            low = np.searchsorted(scan.position[:, 0], mean[0] - reach)
            previous = np.full(dim, np.nan)
            for index in range(low, n_reports):
                if scan.position[index, 0] > mean[0] + reach:
                    break
                side = scan.position[index, 1] - mean[1]
                if side * side > rule.gate * (covariance[1, 1] + largest_sigma[1] ** 2):
                    continue
                if not _is_reachable(nodes, node, scan, index, interval, rule):
                    continue
                same = True
                for axis in range(dim):
                    same = same and previous[axis] == scan.sigma[index, axis]
                if not same:
                    log_determinant = invert_innovation(covariance, scan.sigma[index], inverse)
                    for axis in range(dim):
                        previous[axis] = scan.sigma[index, axis]
                distance = squared_distance(scan.position[index], mean, inverse)
                if not distance <= rule.gate:
                    continue
                if count < candidates.node.shape[0]:
                    candidates.node[count] = node
                    candidates.report[count] = index
                    candidates.cost[count] = (
                        nodes.cost[node]
                        + nodes.tail[node]
                        + scan.survival_cost
                        + 0.5 * (distance + log_determinant + log_volume)
                        + scan.log_clutter
                        - math.log(seen)
                    )
                count += 1
        missed.tail[node] += scan.survival_cost
        if scan.is_silence_telling:
            missed.tail[node] -= math.log(1.0 - seen)
            chance = max(0.0, seen / scan.detection_probability - missed.counted[node])
            missed.counted[node] += chance
            missed.misses[node] += chance
        if missed.misses[node] >= rule.max_misses or interval > rule.max_unseen:
            missed.tail[node] = math.inf
    return count


@jit
def _is_reachable(
    nodes: Nodes, node: int, scan: ScanInput, index: int, interval: float, rule: WindowRule
) -> bool:
    """Tell whether an object no faster than allowed can have come from its last place."""
    dim = scan.position.shape[1]
    distance, variance = 0.0, 0.0
    for axis in range(dim):
        distance += (scan.position[index, axis] - nodes.mean[node, axis]) ** 2
        variance += nodes.covariance[node, axis, axis] + scan.sigma[index, axis] ** 2
    return math.sqrt(distance) <= rule.max_speed * interval + 3.0 * math.sqrt(variance)


@jit
def accumulate_prices(nodes: Nodes, n_nodes: int, priced_out: FloatArray) -> None:
    """Write the sum of the prices along each sequence."""
    for node in range(n_nodes):
        above = nodes.parent[node]
        priced_out[node] = nodes.price[node] + (priced_out[above] if above >= 0 else 0.0)


@jit
def rank_bounds(
    family: IntArray, rank: FloatArray, margin: FloatArray, keep: IntArray, ceiling: FloatArray
) -> FloatArray:
    """Return for each family the worst rank that it keeps.

    That is its best plus its margin, or its k-th best rank if that is less, and never more than
    its ceiling.
    """
    n_families = margin.shape[0]
    start = np.zeros(n_families + 1, dtype=np.int64)
    for entry in range(family.shape[0]):
        start[family[entry] + 1] += 1
    for index in range(n_families):
        start[index + 1] += start[index]
    fill = start[:-1].copy()
    grouped = np.empty(rank.shape[0])
    for entry in range(family.shape[0]):
        grouped[fill[family[entry]]] = rank[entry]
        fill[family[entry]] += 1
    bound = np.empty(n_families)
    for index in range(n_families):
        own = grouped[start[index] : start[index + 1]]
        best = math.inf
        for value in own:
            best = min(best, value)
        bound[index] = min(best + margin[index], ceiling[index])
        if own.shape[0] > keep[index]:
            bound[index] = min(bound[index], np.partition(own, keep[index] - 1)[keep[index] - 1])
    return bound


@jit
def append_children(
    nodes: Nodes,
    n_nodes: int,
    candidates: Candidates,
    chosen: IntArray,
    scan: ScanInput,
    rule: WindowRule,
) -> None:
    """Write the chosen candidates behind the existing nodes, with their updated states."""
    dim = scan.position.shape[1]
    mean = np.empty(2 * dim)
    covariance = np.empty((2 * dim, 2 * dim))
    inverse = np.empty((dim, dim))
    child = n_nodes
    for entry in chosen:
        above, index = candidates.node[entry], candidates.report[entry]
        interval = scan.time - nodes.time[above]
        predict(
            nodes.mean[above],
            nodes.covariance[above],
            interval,
            rule.process_noise,
            mean,
            covariance,
        )
        invert_innovation(covariance, scan.sigma[index], inverse)
        update(
            mean,
            covariance,
            scan.position[index],
            inverse,
            nodes.mean[child],
            nodes.covariance[child],
        )
        nodes.parent[child] = above
        nodes.report[child] = scan.slot[index]
        nodes.family[child] = nodes.family[above]
        nodes.hits[child] = nodes.hits[above] + 1
        nodes.chosen[child] = 0
        nodes.cost[child] = candidates.cost[entry]
        nodes.tail[child] = 0.0
        nodes.misses[child] = 0.0
        nodes.counted[child] = 1.0
        nodes.chances[child] = nodes.chances[above]
        if interval > 0.0 or nodes.report[above] < 0:
            # Misses of this very instant are no chance of their own: it is a hit now.
            nodes.chances[child] += nodes.misses[above] - nodes.counted[above] + 1.0
        nodes.price[child] = 0.0
        nodes.time[child] = scan.time
        child += 1


@jit
def append_roots(
    nodes: Nodes,
    n_nodes: int,
    scan: ScanInput,
    rule: WindowRule,
    first_family: int,
    log_density: FloatArray,
) -> None:
    """Write one new object per report; ``log_density`` is of undetected objects at its place."""
    dim = scan.position.shape[1]
    for index in range(scan.position.shape[0]):
        node = n_nodes + index
        nodes.parent[node] = -1
        nodes.report[node] = scan.slot[index]
        nodes.family[node] = first_family + index
        nodes.hits[node] = 1
        nodes.chosen[node] = 0
        nodes.cost[node] = (
            scan.log_clutter - math.log(scan.detection_probability) - log_density[index]
        )
        nodes.tail[node] = 0.0
        nodes.misses[node] = 0.0
        nodes.counted[node] = 1.0
        nodes.chances[node] = 1.0
        nodes.price[node] = 0.0
        nodes.time[node] = scan.time
        nodes.mean[node, :] = 0.0
        nodes.covariance[node, :, :] = 0.0
        for axis in range(dim):
            nodes.mean[node, axis] = scan.position[index, axis]
            nodes.covariance[node, axis, axis] = scan.sigma[index, axis] ** 2
            nodes.covariance[node, dim + axis, dim + axis] = rule.velocity_variance


@jit
def keep_ancestors(parent: IntArray, n_nodes: int, keep: np.ndarray) -> None:
    """Mark every ancestor of a marked node."""
    for node in range(n_nodes - 1, -1, -1):
        if keep[node] and parent[node] >= 0:
            keep[parent[node]] = True


@jit
def raise_ancestors(parent: IntArray, value: FloatArray) -> None:
    """Give every ancestor at most the value of its descendants, in place."""
    for node in range(parent.shape[0] - 1, -1, -1):
        if parent[node] >= 0:
            value[parent[node]] = min(value[parent[node]], value[node])


@jit
def keep_below(nodes: Nodes, n_nodes: int, root: IntArray, n_fixed: int) -> np.ndarray:
    """Mark what goes on when the slots below ``n_fixed`` are fixed.

    Below a family's root, what takes only later reports; of a family without a root, everything
    if its first report is later.
    """
    keep = np.zeros(n_nodes, dtype=np.bool_)
    for node in range(n_nodes):
        own = root[nodes.family[node]]
        above = nodes.parent[node]
        if own >= 0:
            keep[node] = node == own or (
                above >= 0 and keep[above] and nodes.report[node] >= n_fixed
            )
        else:
            keep[node] = keep[above] if above >= 0 else nodes.report[node] >= n_fixed
    return keep
