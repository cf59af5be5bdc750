"""The patent's search, window by window: how far from the best, after how many evaluations."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.config.search import make_solver
from trackweave.presets import hillis
from trackweave.solvers import Auto, Exact, Genetic, Greedy, Islands
from trackweave.solvers.protocol import Solver, Stop
from trackweave.solvers.resumable import Resumable
from trackweave.studies import Tick, draws
from trackweave.studies.hillis_fitness import (
    BestHypothesis,
    alone_as_tracks,
    document_search,
    sequence,
)
from trackweave.studies.hillis_scenes import (
    Followed,
    dense_scene,
    follow,
    lone_reports,
    meeting_scene,
)
from trackweave.studies.writing import Table, frame

__all__ = [
    "BY_SIZE",
    "CLOSE",
    "DEFAULT",
    "GRID",
    "LISTS",
    "METHODS",
    "USABLE",
    "Evolution",
    "arriving",
    "by_depth",
    "evolve",
    "full_window",
    "interrupted",
    "least_cost",
    "on_islands",
    "searching",
    "stopping",
]

CLOSE = 1e-6
"""Costs that differ by no more are equal [nats]."""
GRID = (500, 1_000, 2_000, 5_000, 10_000, 20_000, 50_000, 100_000, 200_000)
BY_SIZE, LISTS, USABLE, DEFAULT = "by size", "'931 lists", "hillis", "default"
THRESHOLDS = (0.01, 0.1, 0.3, 1.0, 3.0, 10.0)
LOOKS = (1, 2, 5, 10, 20, 40)
# Objects: windows, populations, evaluations of each, and population of association lists.
SIZES: dict[int, tuple[int, tuple[int, ...], int, int]] = {
    5: (12, (50, 300, 1_000, 3_000), 20_000, 300),
    10: (10, (50, 300, 1_000, 3_000), 50_000, 300),
    20: (5, (50, 300, 1_000, 3_000), 100_000, 300),
    50: (2, (300,), 50_000, 300),
}
QUICK_SIZES = {5: (3, (50, 300), 20_000, 300), 10: (2, (50, 300), 20_000, 300)}
ISLANDS, OBJECTS = 4, 10
WITHOUT_END = 10**9
"""A limit that something else comes before."""


def full_window(rng: np.random.Generator, n_objects: int) -> AssignmentProblem:
    """Return the problem of five scans, two more before them rightly fixed as far as possible."""
    followed = follow(dense_scene(rng, n_objects, 7), Exact(), 5, rng)
    return followed.asked.problems[-1]


def least_cost(problem: AssignmentProblem, rng: np.random.Generator, *, lone: bool) -> float:
    """Return what the best hypothesis costs, proven by branch and bound."""
    return Exact()(alone_as_tracks(problem) if lone else problem, rng=rng).cost


@dataclass(frozen=True, slots=True, eq=False)
class Evolution:
    """A search up to each generation: evaluations, best cost, mean less best of the generation."""

    evaluations: FloatArray
    best: FloatArray
    spread: FloatArray

    def at(self, evaluations: int) -> float | None:
        """Return the least cost after so many evaluations; None before the first generation."""
        done = int(np.searchsorted(self.evaluations, evaluations, side="right"))
        return float(self.best[done - 1]) if done else None


def evolve(problem: AssignmentProblem, search: Genetic, rng: np.random.Generator) -> Evolution:
    """Return how a search of all reports as one goes on, to its limits."""
    n_genes = problem.n_items - int(np.count_nonzero(problem.must_cover))
    population, generations = search.sizes(n_genes)
    endless = replace(search, spread=0.0, generations=WITHOUT_END, evaluations=WITHOUT_END)
    state = endless.start(problem, rng=rng)
    rows: list[tuple[float, ...]] = []
    most = min(generations, -(-search.evaluations // population))
    while not state.done and len(rows) < most:
        state = endless.advance(state, evaluations=population)
        if state.search is not None:
            found = problem.base_cost + state.search.best
            rows.append((population * (len(rows) + 1), found, state.search.spread()))
    if not rows:
        rows.append((0.0, endless.answer(state).cost, 0.0))
    return Evolution(*np.array(rows).T)


def searching(rng: np.random.Generator, quick: bool, tick: Tick) -> dict[str, Table]:
    """Return how far searches are from the best hypothesis, by evaluations and size."""
    rows: list[tuple[object, ...]] = []
    stops: list[tuple[object, ...]] = []
    sizes = QUICK_SIZES if quick else SIZES
    total, done = sum(size[0] for size in sizes.values()), 0
    for objects, (n_windows, populations, budget, of_lists) in sizes.items():
        for window, own in enumerate(rng.spawn(n_windows)):
            problem = full_window(own, objects)
            least = [least_cost(problem, own, lone=lone) for lone in (True, False)]
            preset = document_search()
            free = replace(preset, generations=WITHOUT_END, evaluations=budget)
            ways = {f"population {many}": replace(free, population=many) for many in populations}
            ways[LISTS] = replace(free, genotype="association-list", population=of_lists)
            ways[BY_SIZE] = preset
            for name, way in ways.items():
                course = evolve(problem, way, own)
                above = _above(course.best, least[0])
                curve = replace(course, best=above)
                end = int(course.evaluations[-1])
                for at in sorted({end, *(at for at in GRID if at < end)}):
                    rows.append((objects, window, problem.n_items, name, at, curve.at(at)))
                if name == BY_SIZE:
                    stops += _stops(objects, window, curve)
            for name in (USABLE, DEFAULT):
                answer = METHODS[name]()(problem, rng=own)
                excess = float(_above(np.array([answer.cost]), least[1])[0])
                rows.append((objects, window, problem.n_items, name, answer.evaluations, excess))
            done += 1
            tick(done, total)
    head = ("objects", "window", "reports", "search", "evaluations", "excess [nats]")
    stop_head = ("objects", "window", "threshold [nats]", "generation", "of", "excess [nats]")
    return {"search": frame(head, rows), "thresholds": frame(stop_head, stops)}


def _above(cost: FloatArray, least: float) -> FloatArray:
    """Return by how much costs exceed the least, rounding taken away."""
    found: FloatArray = np.where(cost - least > CLOSE, cost - least, 0.0)
    return found


def _stops(objects: int, window: int, curve: Evolution) -> list[tuple[object, ...]]:
    """Return when the mean comes within each threshold of the fittest, and how good it is."""
    rows: list[tuple[object, ...]] = []
    for threshold in THRESHOLDS:
        at = np.flatnonzero(curve.spread <= threshold)
        found = (int(at[0]) + 1, float(curve.best[at[0]])) if at.size else (None, None)
        rows.append((objects, window, threshold, found[0], curve.best.shape[0], found[1]))
    return rows


def stopping(rng: np.random.Generator, quick: bool, tick: Tick) -> dict[str, Table]:
    """Return what the preset's search says when the next scan arrives."""
    rows: list[tuple[object, ...]] = []
    for window, own in draws(rng, 3 if quick else 12, tick):
        problem, seed = full_window(own, OBJECTS), int(own.integers(2**31))
        costs, whole = interrupted(problem, LOOKS, seed)
        above = _above(np.array(costs), least_cost(problem, own, lone=True)).tolist()
        rows += [(window, *row) for row in zip(LOOKS, above, whole, strict=True)]
    return {"interruptions": frame(("window", "looks", "excess [nats]", "whole"), tuple(rows))}


def interrupted(
    problem: AssignmentProblem, looks: Sequence[int], seed: int
) -> tuple[list[float], list[bool]]:
    """Return what the search says when it is interrupted after so many looks at the clock."""
    search, costs, whole = document_search(), [], []
    for most in looks:
        # The same numbers again: each answer is what a longer search would have passed.
        again = np.random.Generator(np.random.PCG64(seed))
        answer = search(problem, rng=again, stop=_after(most))
        taken = [item for node in answer.nodes for item in sequence(problem, int(node))]
        free = np.setdiff1d(np.arange(problem.n_items), np.flatnonzero(problem.must_cover))
        whole.append(len(taken) == len(set(taken)) and set(free.tolist()) <= set(taken))
        costs.append(answer.cost)
    return costs, whole


def _after(looks: int) -> Stop:
    """Return what says to stop when it has been asked so many times before."""
    asked = count()
    return lambda: next(asked) >= looks


def on_islands(rng: np.random.Generator, quick: bool, tick: Tick) -> dict[str, Table]:
    """Return what islands find beside one population, all with as many evaluations."""
    rows: list[tuple[object, ...]] = []
    for window, own in draws(rng, 2 if quick else 6, tick):
        problem, seed = full_window(own, OBJECTS), int(own.integers(2**31))
        least = least_cost(problem, own, lone=True)
        population, generations = document_search().sizes(problem.n_items)
        budget = population * (generations // (8 if quick else 1))
        for name, search in _ways(population).items():
            answer, sent = _searched(search, problem, seed, budget)
            same = None
            if isinstance(search, Islands):
                again = (replace(search, threads=threads) for threads in (2, ISLANDS))
                told = [_told(_searched(each, problem, seed, budget)[0]) for each in again]
                same = all(each == _told(answer) for each in told)
            excess = float(_above(np.array([answer.cost]), least)[0])
            rows.append((window, name, excess, answer.evaluations, sent, same))
    head = ("window", "search", "excess [nats]", "evaluations", "sent", "same on threads")
    return {"islands": frame(head, rows)}


def _ways(population: int) -> dict[str, Resumable]:
    """Return ways to spread the preset's search."""
    one = replace(
        document_search(), population=population, spread=0.0, generations=WITHOUT_END,
        evaluations=WITHOUT_END,
    )  # fmt: skip
    several = Islands((one,), ISLANDS, threads=1, epochs=WITHOUT_END, patience=WITHOUT_END)
    quarter = replace(one, population=max(2, population // ISLANDS))
    return {
        "one population": one,
        "one that keeps its fittest": replace(one, elite=1),
        "4 islands": several,
        "4 islands of a quarter each": replace(several, methods=(quarter,)),
        "4 islands, nothing sent": replace(several, neighbours=0),
    }


def _searched(
    search: Resumable, problem: AssignmentProblem, seed: int, budget: int
) -> tuple[Answer, int | None]:
    """Return the answer after so many evaluations, and how many islands have sent."""
    state = search.start(problem, rng=np.random.Generator(np.random.PCG64(seed)))
    state = search.advance(state, evaluations=budget)
    epochs = getattr(state.search, "epoch", None)
    if epochs is None or not isinstance(search, Islands) or search.neighbours == 0:
        return search.answer(state), None
    return search.answer(state), ISLANDS * int(epochs)


def _told(answer: Answer) -> tuple[object, ...]:
    return answer.nodes.tolist(), answer.certificate, answer.evaluations


METHODS: dict[str, Callable[[], Solver]] = {
    "document": document_search,
    "its best": BestHypothesis,
    "hillis": lambda: make_solver(hillis.CONFIGURATION["search"]),
    "exact": Exact,
    "default": Auto,
    "nearest": Greedy,
}
COMPARED = (1, 5)
# Scans of each sensor; scenes, and how many of them the patent's search and every depth get.
SCANS, SCENES, SEARCHED, AT_EVERY_DEPTH = 5, 20, 6, 6
QUICK = (3, 3, 1, 1)


def by_depth(rng: np.random.Generator, quick: bool, tick: Tick) -> dict[str, Table]:
    """Return how well reports are assigned and objects followed, by depth of the window."""
    n_scans, n_scenes, n_searched, n_deep = QUICK if quick else (
        SCANS, SCENES, SEARCHED, AT_EVERY_DEPTH
    )  # fmt: skip
    rows: list[tuple[object, ...]] = []
    for number, own in draws(rng, n_scenes, tick):
        scene = meeting_scene(own, n_scans)
        for depth in COMPARED if number >= n_deep else (1, 2, 3, 5):
            for name, method in METHODS.items():
                slow = name == "document"
                if slow and (number >= n_searched or depth not in COMPARED):
                    continue
                if name == "nearest" and depth > 1:
                    continue
                found = follow(scene, method(), depth, own, ours=name in ("default", "hillis"))
                excess = _excess(found, own) if slow else None
                rows.append((
                    depth, name, number, found.right, found.switches, found.gospa, found.amended,
                    None if excess is None else float(excess.mean()),
                    None if excess is None else int(np.count_nonzero(excess <= CLOSE)),
                    len(found.asked.problems),
                ))  # fmt: skip
    head = (
        "depth", "method", "scene", "right [%]", "switches", "GOSPA [m]", "amended",
        "excess [nats]", "at the best", "windows",
    )  # fmt: skip
    return {"depths": frame(head, rows)}


def _excess(followed: Followed, rng: np.random.Generator) -> FloatArray:
    """Return by how much each window's answer exceeds the best by the patent's fitness [nats]."""
    found = [
        answer.cost - least_cost(problem, rng, lone=True)
        for problem, answer in zip(followed.asked.problems, followed.asked.answers, strict=True)
    ]
    above: FloatArray = np.maximum(np.array(found), 0.0)
    return above


def arriving(rng: np.random.Generator, quick: bool, tick: Tick) -> dict[str, Table]:
    """Return how rightly reports are assigned that come alone, in order and out of it."""
    rows: list[tuple[object, ...]] = []
    for number, own in draws(rng, 3 if quick else 20, tick):
        scene = meeting_scene(own, SCANS)
        n_scanned = len(scene.target)
        alone = lone_reports(scene, own)
        for order, given in (("none", scene), ("in time", alone), ("late", alone.late(own))):
            found = follow(given, Exact(), 5, own)
            lone = found.is_right[n_scanned:]
            rows.append((
                number, order, 100.0 * float(found.is_right[:n_scanned].mean()),
                100.0 * float(lone.mean()) if lone.size else None, found.gospa,
            ))  # fmt: skip
    head = ("scene", "arrival", "of scans right [%]", "alone right [%]", "GOSPA [m]")
    return {"arrivals": frame(head, rows)}
