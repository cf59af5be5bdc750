"""Which plots of an instant are of an aircraft, told by several methods, and how rightly."""

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.association.plots_rule import PlotsRule, ScoredTuples
from trackweave.association.problem import AssignmentProblem, Status
from trackweave.association.scan_plots import plots_of
from trackweave.domain.scans import Scan
from trackweave.presets.wiranto_2018 import CONFIGURATION
from trackweave.solvers import AntSystem, Auto, Exact, Greedy
from trackweave.solvers.protocol import Solver
from trackweave.studies.wiranto_scenes import SIDE, RadarSky
from trackweave.trackers.plot_choice import objects_in, worth_choosing

__all__ = [
    "DEFAULT",
    "DOCUMENT",
    "METHODS",
    "Instant",
    "Sorted",
    "document_ants",
    "instants_of_sky",
    "judged",
    "seen_alone",
    "sort_plots",
]

Cost = Literal["equation-1", "evidence"]
MOST_TUPLES = 2_000_000
"""The studies leave no tuple out."""
CLOSE = 1e-6
"""Costs that differ by no more are equal [nats]."""
DOCUMENT, DEFAULT = "Ant System, eq. 1", "default"


def document_ants() -> AntSystem:
    """Return the preset's Ant System."""
    search = CONFIGURATION["search"]
    return AntSystem(**{key: value for key, value in search.items() if key != "method"})


# Those that are exact come first: others are measured by what their answers cost.
METHODS: dict[str, tuple[Cost, Callable[[], Solver]]] = {
    "exact, eq. 1": ("equation-1", Exact),
    "exact, evidence": ("evidence", Exact),
    DOCUMENT: ("equation-1", document_ants),
    "greedy, eq. 1": ("equation-1", Greedy),
    DEFAULT: ("evidence", Auto),
    "greedy, evidence": ("evidence", Greedy),
    "Ant System, evidence": ("evidence", document_ants),
}


@dataclass(frozen=True, slots=True, eq=False)
class Instant:
    """The plots of an instant, and what their tuples cost.

    Parameters
    ----------
    scans
        The radars' scans.
    rule
        What tuples cost.
    tuples, problem
        The tuples that are worth choosing, and the problem of choosing.
    """

    scans: tuple[Scan, ...]
    rule: PlotsRule
    tuples: ScoredTuples
    problem: AssignmentProblem


@dataclass(frozen=True, slots=True, eq=False)
class Sorted:
    """A sky's plots by groups.

    Parameters
    ----------
    group
        Number of each plot's group, -1 for a false alarm, shape (plots,).
    time, place
        When [s] and where [m] each group is, shapes (groups,) and (groups, 2).
    counts
        How many groups there are at each instant, shape (instants,).
    costs
        What the answer to each instant costs [nats], shape (instants,).
    proven
        Whether each answer is proven best, shape (instants,).
    stopped
        Why each search ended, in words.
    cpu
        CPU time of the search [s].
    """

    group: NDArray[np.int64]
    time: FloatArray
    place: FloatArray
    counts: NDArray[np.int64]
    costs: FloatArray
    proven: NDArray[np.bool_]
    stopped: tuple[str, ...]
    cpu: float


def instants_of_sky(sky: RadarSky, cost: Cost) -> tuple[Instant, ...]:
    """Return a sky's instants, as the fusion of plots poses them to a solver.

    Parameters
    ----------
    sky
        The sky.
    cost
        ``"equation-1"`` as in the preset, or ``"evidence"`` with the true densities.

    Returns
    -------
    The instants in order.
    """
    if cost == "equation-1":
        gate = CONFIGURATION["plots"]["gate"]
        rule = PlotsRule(cost="equation-1", gate=gate, lone_plots=True, max_tuples=MOST_TUPLES)
    else:
        density = sky.shape.n_objects / SIDE**2
        rule = PlotsRule(density, negative_only=True, lone_plots=True, max_tuples=MOST_TUPLES)
    made = []
    for scans in sky.instants:
        plots = [plots_of(s, sensor, 2) for s, sensor in zip(scans, sky.sensors, strict=True)]
        tuples = worth_choosing(rule(plots), plots, rule)
        made.append(Instant(scans, rule, tuples, tuples.problem()))
    return tuple(made)


def sort_plots(
    sky: RadarSky, instants: Sequence[Instant], solver: Solver, rng: np.random.Generator
) -> Sorted:
    """Return which plots a solver takes for plots of one aircraft.

    Parameters
    ----------
    sky
        The sky.
    instants
        Its instants.
    solver
        What chooses.
    rng
        Source of randomness.

    Returns
    -------
    The plots by groups.
    """
    group = np.full(sky.target.size, -1, dtype=np.int64)
    times, places, counts, answers = [], [np.empty((0, 2))], [], []
    n_groups, cpu = 0, 0.0
    for instant in instants:
        begun = clock.process_time()
        answer = solver(instant.problem, rng=rng)
        cpu += clock.process_time() - begun
        chosen = objects_in(instant.tuples, instant.problem, answer, instant.rule)
        for scan, plot in zip(instant.scans, instant.tuples.tuples[chosen].T, strict=True):
            held = np.flatnonzero(plot)
            group[scan.report[plot[held] - 1]] = n_groups + held
        n_groups += chosen.size
        times += [instant.scans[0].time] * chosen.size
        places.append(instant.tuples.positions[chosen])
        counts.append(chosen.size)
        answers.append(answer)
    return Sorted(
        group, np.array(times), np.concatenate(places), np.array(counts),
        costs=np.array([answer.cost for answer in answers]),
        proven=np.array([answer.status == Status.OPTIMAL for answer in answers]),
        stopped=tuple(answer.stop_reason for answer in answers),
        cpu=cpu,
    )  # fmt: skip


def judged(sky: RadarSky, found: Sorted, least: FloatArray) -> dict[str, float]:
    """Return how rightly a sky's plots were sorted.

    Parameters
    ----------
    sky
        The sky.
    found
        The plots by groups.
    least
        What the exact answer to each instant costs [nats].

    Returns
    -------
    Measures by their names.
    """
    excess = np.maximum(0.0, found.costs - least)
    is_object, is_told, alone = sky.target >= 0, found.group >= 0, seen_alone(sky)
    return {
        "classified rightly [%]": _percent(is_told == is_object),
        "grouped rightly [%]": _percent(_grouped_rightly(sky, found.group)),
        "objects per scan": float(found.counts.mean()),
        "scans with the true number [%]": _percent(found.counts == sky.shape.n_objects),
        "scans with all seen twice [%]": _percent(_all_seen_twice(sky)),
        "above the least cost [nats]": float(excess.mean()),
        "scans at the least cost [%]": _percent(excess <= CLOSE),
        "scans proven best [%]": _percent(found.proven),
        "scans at the limit of cycles [%]": _percent(np.array(found.stopped) == "cycles"),
        "CPU [ms/scan]": 1000.0 * found.cpu / found.counts.size,
        "aircraft seen by one radar [%]": _percent(alone),
        "aircraft left out though seen by more [%]": _percent(is_object & ~is_told & ~alone),
        "false alarms taken for aircraft [%]": _percent(is_told & ~is_object),
    }


def _percent(chosen: NDArray[np.bool_]) -> float:
    return 100.0 * float(np.mean(chosen))


def seen_alone(sky: RadarSky) -> NDArray[np.bool_]:
    """Return which plots are of an aircraft that no other radar reports then.

    At one instant nothing tells them from false alarms.

    Parameters
    ----------
    sky
        The sky.

    Returns
    -------
    One truth value per plot.
    """
    alone: NDArray[np.bool_] = (sky.target >= 0) & (_sizes(_objects(sky)) == 1)
    return alone


def _all_seen_twice(sky: RadarSky) -> NDArray[np.bool_]:
    """Return whether two radars or more report each aircraft, by instant."""
    objects, first, count = np.unique(_objects(sky), return_index=True, return_counts=True)
    twice = (sky.target[first] >= 0) & (count > 1)
    instant = objects[twice] // (sky.shape.n_objects + 1)
    found: NDArray[np.bool_] = (
        np.bincount(instant, minlength=len(sky.instants)) == sky.shape.n_objects
    )
    return found


def _objects(sky: RadarSky) -> NDArray[np.int64]:
    """Return one number per plot, the same for an aircraft's plots of one instant."""
    instant = np.empty(sky.target.size, dtype=np.int64)
    for number, scans in enumerate(sky.instants):
        for scan in scans:
            instant[scan.report] = number
    keys: NDArray[np.int64] = instant * (sky.shape.n_objects + 1) + sky.target + 1
    return keys


def _sizes(label: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return how many plots have the label of each."""
    _, place, count = np.unique(label, return_inverse=True, return_counts=True)
    sizes: NDArray[np.int64] = count[place]
    return sizes


def _grouped_rightly(sky: RadarSky, group: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which plots are in the group of all their aircraft's plots and no other, or none."""
    objects = _objects(sky)
    common = _sizes(objects * (int(group.max(initial=0)) + 2) + group + 1)
    whole = (group >= 0) & (common == _sizes(objects)) & (common == _sizes(group))
    right: NDArray[np.bool_] = np.where(sky.target >= 0, whole, group < 0)
    return right
