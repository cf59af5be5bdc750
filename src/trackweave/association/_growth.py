"""Growing a forest of sequences by one scan. Nothing here checks or raises."""

import math

from trackweave._loops import overwrite
from trackweave.arrays import FloatArray, IntArray
from trackweave.association._bearing_tracks import BEARING, begin_line, cross_line
from trackweave.association._crowding import Crowding, admit, nearest_of
from trackweave.association._gating import (
    is_any_reachable,
    is_beside,
    is_reachable,
    most_moved,
    widest,
    within_reach,
)
from trackweave.association._leaps import (
    begin_state,
    is_named,
    propose_leaps,
    spread_over_modes,
)
from trackweave.association._levels import begin_level, take_level
from trackweave.association._missing import begin_misses, end_misses, look_at, report_cost
from trackweave.association._nodes import Candidates, Misses, Nodes, ScanInput, State, WindowRule
from trackweave.association._rhythm import begin_rhythm, hear, rhythm_cost
from trackweave.association._scoring import (
    LOG_TWO_PI,
    POSITION,
    expect,
    is_too_soon,
    naming_cost,
    room_for_expectation,
    room_for_state,
    share_covered,
    take_identity,
    take_rate,
)
from trackweave.association._tails import compare_either, compare_in_plane, take_in_either
from trackweave.filters._kernels import distance_of, invert_sum, predict, update
from trackweave.filters._states import advance, is_straight
from trackweave.filters._tails import share_after
from trackweave.jit import jit

HOPELESS = 50.0
"""What a report costs as a new object that it cannot begin [nats]."""


@jit
def propose(
    nodes: Nodes,
    n_nodes: int,
    scan: ScanInput,
    rule: WindowRule,
    candidates: Candidates,
    missed: Misses,
    crowding: Crowding,
    general: State | None,
) -> int:
    """Write every gated child to ``candidates`` and what a miss makes of each to ``missed``.

    Without room for states in ``general`` all go the short way of ``_nodes.is_plain``, and what
    the long one needs is not even compiled; so it is with the functions below.

    A node with an infinite tail does not grow. Returns how many candidates there are; more than
    fit are counted but not written, so that the caller can make room and call again.
    """
    motion = rule.motion
    n_reports, n_components = scan.measurement.shape
    state, expected = room_for_state(motion), room_for_expectation(motion, n_components)
    # What most scans are is done without handing over whole motions and expectations.
    straight = is_straight(motion)
    of_two = scan.kind == POSITION and n_components == 2
    plane = general is not None and of_two and not scan.has_moments
    broad, slack = widest(scan, motion.dim), most_moved(scan, motion.max_speed)
    mean, covariance, inverse = state.mean[0], state.covariance[0], expected.inverse[0]
    crowding.left_out[:], crowding.dearest[0] = 0, -1
    stride = 1
    if not scan.is_located:
        stride = max(1, -(-n_reports // max(crowding.looks, crowding.looks_anywhere)))
    # Where a scan tells nothing of whom it does not report, who is far from it needs no state.
    is_narrow = (
        scan.is_located and scan.coverage.everywhere and not scan.is_silence_telling
        and not scan.has_moments and n_reports <= crowding.looks
    )  # fmt: skip
    begin_misses(nodes, n_nodes, scan, missed)
    count = 0
    for node in range(n_nodes):
        begin = count
        if nodes.tail[node] == math.inf:
            continue
        seen = scan.detection_probability
        is_line = False
        if general is not None:
            is_line = nodes.is_line[node] == 1
            if is_line:
                count = _propose_crossings(
                    nodes, node, scan, rule, candidates, count, crowding, general
                )
        leaps = scan.is_located and not is_line and is_named(nodes, node, scan)
        is_far = is_narrow and not leaps and not is_any_reachable(
            nodes.mean, nodes.covariance, nodes.weight, node, scan.position,
            scan.position_covariance, broad, motion.max_speed * abs(scan.time - nodes.time[node]),
            scan.tail_scale,
        )  # fmt: skip
        if not is_line and not is_far:
            interval = scan.reference - nodes.time[node]
            if general is not None and not straight:
                advance(
                    nodes.mean[node], nodes.covariance[node], nodes.weight[node], interval,
                    motion, state.mean, state.covariance, state.weight,
                )  # fmt: skip
            else:
                # Noise is as large on the way back as on the way there.
                predict(
                    nodes.mean[node, 0], nodes.covariance[node, 0], interval,
                    math.copysign(motion.noise[0, 0], interval), mean, covariance,
                )  # fmt: skip
            if not scan.coverage.everywhere:
                seen *= share_covered(state, scan.coverage)
            missed.seen[node] = seen
            chance = look_at(
                missed.hidden[node], missed.unseen, node, seen, scan.detection_probability,
                scan.fading, scan.clearing,
            )  # fmt: skip
            low, high = 0, n_reports
            if scan.is_located:
                low, high = within_reach(
                    scan.position, scan.gate, state.mean, state.covariance, broad[0], slack
                )
                if high - low > crowding.looks:
                    reached = high - low
                    low, high = nearest_of(
                        scan.position, low, high, crowding.looks, scan.gate, state.mean,
                        state.covariance, broad[1], slack,
                    )  # fmt: skip
                    crowding.left_out[0] += reached - (high - low)
            known = -1
            if stride > 1:
                crowding.left_out[0] += n_reports - n_reports // stride
            for index in range(low + node % stride if seen > 0.0 else high, high, stride):
                if scan.is_located and not (
                    is_beside(
                        scan.position[index, 1], scan.gate, state.mean, state.covariance,
                        broad[1], slack,
                    )
                    and is_reachable(
                        nodes.mean, nodes.covariance, nodes.weight, node, scan.position,
                        scan.position_covariance, index,
                        motion.max_speed * abs(scan.moment[index] - nodes.time[node]),
                        scan.tail_scale,
                    )
                ):  # fmt: skip
                    continue
                if scan.separation > 0.0 and is_too_soon(
                    nodes, node, scan.sensor, scan.moment[index], scan.separation
                ):
                    continue
                setting = scan.setting[index]
                has_moment = False
                if general is not None:
                    has_moment = scan.has_moments
                    if has_moment:
                        advance(
                            nodes.mean[node], nodes.covariance[node], nodes.weight[node],
                            scan.moment[index] - nodes.time[node], motion,
                            general.mean, general.covariance, general.weight,
                        )  # fmt: skip
                        expect(
                            scan.kind, scan.noise[setting], scan.platform[setting], general,
                            motion.dim, motion.unscented, expected,
                        )  # fmt: skip
                if not plane and not has_moment and setting != known:
                    known = setting
                    if general is None:
                        expected.log_determinant[0] = invert_sum(
                            covariance, scan.noise, setting, inverse
                        )
                    else:
                        expect(
                            scan.kind, scan.noise[setting], scan.platform[setting], state,
                            motion.dim, motion.unscented, expected,
                        )  # fmt: skip
                if general is None:
                    distance = distance_of(scan.measurement, index, mean, inverse)
                    log_likelihood = -0.5 * (
                        distance + expected.log_determinant[0] + n_components * LOG_TWO_PI
                    )
                elif plane:
                    distance, log_likelihood = compare_in_plane(
                        scan.measurement, index, scan.noise, setting, state.mean,
                        state.covariance, state.weight,
                        share_after(nodes.wild[node], scan.tail_share, scan.tail_persistence),
                        scan.tail_scale,
                    )  # fmt: skip
                else:
                    distance, log_likelihood = compare_either(
                        scan.kind, scan.measurement, index,
                        general.weight if has_moment else state.weight, expected,
                        scan.noise[setting],
                        share_after(nodes.wild[node], scan.tail_share, scan.tail_persistence),
                        scan.tail_scale,
                    )  # fmt: skip
                if not distance <= scan.gate:
                    continue
                cost = report_cost(
                    nodes.cost[node] + nodes.tail[node] + scan.survival_cost, log_likelihood,
                    scan.log_clutter, chance, scan.evidence[index],
                ) + naming_cost(nodes, node, scan, index)  # fmt: skip
                if scan.is_heard:
                    cost += rhythm_cost(nodes.rhythm, node, scan, index)
                count = admit(candidates, begin, count, crowding, node, index, cost)
            if leaps and seen > 0.0:
                count = propose_leaps(
                    nodes, node, scan, motion, chance, candidates, begin, count, crowding
                )
    end_misses(nodes, n_nodes, scan, rule, missed)
    return count


@jit
def _propose_crossings(
    nodes: Nodes, node: int, scan: ScanInput, rule: WindowRule, candidates: Candidates,
    count: int, crowding: Crowding, moved: State,
) -> int:  # fmt: skip
    """Write the reports that say where an object on a line is; return how many there are now."""
    if abs(scan.time - nodes.time[node]) > rule.crossing_time:
        return count
    begin, n_reports = count, scan.measurement.shape[0]
    stride = max(1, -(-n_reports // crowding.looks))
    for index in range(node % stride, n_reports, stride):
        evidence = cross_line(nodes, node, scan, index, rule, moved.mean[0], moved.covariance[0])
        if evidence == -math.inf:
            continue
        cost = (
            nodes.covariance[node, 0, 0, 0]
            + nodes.tail[node]
            + scan.survival_cost
            + scan.log_clutter
            - math.log(scan.detection_probability)
            - evidence
            - scan.evidence[index]
            + naming_cost(nodes, node, scan, index)
        )
        count = admit(candidates, begin, count, crowding, node, index, cost)
    return count


@jit
def append_children(
    nodes: Nodes,
    n_nodes: int,
    candidates: Candidates,
    chosen: IntArray,
    scan: ScanInput,
    rule: WindowRule,
    general: State | None,
) -> None:
    """Write the chosen candidates behind the existing nodes, with their updated states."""
    motion = rule.motion
    state = room_for_state(motion)
    expected = room_for_expectation(motion, scan.measurement.shape[1])
    mean, covariance = state.mean[0], state.covariance[0]
    child, moved, waited = n_nodes, -1, 0.0
    for entry in chosen:
        above, index = candidates.node[entry], candidates.report[entry]
        interval = scan.moment[index] - nodes.time[above]
        wild = nodes.wild[above]
        if candidates.leap[entry]:
            begin_state(nodes, child, scan, index, motion, general)
        elif general is None:
            predict(
                nodes.mean[above, 0], nodes.covariance[above, 0], interval,
                motion.noise[0, 0], mean, covariance,
            )  # fmt: skip
            update(
                mean, covariance, scan.measurement[index], scan.noise[scan.setting[index]],
                nodes.mean[child, 0], nodes.covariance[child, 0],
            )  # fmt: skip
            nodes.weight[child, 0] = 1.0
        elif nodes.is_line[above] == 1:
            cross_line(
                nodes, above, scan, index, rule, nodes.mean[child, 0], nodes.covariance[child, 0]
            )
            take_rate(scan, index, nodes.mean[child, 0], nodes.covariance[child, 0], motion.dim)
            spread_over_modes(nodes, child, motion)
        else:
            # Children of one parent stand together, and mostly wait as long.
            if above != moved or interval != waited:
                moved, waited = above, interval
                advance(
                    nodes.mean[above], nodes.covariance[above], nodes.weight[above], interval,
                    motion, state.mean, state.covariance, state.weight,
                )  # fmt: skip
            setting = scan.setting[index]
            share = share_after(nodes.wild[above], scan.tail_share, scan.tail_persistence)
            part = take_in_either(
                scan.kind, scan.measurement[index], scan.noise[setting],
                scan.platform[setting], state, motion.dim, motion.unscented, expected,
                share, scan.tail_scale,
                nodes.mean[child], nodes.covariance[child], nodes.weight[child],
            )  # fmt: skip
            if scan.tail_persistence > 0.0:
                wild = part
        for column in range(nodes.rhythm.shape[1]):
            nodes.rhythm[child, column] = nodes.rhythm[above, column]
        if scan.is_heard:
            hear(nodes.rhythm, child, scan.sensor, scan.moment[index])
        nodes.parent[child] = above
        nodes.report[child] = scan.slot[index]
        nodes.family[child] = nodes.family[above]
        nodes.hits[child] = nodes.hits[above] + 1
        nodes.chosen[child] = 0
        nodes.sensor[child] = scan.sensor
        nodes.is_line[child] = 0
        nodes.cost[child] = candidates.cost[entry]
        nodes.tail[child] = 0.0
        nodes.hidden[child] = 0.0
        for column in range(nodes.unseen.shape[1]):
            nodes.unseen[child, column] = nodes.unseen[above, column]
        if scan.column >= 0:
            nodes.unseen[child, scan.column] = 0.0
        nodes.misses[child] = 0.0
        nodes.counted[child] = 1.0
        nodes.price[child] = 0.0
        nodes.belief[child] = 0.0
        nodes.time[child] = scan.moment[index]
        nodes.wild[child] = wild
        nodes.chances[child] = nodes.chances[above]
        if interval != 0.0 or nodes.report[above] < 0:
            # Misses of this very instant are no chance of their own: it is a hit now.
            nodes.chances[child] += nodes.misses[above] - nodes.counted[above] + 1.0
        claimed = scan.identity[index]
        nodes.identity[child] = nodes.identity[above]
        nodes.other[child] = nodes.other[above]
        if claimed >= 0:
            take_identity(nodes, child, claimed)
        for column in range(nodes.level.shape[1]):
            nodes.level[child, column] = nodes.level[above, column]
        heard = scan.level[index], scan.moment[index], scan.sigma_level
        take_level(nodes.level, child, heard, scan.sensor)
        child += 1


@jit
def append_roots(
    nodes: Nodes,
    n_nodes: int,
    scan: ScanInput,
    rule: WindowRule,
    first_family: int,
    log_density: FloatArray,
    general: State | None,
) -> None:
    """Write one new object per report; ``log_density`` is of undetected objects at its place."""
    motion = rule.motion
    dim = motion.dim
    for index in range(scan.measurement.shape[0]):
        node = n_nodes + index
        nodes.parent[node] = -1
        nodes.report[node] = scan.slot[index]
        nodes.family[node] = first_family + index
        nodes.hits[node] = 1
        nodes.chosen[node] = 0
        nodes.sensor[node] = scan.sensor
        nodes.is_line[node] = 0
        nodes.tail[node] = 0.0
        nodes.hidden[node] = 0.0
        for column in range(nodes.unseen.shape[1]):
            nodes.unseen[node, column] = rule.unseen[column]
        if scan.column >= 0:
            nodes.unseen[node, scan.column] = 0.0
        nodes.misses[node] = 0.0
        nodes.counted[node] = 1.0
        nodes.price[node] = 0.0
        nodes.belief[node] = 0.0
        nodes.time[node] = scan.moment[index]
        nodes.wild[node] = -1.0
        nodes.chances[node] = 1.0
        nodes.identity[node] = scan.identity[index]
        nodes.other[node] = -1
        heard = scan.level[index], scan.moment[index], scan.sigma_level
        begin_level(nodes.level, node, heard, scan.sensor)
        heard_by = scan.sensor if scan.is_heard else -1
        begin_rhythm(nodes.rhythm, node, heard_by, scan.moment[index])
        if scan.is_located:
            nodes.cost[node] = (
                scan.log_clutter - math.log(scan.detection_probability) - log_density[index]
                - scan.log_begin[index] - scan.evidence[index]
            )  # fmt: skip
            begin_state(nodes, node, scan, index, motion, general)
        else:
            nodes.mean[node] = 0.0
            nodes.covariance[node] = 0.0
            overwrite(nodes.weight[node], motion.share)
            nodes.cost[node] = HOPELESS
            nodes.tail[node] = math.inf
            if general is not None and scan.kind == BEARING and dim == 2:
                nodes.tail[node] = 0.0
                begin_line(nodes, node, scan, index, log_density[index])
