"""Where components of a tree may be seen. Nothing here checks or raises."""

import math
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._clusters import find
from trackweave.association._nodes import Nodes, State
from trackweave.association._predicting import move_state
from trackweave.jit import jit
from trackweave.models.coverage import Coverage
from trackweave.models.motion import CONSTANT_VELOCITY, MotionRule

SPREADS = 3.0
"""So many standard deviations about where they are expected objects are looked for."""


class Whereabouts(NamedTuple):
    """Circles in which a component's objects are, one per component.

    At ``time`` [s] one is about ``begin`` and a horizon later about ``end``, shapes (components,
    2), and its ``radius`` is the same throughout [m]; minus infinity where nothing grows, and
    infinity where nobody knows.
    """

    time: FloatArray
    begin: FloatArray
    end: FloatArray
    radius: FloatArray


@jit
def label_families(
    family: IntArray, place: IntArray, n_nodes: int, n_reports: int, n_families: int
) -> tuple[IntArray, int]:
    """Return each family's component, and how many there are: who shares a report is in one.

    ``place`` is each node's report, -1 for none.
    """
    leader = np.arange(n_families)
    owner = np.full(n_reports, -1, dtype=np.int64)
    for node in range(n_nodes):
        report = place[node]
        if report < 0:
            continue
        if owner[report] < 0:
            owner[report] = family[node]
        else:
            first, second = find(leader, family[node]), find(leader, owner[report])
            leader[max(first, second)] = min(first, second)
    label = np.full(n_families, -1, dtype=np.int64)
    count = 0
    for index in range(n_families):
        top = find(leader, index)
        if label[top] < 0:
            label[top] = count
            count += 1
        label[index] = label[top]
    return label, count


@jit
def locate(
    nodes: Nodes,
    rows: IntArray,
    label: IntArray,
    n_labels: int,
    time: float,
    horizon: float,
    motion: MotionRule,
    general: State | None,
) -> Whereabouts:
    """Return where the growing ones of some nodes are, by component, until a horizon after."""
    size, n_nodes = nodes.mean.shape[2], rows.shape[0]
    center, radius = np.zeros((2, n_labels, 2)), np.full(n_labels, -math.inf)
    place, reach = np.empty((2, n_nodes, 2)), np.empty((2, n_nodes))
    count = np.zeros(n_labels)
    moved, predicted = np.empty(size), np.empty((size, size))
    is_straight = motion.kind.shape[0] == 1 and motion.kind[0] == CONSTANT_VELOCITY
    for index in range(n_nodes):
        node = rows[index]
        if nodes.tail[node] == math.inf:
            continue
        own = label[nodes.family[node]]
        if nodes.is_line[node] == 1:
            radius[own] = math.inf
            continue
        count[own] += 1.0
        for step in range(2):
            then = time + step * horizon
            if is_straight:
                spread = _move_place(nodes, node, then, motion, moved)
            else:
                move_state(nodes, node, then, motion, general, moved, predicted)
                spread = predicted[0, 0] + predicted[1, 1]
            reach[step, index] = SPREADS * math.sqrt(max(spread, 0.0))
            for axis in range(2):
                place[step, index, axis] = moved[axis]
                center[step, own, axis] += moved[axis]
    for own in range(n_labels):
        for step in range(2):
            for axis in range(2):
                center[step, own, axis] /= max(count[own], 1.0)
    for index in range(n_nodes):
        node = rows[index]
        if nodes.tail[node] == math.inf or nodes.is_line[node] == 1:
            continue
        own = label[nodes.family[node]]
        for step in range(2):
            apart = math.hypot(
                place[step, index, 0] - center[step, own, 0],
                place[step, index, 1] - center[step, own, 1],
            )
            radius[own] = max(radius[own], apart + reach[step, index])
    return Whereabouts(np.full(n_labels, time), center[0], center[1], radius)


@jit
def _move_place(
    nodes: Nodes, node: int, time: float, motion: MotionRule, mean_out: FloatArray
) -> float:
    """Write where an object that moves straight is, x and y; return their variances' sum."""
    interval, dim = time - nodes.time[node], motion.dim
    spread: float = 2.0 * motion.noise[0, 0] * abs(interval) ** 3 / 3.0
    mean, covariance = nodes.mean[node, 0], nodes.covariance[node, 0]
    for axis in range(2):
        mean_out[axis] = mean[axis] + interval * mean[dim + axis]
        cross = covariance[axis, dim + axis] + covariance[dim + axis, axis]
        spread += covariance[axis, axis] + interval * (
            cross + interval * covariance[dim + axis, dim + axis]
        )
    return spread


@jit
def concerned(
    known: Whereabouts, count: int, coverage: Coverage, time: float, horizon: float, slack: float
) -> np.ndarray:
    """Tell which components a scan may see, at a time; an object may be ``slack`` off [m].

    What has not been looked at for a horizon is concerned by whatever comes.
    """
    told = np.ones(count, dtype=np.bool_)
    for index in range(count):
        waited = time - known.time[index]
        if waited >= horizon:
            continue
        if known.radius[index] == -math.inf:
            told[index] = False
            continue
        share = max(waited, 0.0) / horizon
        radius = known.radius[index] + slack
        x = known.begin[index, 0] + share * (known.end[index, 0] - known.begin[index, 0])
        y = known.begin[index, 1] + share * (known.end[index, 1] - known.begin[index, 1])
        told[index] = _meets(
            x - coverage.position[0], y - coverage.position[1], radius, coverage.bounds
        )
    return told


@jit
def _meets(east: float, north: float, radius: float, bounds: FloatArray) -> bool:
    """Tell whether a circle may meet a sector of a ring about the origin."""
    distance = math.hypot(east, north)
    if distance - radius > bounds[1] or distance + radius < bounds[0]:
        return False
    if radius >= distance or bounds[3] >= 2.0 * math.pi:
        return True
    half = math.asin(radius / distance)
    turn = (math.atan2(east, north) - bounds[2]) % (2.0 * math.pi)
    return bool(turn <= bounds[3] + half or turn >= 2.0 * math.pi - half)
