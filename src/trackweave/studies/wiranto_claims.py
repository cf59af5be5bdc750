"""What Wiranto and Bonok (2018) say, and what one would expect of it, judged by the numbers."""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.studies import Claim
from trackweave.studies.wiranto_parts import PLOTS, SELECTED, SKIES, SMOOTHED, spread_of
from trackweave.studies.wiranto_plots import DEFAULT, DOCUMENT
from trackweave.studies.wiranto_tracks import IMM, LEGS, MULTISCAN, PAIRED, PRESET
from trackweave.studies.writing import Table

__all__ = ["claims_of"]

CLASSIFIED, GROUPED = "classified rightly [%]", "grouped rightly [%]"
OBJECTS, TRUE_NUMBER = "objects per scan", "scans with the true number [%]"
EXCESS, AT_LEAST = "above the least cost [nats]", "scans at the least cost [%]"
FIRST, DENSE, FORMATIONS = SKIES
RIGHTLY = 99.0
"""What share of the plots is to be classified rightly [%]."""
CLOSE_COUNT = 0.05
"""By what share the number of objects may be off."""
SIGNIFICANT = 2.0
"""Differences of more standard errors than this are not chance."""


def claims_of(sorting: Table, tracking: Table, courses: Table) -> tuple[Claim, ...]:
    """Return the claims in the order of the report.

    Parameters
    ----------
    sorting
        How rightly each method sorts plots, by sky and draw.
    tracking
        How well whole trackers follow, by draw.
    courses
        How far off the courses measurements and estimates are, by leg and draw.

    Returns
    -------
    The document's claims, then ours.
    """
    return (
        *_claims_of_sorting(sorting),
        *_claims_of_filter(courses),
        *_claims_of_default(sorting, tracking, courses),
    )


def _claims_of_sorting(sorting: Table) -> tuple[Claim, ...]:
    def found(name: str, method: str = DOCUMENT, sky: str = FIRST) -> FloatArray:
        return sorting.column(name, method=method, sky=sky)

    counts = {sky: found(OBJECTS, sky=sky) for sky in SKIES}
    off = {sky: counts[sky].mean() / SKIES[sky].n_objects - 1.0 for sky in SKIES}
    proven = sorting.column("scans proven best [%]", method="exact, eq. 1")
    ants, greedy = found(EXCESS), found(EXCESS, "greedy, eq. 1")
    ended = 100.0 - sorting.column("scans at the limit of cycles [%]", method=DOCUMENT)
    return (
        Claim(
            "“The Ant System algorithm is able to separate between true and false alarm” "
            "(abstract; here: 99 % of the plots of a sky as chosen)",
            bool(found(CLASSIFIED).mean() >= RIGHTLY),
            f"It classifies {spread_of(found(CLASSIFIED))} % of the plots rightly, and puts "
            f"{spread_of(found(GROUPED))} % into the right group. In dense clutter "
            f"{spread_of(found(CLASSIFIED, sky=DENSE))} %, with formations "
            f"{spread_of(found(CLASSIFIED, sky=FORMATIONS))} %.",
        ),
        Claim(
            "It tells the number of targets (introduction; here: on average within 5 %)",
            bool(abs(off[FIRST]) <= CLOSE_COUNT),
            f"{spread_of(counts[FIRST])} objects per scan of three; the true number in "
            f"{spread_of(found(TRUE_NUMBER))} % of the scans. Every "
            "aircraft is seen by two radars in "
            f"{spread_of(found('scans with all seen twice [%]'))} %; nothing tells one that is "
            "not from a false alarm.",
        ),
        Claim(
            "So it does in dense clutter", bool(abs(off[DENSE]) <= CLOSE_COUNT),
            f"{spread_of(counts[DENSE])} objects per scan of three, and "
            f"{spread_of(counts[FORMATIONS])} of nine with formations. The exact answer by eq. 1 "
            f"finds {spread_of(found(OBJECTS, 'exact, eq. 1', DENSE))}: it is the cost that draws "
            "false alarms together, because eq. 1 takes one false alarm in the whole field of "
            f"view for granted; by evidence it is {spread_of(found(OBJECTS, DEFAULT, DENSE))}.",
        ),
        Claim(
            "“To solve this problem required a heuristic method” (abstract)",
            bool(np.min(proven) < 100.0),
            f"The exact solver proves its answer best at {proven.mean():.4g} % of the instants of "
            "all skies; cpu.csv tells in what time.",
        ),
        Claim(
            "Ant colonies produce better solutions than other algorithms (introduction)",
            bool(ants.mean() < greedy.mean()),
            f"Its answers cost {spread_of(ants)} nats more than the exact ones (at these in "
            f"{spread_of(found(AT_LEAST))} % of the scans), greedy ones {spread_of(greedy)}; "
            f"with formations {spread_of(found(EXCESS, sky=FORMATIONS))} and "
            f"{spread_of(found(EXCESS, 'greedy, eq. 1', FORMATIONS))}.",
        ),
        Claim(
            "“Algorithm will stop when all the ants have the same route”",
            bool(np.min(ended) == 100.0),
            f"In {ended.mean():.4g} % of the scans of all skies; the others reach the limit of "
            "200 cycles.",
        ),
    )  # fmt: skip


def _claims_of_filter(courses: Table) -> tuple[Claim, ...]:
    straight, turn = LEGS[:2]

    def found(name: str, what: str, leg: str) -> FloatArray:
        return courses.column(name, what=what, leg=leg)

    rmse = {what: found("RMSE [m]", what, straight) for what in (PLOTS, SELECTED, PRESET)}
    scatter = {what: found("scatter [m]", what, turn) for what in (PLOTS, SELECTED, PRESET)}
    aside, before = (found("to the right [m]", PRESET, leg) for leg in (turn, straight))
    in_turn = {what: found("RMSE [m]", what, turn) for what in (PLOTS, SELECTED, PRESET)}
    return (
        Claim(
            "“For constan velocity targets the estimation results are better than the "
            "measurement results” (Figure 5)",
            bool(rmse[PRESET].mean() < min(rmse[PLOTS].mean(), rmse[SELECTED].mean())),
            f"RMSE {spread_of(rmse[PRESET])} m, beside {spread_of(rmse[PLOTS])} m of single plots "
            f"and {spread_of(rmse[SELECTED])} m of those that are selected and fused.",
        ),
        Claim(
            "“On maneuvered targets, the estimation is more precise” (Figure 6)",
            bool(scatter[PRESET].mean() < min(scatter[PLOTS].mean(), scatter[SELECTED].mean())),
            f"In the turn estimates scatter by {spread_of(scatter[PRESET])} m about their mean "
            f"offset, single plots by {spread_of(scatter[PLOTS])} m and fused ones by "
            f"{spread_of(scatter[SELECTED])} m. With the offset, the RMSE is "
            f"{spread_of(in_turn[PRESET])} m beside {spread_of(in_turn[PLOTS])} m and "
            f"{spread_of(in_turn[SELECTED])} m.",
        ),
        Claim(
            "“… but the estimated target trajectory shifts slightly” (Figure 6)",
            bool(_exceeds(aside, before)),
            f"It lies {spread_of(aside)} m outside of the turn, beside {spread_of(before)} m on "
            "the straight courses.",
        ),
    )


def _claims_of_default(sorting: Table, tracking: Table, courses: Table) -> tuple[Claim, ...]:
    def found(name: str, sky: str = FIRST) -> FloatArray:
        return sorting.column(name, method=DEFAULT, sky=sky)

    def run(name: str, tracker: str) -> FloatArray:
        return tracking.column(name, tracker=tracker)

    lone = found("aircraft seen by one radar [%]")
    left, taken = (
        found(f"{what} [%]")
        for what in ("aircraft left out though seen by more", "false alarms taken for aircraft")
    )
    whole = run(CLASSIFIED, MULTISCAN)
    false = "false tracks per scan"
    return (
        Claim(
            "Ours: choosing by evidence classifies 99 % of the plots rightly, instant by instant",
            bool(found(CLASSIFIED).mean() >= RIGHTLY),
            f"{spread_of(found(CLASSIFIED))} %, and {spread_of(found(GROUPED))} % grouped "
            f"rightly. What is wrong: {lone.mean():.2f} % are of aircraft that one radar sees, "
            f"which nothing tells at one instant, {left.mean():.2f} % of others left out, "
            f"{taken.mean():.2f} % false alarms near one another or near an aircraft. In dense "
            f"clutter {spread_of(found(CLASSIFIED, DENSE))} %, with formations "
            f"{spread_of(found(CLASSIFIED, FORMATIONS))} %.",
        ),
        Claim(
            "Ours: so does the default tracker, which compares plots over scans",
            bool(whole.mean() >= RIGHTLY),
            f"{spread_of(whole)} %; the preset's tracker {spread_of(run(CLASSIFIED, PRESET))} %.",
        ),
        Claim(
            "Ours: false tracks of the preset come of pairing each track with its nearest plot, "
            "whoever else takes it",
            bool(_exceeds(run(false, PRESET), run(false, PAIRED))),
            f"{spread_of(run(false, PRESET))} false tracks per scan; each plot to one track only, "
            f"{spread_of(run(false, PAIRED))}; default {spread_of(run(false, MULTISCAN))}.",
        ),
        _claim_of_imm(courses),
    )


def _claim_of_imm(courses: Table) -> Claim:
    right = {leg: courses.column("to the right [m]", what=IMM, leg=leg) for leg in LEGS}
    right[SMOOTHED] = courses.column("to the right [m]", what=SMOOTHED, leg=LEGS[1])
    document = courses.column("to the right [m]", what=PRESET, leg=LEGS[1])
    rmse = {what: courses.column("RMSE [m]", what=what, leg=LEGS[1]) for what in (IMM, PRESET)}
    behind = -courses.column("ahead [m]", what=IMM, leg=LEGS[1])
    kept = 100.0 * right[LEGS[1]].mean() / document.mean()
    return Claim(
        'Ours: `motion.model = "imm"` removes the displacement',
        not _exceeds(right[LEGS[1]], right[LEGS[0]]),
        f"{spread_of(right[LEGS[1]])} m remain in the turn ({kept:.0f} % of the preset's), "
        f"beside {spread_of(right[LEGS[0]])} m on straight courses, and it lags by "
        f"{spread_of(behind)} m; RMSE in the turn "
        f"{spread_of(rmse[IMM])} m beside {spread_of(rmse[PRESET])} m. In the history, smoothed "
        f"after the fact, {spread_of(right[SMOOTHED])} m.",
    )


def _exceeds(values: FloatArray, others: FloatArray) -> bool:
    """Return whether numbers exceed others of the same draws by more than chance."""
    more = values - others
    return bool(more.mean() > SIGNIFICANT * more.std() / np.sqrt(max(1, more.size - 1)))
