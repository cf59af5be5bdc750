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

__all__ = ["claims_of"]

CLASSIFIED, GROUPED = "classified rightly [%]", "grouped rightly [%]"
OBJECTS, EXCESS = "objects per scan", "above the least cost [nats]"
RIGHTLY, CLOSE_COUNT, ENDED = 99.0, 0.05, 99.0
FIRST, DENSE, FORMATIONS = SKIES
FEW, MANY, LETTER, STRONG = COLONIES


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
        Claim(
            "“The Ant System algorithm is able to separate between true and false alarm” "
            "(abstract)",
            at_least(right, RIGHTLY),
            f"Of the plots of a sky as chosen {right} are classified rightly, and "
            f"{found(GROUPED, unit='%')} are in the right group. In dense clutter "
            f"{found(CLASSIFIED, DENSE, unit='%')}, with formations "
            f"{found(CLASSIFIED, FORMATIONS, unit='%')}.",
            f"≥ {RIGHTLY:g} % of the plots (ours)",
        ),
        Claim(
            "“How to determine the correct number of targets” (introduction)",
            _within(count, *near),
            f"{count} objects per scan of three; the true number in "
            f"{found('scans with the true number [%]', unit='%')} of the scans. Every aircraft is "
            f"seen by two radars in {found('scans with all seen twice [%]', unit='%')} of them; "
            "nothing tells one that is not from a false alarm.",
            "± 5 % of the objects on average (ours)",
        ),
        Claim(
            "So it does in dense clutter", _within(dense, *near),
            f"{dense} objects per scan of three, and {found(OBJECTS, FORMATIONS)} of nine with "
            f"formations. The exact answer by eq. 1 finds {found(OBJECTS, DENSE, EXACT)}: it is "
            "the cost that draws false alarms together, not the search, because eq. 1 takes one "
            "false alarm in the whole field of view for granted. By evidence it is "
            f"{found(OBJECTS, DENSE, DEFAULT)}.",
            "± 5 % of the objects on average (ours)",
        ),
        Claim(
            "“To solve this problem required a heuristic method” (abstract)",
            verdict_of(exact["scans proven best"] < exact["scans"]),
            f"The exact solver proves its answer best at {proven} of the instants of all skies.",
            "an instant that exact solving leaves open (ours)",
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
        Claim(
            "Ant colonies produce “a better solution than other algorithms” (introduction, of "
            "salesmen)",
            at_most(beyond, 0.0),
            "With formations in dense clutter, at the curves' ends, nats above the exact answer: "
            f"{curve}; greedy {mean_of(values(GREEDY))}. The best colony, {best}, is {beyond} "
            f"above greedy. On skies as chosen the preset is {easy[LETTER]} above, greedy "
            f"{easy[GREEDY]}. Exact answers and our default are at 0. See the curves.",
            "no dearer than greedy answers where plots are many, with the best of four colonies "
            "(ours)",
        ),
        Claim(
            "“The number of ants determined arbitrarily”",
            at_most(fewer, 0.25),
            f"With formations in dense clutter {FEW} end {fewer} above {MANY}, which make ten "
            f"times as many tours. The preset's 3 N ants gain {late} from the last two "
            f"thirds of their tours. α matters as much: with α = 1 and β = 5 they end at "
            f"{mean_of(values(STRONG))}, not at {mean_of(values(LETTER))}.",
            "within 0.25 nats a scan of each other (ours)",
        ),
        Claim(
            "“Algorithm will stop when all the ants have the same route”", at_least(route, ENDED),
            f"In {route} of the scans of all skies; the others reach the limit of N cycles, "
            "because weak trails (α = ½) leave ants free. With α = 1, which gives dearer answers, "
            f"all have one route within 100 cycles in {agreed} of the scans.",
            f"≥ {ENDED:g} % of the scans (ours)",
        ),
        Claim(
            "“Total points visited by each ant in one cycle (N) = 1 + Σ n_i”",
            verdict_of(visited.low >= 100.0),
            f"The best tours visit {visited} of N points, at most {most:.3g} %: a point that is a "
            "tuple of several plots covers them all. N is reached where every plot stays alone, "
            "with the tuple of dummies counted. Nothing in eqs. 3 to 7 depends on it but the name "
            "of the time; here it sets the number of ants.",
            "every tour has N points (the document's)",
        ),
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
        Claim(
            "“For constan velocity targets the estimation results are better than the measurement "
            "results” (Figure 5)",
            at_most(less("RMSE [m]", straight), 0.0),
            f"RMSE {told('RMSE [m]', straight)}: by {less('RMSE [m]', straight)} from the better.",
            "RMSE below that of plots, single or fused (ours)",
        ),
        Claim(
            "“On maneuvered targets, the estimation is more precise” (Figure 6)",
            at_most(less("scatter [m]", turn), 0.0),
            "In the turn estimates scatter about their mean offset by "
            f"{told('scatter [m]', turn)}. With the offset, the RMSE is {told('RMSE [m]', turn)}.",
            "scatter below that of plots, single or fused (ours)",
        ),
        Claim(
            "“… but the estimated target trajectory shifts slightly from the actual target "
            "trajectory” (Figure 6)",
            _within(shift, 0.0, SIGMA),
            f"It lies {mean_of(aside, 'm')} outside of the turn, beside {mean_of(before, 'm')} on "
            f"the straight courses: a shift of {shift}.",
            f"above 0 and below the {SIGMA:g} m of a plot's σ (ours)",
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
        Claim(
            "Ours: choosing by evidence classifies plots rightly, instant by instant",
            at_least(found(CLASSIFIED), RIGHTLY),
            f"{found(CLASSIFIED)}, and {found(GROUPED)} grouped rightly. What is wrong: "
            f"{found('aircraft seen by one radar [%]')} are of aircraft that one radar sees, "
            "which nothing tells at one instant, "
            f"{found('aircraft left out though seen by more [%]')} of others left out, "
            f"{found('false alarms taken for aircraft [%]')} false alarms near one another or "
            f"near an aircraft. In dense clutter {found(CLASSIFIED, DENSE)}, with formations "
            f"{found(CLASSIFIED, FORMATIONS)}.",
            f"≥ {RIGHTLY:g} % of the plots (ours)",
        ),
        Claim(
            "Ours: so does the default tracker, which compares plots over scans",
            at_least(whole[MULTISCAN], RIGHTLY),
            f"{whole[MULTISCAN]}; the preset's tracker {whole[PRESET]}.",
            f"≥ {RIGHTLY:g} % of the plots (ours)",
        ),
        Claim(
            "Ours: the usable preset, `wiranto`, is as good as the default on this sky",
            at_least(usable, 0.0, 1.0),
            f"{whole[USABLE]} of the plots classified rightly, {usable} from the default's; "
            f"{mean_of(run(false, USABLE))} false tracks per scan, RMSE "
            f"{mean_of(run('RMSE [m]', USABLE), 'm')} beside "
            f"{mean_of(run('RMSE [m]', MULTISCAN), 'm')}.",
            "no fewer than the default, one percentage point is the tolerance (ours)",
        ),
        Claim(
            "Ours: false tracks of the preset come of pairing each track with its nearest plot, "
            "whoever else takes it",
            at_least(shared, 0.0),
            f"{mean_of(run(false, PRESET))} false tracks per scan; each plot to one track only, "
            f"{mean_of(run(false, PAIRED))}: {shared} fewer. Default "
            f"{mean_of(run(false, MULTISCAN))}.",
            "fewer with one-to-one pairing (ours)",
        ),
        Claim(
            'Ours: `motion.model = "imm"` removes the displacement',
            at_most(left, 0.0, 2.0),
            f"{mean_of(right(IMM, turn), 'm')} remain in the turn of the preset's "
            f"{mean_of(right(PRESET, turn), 'm')}, beside {mean_of(right(IMM, straight), 'm')} on "
            f"straight courses; RMSE in the turn {rmse[IMM]} beside {rmse[PRESET]}. In the "
            f"history, smoothed after the fact, {mean_of(right(SMOOTHED, turn), 'm')}.",
            "no more than on straight courses, 2 m is the tolerance (ours)",
        ),
    )
