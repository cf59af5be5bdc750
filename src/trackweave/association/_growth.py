"""Growing a forest of sequences by one scan. Nothing here checks or raises."""

import math

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._lines import BEARING, begin_line, cross_line
from trackweave.association._nodes import (
    Candidates,
    Misses,
    Nodes,
    ScanInput,
    State,
    WindowRule,
)
from trackweave.association._scoring import (
    compare,
    expect,
    identity_cost,
    is_reachable,
    is_too_soon,
    room_for_expectation,
    room_for_state,
    share_covered,
    take_in,
)
from trackweave.domain.measurements import MeasurementKind
from trackweave.filters._measuring import correct, innovation, invert, measure
from trackweave.filters._states import advance
from trackweave.jit import jit

HOPELESS = 50.0
"""What a report costs as a new object that it cannot begin [nats]."""
RANGE_RATE = int(MeasurementKind.RANGE_RATE)


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
    motion = rule.motion
    n_reports, n_components = scan.measurement.shape
    state, moved = room_for_state(motion), room_for_state(motion)
    expected = room_for_expectation(motion, n_components)
    widest = _widest(scan, motion.dim, motion.max_speed)
    count = 0
    for node in range(n_nodes):
        missed.tail[node] = nodes.tail[node]
        missed.misses[node] = nodes.misses[node]
        missed.counted[node] = 0.0 if scan.new_instant else nodes.counted[node]
        if nodes.tail[node] == math.inf:
            continue
        if nodes.is_line[node] == 1:
            seen = scan.detection_probability
            count = _propose_crossings(nodes, node, scan, rule, candidates, count, moved)
        else:
            advance(
                nodes.mean[node], nodes.covariance[node], nodes.weight[node],
                scan.reference - nodes.time[node], motion,
                state.mean, state.covariance, state.weight,
            )  # fmt: skip
            seen = scan.detection_probability * share_covered(state, scan.coverage)
            low, high = 0, n_reports
            if scan.is_located:
                low, high = _within_reach(scan, state, widest)
            known = -1
            for index in range(low if seen > 0.0 else high, high):
                if scan.is_located and not (
                    _is_beside(scan, index, state, widest)
                    and is_reachable(nodes, node, scan, index, motion)
                ):
                    continue
                if scan.separation > 0.0 and is_too_soon(nodes, node, scan, index):
                    continue
                if scan.has_moments:
                    advance(
                        nodes.mean[node], nodes.covariance[node], nodes.weight[node],
                        scan.moment[index] - nodes.time[node], motion,
                        moved.mean, moved.covariance, moved.weight,
                    )  # fmt: skip
                    expect(scan, scan.setting[index], moved, motion, expected)
                elif scan.setting[index] != known:
                    known = scan.setting[index]
                    expect(scan, known, state, motion, expected)
                distance, log_likelihood = compare(
                    scan, index, moved if scan.has_moments else state, expected
                )
                if not distance <= scan.gate:
                    continue
                if count < candidates.node.shape[0]:
                    candidates.node[count] = node
                    candidates.report[count] = index
                    candidates.cost[count] = (
                        nodes.cost[node]
                        + nodes.tail[node]
                        + scan.survival_cost
                        - log_likelihood
                        + scan.log_clutter
                        - math.log(seen)
                        - scan.evidence[index]
                        + identity_cost(nodes, node, scan, index)
                    )
                count += 1
        _miss(nodes, node, scan, rule, seen, missed)
    return count


@jit
def _miss(
    nodes: Nodes, node: int, scan: ScanInput, rule: WindowRule, seen: float, missed: Misses
) -> None:
    """Write what a sequence becomes if the scan has no report of it."""
    missed.tail[node] += scan.survival_cost
    if scan.is_silence_telling:
        missed.tail[node] -= math.log(1.0 - seen)
        chance = max(0.0, seen / scan.detection_probability - missed.counted[node])
        missed.counted[node] += chance
        missed.misses[node] += chance
    if missed.misses[node] >= rule.max_misses or scan.time - nodes.time[node] > rule.max_unseen:
        missed.tail[node] = math.inf


@jit
def _widest(scan: ScanInput, dim: int, max_speed: float) -> FloatArray:
    """Return the largest variance of a report's place along each axis, and last the slack [m]."""
    widest = np.zeros(dim + 1)
    for index in range(scan.measurement.shape[0]):
        if scan.is_located:
            for axis in range(dim):
                widest[axis] = max(widest[axis], scan.position_covariance[index, axis, axis])
        widest[dim] = max(widest[dim], max_speed * abs(scan.moment[index] - scan.reference))
    return widest


@jit
def _within_reach(scan: ScanInput, state: State, widest: FloatArray) -> tuple[int, int]:
    """Return the span of reports that any mode may reach along the first axis."""
    low, high = math.inf, -math.inf
    for mode in range(state.weight.shape[0]):
        reach = (
            math.sqrt(scan.gate * (state.covariance[mode, 0, 0] + widest[0]))
            + widest[widest.shape[0] - 1]
        )
        low = min(low, state.mean[mode, 0] - reach)
        high = max(high, state.mean[mode, 0] + reach)
    first = np.searchsorted(scan.position[:, 0], low)
    last = np.searchsorted(scan.position[:, 0], high, side="right")
    return int(first), int(last)


@jit
def _is_beside(scan: ScanInput, index: int, state: State, widest: FloatArray) -> bool:
    """Tell whether any mode may reach a report along the second axis."""
    for mode in range(state.weight.shape[0]):
        side = abs(scan.position[index, 1] - state.mean[mode, 1]) - widest[widest.shape[0] - 1]
        if side <= 0.0 or side * side <= scan.gate * (state.covariance[mode, 1, 1] + widest[1]):
            return True
    return False


@jit
def _propose_crossings(
    nodes: Nodes, node: int, scan: ScanInput, rule: WindowRule, candidates: Candidates,
    count: int, moved: State,
) -> int:  # fmt: skip
    """Write the reports that say where an object on a line is; return how many there are now."""
    if abs(scan.time - nodes.time[node]) > rule.crossing_time:
        return count
    for index in range(scan.measurement.shape[0]):
        evidence = cross_line(nodes, node, scan, index, rule, moved.mean[0], moved.covariance[0])
        if evidence == -math.inf:
            continue
        if count < candidates.node.shape[0]:
            candidates.node[count] = node
            candidates.report[count] = index
            candidates.cost[count] = (
                nodes.covariance[node, 0, 0, 0]
                + nodes.tail[node]
                + scan.survival_cost
                + scan.log_clutter
                - math.log(scan.detection_probability)
                - evidence
                - scan.evidence[index]
                + identity_cost(nodes, node, scan, index)
            )
        count += 1
    return count


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
    motion = rule.motion
    state = room_for_state(motion)
    expected = room_for_expectation(motion, scan.measurement.shape[1])
    child = n_nodes
    for entry in chosen:
        above, index = candidates.node[entry], candidates.report[entry]
        interval = scan.moment[index] - nodes.time[above]
        if nodes.is_line[above] == 1:
            cross_line(
                nodes, above, scan, index, rule, nodes.mean[child, 0], nodes.covariance[child, 0]
            )
            _spread_over_modes(nodes, child, motion.share)
        else:
            advance(
                nodes.mean[above], nodes.covariance[above], nodes.weight[above], interval,
                motion, state.mean, state.covariance, state.weight,
            )  # fmt: skip
            take_in(
                scan, index, state, motion, expected,
                nodes.mean[child], nodes.covariance[child], nodes.weight[child],
            )  # fmt: skip
        _enter(nodes, child, scan, index)
        nodes.parent[child] = above
        nodes.family[child] = nodes.family[above]
        nodes.hits[child] = nodes.hits[above] + 1
        nodes.cost[child] = candidates.cost[entry]
        nodes.chances[child] = nodes.chances[above]
        if interval != 0.0 or nodes.report[above] < 0:
            # Misses of this very instant are no chance of their own: it is a hit now.
            nodes.chances[child] += nodes.misses[above] - nodes.counted[above] + 1.0
        _remember_identity(nodes, child, above, scan.identity[index])
        child += 1


@jit
def _enter(nodes: Nodes, node: int, scan: ScanInput, index: int) -> None:
    """Write what every sequence is that has just taken a report."""
    nodes.report[node] = scan.slot[index]
    nodes.chosen[node] = 0
    nodes.sensor[node] = scan.sensor
    nodes.is_line[node] = 0
    nodes.tail[node] = 0.0
    nodes.misses[node] = 0.0
    nodes.counted[node] = 1.0
    nodes.price[node] = 0.0
    nodes.time[node] = scan.moment[index]


@jit
def _remember_identity(nodes: Nodes, child: int, above: int, claimed: int) -> None:
    """Write whom a sequence is of after a report that is of somebody, or of nobody known."""
    nodes.identity[child] = nodes.identity[above]
    nodes.former[child] = nodes.former[above]
    if claimed >= 0 and claimed != nodes.identity[above]:
        nodes.former[child] = nodes.identity[above]
        nodes.identity[child] = claimed


@jit
def _spread_over_modes(nodes: Nodes, node: int, share: FloatArray) -> None:
    """Give every mode the first one's state."""
    for mode in range(share.shape[0]):
        nodes.weight[node, mode] = share[mode]
        if mode > 0:
            nodes.mean[node, mode] = nodes.mean[node, 0]
            nodes.covariance[node, mode] = nodes.covariance[node, 0]


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
    motion = rule.motion
    dim = motion.dim
    for index in range(scan.measurement.shape[0]):
        node = n_nodes + index
        _enter(nodes, node, scan, index)
        nodes.parent[node] = -1
        nodes.family[node] = first_family + index
        nodes.hits[node] = 1
        nodes.chances[node] = 1.0
        nodes.identity[node] = scan.identity[index]
        nodes.former[node] = -1
        nodes.mean[node] = 0.0
        nodes.covariance[node] = 0.0
        nodes.weight[node] = motion.share
        if scan.is_located:
            nodes.cost[node] = (
                scan.log_clutter - math.log(scan.detection_probability) - log_density[index]
                - scan.log_begin[index] - scan.evidence[index]
            )  # fmt: skip
            mean, covariance = nodes.mean[node, 0], nodes.covariance[node, 0]
            for component in range(motion.prior.shape[0]):
                covariance[component, component] = motion.prior[component]
            for row in range(dim):
                mean[row] = scan.position[index, row]
                for column in range(dim):
                    covariance[row, column] = scan.position_covariance[index, row, column]
            _take_rate(scan, index, mean, covariance, dim)
            _spread_over_modes(nodes, node, motion.share)
        elif scan.kind == BEARING and dim == 2:
            begin_line(nodes, node, scan, index, log_density[index])
        else:
            nodes.cost[node] = HOPELESS
            nodes.tail[node] = math.inf


@jit
def _take_rate(
    scan: ScanInput, index: int, mean: FloatArray, covariance: FloatArray, dim: int
) -> None:
    """Let a report's range rate, its last number, tell of a new object's velocity, in place."""
    if scan.kind != 2 and scan.kind != 4:
        return
    size = mean.shape[0]
    setting, last = scan.setting[index], scan.measurement.shape[1] - 1
    predicted, off, cross = np.empty(1), np.empty(1), np.empty((size, 1))
    spread, inverse = np.empty((1, 1)), np.empty((1, 1))
    measure(
        RANGE_RATE, mean, covariance, scan.platform[setting], dim, False,
        predicted, spread, cross,
    )  # fmt: skip
    spread[0, 0] += scan.noise[setting, last, last]
    invert(spread, inverse)
    innovation(RANGE_RATE, scan.measurement[index, last:], predicted, off)
    correct(mean.copy(), covariance.copy(), off, inverse, cross, mean, covariance)
