"""What each part of the search gains: with it and without it, on the same problems, in turn.

Each way runs in turn with the other, and the least CPU time of its turns counts.
"""

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from bench_data import Bench, add_arguments, bench_of
from gains_parts import (
    GrownAnew,
    Problems,
    Wide,
    WithoutPrices,
    followed,
    paired,
    wide_run,
    windows_of,
)
from simulated_scenes import rotating
from solvers_families import ENDLESS, Clock
from text_tables import command, heading, table

from trackweave import MultiHypothesisTracker
from trackweave.association._clusters import partition
from trackweave.association.problem import AssignmentProblem, Status
from trackweave.solvers import Annealing, Auto, Dual, Genetic, Hint
from trackweave.solvers._kernels import part_of
from trackweave.solvers.genetic._decoding import Lookup, evaluate
from trackweave.solvers.genetic._operators import breed, random_population
from trackweave.solvers.genetic.report_genes import fresh_trail, make_lookup
from trackweave.solvers.relaxation import Relaxation
from trackweave.solvers.warming import warm_up

Row = list[Any]
HEAD = ["part", "where", "with it", "without", "gain", "answers"]
POPULATION, GENERATIONS = 50, 20


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    add_arguments(parser, seeds=2)
    parser.add_argument("--times", type=int, default=3, help="turns of each way")
    parser.add_argument("--aircraft", type=int, default=2000, help="in the wide scene")
    arguments = parser.parse_args()
    bench = bench_of(arguments)
    for solver in (Auto(), Dual(), Genetic(), Genetic(seeded=False), Annealing(seeded=False)):
        warm_up(solver, np.random.default_rng(0))
    rows: list[Row] = []
    for targets, depth in ((20, 5), (20, 7), (100, 5), (100, 7)):
        rows.append(reuse(bench, targets, depth, arguments.times))
    windows = {
        f"T{targets}": windows_of(bench.scene(targets, 1, 1))[8:] for targets in (20, 50, 100)
    }
    scene = rotating(1, aircraft=arguments.aircraft, seconds=30.0)
    wide = wide_run(scene.reports, scene.config)
    windows["wide"] = wide.problems
    rows.append(inactive_clusters(scene, wide))
    rows += of_solvers(windows, arguments.times)
    for targets in (20, 100):
        rows.append(beliefs_prices(bench, targets, arguments.times))
    for name in ("T20", "T100"):
        for method, solver in (("genes", Genetic), ("annealing", Annealing)):
            rows.append(dual_first(f"{name}, {method}", windows[name], solver))
    print(heading(command("gains.py")), end="\n\n")
    print(
        f"Wide: sectors of ten turning radars, {arguments.aircraft} aircraft. Milliseconds a scan."
    )
    print()
    print(table(HEAD, rows))


def of_solvers(windows: dict[str, Problems], times: int) -> list[Row]:
    """Return the rows of what solvers do with the windows' problems."""
    return [
        *(shared_beginnings(name, windows[name][-1][0], times) for name in ("T20", "T50", "T100")),
        *(apart(name, problems, times) for name, problems in windows.items()),
        *(searched_apart(name, windows[name]) for name in ("T50", "T100")),
        *(hinted(name, problems, times) for name, problems in windows.items()),
        *(hurried("T100", windows["T100"], milliseconds) for milliseconds in (1.0, 2.0)),
    ]


def reuse(bench: Bench, targets: int, depth: int, times: int) -> Row:
    """Return what keeping the tree from scan to scan gains."""
    scene = bench.scene(targets, 1, 1)
    kinds = (MultiHypothesisTracker, GrownAnew)
    ways = [lambda kind=kind: followed(kind, scene, depth) for kind in kinds]
    (_, kept), (_, anew) = paired(ways, times)
    gospa = [bench.score(scene, way.rows)["gospa"] for way in (kept, anew)]
    return _row(
        ("tree kept from scan to scan", f"T{targets}, window {depth}"), kept.cpu, anew.cpu,
        f"GOSPA {gospa[0]:.1f}, {gospa[1]:.1f}", scene.n_scans,
    )  # fmt: skip


def shared_beginnings(name: str, problem: AssignmentProblem, times: int) -> Row:
    """Return what decoding only the part of a child that is new gains, in the whole window."""
    parts = partition(problem.parent, problem.item, problem.total, problem.must_cover, True)
    component = part_of(parts, 0)
    lookup = make_lookup(component, problem.cost[parts.node], problem.instant[parts.item_of], True)
    generations = _generations(component, lookup)

    def decode(*, each: bool) -> Any:
        costs = []
        for population, order in generations:
            cost = np.empty(population.shape[0])
            selection = np.empty(component.must.shape[0], dtype=np.int64)
            for rows in np.split(order, order.shape[0]) if each else [order]:
                trail = fresh_trail(component, population.shape[1])
                evaluate(component, lookup, True, population, rows, trail, cost, selection, np.inf)
            costs.append(cost)
        return np.concatenate(costs)

    (shared, first), (alone, second) = paired(
        [lambda: decode(each=False), lambda: decode(each=True)], times
    )
    n_decoded = POPULATION * GENERATIONS
    same = "same" if np.array_equal(first, second) else "DIFFERENT"
    unit = f"{1e6 * shared / n_decoded / lookup.gene_item.shape[0]:.2f} µs a report"
    return _row(
        ("shared beginnings decoded once", f"{name}, {lookup.gene_item.shape[0]} reports"),
        shared, alone, f"{same}; {unit}; ms a decode", n_decoded,
    )  # fmt: skip


def _generations(component: Any, lookup: Lookup) -> list[tuple[Any, Any]]:
    """Return the populations of a genetic search, and the orders in which they are decoded."""
    rng, n_genes = np.random.default_rng(1), lookup.gene_item.shape[0]
    population = np.empty((POPULATION, n_genes), dtype=np.int64)
    random_population(component, lookup, True, rng, 0, population)
    order, found = np.arange(POPULATION), []
    for _ in range(GENERATIONS):
        found.append((population, order))
        cost = np.empty(POPULATION)
        selection = np.empty(component.must.shape[0], dtype=np.int64)
        trail = fresh_trail(component, n_genes)
        evaluate(component, lookup, True, population, order, trail, cost, selection, np.inf)
        offspring, key = np.empty_like(population), np.empty(POPULATION, dtype=np.int64)
        breed(
            component, lookup, True, population, cost, np.array([0.8, 0.5]), 1, 1, rng, offspring,
            key,
        )  # fmt: skip
        population, order = offspring, np.argsort(key, kind="stable")
    return found


def apart(name: str, problems: Problems, times: int) -> Row:
    """Return what solving components apart gains, to the proof."""

    def solve(*, whole: bool) -> Callable[[], Any]:
        return lambda: [
            Dual().relax(Relaxation.of(p, None, whole=whole), None)[0].answer(0, "")
            for p, _ in problems
        ]

    (ours, first), (theirs, second) = paired([solve(whole=False), solve(whole=True)], times)
    return _row(("components apart", name), ours, theirs, _compared(first, second), len(problems))


def searched_apart(name: str, problems: Problems) -> Row:
    """Return what a search gains from components apart: what it comes to in the same CPU time."""
    apart, whole, cpu = [], [], [0.0, 0.0]
    unlimited = Annealing(seeded=False, decompose=False, evaluations=ENDLESS, patience=ENDLESS)
    for problem, _ in problems[::5]:
        begun = time.process_time()
        rngs = [np.random.default_rng(1) for _ in range(2)]
        apart.append(Annealing(seeded=False, evaluations=5_000)(problem, rng=rngs[0]))
        between = time.process_time()
        whole.append(unlimited(problem, rng=rngs[1], stop=Clock(between - begun)))
        cpu[0] += between - begun
        cpu[1] += time.process_time() - between
    compared = _compared(apart, whole)
    row = _row(("components apart, annealing alone", name), *cpu, compared, len(apart))
    return [*row[:4], "same time", row[-1]]


def hinted(name: str, problems: Problems, times: int) -> Row:
    """Return what the prices of the window before gain."""

    def solve(*, with_prices: bool) -> Callable[[], Any]:
        return lambda: [
            Auto()(
                p, rng=np.random.default_rng(1),
                hint=Hint(hint.prices if with_prices and hint else None, hint and hint.nodes),
            )
            for p, hint in problems
        ]  # fmt: skip

    (ours, first), (theirs, second) = paired(
        [solve(with_prices=True), solve(with_prices=False)], times
    )
    return _row(
        ("prices of the window before", name),
        ours,
        theirs,
        _compared(first, second),
        len(problems),
    )


def hurried(name: str, problems: Problems, milliseconds: float) -> Row:
    """Return what the prices of the window before gain where time is short: mean gaps."""
    gaps = [
        np.mean(
            [
                Auto()(
                    problem, rng=np.random.default_rng(1), stop=Clock(milliseconds / 1e3),
                    hint=Hint(hint.prices if with_prices and hint else None, hint and hint.nodes),
                ).gap
                for problem, hint in problems
            ]
        )
        for with_prices in (True, False)
    ]  # fmt: skip
    what = f"{name}, {milliseconds:g} ms a scan"
    told = [f"gap {100 * gap:.2f} %" for gap in gaps]
    return ["prices of the window before", what, *told, f"{gaps[1] / gaps[0]:.2f} ×", ""]


def beliefs_prices(bench: Bench, targets: int, times: int) -> Row:
    """Return what growth gains from knowing which reports others want."""
    scene = bench.scene(targets, 1, 1)
    kinds = (MultiHypothesisTracker, WithoutPrices)
    ways = [lambda kind=kind: followed(kind, scene, 7) for kind in kinds]
    (_, priced), (_, plain) = paired(ways, times)
    gospa = [bench.score(scene, way.rows)["gospa"] for way in (priced, plain)]
    return _row(
        ("prices in growth", f"T{targets}, window 7"), priced.cpu, plain.cpu,
        f"GOSPA {gospa[0]:.1f}, {gospa[1]:.1f}; sequences {priced.n_sequences:.0f}, "
        f"{plain.n_sequences:.0f}", scene.n_scans,
    )  # fmt: skip


def dual_first(name: str, problems: Problems, solver: Any) -> Row:
    """Return what the dual before a search gains: CPU time, and where each comes to."""
    some = problems[::5]

    def solve(*, seeded: bool) -> Callable[[], Any]:
        return lambda: [
            solver(seeded=seeded, evaluations=4_000)(p, rng=np.random.default_rng(1))
            for p, _ in some
        ]

    (ours, first), (theirs, second) = paired([solve(seeded=True), solve(seeded=False)], 1)
    compared = _compared(first, second)
    return _row(("the dual before a search", name), ours, theirs, compared, len(some))


def inactive_clusters(scene: Any, wide: Wide) -> Row:
    """Return what leaving alone what no scan concerns gains."""
    every = wide_run(scene.reports, scene.config, inactive_clusters=False)
    off = max(abs(a - b) for a, b in zip(wide.n_tracks, every.n_tracks, strict=True))
    sizes = [np.mean([p.n_nodes for p, _ in run.problems]) for run in (wide, every)]
    return _row(
        ("inactive clusters", "wide"), wide.cpu, every.cpu,
        f"at most {off} of {np.mean(every.n_tracks):.0f} tracks more or fewer; sequences "
        f"{sizes[0]:.0f}, {sizes[1]:.0f}; solving takes {100 * wide.solving / wide.cpu:.0f} %, "
        f"{100 * every.solving / every.cpu:.0f} % of it", len(wide.problems),
    )  # fmt: skip


def _compared(first: list[Any], second: list[Any]) -> str:
    """Return how far two ways' answers lie apart, and how many each proves."""
    proven = [
        f"{100 * np.mean([a.status == Status.OPTIMAL for a in way]):.0f} %"
        for way in (first, second)
    ]
    loss = max(b.cost - a.cost for a, b in zip(first, second, strict=True))
    same = "same costs" if abs(loss) < 1e-6 else f"up to {loss:.1f} nats dearer without"
    return f"{same}; proven {proven[0]}, {proven[1]}"


def _row(what: tuple[str, str], ours: float, theirs: float, answers: str, scans: int) -> Row:
    per = 1e3 / scans
    gain = f"{theirs / ours:.2f} ×"
    return [*what, f"{per * ours:.3g} ms", f"{per * theirs:.3g} ms", gain, answers]


if __name__ == "__main__":
    main()
