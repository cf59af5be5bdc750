"""The patent's Figures 1 to 4 with reports of a sensor: what is decoded, and what pays when."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association.problem import AssignmentProblem
from trackweave.domain.scans import Scan
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor
from trackweave.solvers.genetic._operators import crossover
from trackweave.solvers.protocol import Solver
from trackweave.studies import Tick
from trackweave.studies.hillis_fitness import (
    BestHypothesis,
    Recorded,
    decoded,
    document_growth,
    document_search,
    sequence,
)
from trackweave.studies.writing import Table, frame
from trackweave.trackers.hypothesis import Amendment
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.window import Window

__all__ = [
    "FIGURES",
    "PLACES",
    "REPORTS",
    "Run",
    "decoded_figure",
    "drawn",
    "least_cost_with",
    "name_of",
    "run_example",
    "tracks_of",
]

Tracks = frozenset[tuple[int, ...]]

# Two objects go up and to the left, the one along D0,1 D1,0 D2,0 faster than the other; D0,0 is a
# false alarm, nearer to D1,0 than D0,1 is. The document gives no places: these are ours.
SCANS = (
    ((0.0, 0.0), (100.0, 0.0), (200.0, 0.0)),
    ((40.0, 50.0), (160.0, 50.0)),
    ((-20.0, 100.0), (120.0, 100.0)),
)
PLACES: FloatArray = np.array([place for scan in SCANS for place in scan])
REPORTS = ("D0,0", "D0,1", "D0,2", "D1,0", "D1,1", "D2,0", "D2,1")
FIGURES: dict[str, tuple[str, str]] = {
    # As printed, Figure 1's string names D1,0 twice; the second must be D1,1, as in the drawing.
    "1": ("D0,0-D1,0-D0,1-D1,1-D0,2", "D0,0-D1,0 D0,1-D1,1 D0,2"),
    "2": ("D0,0-D1,0-D0,2-D1,1-D0,1", "D0,0-D1,0 D0,2-D1,1 D0,1"),
    "3": ("D0,1-D1,0-D0,2-D1,1-D0,0", "D0,1-D1,0 D0,2-D1,1 D0,0"),
    "4": ("D0,1-D1,0-D2,0-D0,2-D1,1-D2,1-D0,0", "D0,1-D1,0-D2,0 D0,2-D1,1-D2,1 D0,0"),
}
"""Each figure's string, and its drawing as tracks."""
SENSOR = Sensor(
    "radar", sigma=8.0, detection_probability=0.9, clutter_density=1e-6, scan_period=1.0
)
FORBIDDEN = 1e3
"""More than any hypothesis of the example costs [nats]."""
MOTION = ConstantVelocity(1.0, max_speed=100.0)


def name_of(tracks: Iterable[tuple[int, ...]]) -> str:
    """Return tracks as text, in the patent's names, the longest first."""
    ordered = sorted(tracks, key=lambda track: (-len(track), track))
    return " ".join("-".join(REPORTS[report] for report in track) for track in ordered)


def tracks_of(drawing: str) -> Tracks:
    """Return the tracks that such a text names."""
    return frozenset(
        tuple(REPORTS.index(name) for name in track.split("-")) for track in drawing.split()
    )


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """What a tracker says of the example, scan by scan."""

    problems: tuple[AssignmentProblem, ...]
    hypotheses: tuple[Tracks, ...]
    amendments: tuple[tuple[Amendment, ...], ...]


def run_example(depth: int, rng: np.random.Generator, solver: Solver | None = None) -> Run:
    """Track the example's three scans."""
    asked = Recorded(solver or BestHypothesis())
    tracker = MultiHypothesisTracker(
        motion=MOTION, sensors=[SENSOR], window=Window(depth), search=asked,
        lifecycle=Lifecycle(new_target_density=1e-6), limits=document_growth(), estimate="best",
    )  # fmt: skip
    said: dict[int, int] = {}
    hypotheses, amendments = [], []
    for time, places in enumerate(SCANS):
        found = tracker.step(Scan(float(time), SENSOR.name, np.array(places)), rng=rng)
        for known in (found.final, tracker.pending()):
            said |= dict(zip(known.report.tolist(), known.track.tolist(), strict=True))
        of_track: dict[int, list[int]] = {}
        for report, track in sorted(said.items()):
            of_track.setdefault(track, []).append(report)
        hypotheses.append(frozenset(tuple(track) for track in of_track.values()))
        amendments.append(found.amendments)
    return Run(tuple(asked.problems), tuple(hypotheses), tuple(amendments))


def decoded_figure(figure: str, run: Run) -> tuple[float, Tracks, bool]:
    """Return what a figure's string decodes to."""
    string, drawing = FIGURES[figure]
    order = [REPORTS.index(name) for name in string.split("-")]
    problem = next(each for each in run.problems if each.n_items == len(order))
    cost, tracks = decoded(problem, order)
    return cost, frozenset(tracks), frozenset(tracks) == tracks_of(drawing)


def least_cost_with(
    figure: str, problem: AssignmentProblem, rng: np.random.Generator
) -> tuple[float, Tracks]:
    """Return the best hypothesis that says of the first two scans what a figure says."""
    early = [track for track in tracks_of(FIGURES[figure][1]) if track[0] < len(SCANS[0])]
    last = min(problem.n_items, len(SCANS[0]) + len(SCANS[1]))
    said = {tuple(item for item in track if item < last) for track in early}
    total = problem.total.copy()
    for node in range(problem.n_nodes):
        known = tuple(item for item in sequence(problem, node) if item < last)
        # A report of its own track must stand somewhere, be it at a price that no answer pays.
        if known and known not in said:
            total[node] = FORBIDDEN if problem.parent[node] < 0 else np.inf
    answer = BestHypothesis()(replace(problem, total=total), rng=rng)
    tracks = frozenset(sequence(problem, int(node)) for node in answer.nodes)
    return answer.cost if answer.cost < FORBIDDEN / 2 else np.inf, tracks


def drawn(rng: np.random.Generator, quick: bool, tick: Tick) -> dict[str, Table]:
    """Return what is certain: the drawings, the crossover's example, an early choice."""
    window = run_example(5, rng)
    runs = {
        "five scans": window,
        "one scan": run_example(1, rng),
        "five scans, searched": run_example(5, rng, document_search()),
    }
    figures = [
        (figure, FIGURES[figure][0], FIGURES[figure][1], name_of(tracks), cost)
        for figure in FIGURES
        for cost, tracks, _ in [decoded_figure(figure, window)]
    ]
    early = [
        (scan + 1, figure, cost if np.isfinite(cost) else None, name_of(tracks))
        for scan, problem in enumerate(window.problems)
        for figure in "123"
        for cost, tracks in [least_cost_with(figure, problem, rng)]
    ]
    said = [
        (name, scan + 1, name_of(tracks), _amended(run.amendments[scan]))
        for name, run in runs.items()
        for scan, tracks in enumerate(run.hypotheses)
    ]
    tick(1, 1)
    return {
        "figures": frame(
            ("figure", "string", "drawing", "decoded", "cost [nats]"), tuple(figures)
        ),
        "strings": frame(("strings", "hypotheses", "best"), (_distinct(window.problems[1]),)),
        "children": frame(("first", "second"), (_children(),)),
        "example": frame(("scans", "as in Figure", "cost [nats]", "tracks"), tuple(early)),
        "said": frame(("window", "scans", "tracks", "amended"), tuple(said)),
    }


def _amended(amendments: Iterable[Amendment]) -> str | None:
    words = [f"{REPORTS[a.report]}: track {a.before} to {a.after}" for a in amendments]
    return ", ".join(words) or None


def _distinct(problem: AssignmentProblem) -> tuple[int, int, int]:
    """Return how many strings there are, hypotheses they decode to, and best strings."""
    found = [decoded(problem, list(order)) for order in permutations(range(problem.n_items))]
    least = min(cost for cost, _ in found)
    best = sum(cost <= least + 1e-6 for cost, _ in found)
    return len(found), len({frozenset(tracks) for _, tracks in found}), best


def _children() -> tuple[str, str]:
    """Return the children of the patent's example of a crossover."""
    first, second = np.array([1, 2, 3, 4, 5, 6]), np.array([3, 4, 1, 2, 6, 5])
    seen, children = np.zeros(7, dtype=np.bool_), np.empty((2, 6), dtype=np.int64)
    crossover(first, second, 3, seen, children[0])
    crossover(second, first, 3, seen, children[1])
    return "-".join(map(str, children[0].tolist())), "-".join(map(str, children[1].tolist()))
