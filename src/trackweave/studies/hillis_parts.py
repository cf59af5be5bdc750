"""The parts of the patent's study, each a table of numbers."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.solvers import Auto, Exact, Genetic, Greedy
from trackweave.solvers.protocol import Solver
from trackweave.studies.hillis_example import Run, least_cost_with
from trackweave.studies.hillis_fitness import (
    BestHypothesis,
    decoded,
    document_search,
)
from trackweave.studies.hillis_scenes import Followed, follow, lone_reports, meeting_scene
from trackweave.studies.hillis_search import (
    Evolution,
    evolve,
    full_window,
    interrupted,
    least_cost,
)
from trackweave.studies.writing import Table

__all__ = [
    "CLOSE",
    "METHODS",
    "Table",
    "arriving",
    "by_depth",
    "by_size",
    "costs_by_scan",
    "distinct_hypotheses",
    "generations_table",
    "stopping",
    "thresholds_table",
]

CLOSE = 1e-6
"""Costs that differ by no more are equal [nats]."""
DOCUMENT_DEPTHS = (1, 2, 3, 5)
# Deep windows take long: on further scenes the depths that are compared will do.
AT_EVERY_DEPTH, COMPARED = 6, (1, 5)
LOOKS = (1, 2, 5, 10, 20)
SHOWN = (1, 2, 5, 10, 20, 35, 50, 75, 100, 150, 200)
THRESHOLDS = (0.01, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0)
METHODS: dict[str, Callable[[], Solver]] = {
    "document": document_search,
    "its best": BestHypothesis,
    "exact": Exact,
    "default": Auto,
    "nearest": Greedy,
}
Step = Callable[[], None]


def distinct_hypotheses(run: Run) -> tuple[int, int, int]:
    """Return how many strings the first two scans have, hypotheses they decode to, and best ones.

    Parameters
    ----------
    run
        The example's run.

    Returns
    -------
    Number of strings, of different hypotheses, and of strings that decode to the cheapest.
    """
    problem = run.problems[1]
    found = [decoded(problem, list(order)) for order in permutations(range(problem.n_items))]
    least = min(cost for cost, _ in found)
    best = sum(cost <= least + CLOSE for cost, _ in found)
    return len(found), len({frozenset(tracks) for _, tracks in found}), best


def costs_by_scan(run: Run, rng: np.random.Generator) -> Table:
    """Return what it costs after each scan to have linked the first two as each figure does."""
    rows = [
        (scan + 1, *(least_cost_with(figure, problem, rng)[0] for figure in "123"))
        for scan, problem in enumerate(run.problems)
    ]
    return Table(("scans", *(f"as in Figure {figure} [nats]" for figure in "123")), tuple(rows))


def _excess(followed: Followed, rng: np.random.Generator, *, lone: bool) -> FloatArray:
    """Return by how much each window's answer exceeds the best there is [nats]."""
    found = [
        answer.cost - least_cost(problem, rng, lone=lone)
        for problem, answer in zip(followed.asked.problems, followed.asked.answers, strict=True)
    ]
    return _positive(np.array(found))


def _positive(excess: FloatArray) -> FloatArray:
    """Return what is more than rounding."""
    found: FloatArray = np.where(excess > CLOSE, excess, 0.0)
    return found


def by_depth(
    rng: np.random.Generator,
    depths: Sequence[int],
    n_scenes: tuple[int, int],
    n_scans: int,
    step: Step,
) -> Table:
    """Return how well reports are assigned and objects followed, by depth of the window.

    Parameters
    ----------
    rng
        Source of randomness.
    depths
        Scans in the window.
    n_scenes
        How many scenes, and on how many of them the patent's search is tried.
    n_scans
        Scans of each sensor.
    step
        Called after each scene.

    Returns
    -------
    One row per depth, method and scene.
    """
    rows: list[tuple[object, ...]] = []
    for number, own in enumerate(rng.spawn(n_scenes[0])):
        scene = meeting_scene(own, n_scans=n_scans)
        for depth in depths:
            for name, method in METHODS.items():
                slow = name == "document"
                if slow and (number >= n_scenes[1] or depth not in DOCUMENT_DEPTHS):
                    continue
                if name == "nearest" and depth > 1:
                    continue
                if number >= AT_EVERY_DEPTH and depth not in COMPARED:
                    continue
                found = follow(scene, method(), depth, own, ours=name == "default")
                excess = _excess(found, own, lone=True) if slow else None
                rows.append((
                    depth, name, number, found.right, found.switches, found.gospa, found.amended,
                    None if excess is None else float(excess.mean()),
                    None if excess is None else 100.0 * float(np.mean(excess <= CLOSE)),
                ))  # fmt: skip
        step()
    head = (
        "depth", "method", "scene", "right [%]", "switches", "GOSPA [m]", "amended",
        "excess [nats]", "at the best [%]",
    )  # fmt: skip
    return Table(head, tuple(rows))


def by_size(
    rng: np.random.Generator, sizes: Sequence[int], n_windows: int, step: Step
) -> tuple[Table, dict[int, list[Evolution]]]:
    """Return how often the search finds a full window's best hypothesis, by number of objects.

    Parameters
    ----------
    rng
        Source of randomness.
    sizes
        Numbers of objects.
    n_windows
        Windows of each.
    step
        Called after each size.

    Returns
    -------
    One row per size, and each window's search generation by generation.
    """
    rows: list[tuple[object, ...]] = []
    evolutions: dict[int, list[Evolution]] = {}
    for size in sizes:
        evolutions[size] = []
        alone, settled, default = [], [], []
        for own in rng.spawn(n_windows):
            problem = full_window(own, size)
            found = evolve(problem, own)
            evolutions[size].append(found)
            alone.append(float(found.best[-1]))
            least = least_cost(problem, own, lone=False)
            settled.append(replace(document_search(), settle=True)(problem, rng=own).cost - least)
            default.append(Genetic()(problem, rng=own).cost - least)
        reports = float(np.mean([each.reports for each in evolutions[size]]))
        row: list[object] = [size, reports]
        row += [_at_best(alone), float(np.mean(alone))]
        row += [_at_best(settled), float(np.mean(np.maximum(settled, 0.0))), _at_best(default)]
        rows.append(tuple(row))
        step()
    head = (
        "objects", "reports", "document at the best [%]", "excess [nats]",
        "with false alarms [%]", "its excess [nats]", "default genetic [%]",
    )  # fmt: skip
    return Table(head, tuple(rows)), evolutions


def _at_best(excess: Sequence[float]) -> float:
    return 100.0 * float(np.mean(np.array(excess) <= CLOSE))


def generations_table(evolutions: dict[int, list[Evolution]]) -> Table:
    """Return best and mean cost above the best there is, by generation and number of objects."""
    head = ["generation"]
    columns: list[list[float]] = []
    for size, found in evolutions.items():
        for kind in ("best", "mean"):
            head.append(f"{size} objects, {kind} [nats]")
            over = np.mean([getattr(each, kind) for each in found], axis=0)
            columns.append(over[np.array(SHOWN) - 1].tolist())
    return Table(tuple(head), tuple(zip(SHOWN, *columns, strict=True)))


def thresholds_table(found: Sequence[Evolution]) -> Table:
    """Return when the mean comes within a threshold of the fittest, and how good that one is."""
    rows = []
    for threshold in THRESHOLDS:
        at = [np.flatnonzero(each.spread <= threshold) for each in found]
        stops = [(int(when[0]), each) for when, each in zip(at, found, strict=True) if when.size]
        rows.append((
            threshold, 100.0 * len(stops) / len(found),
            float(np.median([when + 1 for when, _ in stops])) if stops else None,
            float(np.mean([each.best[when] for when, each in stops])) if stops else None,
        ))  # fmt: skip
    head = ("threshold [nats]", "reached [%]", "after generations", "excess [nats]")
    return Table(head, tuple(rows))


def stopping(rng: np.random.Generator, size: int, n_windows: int) -> tuple[Table, bool, bool]:
    """Return what the search says when the next scan arrives.

    Parameters
    ----------
    rng
        Source of randomness.
    size
        Number of objects.
    n_windows
        How many windows.

    Returns
    -------
    The mean excess by how often the search had looked at the clock; whether every answer was a
    whole hypothesis; whether none was worse than an earlier one.
    """
    excess, wholes, ordered = [], [], []
    for own in rng.spawn(n_windows):
        problem = full_window(own, size)
        seed = int(own.integers(2**31))
        costs, whole = interrupted(problem, LOOKS, seed)
        excess.append(np.array(costs) - least_cost(problem, own, lone=True))
        wholes.append(whole)
        ordered.append(bool(np.all(np.diff(costs) <= CLOSE)))
    rows = zip(LOOKS, np.mean(excess, axis=0).tolist(), strict=True)
    return Table(("looks", "excess [nats]"), tuple(rows)), all(wholes), all(ordered)


def arriving(rng: np.random.Generator, n_scenes: int, n_scans: int) -> Table:
    """Return how rightly reports are assigned that come alone, in order and out of it.

    Parameters
    ----------
    rng
        Source of randomness.
    n_scenes, n_scans
        How many scenes, and scans of each sensor.

    Returns
    -------
    One row per scene and order of arrival.
    """
    rows: list[tuple[object, ...]] = []
    for number, own in enumerate(rng.spawn(n_scenes)):
        scene = meeting_scene(own, n_scans=n_scans)
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
    return Table(head, tuple(rows))
