"""What Wiranto and Bonok (2018) say, and what one would expect of it, judged by the tables."""

from collections.abc import Mapping

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.studies import Claim
from trackweave.studies.judging import (
    Interval,
    Verdict,
    at_least,
    at_most,
    mean_of,
    share_of,
    verdict_of,
)
from trackweave.studies.sentences import Sentences
from trackweave.studies.wiranto_plots import COLONIES, DEFAULT, DOCUMENT, EXACT, GREEDY
from trackweave.studies.wiranto_scenes import SIGMA, SKIES
from trackweave.studies.wiranto_tracks import (
    IMM,
    LEGS,
    MULTISCAN,
    PAIRED,
    PLOTS,
    PRESET,
    SELECTED,
    SMOOTHED,
    USABLE,
)  # fmt: skip
from trackweave.studies.writing import Table, numbers

__all__ = ["SAY", "claims_of"]

CLASSIFIED, GROUPED = "classified rightly [%]", "grouped rightly [%]"
OBJECTS, EXCESS = "objects per scan", "above the least cost [nats]"
RIGHTLY, CLOSE_COUNT, ENDED = 99.0, 0.05, 99.0
FIRST, DENSE, FORMATIONS = SKIES
FEW, MANY, LETTER, STRONG = COLONIES
SAY = Sentences("wiranto", rightly=RIGHTLY, ended=ENDED, sigma=SIGMA, few=FEW, many=MANY)


def claims_of(tables: Mapping[str, Table]) -> tuple[Claim, ...]:
    """Return the document's claims, then ours, in the order of the report."""
    return (
        *_of_sorting(tables["sorting"]),
        *_of_search(tables["sorting"], tables["search"]),
        *_of_filter(tables["courses"]),
        *_of_default(tables["sorting"], tables["tracking"], tables["courses"]),
    )


def _within(found: Interval, low: float, high: float) -> Verdict:
    """Tell whether a figure lies between two thresholds."""
    both = {at_least(found, low), at_most(found, high)}
    for verdict in (Verdict.DOES_NOT_HOLD, Verdict.CANNOT_BE_TOLD):
        if verdict in both:
            return verdict
    return Verdict.HOLDS


def _of_sorting(sorting: Table) -> tuple[Claim, ...]:
    def found(name: str, sky: str = FIRST, method: str = DOCUMENT, unit: str = "") -> Interval:
        return mean_of(numbers(sorting, name, method=method, sky=sky), unit)

    right, count, dense = found(CLASSIFIED, unit="%"), found(OBJECTS), found(OBJECTS, DENSE)
    n_true = SKIES[FIRST].n_objects
    near = (n_true * (1.0 - CLOSE_COUNT), n_true * (1.0 + CLOSE_COUNT))
    exact = {
        name: int(numbers(sorting, name, method=EXACT).sum())
        for name in ("scans", "scans proven best")
    }
    proven = share_of(exact["scans proven best"], exact["scans"])
    return (
        SAY.claim(
            "separates", at_least(right, RIGHTLY), right=right, grouped=found(GROUPED, unit="%"),
            in_clutter=found(CLASSIFIED, DENSE, unit="%"),
            with_formations=found(CLASSIFIED, FORMATIONS, unit="%"),
        ),
        SAY.claim(
            "count", _within(count, *near), count=count,
            true_number=found("scans with the true number [%]", unit="%"),
            seen_twice=found("scans with all seen twice [%]", unit="%"),
        ),
        SAY.claim(
            "count-in-clutter", _within(dense, *near), dense=dense,
            with_formations=found(OBJECTS, FORMATIONS), exact=found(OBJECTS, DENSE, EXACT),
            by_evidence=found(OBJECTS, DENSE, DEFAULT),
        ),
        SAY.claim(
            "heuristic", verdict_of(exact["scans proven best"] < exact["scans"]), proven=proven,
        ),
    )  # fmt: skip


def _of_search(sorting: Table, search: Table) -> tuple[Claim, ...]:
    last = int(numbers(search, "cycles").max())

    def values(name: str, cycles: int = last) -> FloatArray:
        cycles = 0 if name in {EXACT, GREEDY, DEFAULT} else cycles
        return numbers(search, EXCESS, sky=FORMATIONS, method=name, cycles=cycles)

    best = min(COLONIES, key=lambda name: float(values(name).mean()))
    beyond = mean_of(values(best) - values(GREEDY), "nats")
    fewer = mean_of(values(FEW) - values(MANY), "nats")
    late = mean_of(values(LETTER, 30) - values(LETTER), "nats")
    agreed = mean_of(numbers(search, "one route [%]", method=STRONG, cycles=last), "%")
    ended = [
        int(numbers(sorting, n, method=DOCUMENT).sum()) for n in ("scans with one route", "scans")
    ]
    route = share_of(*ended)
    visited = mean_of(numbers(sorting, "points visited of N [%]", method=DOCUMENT), "%")
    most = float(numbers(sorting, "most points visited of N [%]", method=DOCUMENT).max())
    curve = ", ".join(f"{name} {mean_of(values(name))}" for name in COLONIES)
    easy = {
        name: mean_of(numbers(search, EXCESS, sky=FIRST, method=name, cycles=cycles))
        for name, cycles in ((LETTER, last), (GREEDY, 0))
    }
    return (
        SAY.claim(
            "colonies", at_most(beyond, 0.0), curve=curve, greedy=mean_of(values(GREEDY)),
            best=best, beyond=beyond, easy_preset=easy[LETTER], easy_greedy=easy[GREEDY],
        ),
        SAY.claim(
            "ants", at_most(fewer, 0.25), fewer=fewer, late=late, strong=mean_of(values(STRONG)),
            preset=mean_of(values(LETTER)),
        ),
        SAY.claim("one-route", at_least(route, ENDED), route=route, agreed=agreed),
        SAY.claim("points", verdict_of(visited.low >= 100.0), visited=visited, most=most),
    )  # fmt: skip


def _of_filter(courses: Table) -> tuple[Claim, ...]:
    def found(name: str, what: str, leg: str) -> FloatArray:
        return numbers(courses, name, what=what, leg=leg)

    def told(name: str, leg: str) -> str:
        means = {what: mean_of(found(name, what, leg), "m") for what in (PRESET, PLOTS, SELECTED)}
        return (
            f"{means[PRESET]}, beside {means[PLOTS]} of single plots and {means[SELECTED]} of "
            "those that are selected and fused"
        )

    def less(name: str, leg: str) -> Interval:
        better = np.minimum(found(name, PLOTS, leg), found(name, SELECTED, leg))
        return mean_of(found(name, PRESET, leg) - better, "m")

    straight, turn = LEGS
    aside, before = (found("to the right [m]", PRESET, leg) for leg in (turn, straight))
    shift = mean_of(aside - before, "m")
    return (
        SAY.claim(
            "straight",
            at_most(less("RMSE [m]", straight), 0.0),
            told=told("RMSE [m]", straight),
            less=less("RMSE [m]", straight),
        ),
        SAY.claim(
            "turn",
            at_most(less("scatter [m]", turn), 0.0),
            scatter=told("scatter [m]", turn),
            rmse=told("RMSE [m]", turn),
        ),
        SAY.claim(
            "shift",
            _within(shift, 0.0, SIGMA),
            aside=mean_of(aside, "m"),
            before=mean_of(before, "m"),
            shift=shift,
        ),
    )


def _of_default(sorting: Table, tracking: Table, courses: Table) -> tuple[Claim, ...]:
    def found(name: str, sky: str = FIRST) -> Interval:
        return mean_of(numbers(sorting, name, method=DEFAULT, sky=sky), "%")

    def run(name: str, tracker: str) -> FloatArray:
        return numbers(tracking, name, tracker=tracker)

    def right(what: str, leg: str) -> FloatArray:
        return numbers(courses, "to the right [m]", what=what, leg=leg)

    false, straight, turn = "false tracks per scan", *LEGS
    whole = {name: mean_of(run(CLASSIFIED, name), "%") for name in (MULTISCAN, USABLE, PRESET)}
    usable = mean_of(run(CLASSIFIED, USABLE) - run(CLASSIFIED, MULTISCAN), "points")
    shared = mean_of(run(false, PRESET) - run(false, PAIRED))
    left = mean_of(right(IMM, turn) - right(IMM, straight), "m")
    rmse = {
        what: mean_of(numbers(courses, "RMSE [m]", what=what, leg=turn), "m")
        for what in (IMM, PRESET)
    }
    return (
        SAY.claim(
            "ours-evidence",
            at_least(found(CLASSIFIED), RIGHTLY),
            classified=found(CLASSIFIED),
            grouped=found(GROUPED),
            seen_once=found("aircraft seen by one radar [%]"),
            left_out=found("aircraft left out though seen by more [%]"),
            taken=found("false alarms taken for aircraft [%]"),
            in_clutter=found(CLASSIFIED, DENSE),
            with_formations=found(CLASSIFIED, FORMATIONS),
        ),
        SAY.claim(
            "ours-tracker",
            at_least(whole[MULTISCAN], RIGHTLY),
            default=whole[MULTISCAN],
            preset=whole[PRESET],
        ),
        SAY.claim(
            "ours-usable",
            at_least(usable, 0.0, 1.0),
            right=whole[USABLE],
            usable=usable,
            false_tracks=mean_of(run(false, USABLE)),
            rmse=mean_of(run("RMSE [m]", USABLE), "m"),
            default_rmse=mean_of(run("RMSE [m]", MULTISCAN), "m"),
        ),
        SAY.claim(
            "ours-pairing",
            at_least(shared, 0.0),
            preset=mean_of(run(false, PRESET)),
            paired=mean_of(run(false, PAIRED)),
            shared=shared,
            default=mean_of(run(false, MULTISCAN)),
        ),
        SAY.claim(
            "ours-imm",
            at_most(left, 0.0, 2.0),
            imm=mean_of(right(IMM, turn), "m"),
            preset=mean_of(right(PRESET, turn), "m"),
            straight=mean_of(right(IMM, straight), "m"),
            imm_rmse=rmse[IMM],
            preset_rmse=rmse[PRESET],
            smoothed=mean_of(right(SMOOTHED, turn), "m"),
        ),
    )
