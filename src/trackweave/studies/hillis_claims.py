"""What the patent says, and what came out."""

from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.solvers.genetic._operators import crossover
from trackweave.studies import Claim
from trackweave.studies.hillis_example import FIGURES, REPORTS, Run, decoded_figure, name_of
from trackweave.studies.hillis_parts import Table

__all__ = ["Findings", "claims_of"]

NEAR = 1.0
"""A hypothesis is close to the best there is within this [nats]: less than e times less likely."""
OFTEN = 95.0
"""What counts as finding the best hypothesis [% of windows]."""
ALIKE = 5.0
"""Shares within this of each other are alike [points of per cent]."""


@dataclass(frozen=True, slots=True, eq=False)
class Findings:
    """What claims are judged by.

    Parameters
    ----------
    window, one, searched
        The example with a window of five scans and of one, exactly solved, and searched as the
        patent does.
    strings
        Number of strings of the first two scans, of hypotheses, and of best strings.
    tables
        The parts' numbers.
    whole, ordered
        Whether interrupted searches gave whole hypotheses, and later ones none that was worse.
    alike
        Whether islands gave the same hypotheses on any number of threads.
    """

    window: Run
    one: Run
    searched: Run
    strings: tuple[int, int, int]
    tables: dict[str, Table]
    whole: bool
    ordered: bool
    alike: bool


def claims_of(found: Findings) -> tuple[Claim, ...]:
    """Return the patent's claims with what came out of each.

    Parameters
    ----------
    found
        The study's findings.

    Returns
    -------
    The claims in the report's order.
    """
    return (
        *(_figure(number, found.window) for number in FIGURES),
        _mapping(found.strings),
        _crossing(),
        *_early_choice(found),
        *_window(found.tables["depths"]),
        *_sizes(found.tables["sizes"]),
        *_stops(found),
        _alone(found.tables["arrivals"]),
        _islands(found),
    )  # fmt: skip


def _figure(number: str, run: Run) -> Claim:
    cost, tracks, is_drawing = decoded_figure(number, run)
    string = FIGURES[number][0]
    misprint = " (as printed it names D1,0 twice)" if number == "1" else ""
    return Claim(
        f"Figure {number} is encoded by {string}{misprint}", is_drawing,
        f"The string decodes to {name_of(tracks)}, at {cost:.2f} nats.",
    )  # fmt: skip


def _mapping(strings: tuple[int, int, int]) -> Claim:
    every, different, best = strings
    return Claim(
        "The mapping of strings to hypotheses is not one to one", different < every,
        f"The {every} strings of the five detections decode to {different} hypotheses, {best} of "
        "them to the best.",
    )  # fmt: skip


def _crossing() -> Claim:
    first, second = np.array([1, 2, 3, 4, 5, 6]), np.array([3, 4, 1, 2, 6, 5])
    seen = np.zeros(7, dtype=np.bool_)
    children = np.empty((2, 6), dtype=np.int64)
    crossover(first, second, 3, seen, children[0])
    crossover(second, first, 3, seen, children[1])
    words = ["-".join(map(str, child)) for child in children.tolist()]
    return Claim(
        "1-2-3-4-5-6 and 3-4-1-2-6-5, cut after the third point, have the children 1-2-3-4-6-5 "
        "and 3-4-1-2-5-6", words == ["1-2-3-4-6-5", "3-4-1-2-5-6"],
        f"They have {words[0]} and {words[1]}.",
    )  # fmt: skip


def _early_choice(found: Findings) -> tuple[Claim, ...]:
    costs = found.tables["example"]
    second, third = costs.column("as in Figure 2 [nats]"), costs.column("as in Figure 3 [nats]")
    best = decoded_figure("4", found.window)[1]
    amended = [
        f"{REPORTS[each.report]} from track {each.before} to track {each.after} after scan {scan}"
        for scan, scan_amended in enumerate(found.searched.amendments, start=1)
        for each in scan_amended
    ]
    return (
        Claim(
            "A hypothesis with a relatively poor score at an early scan may lead to the best one "
            "at a later scan", bool(third[1] > second[1] and third[2] < second[2]),
            f"After two scans Figure 3 costs {third[1] - second[1]:.2f} nats more than Figure 2; "
            f"after three what goes on from it, Figure 4, costs {second[2] - third[2]:.2f} less.",
        ),
        Claim(
            "The best assignment of each scan by itself need not be the best across scans",
            found.one.hypotheses[-1] != best,
            f"With a window of one scan the tracks are {name_of(found.one.hypotheses[-1])}.",
        ),
        Claim(
            "Later hypotheses may amend earlier ones with more data",
            found.searched.hypotheses[-1] == best and bool(amended),
            f"With the window the search ends with {name_of(found.searched.hypotheses[-1])}; "
            f"amended: {', '.join(amended) or 'nothing'}.",
        ),
    )  # fmt: skip


def _means(table: Table, measure: str, method: str, depth: int) -> FloatArray:
    return table.column(measure, method=method, depth=depth)


def _window(table: Table) -> tuple[Claim, ...]:
    methods = ("document", "its best", "exact", "default")
    gains = {
        method: (
            _means(table, "right [%]", method, 5) - _means(table, "right [%]", method, 1),
            _means(table, "switches", method, 5) - _means(table, "switches", method, 1),
        )
        for method in methods
    }
    words = [
        f"{method} {gain.mean():+.1f} points of reports and {switches.mean():+.1f} switches"
        for method, (gain, switches) in gains.items()
    ]
    best = gains["exact"][0]
    error = float(best.std() / np.sqrt(best.size))
    excess = _means(table, "excess [nats]", "document", 5)
    at_best = _means(table, "at the best [%]", "document", 5)
    shallow = int(table.column("depth").min())
    first = _means(table, "excess [nats]", "document", shallow)
    return (
        Claim(
            "Several scans resolve what one cannot, if each window's best hypothesis is found",
            None if abs(best.mean()) <= 2.0 * error else bool(best.mean() > 0.0),
            "Right reports and switches with five scans, beside one: "
            + "; ".join(words) + f". Standard error of exact's gain: {error:.1f} points.",
        ),
        Claim(
            "So it does with the patent's own search and numbers of ours",
            bool(gains["document"][0].mean() > 0.0),
            f"Right reports with five scans: "
            f"{_means(table, 'right [%]', 'document', 5).mean():.1f} %; with one: "
            f"{_means(table, 'right [%]', 'document', 1).mean():.1f} %.",
        ),
        Claim(
            "The search finds a good, though quite possibly sub-optimal hypothesis: within "
            f"{NEAR:g} nat of the best, on average, in windows of five scans of two sensors",
            bool(excess.mean() <= NEAR),
            f"It is {excess.mean():.1f} nats from it ({excess.min():.1f} to {excess.max():.1f} "
            f"over scenes) and finds it in {at_best.mean():.0f} % of the windows; with a window "
            f"of one scan it is {first.mean():.1f} nats from it.",
        ),
    )  # fmt: skip


def _sizes(table: Table) -> tuple[Claim, ...]:
    objects, share = table.column("objects"), table.column("document at the best [%]")
    excess = table.column("excess [nats]")
    settled, default = table.column("with false alarms [%]"), table.column("default genetic [%]")
    said = [
        f"{int(many)} objects: {best:.0f} %, {over:.1f} nats from it on average"
        for many, best, over in zip(objects, share, excess, strict=True)
    ]
    listed = ", ".join(f"{value:.0f}" for value in settled)
    return (
        Claim(
            "A population of random permutations finds the best hypothesis, for few objects "
            "and for many", bool(np.all(share >= OFTEN)),
            f"In full windows of one sensor it is found in – {'; '.join(said)}. Where lone "
            f"reports may be false alarms: {listed} %.",
        ),
        Claim(
            "Begun from prices, part by part and with improvement, a genetic search finds it "
            "for many objects too", bool(np.all(default >= OFTEN)),
            "Ours does in " + ", ".join(f"{value:.0f}" for value in default) + " %.",
        ),
    )  # fmt: skip


def _stops(found: Findings) -> tuple[Claim, ...]:
    generations, thresholds = found.tables["generations"], found.tables["thresholds"]
    names = [name for name in generations.head if name.endswith("best [nats]")]
    best = np.array([generations.column(name) for name in names])
    half = generations.column("generation").tolist().index(100)
    reached, after = thresholds.column("reached [%]"), thresholds.column("after generations")
    level, over = thresholds.column("threshold [nats]"), thresholds.column("excess [nats]")
    words = [
        f"{at:g} nats in {share:.0f} %"
        + (f" (after {when:.0f} generations, {far:.1f} nats from the best)" if share else "")
        for at, share, when, far in zip(level, reached, after, over, strict=True)
    ]
    stops = found.tables["interruptions"]
    looks, late = stops.column("looks"), stops.column("excess [nats]")
    return (
        Claim(
            "The search may end after a fixed number of generations: more find no worse",
            bool(np.all(np.diff(best, axis=1) <= 1e-9)),
            "Nats above the best there is after 1, 100 and 200 generations: "
            + "; ".join(
                f"{name.partition(',')[0]} {row[0]:.0f}, {row[half]:.1f}, {row[-1]:.1f}"
                for name, row in zip(names, best, strict=True)
            ) + ".",
        ),
        Claim(
            "It may end when fittest and mean differ by less than a threshold: the preset's is "
            f"reached within {int(generations.column('generation')[-1])} generations",
            bool(reached[0] > 50.0),
            f"Thresholds reached: {'; '.join(words)}.",
        ),
        Claim(
            "It may be interrupted by the next scan, and the fittest so far is a hypothesis",
            found.whole and found.ordered,
            "Every report is in one track of each interrupted answer, and a later one is no "
            "worse. Nats above the best there is after so many looks: "
            + ", ".join(f"{int(at)}: {far:.0f}" for at, far in zip(looks, late, strict=True))
            + ".",
        ),
    )  # fmt: skip


def _alone(table: Table) -> Claim:
    ordered, late = (table.column("alone right [%]", arrival=name) for name in ("in time", "late"))
    scans = table.column("of scans right [%]", arrival="in time")
    shuffled = table.column("of scans right [%]", arrival="late")
    without = table.column("of scans right [%]", arrival="none")
    less = np.stack([scans - ordered, shuffled - late, ordered - late])
    error = less.std(axis=1) / np.sqrt(less.shape[1])
    # So few come alone that chance alone may set them apart.
    is_alike, may_be = less.mean(axis=1) <= ALIKE, less.mean(axis=1) <= ALIKE + 2.0 * error
    return Claim(
        "Sensors need not scan: a report may come alone, at any time and in any order within "
        "the window", True if is_alike.all() else None if may_be.all() else False,
        f"Of the reports that come alone {ordered.mean():.1f} % are assigned rightly in order of "
        f"time and {late.mean():.1f} % out of it; of the scans' {without.mean():.1f} % without "
        f"them, {scans.mean():.1f} % and {shuffled.mean():.1f} % with them.",
    )  # fmt: skip


def _islands(found: Findings) -> Claim:
    table = found.tables["islands"]
    said = [f"{name}: {mean:.1f}" for name, mean, _ in table.rows]
    return Claim(
        "The search is spread over processors in the island model", found.alike,
        "Populations on islands that send each other their fittest give the same hypotheses on "
        f"one, two and four threads. Nats above the best there is – {'; '.join(said)}.",
    )  # fmt: skip
