"""Objects that moved as no model foresees, known by their identity. Nothing here checks or raises.

A report under a track's own identity that lies beyond its gate is its object's with a small
probability, anywhere in the disc about where it was that reaches as far as the report, or as its
speed lets it come. Its state begins anew there.
"""

import math

from trackweave._loops import overwrite, overwrite_rows
from trackweave.association._crowding import Crowding, admit
from trackweave.association._missing import report_cost
from trackweave.association._nodes import Candidates, Nodes, ScanInput, State
from trackweave.association._rhythm import rhythm_cost
from trackweave.association._scoring import is_too_soon, take_rate
from trackweave.jit import jit
from trackweave.models.motion import MotionRule

LOG_LEAP = math.log(0.01)
"""How probable it is that an object's way between two reports is none of its model's."""
LOG_BEYOND_REACH = math.log(1e-4)
"""… and takes it farther than its greatest speed does: sooner two have swapped identities."""


@jit
def is_named(nodes: Nodes, node: int, scan: ScanInput) -> bool:
    """Tell whether some report is under the identity that a node has."""
    own = nodes.identity[node]
    if own >= 0:
        for claimed in scan.identity:
            if claimed == own:
                return True
    return False


@jit
def propose_leaps(
    nodes: Nodes, node: int, scan: ScanInput, motion: MotionRule, chance: float,
    candidates: Candidates, begin: int, count: int, crowding: Crowding,
) -> int:  # fmt: skip
    """Write the node's reports by identity that no gate let in; return how many there are now."""
    first = count
    for index in range(scan.identity.shape[0]):
        if scan.identity[index] != nodes.identity[node]:
            continue
        is_in = count > candidates.node.shape[0]
        for entry in range(begin, min(first, candidates.node.shape[0])):
            is_in = is_in or candidates.report[entry] == index
        if is_in or count - begin >= crowding.children[node]:
            continue
        if scan.separation > 0.0 and is_too_soon(
            nodes, node, scan.sensor, scan.moment[index], scan.separation
        ):
            continue
        square = 0.0
        for axis in range(motion.dim):
            square += (scan.position[index, axis] - nodes.mean[node, 0, axis]) ** 2
        distance = math.sqrt(square)
        reach = motion.max_speed * abs(scan.moment[index] - nodes.time[node])
        unit = math.pi if motion.dim == 2 else 4.0 / 3.0 * math.pi
        log_likelihood = LOG_LEAP if distance <= reach else LOG_BEYOND_REACH
        log_likelihood -= math.log(unit) + motion.dim * math.log(max(distance, reach, 1e-6))
        cost = report_cost(
            nodes.cost[node] + nodes.tail[node] + scan.survival_cost,
            log_likelihood + scan.log_begin[index],
            scan.log_clutter, chance, scan.evidence[index] + scan.identity_gain,
        )  # fmt: skip
        if scan.is_heard:
            cost += rhythm_cost(nodes.rhythm, node, scan, index)
        count = admit(candidates, begin, count, crowding, node, index, cost)
        if count <= candidates.node.shape[0]:
            candidates.leap[count - 1] = True
    return count


@jit
def begin_state(
    nodes: Nodes, node: int, scan: ScanInput, index: int, motion: MotionRule,
    general: State | None,
) -> None:  # fmt: skip
    """Write the state of an object of which nothing is known but a report that says where."""
    nodes.mean[node] = 0.0
    nodes.covariance[node] = 0.0
    mean, covariance = nodes.mean[node, 0], nodes.covariance[node, 0]
    for component in range(motion.prior.shape[0]):
        covariance[component, component] = motion.prior[component]
    for row in range(motion.dim):
        mean[row] = scan.position[index, row]
        for column in range(motion.dim):
            covariance[row, column] = scan.position_covariance[index, row, column]
    if general is not None:
        take_rate(scan, index, mean, covariance, motion.dim)
    spread_over_modes(nodes, node, motion)


@jit
def spread_over_modes(nodes: Nodes, node: int, motion: MotionRule) -> None:
    """Give every mode the first one's state."""
    for mode in range(motion.share.shape[0]):
        nodes.weight[node, mode] = motion.share[mode]
        if mode > 0:
            overwrite(nodes.mean[node, mode], nodes.mean[node, 0])
            overwrite_rows(nodes.covariance[node, mode], nodes.covariance[node, 0])
