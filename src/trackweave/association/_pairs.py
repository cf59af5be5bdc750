"""Growth in two passes, for models that no kernel knows. Nothing here checks or raises.

The first pass finds which sequences may have which reports, by position; then one call of a model
foresees all of these pairs at once; the second pass makes candidates of them, as ``_growth`` does.
"""

import math

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._crowding import Crowding, admit, nearest_of
from trackweave.association._gating import (
    is_any_reachable,
    is_beside,
    is_reachable,
    most_moved,
    widest,
    within_reach,
)
from trackweave.association._growth import _propose_crossings
from trackweave.association._missing import begin_misses, end_misses, look_at, report_cost
from trackweave.association._nodes import Candidates, Misses, Nodes, ScanInput, State, WindowRule
from trackweave.association._rhythm import rhythm_cost
from trackweave.association._scoring import (
    compare,
    expect,
    is_too_soon,
    naming_cost,
    room_for_expectation,
    share_covered,
    take_in,
)
from trackweave.jit import jit
from trackweave.models.motion import MotionRule

NO_TAILS = 1.0
"""How many times as wide noise may be: models from outside know nothing of heavy tails."""


@jit
def near_nodes(
    nodes: Nodes, n_nodes: int, scan: ScanInput, motion: MotionRule, crowding: Crowding
) -> IntArray:
    """Return the nodes that grow and of which a scan tells something, lines left out."""
    near = np.empty(n_nodes, dtype=np.int64)
    broad = widest(scan, motion.dim)
    is_narrow = (
        scan.is_located and scan.coverage.everywhere and not scan.is_silence_telling
        and not scan.has_moments and scan.measurement.shape[0] <= crowding.looks
    )  # fmt: skip
    count = 0
    for node in range(n_nodes):
        if nodes.tail[node] == math.inf or nodes.is_line[node] == 1:
            continue
        if is_narrow and not is_any_reachable(
            nodes.mean, nodes.covariance, nodes.weight, node, scan.position,
            scan.position_covariance, broad, motion.max_speed * abs(scan.time - nodes.time[node]),
            NO_TAILS,
        ):  # fmt: skip
            continue
        near[count] = node
        count += 1
    return near[:count]


@jit
def gate_pairs(
    nodes: Nodes,
    near: IntArray,
    ahead: State,
    scan: ScanInput,
    motion: MotionRule,
    crowding: Crowding,
    seen_out: FloatArray,
    row_out: IntArray,
    report_out: IntArray,
) -> int:
    """Write the pairs of a near node's row and a report that it may have; return how many.

    ``ahead`` are the near nodes' states when the scan looks. More than fit are counted, but not
    written. ``seen_out`` is how probably the scan reports each of them.
    """
    n_reports = scan.measurement.shape[0]
    broad, slack = widest(scan, motion.dim), most_moved(scan, motion.max_speed)
    crowding.left_out[:], crowding.dearest[0] = 0, -1
    stride = 1
    if not scan.is_located:
        stride = max(1, -(-n_reports // max(crowding.looks, crowding.looks_anywhere)))
    count = 0
    for row in range(near.shape[0]):
        node = near[row]
        mean, covariance = ahead.mean[row], ahead.covariance[row]
        seen_out[row] = scan.detection_probability
        if not scan.coverage.everywhere:
            seen_out[row] *= share_covered(
                State(mean, covariance, ahead.weight[row]), scan.coverage
            )
        low, high = 0, n_reports
        if scan.is_located:
            low, high = within_reach(scan.position, scan.gate, mean, covariance, broad[0], slack)
            if high - low > crowding.looks:
                reached = high - low
                low, high = nearest_of(
                    scan.position, low, high, crowding.looks, scan.gate, mean, covariance,
                    broad[1], slack,
                )  # fmt: skip
                crowding.left_out[0] += reached - (high - low)
        if stride > 1:
            crowding.left_out[0] += n_reports - n_reports // stride
        for index in range(low + node % stride if seen_out[row] > 0.0 else high, high, stride):
            if scan.is_located and not (
                is_beside(scan.position[index, 1], scan.gate, mean, covariance, broad[1], slack)
                and is_reachable(
                    nodes.mean, nodes.covariance, nodes.weight, node, scan.position,
                    scan.position_covariance, index,
                    motion.max_speed * abs(scan.moment[index] - nodes.time[node]), NO_TAILS,
                )
            ):  # fmt: skip
                continue
            if scan.separation > 0.0 and is_too_soon(
                nodes, node, scan.sensor, scan.moment[index], scan.separation
            ):
                continue
            if count < row_out.shape[0]:
                row_out[count] = row
                report_out[count] = index
            count += 1
    return count


@jit
def compare_pairs(
    state: State,
    index: IntArray,
    scan: ScanInput,
    motion: MotionRule,
    distance_out: FloatArray,
    log_likelihood_out: FloatArray,
) -> None:
    """Write how well reports of a kind of ours fit a state each, a row of ``state`` for each."""
    expected = room_for_expectation(motion, scan.measurement.shape[1])
    for row in range(index.shape[0]):
        setting, own = scan.setting[index[row]], _row_of(state, row)
        expect(
            scan.kind, scan.noise[setting], scan.platform[setting], own,
            motion.dim, motion.unscented, expected,
        )  # fmt: skip
        distance_out[row], log_likelihood_out[row] = compare(
            scan.kind, scan.measurement, index[row], own.weight, expected.mean,
            expected.inverse, expected.log_determinant, expected.innovation,
        )  # fmt: skip


@jit
def take_in_pairs(
    state: State, index: IntArray, scan: ScanInput, motion: MotionRule, out: State
) -> None:
    """Write the states after a report of a kind of ours each."""
    expected = room_for_expectation(motion, scan.measurement.shape[1])
    for row in range(index.shape[0]):
        setting = scan.setting[index[row]]
        take_in(
            scan.kind, scan.measurement[index[row]], scan.noise[setting], scan.platform[setting],
            _row_of(state, row), motion.dim, motion.unscented, expected,
            out.mean[row], out.covariance[row], out.weight[row],
        )  # fmt: skip


@jit
def _row_of(state: State, row: int) -> State:
    return State(state.mean[row], state.covariance[row], state.weight[row])


@jit
def admit_pairs(
    nodes: Nodes,
    n_nodes: int,
    pairs: tuple[IntArray, IntArray, FloatArray, FloatArray],
    seen: FloatArray,
    scan: ScanInput,
    rule: WindowRule,
    candidates: Candidates,
    missed: Misses,
    crowding: Crowding,
    general: State,
) -> int:
    """Write every gated child, and what a miss makes of each node, as ``_growth.propose`` does.

    ``pairs`` are node, ascending, report, squared distance and log likelihood; ``seen`` is how
    probably the scan reports each node.
    """
    own, report, distance, log_likelihood = pairs
    begin_misses(nodes, n_nodes, scan, missed)
    missed.seen[:n_nodes] = seen[:n_nodes]
    count, at = 0, 0
    for node in range(n_nodes):
        begin = count
        if nodes.tail[node] == math.inf:
            continue
        if nodes.is_line[node] == 1:
            count = _propose_crossings(
                nodes, node, scan, rule, candidates, count, crowding, general
            )
        chance = look_at(
            missed.hidden[node], missed.unseen, node, seen[node], scan.detection_probability,
            scan.fading, scan.clearing,
        )  # fmt: skip
        while at < own.shape[0] and own[at] == node:
            if distance[at] <= scan.gate:
                index = report[at]
                cost = report_cost(
                    nodes.cost[node] + nodes.tail[node] + scan.survival_cost, log_likelihood[at],
                    scan.log_clutter, chance, scan.evidence[index],
                ) + naming_cost(nodes, node, scan, index)  # fmt: skip
                if scan.is_heard:
                    cost += rhythm_cost(nodes.rhythm, node, scan, index)
                count = admit(candidates, begin, count, crowding, node, index, cost)
            at += 1
    end_misses(nodes, n_nodes, scan, rule, missed)
    return count
