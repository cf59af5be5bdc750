"""Which plots of an instant are of an aircraft, told by several methods, and how rightly."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.plots_rule import PlotsRule, ScoredTuples
from trackweave.association.problem import Answer, AssignmentProblem, Status
from trackweave.association.scan_plots import plots_of
from trackweave.config.search import make_solver
from trackweave.presets.wiranto_2018 import CONFIGURATION
from trackweave.solvers import AntSystem, Auto, Exact, Greedy
from trackweave.solvers.ants.ant_system import most_visited
from trackweave.solvers.protocol import Solver
from trackweave.studies import Tick
from trackweave.studies.wiranto_scenes import SIDE, SKIES, RadarSky, draw_sky
from trackweave.studies.writing import Table, frame
from trackweave.trackers.plot_choice import objects_in, worth_choosing

__all__ = [
    "COLONIES", "CYCLES", "DEFAULT", "DOCUMENT", "EXACT", "GREEDY", "METHODS", "Posed", "Sorted",
    "judged", "posed", "search", "sort_plots", "sorting",
]  # fmt: skip

Cost = Literal["equation-1", "evidence"]
MOST_TUPLES = 2_000_000
"""The studies leave no tuple out."""
CLOSE = 1e-6
"""Costs that differ by no more are equal [nats]."""
EXACT, DOCUMENT, GREEDY = "exact, eq. 1", "Ant System, eq. 1", "greedy, eq. 1"
DEFAULT = "default"


def _ants(**changes: Any) -> AntSystem:
    """Return the preset's Ant System with some options changed."""
    search: AntSystem = make_solver({**CONFIGURATION["search"], **changes})
    return search


# Those that are exact come first: others are measured by what their answers cost.
METHODS: dict[str, tuple[Cost, Solver]] = {
    EXACT: ("equation-1", Exact()),
    "exact, evidence": ("evidence", Exact()),
    DOCUMENT: ("equation-1", _ants()),
    GREEDY: ("equation-1", Greedy()),
    DEFAULT: ("evidence", Auto()),
}
CYCLES = (1, 3, 10, 30, 100)
# Not stopped by their own number of cycles: the curves have the same for all.
COLONIES: dict[str, AntSystem] = {
    **{f"{n} ants": _ants(ants=n, cycles=CYCLES[-1]) for n in (10, 100)},
    "3 N ants, the preset": _ants(cycles=CYCLES[-1]),
    "3 N ants, α = 1, β = 5": _ants(
        cycles=CYCLES[-1], pheromone_weight=1.0, visibility_weight=5.0
    ),
}  # fmt: skip
SEARCHED_SCANS = 10
"""How many instants of each sky the curves rest on."""


@dataclass(frozen=True, slots=True, eq=False)
class Posed:
    """A sky's instants as problems: tuples worth choosing, and the problem of choosing them."""

    rule: PlotsRule
    tuples: tuple[ScoredTuples, ...]
    problems: tuple[AssignmentProblem, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Sorted:
    """A sky's plots by groups, -1 for a false alarm.

    ``time`` [s] and ``place`` [m] tell when and where each group is, ``counts`` how many there are
    at each instant.
    """

    group: IntArray
    time: FloatArray
    place: FloatArray
    counts: IntArray


def posed(sky: RadarSky, cost: Cost) -> Posed:
    """Return a sky's instants, as the fusion of plots poses them to a solver."""
    if cost == "equation-1":
        gate = CONFIGURATION["plots"]["gate"]
        rule = PlotsRule(cost="equation-1", gate=gate, lone_plots=True, max_tuples=MOST_TUPLES)
    else:
        density = sky.shape.n_objects / SIDE**2
        rule = PlotsRule(density, negative_only=True, lone_plots=True, max_tuples=MOST_TUPLES)
    made, sensors = [], {sensor.name: sensor for sensor in sky.sensors}
    for scans in sky.instants:
        plots = [plots_of(scan, sensors[scan.sensor], 2) for scan in scans]
        made.append(worth_choosing(rule(plots), plots, rule))
    return Posed(rule, tuple(made), tuple(tuples.problem() for tuples in made))


def sort_plots(sky: RadarSky, instants: Posed, answers: Sequence[Answer]) -> Sorted:
    """Return which plots answers to the instants take for plots of one aircraft."""
    group = np.full(sky.target.size, -1, dtype=np.int64)
    times: list[float] = []
    places, counts = [np.empty((0, 2))], list[int]()
    for scans, tuples, problem, answer in zip(
        sky.instants, instants.tuples, instants.problems, answers, strict=True
    ):
        chosen = objects_in(tuples, problem, answer, instants.rule)
        for scan, plot in zip(scans, tuples.tuples[chosen].T, strict=True):
            held = np.flatnonzero(plot)
            group[scan.report[plot[held] - 1]] = sum(counts) + held
        times += [scans[0].time] * chosen.size
        places.append(tuples.positions[chosen])
        counts.append(chosen.size)
    return Sorted(group, np.array(times), np.concatenate(places), np.array(counts))


def sorting(
    rng: np.random.Generator, n_skies: dict[str, int], n_scans: int, tick: Tick
) -> dict[str, Table]:
    """Return how rightly each method sorts the plots of some skies of each kind."""
    rows: list[dict[str, object]] = []
    for kind, count in n_skies.items():
        for number, own in enumerate(rng.spawn(count)):
            sky = draw_sky(replace(SKIES[kind], n_scans=n_scans), own)
            instants: dict[Cost, Posed] = {}
            least: dict[Cost, FloatArray] = {}
            for name, (cost, solver) in METHODS.items():
                if cost not in instants:
                    instants[cost] = posed(sky, cost)
                answers = [solver(problem, rng=own) for problem in instants[cost].problems]
                costs = np.array([answer.cost for answer in answers])
                found = judged(sky, sort_plots(sky, instants[cost], answers))
                excess = np.maximum(0.0, costs - least.setdefault(cost, costs))
                rows.append({
                    "sky": kind, "method": name, "draw": number, **found,
                    "above the least cost [nats]": float(excess.mean()),
                    "scans at the least cost [%]": _percent(excess <= CLOSE),
                    **_ends(instants[cost], answers),
                })  # fmt: skip
            tick(len(rows), sum(n_skies.values()) * len(METHODS))
    return {"sorting": Table(rows, infer_schema_length=None)}


def _ends(instants: Posed, answers: Sequence[Answer]) -> dict[str, float]:
    """Return how searches ended, and how many points the best tours visit of the document's N."""
    visited = []
    for tuples, problem, answer in zip(instants.tuples, instants.problems, answers, strict=True):
        assert problem.row is not None  # made of tuples
        sizes = np.count_nonzero(tuples.tuples[problem.row[answer.nodes]], axis=1)
        points = problem.n_items - int(np.sum(sizes - 1))
        visited.append(points / most_visited(problem.n_items))
    return {
        "scans": float(len(answers)),
        "scans proven best": float(sum(a.status == Status.OPTIMAL for a in answers)),
        "scans with one route": float(sum(a.stop_reason == "converged" for a in answers)),
        "points visited of N [%]": 100.0 * float(np.mean(visited)),
        "most points visited of N [%]": 100.0 * float(np.max(visited)),
        "evaluations per scan": float(np.mean([answer.evaluations for answer in answers])),
    }


def search(rng: np.random.Generator, n_skies: int, tick: Tick) -> dict[str, Table]:
    """Return how good answers are after so many cycles, by the number of ants."""
    rows: list[tuple[object, ...]] = []
    kinds = [kind for kind in SKIES if kind != "dense clutter"]
    for kind in kinds:
        for number, own in enumerate(rng.spawn(n_skies)):
            sky = draw_sky(replace(SKIES[kind], n_scans=SEARCHED_SCANS), own)
            by_cost: dict[Cost, Posed] = {
                "equation-1": posed(sky, "equation-1"), "evidence": posed(sky, "evidence"),
            }  # fmt: skip
            instants = by_cost["equation-1"]
            least = [Exact()(problem, rng=own).cost for problem in instants.problems]
            for name in (EXACT, GREEDY, DEFAULT):
                cost, solver = METHODS[name]
                answers = [solver(problem, rng=own) for problem in by_cost[cost].problems]
                # By another cost there is nothing to compare.
                found = _quality(sky, by_cost[cost], answers, least)
                excess = found[1] if cost == "equation-1" else None
                rows.append((kind, number, name, 0, found[0], excess, *found[2:]))
            for name, colony in COLONIES.items():
                states = [colony.start(problem, rng=own) for problem in instants.problems]
                ants = [colony.colony(problem.n_items) for problem in instants.problems]
                for before, cycles in zip((0, *CYCLES), CYCLES, strict=False):
                    states = [
                        colony.advance(state, evaluations=(cycles - before) * many)
                        for state, many in zip(states, ants, strict=True)
                    ]
                    answers = [colony.answer(state) for state in states]
                    found = _quality(sky, instants, answers, least)
                    rows.append((kind, number, name, cycles, *found))
            tick(kinds.index(kind) * n_skies + number + 1, len(kinds) * n_skies)
    head = (
        "sky", "draw", "method", "cycles", "evaluations", "above the least cost [nats]",
        "classified rightly [%]", "one route [%]",
    )  # fmt: skip
    return {"search": frame(head, rows)}


def _quality(
    sky: RadarSky, instants: Posed, answers: Sequence[Answer], least: Sequence[float]
) -> tuple[float, float, float, float]:
    """Return evaluations, excess over the least costs, and how many are right and of one route."""
    told = sort_plots(sky, instants, answers).group >= 0
    excess = np.mean([answer.cost - cost for answer, cost in zip(answers, least, strict=True)])
    return (
        float(np.mean([answer.evaluations for answer in answers])), max(0.0, float(excess)),
        _percent(told == (sky.target >= 0)),
        _percent(np.array([answer.stop_reason == "converged" for answer in answers])),
    )  # fmt: skip


def judged(sky: RadarSky, found: Sorted) -> dict[str, float]:
    """Return how rightly a sky's plots were sorted, by the measures' names."""
    objects = sky.instant * (sky.shape.n_objects + 1) + sky.target + 1
    size, is_object, is_told = _sizes(objects), sky.target >= 0, found.group >= 0
    alone = is_object & (size == 1)
    _, first = np.unique(objects, return_index=True)
    first = first[is_object[first] & (size[first] > 1)]
    twice = np.bincount(sky.instant[first], minlength=len(sky.instants)) == sky.shape.n_objects
    # A group is whole where its plots are all that the aircraft has, and no others.
    common = _sizes(objects * (int(found.group.max(initial=0)) + 2) + found.group + 1)
    whole = is_told & (common == size) & (common == _sizes(found.group))
    return {
        "classified rightly [%]": _percent(is_told == is_object),
        "grouped rightly [%]": _percent(np.where(is_object, whole, ~is_told)),
        "objects per scan": float(found.counts.mean()),
        "scans with the true number [%]": _percent(found.counts == sky.shape.n_objects),
        "scans with all seen twice [%]": _percent(twice),
        # At one instant nothing tells these from false alarms.
        "aircraft seen by one radar [%]": _percent(alone),
        "aircraft left out though seen by more [%]": _percent(is_object & ~is_told & ~alone),
        "false alarms taken for aircraft [%]": _percent(is_told & ~is_object),
    }


def _percent(chosen: NDArray[np.bool_]) -> float:
    return 100.0 * float(np.mean(chosen))


def _sizes(label: IntArray) -> IntArray:
    """Return how many plots have the label of each."""
    _, place, count = np.unique(label, return_inverse=True, return_counts=True)
    sizes: IntArray = count[place]
    return sizes
