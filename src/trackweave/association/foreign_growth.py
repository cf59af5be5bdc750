"""A forest grown by a scan where motion or measurement is from outside the package.

What the compiled way does node by node goes in two passes here: a gate by position, then one call
of each model for all pairs of a sequence and a report that it may have.
"""

from typing import cast

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._crowding import Crowding
from trackweave.association._growth import append_children, append_roots, propose
from trackweave.association._nearest import squared_distances
from trackweave.association._nodes import (
    Candidates,
    ForeignReports,
    Misses,
    Nodes,
    ScanInput,
    State,
    WindowRule,
    bare,
)
from trackweave.association._pairs import (
    admit_pairs,
    compare_pairs,
    gate_pairs,
    near_nodes,
    take_in_pairs,
)
from trackweave.association._scoring import POSITION, take_rate
from trackweave.filters.foreign import Foreseen, States, advanced, foreseen, taken_in
from trackweave.models.foreign_motion import ForeignMotion
from trackweave.models.motion import MotionRule

__all__ = ["appended", "distances_of", "moved", "proposed", "rooted_in"]


def proposed(
    grown: tuple[Nodes, int, WindowRule],
    scan: ScanInput,
    out: tuple[Candidates, Misses],
    crowding: Crowding,
    general: State | None,
) -> int:
    """Write the children that a scan offers and what misses make; return how many there are."""
    # ``grown`` are nodes, their number and the rule; all as for ``_growth.propose``.
    nodes, n_nodes, rule = grown
    if rule.way is None and scan.foreign is None:
        return propose(nodes, n_nodes, scan, rule, *out, crowding, general)
    known, plain = bare(scan), rule._replace(way=None)
    near = near_nodes(nodes, n_nodes, known, rule.motion, crowding)
    ahead = advanced(_states(nodes, near), scan.reference - nodes.time[near], *_motion(rule))
    share = np.empty(near.shape[0])
    row, index = _gated(nodes, near, ahead, known, (plain, crowding, share))
    seen = np.full(n_nodes, scan.detection_probability)
    seen[near] = share
    if scan.has_moments:
        above = near[row]
        late = scan.moment[index] - nodes.time[above]
        states = advanced(_states(nodes, above), late, *_motion(rule))
    else:
        states = ahead.part(row)
    pairs = (near[row], index, *_compared(states, index, scan, rule))
    return admit_pairs(
        nodes, n_nodes, pairs, seen, known, plain, *out, crowding, cast("State", general)
    )


def appended(
    grown: tuple[Nodes, int, WindowRule],
    candidates: Candidates,
    chosen: IntArray,
    scan: ScanInput,
    general: State | None,
) -> None:
    """Write the chosen candidates behind the existing nodes; as ``append_children``."""
    nodes, n_nodes, rule = grown
    if rule.way is None and scan.foreign is None:
        append_children(nodes, n_nodes, candidates, chosen, scan, rule, general)
        return
    append_children(
        nodes, n_nodes, candidates, chosen, _still(scan), rule._replace(way=None), general
    )
    above, index = candidates.node[chosen], candidates.report[chosen]
    plain = np.flatnonzero(nodes.is_line[above] == 0)
    above, index = above[plain], index[plain]
    late = scan.moment[index] - nodes.time[above]
    states = advanced(_states(nodes, above), late, *_motion(rule))
    if scan.foreign is None:
        after = States(*(np.empty_like(column) for column in states))
        take_in_pairs(State(*states), index, bare(scan), rule.motion, State(*after))
    else:
        after = taken_in(states, _foreseen(states, index, scan))
    children = n_nodes + plain
    nodes.mean[children], nodes.covariance[children], nodes.weight[children] = after


def rooted_in(
    grown: tuple[Nodes, int, WindowRule],
    scan: ScanInput,
    first_family: int,
    log_density: FloatArray,
    general: State | None,
) -> None:
    """Write one new object per report; as ``append_roots``."""
    nodes, n_nodes, rule = grown
    known = _still(scan)
    append_roots(
        nodes, n_nodes, known, rule._replace(way=None), first_family, log_density, general
    )
    if rule.way is None or not scan.is_located:
        return
    rows = slice(n_nodes, n_nodes + scan.measurement.shape[0])
    size = nodes.mean.shape[2]
    if scan.position.shape[0]:
        begun = rule.way.begin(scan.position, scan.position_covariance, size)
        nodes.mean[rows, 0], nodes.covariance[rows, 0] = begun
        for index in range(scan.position.shape[0]):
            node = n_nodes + index
            mean, covariance = nodes.mean[node, 0], nodes.covariance[node, 0]
            take_rate(known, index, mean, covariance, rule.motion.dim)


def distances_of(
    grown: tuple[Nodes, IntArray, WindowRule], scan: ScanInput, general: State | None
) -> FloatArray:
    """Return the squared distance of each child's report from where its parent expects it."""
    nodes, child, rule = grown
    if rule.way is None and scan.foreign is None:
        distance = np.empty(child.shape[0])
        squared_distances(nodes, child, scan, rule.motion, distance, general)
        return distance
    above, index = nodes.parent[child], nodes.report[child]
    late = scan.moment[index] - nodes.time[above]
    states = advanced(_states(nodes, above), late, *_motion(rule))
    return _compared(states, index, scan, rule)[0]


def moved(nodes: Nodes, n_nodes: int, time: float, rule: WindowRule) -> Nodes:
    """Return nodes as of one time, which kernels then need not move, for a motion from outside."""
    placed = np.flatnonzero(nodes.is_line[:n_nodes] == 0)
    now = _states(nodes, np.arange(n_nodes))
    ahead = advanced(now.part(placed), time - nodes.time[placed], *_motion(rule))
    for column, later in zip(now, ahead, strict=True):
        column[placed] = later
    return nodes._replace(time=np.full(n_nodes, time), **now._asdict())


def _motion(rule: WindowRule) -> tuple[MotionRule, ForeignMotion | None]:
    return rule.motion, rule.way


def _states(nodes: Nodes, rows: IntArray) -> States:
    return States(nodes.mean[rows], nodes.covariance[rows], nodes.weight[rows])


def _still(scan: ScanInput) -> ScanInput:
    """Return a scan as if it held the positions of what it reports, without motion between."""
    # Kernels that write all else of a node write a state too, which is written over then.
    count, dim = scan.position.shape
    if scan.foreign is None:
        return scan
    return scan._replace(
        foreign=None,
        kind=POSITION,
        measurement=scan.position,
        setting=np.zeros(count, dtype=np.int64),
        noise=np.eye(dim)[None],
        platform=np.zeros((1, 6)),
    )


def _gated(
    nodes: Nodes, near: IntArray, ahead: States, scan: ScanInput,
    by: tuple[WindowRule, Crowding, FloatArray],
) -> tuple[IntArray, IntArray]:  # fmt: skip
    """Return rows of near nodes and reports that may go together."""
    rule, crowding, share = by
    room = 4 * near.shape[0] + 64
    while True:
        row, index = np.empty((2, room), dtype=np.int64)
        count = gate_pairs(
            nodes, near, State(*ahead), scan, rule.motion, crowding, share, row, index
        )
        if count <= room:
            return row[:count], index[:count]
        room = count


def _compared(
    states: States, index: IntArray, scan: ScanInput, rule: WindowRule
) -> tuple[FloatArray, FloatArray]:
    """Return the squared distance of each pair, from the nearest mode, and its log likelihood."""
    if scan.foreign is None:
        distance, log_likelihood = np.empty((2, index.shape[0]))
        compare_pairs(State(*states), index, scan, rule.motion, distance, log_likelihood)
        return distance, log_likelihood
    seen = _foreseen(states, index, scan)
    with np.errstate(divide="ignore"):
        by_mode = seen.log_likelihood + np.log(states.weight)
    most = by_mode.max(axis=1)
    proper = np.isfinite(most)
    shifted = np.where(proper[:, None], by_mode - np.where(proper, most, 0.0)[:, None], 0.0)
    total = np.where(proper, most + np.log(np.exp(shifted).sum(axis=1)), -np.inf)
    return seen.distance.min(axis=1), total


def _foreseen(states: States, index: IntArray, scan: ScanInput) -> Foreseen:
    kind, reported = cast("ForeignReports", scan.foreign)
    platform = np.ascontiguousarray(scan.platform[scan.setting[index]])
    return foreseen(kind, states, platform, reported.part(index))
