"""Windows of one scan and of several, and reports that come alone, over whole scenes."""

from collections.abc import Callable

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.presets import hillis
from trackweave.solvers import Auto, Exact, Greedy
from trackweave.solvers.protocol import Solver
from trackweave.studies import Tick
from trackweave.studies.hillis_fitness import BestHypothesis, document_search, search_of
from trackweave.studies.hillis_scenes import Followed, follow, lone_reports, meeting_scene
from trackweave.studies.hillis_search import CLOSE, least_cost
from trackweave.studies.writing import Table, frame

__all__ = ["METHODS", "arriving", "by_depth"]

METHODS: dict[str, Callable[[], Solver]] = {
    "document": document_search,
    "its best": BestHypothesis,
    "hillis": lambda: search_of(hillis),
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
    for number, own in enumerate(rng.spawn(n_scenes)):
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
        tick(number + 1, n_scenes)
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
    n_scenes = 3 if quick else 20
    for number, own in enumerate(rng.spawn(n_scenes)):
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
        tick(number + 1, n_scenes)
    head = ("scene", "arrival", "of scans right [%]", "alone right [%]", "GOSPA [m]")
    return {"arrivals": frame(head, rows)}
