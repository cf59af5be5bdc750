"""The methods that the study of Huo and others sets side by side."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.special import chdtri

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.chain_rule import (
    Chains,
    TrackEstimates,
    accumulated_distance,
    same_object_threshold,
    track_chains,
)
from trackweave.association.problem import AssignmentProblem
from trackweave.config.search import make_solver
from trackweave.fusion.associator import TrackAssociator
from trackweave.fusion.statistic import Statistic, tuple_values
from trackweave.presets.huo_2008 import CONFIGURATION
from trackweave.solvers import Dual, Exact, ListGenetic
from trackweave.solvers.genetic._columns import decode_columns
from trackweave.solvers.genetic.list_genes import make_table
from trackweave.solvers.protocol import Solver
from trackweave.solvers.relaxation import Relaxation
from trackweave.studies.scenes import TrackScene

__all__ = [
    "ALPHA",
    "COMPLETE",
    "METHODS",
    "TWO_NODES",
    "curve",
    "decoded",
    "document_search",
    "groups",
    "nearest_neighbour",
    "pairwise_sequential",
    "successive",
    "two_nodes",
]


def pairwise_sequential(
    sensors: Sequence[TrackEstimates], *, false_rejection: float = 0.01
) -> list[IntArray]:
    """Return groups of tracks by one optimal assignment per further sensor."""
    # The first sensor's tracks are the first groups. Each further sensor's are assigned to the
    # groups so far, at least total accumulated distance to their fused estimates; what is beyond
    # the threshold begins a group.
    return _sequential(sensors, false_rejection, _assigned)


def nearest_neighbour(
    sensors: Sequence[TrackEstimates], *, false_rejection: float = 0.01
) -> list[IntArray]:
    """Return groups of tracks where each track in turn takes the nearest group that is free."""
    return _sequential(sensors, false_rejection, _nearest)


_Choice = Callable[[FloatArray, float], IntArray]


def _sequential(
    sensors: Sequence[TrackEstimates], false_rejection: float, choose: _Choice
) -> list[IntArray]:
    """Return groups, taking sensor after sensor; ``choose`` gives tracks groups, -1 for none."""
    first = sensors[0]
    threshold = same_object_threshold(false_rejection, first.n_times, first.dim)
    labels = [np.arange(first.n_tracks)]
    # Of each group the information and the information-weighted state.
    weight = np.linalg.inv(first.covariance)
    pull = np.einsum("ktij,ktj->kti", weight, first.mean)
    for sensor in sensors[1:]:
        covariance = np.linalg.inv(weight)
        covariance = (covariance + covariance.swapaxes(-1, -2)) / 2.0
        fused = TrackEstimates(np.einsum("ktij,ktj->kti", covariance, pull), covariance)
        label = choose(accumulated_distance(fused, sensor), threshold)
        information = np.linalg.inv(sensor.covariance)
        pulled = np.einsum("ktij,ktj->kti", information, sensor.mean)
        taken = label >= 0
        weight[:, label[taken]] += information[:, taken]
        pull[:, label[taken]] += pulled[:, taken]
        label[~taken] = weight.shape[1] + np.arange(np.count_nonzero(~taken))
        weight = np.concatenate([weight, information[:, ~taken]], axis=1)
        pull = np.concatenate([pull, pulled[:, ~taken]], axis=1)
        labels.append(label)
    return labels


def _assigned(distance: FloatArray, threshold: float) -> IntArray:
    """Return the group of each track at least total distance; none costs the threshold."""
    label = np.full(distance.shape[1], -1, dtype=np.int64)
    group, track = linear_sum_assignment(np.minimum(distance, threshold))
    within = distance[group, track] < threshold
    label[track[within]] = group[within]
    return label


def _nearest(distance: FloatArray, threshold: float) -> IntArray:
    """Return the nearest free group of each track in turn."""
    label = np.full(distance.shape[1], -1, dtype=np.int64)
    free = distance.copy()
    for track in range(distance.shape[1]):
        group = int(np.argmin(free[:, track])) if free.shape[0] else -1
        if group >= 0 and free[group, track] < threshold:
            label[track] = group
            free[group] = np.inf
    return label


COMPLETE = ("document", "relaxation", "exact")
"""Methods of the document's problem, for which every sensor has to see every object."""
METHODS = (*COMPLETE, "pairwise", "nearest", "default")
TWO_NODES = ("weighted", "modified", "nearest neighbour")
ALPHA = CONFIGURATION["statistic"]["false_rejection"]


def document_search() -> ListGenetic:
    """Return the genetic search of the preset."""
    search: ListGenetic = make_solver(CONFIGURATION["search"])
    return search


def groups(
    scene: TrackScene, methods: Sequence[str], rng: np.random.Generator
) -> dict[str, list[IntArray]]:
    """Return the group of each track of each sensor, by the last time, after some ``METHODS``."""
    searches: Mapping[str, Solver] = {
        "document": document_search(), "relaxation": Dual(), "exact": Exact(),
    }  # fmt: skip
    found = {}
    chains = track_chains(scene.estimates) if set(methods) & set(COMPLETE) else None
    problem = chains.problem() if chains else None
    for name in methods:
        if chains and problem and name in COMPLETE:
            nodes = searches[name](problem, rng=rng).nodes
            found[name] = _declared(scene, _tuples(chains, problem, nodes))
        elif name == "default":
            found[name] = _default(scene, rng)
        else:
            practice = pairwise_sequential if name == "pairwise" else nearest_neighbour
            found[name] = practice(scene.estimates, false_rejection=ALPHA)
    return found


def _default(scene: TrackScene, rng: np.random.Generator) -> list[IntArray]:
    associator = TrackAssociator(sensors=scene.names)
    for time in range(scene.estimates[0].n_times):
        found = associator.step(float(time), scene.pictures(time), rng=rng)
    return [found.object[found.sensor == number] for number in range(len(scene.names))]


def _tuples(chains: Chains, problem: AssignmentProblem, nodes: IntArray) -> IntArray:
    assert problem.row is not None
    return chains.tuples[problem.row[nodes]] - 1


def _declared(scene: TrackScene, tuples: IntArray) -> list[IntArray]:
    """Return groups: tuples within the threshold, and each other track alone."""
    members = [(each.mean[:, mine], each.covariance[:, mine])
               for each, mine in zip(scene.estimates, tuples.T, strict=True)]  # fmt: skip
    mean, covariance = (
        np.stack(part, axis=2).swapaxes(0, 1) for part in zip(*members, strict=True)
    )
    judged = tuple_values(mean, covariance, Statistic(**CONFIGURATION["statistic"]))
    same = judged.value <= judged.threshold
    labels = []
    for number, mine in enumerate(tuples.T):
        label = np.arange(len(mine)) + len(mine) * (number + 1)
        label[mine[same]] = np.flatnonzero(same)
        labels.append(label)
    return labels


def successive(
    scene: TrackScene, rng: np.random.Generator, *, full: bool
) -> list[frozenset[tuple[int, ...]]]:
    """Return what the document's method pairs at each time, tracks alone left out."""
    # λ sums over all times so far where ``full``, as in the document; else each is judged alone.
    outcomes = []
    for time in range(scene.estimates[0].n_times):
        first = 0 if full else time
        then = replace(
            scene,
            estimates=tuple(
                TrackEstimates(each.mean[first : time + 1], each.covariance[first : time + 1])
                for each in scene.estimates
            ),
        )
        labels = np.stack(groups(then, ["document"], rng)["document"])
        tuples = [np.argwhere(labels == number)[:, 1] for number in range(labels.shape[1])]
        outcomes.append(frozenset(tuple(each.tolist()) for each in tuples if len(each)))
    return outcomes


def curve(
    problem: AssignmentProblem, search: ListGenetic, marks: Sequence[int], rng: np.random.Generator
) -> list[float]:
    """Return the best J after so many evaluations, ascending, one search gone on with."""
    # Where it stops, its last answer stays.
    state, best = search.start(problem, rng=rng), []
    for mark in marks:
        if not state.done and mark > state.evaluations:
            state = search.advance(state, evaluations=mark - state.evaluations)
        best.append(search.answer(state).cost)
    return best


def two_nodes(method: str, scene: TrackScene) -> list[IntArray]:
    """Return the groups of two nodes' tracks by the estimates of the last time alone."""
    # "weighted": the distance weighted by P₁ + P₂ (R. Singer, A. Kanyuck, *Computer control of
    # multiple site track correlation*, Automatica 1971); "modified": the covariance without what
    # both errors share (Y. Bar-Shalom, *On the track-to-track correlation problem*, IEEE Trans. AC
    # 1981); "nearest neighbour": each number within a gate of its own. The nearest pairs that pass
    # the test come first.
    first, second = scene.estimates[:2]
    apart = first.mean[-1][:, None] - second.mean[-1][None]
    mine, yours = first.covariance[-1][:, None], second.covariance[-1][None]
    spread = mine + yours
    if method == "modified":
        # Covariances of these scenes are diagonal, and so is what errors have in common.
        spread = spread - 2.0 * scene.shared * np.sqrt(mine * yours)
    variance = np.diagonal(spread, axis1=2, axis2=3)
    if method == "nearest neighbour":
        n = apart.shape[2]
        allowed = (apart**2 <= chdtri(1, ALPHA / n) * variance).all(axis=2)
        distance = np.linalg.norm(apart[..., :2], axis=2)
    else:
        distance = np.einsum(
            "abi,abi->ab", apart, np.linalg.solve(spread, apart[..., None])[..., 0]
        )
        allowed = distance <= chdtri(apart.shape[2], ALPHA)
    label = len(apart) + np.arange(apart.shape[1])
    left = np.where(allowed, distance, np.inf)
    while np.isfinite(left).any():
        row, column = np.unravel_index(np.argmin(left), left.shape)
        label[column] = row
        left[row], left[:, column] = np.inf, np.inf
    return [np.arange(len(apart)), label]


def decoded(chromosome: IntArray) -> list[tuple[int, ...]]:
    """Return the tuples of tracks that the list-genetic search reads out of a chromosome."""
    # One permutation of track numbers from 1 per sensor; tuples in the order of sensor 1's tracks.
    n_sensors, n = chromosome.shape
    flat = TrackEstimates(np.zeros((n, 1)), np.ones((n, 1, 1)))
    chains = track_chains([flat] * n_sensors)
    problem = chains.problem()
    whole = Relaxation.of(problem, None, whole=True).rest
    component = whole.component(0)
    nodes = np.empty(component.must.shape[0], dtype=np.int64)
    room = np.empty((3, n_sensors + 1), dtype=np.int64)
    instant = np.repeat(np.arange(n_sensors), n)
    decode_columns(component, make_table(component, instant), chromosome - 1, room, nodes)
    taken = whole.parts.node[nodes[nodes >= 0]]
    return sorted(tuple((row + 1).tolist()) for row in _tuples(chains, problem, taken))
