"""Windows as the tracker meets them on the bench: the search of each scan beside HiGHS."""

import argparse
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from bench_data import Scene, add_arguments, bench_of
from runs import CONFIGURATION, configuration_for, priors_of, reports_of
from solvers_families import SEED, solver_named, warm_up
from solvers_highs import Columns, columns_of_problem, mixed_integer
from text_tables import command, heading, table

from trackweave import MultiHypothesisTracker, read_reports, solve
from trackweave.association.problem import Answer, AssignmentProblem, Status
from trackweave.config import load_configuration
from trackweave.io.tracks_in import read_priors
from trackweave.run.tracking import settings_for
from trackweave.solvers import Hint, Stop

SIZES = (20, 50, 100)
LIMIT = 30.0


@dataclass
class Collector:
    """The default solver, which keeps every problem and hint that it is given."""

    met: list[tuple[AssignmentProblem, Hint | None]] = field(default_factory=list)

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: np.random.Generator,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Answer:
        """Return the default solver's answer."""
        self.met.append((problem, hint))
        return solve(problem, rng=rng, hint=hint, stop=stop)


def collected(scene: Scene, *, priors: bool) -> list[tuple[AssignmentProblem, Hint | None]]:
    """Return the windows of a scene of the bench, scan by scan."""
    table_read = read_reports(reports_of(scene))
    settings = settings_for(
        table_read, load_configuration(configuration_for(scene, CONFIGURATION, {}))
    )
    collector = Collector()
    tracker = MultiHypothesisTracker(
        motion=settings.motion,
        sensors=list(settings.sensors),
        window=settings.window,
        search=collector,
        lifecycle=settings.lifecycle,
        priors=read_priors(priors_of(scene), table_read.frame) if priors else None,
        limits=settings.growth,
        estimate=settings.estimate,
    )
    rng = np.random.default_rng(scene.seed)
    for scan in table_read.scans():
        tracker.step(scan, rng=rng)
    return collector.met


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser, seeds=1)
    parser.add_argument("--solvers", nargs="+", default=["default", "Dual", "Exact"])
    parser.add_argument("--highs", type=int, default=5, help="windows of each scene for HiGHS")
    arguments = parser.parse_args()
    if not (arguments.bench / "gen.py").exists():
        print("Skipped: no bench beside the checkout.")
        return
    bench = bench_of(arguments)
    solvers = {name: solver_named(name) for name in arguments.solvers}
    warm_up(*solvers.values())
    rows = []
    for targets in SIZES:
        for priors in (True, False):
            windows = collected(bench.scene(targets, 1, arguments.first), priors=priors)
            name = f"T{targets}, {'priors' if priors else 'none'}"
            rows += _rows(name, windows, solvers, arguments.highs)
    print(heading(command("solvers_windows.py")), end="\n\n")
    head = ["scene, start", "sequences, median", "most", "solver", "scans with the gap closed",
            "greatest gap", "CPU ms/scan, mean", "greatest", "scans beside HiGHS",
            "HiGHS ms/scan, mean", "ours there", "HiGHS ÷ ours"]  # fmt: skip
    print(table(head, rows))


def _rows(name: str, windows: list[Any], solvers: dict[str, Any], n_highs: int) -> list[list[Any]]:
    chosen = np.unique(np.linspace(4, len(windows) - 1, n_highs).astype(int))
    theirs = {number: _highs(windows[number][0]) for number in chosen.tolist()}
    sizes = [problem.n_nodes for problem, _ in windows]
    rows: list[list[Any]] = []
    for solver_name, solver in solvers.items():
        for problem, hint in windows[:3]:
            solve(problem, solver, rng=np.random.default_rng(SEED), hint=hint)
        runs = [_ours(problem, hint, solver) for problem, hint in windows]
        cpu = np.array([seconds for _, seconds in runs])
        closed = np.mean([answer.status == Status.OPTIMAL for answer, _ in runs])
        for number, (cost, bound, _) in theirs.items():
            _compare(f"{name}, scan {number}", runs[number][0], cost, bound)
        their_cpu = float(np.mean([seconds for _, _, seconds in theirs.values()]))
        our_cpu = float(np.mean(cpu[chosen]))
        rows.append([
            name, int(np.median(sizes)), max(sizes), solver_name, f"{100 * closed:.0f} %",
            f"{max(answer.gap for answer, _ in runs):.1e}", 1e3 * float(cpu.mean()),
            1e3 * float(cpu.max()), len(theirs), 1e3 * their_cpu, 1e3 * our_cpu,
            their_cpu / our_cpu,
        ])  # fmt: skip
    return rows


def _ours(problem: AssignmentProblem, hint: Hint | None, solver: Any) -> tuple[Answer, float]:
    begun = time.process_time()
    answer = solve(problem, solver, rng=np.random.default_rng(SEED), hint=hint)
    return answer, time.process_time() - begun


def _highs(problem: AssignmentProblem) -> tuple[float, float, float]:
    """Return HiGHS's cost, bound and CPU time [s], and leave its tolerances to it."""
    columns: Columns = columns_of_problem(problem)
    last = mixed_integer(columns, LIMIT)[-1]
    return problem.base_cost + last.cost, problem.base_cost + last.bound, last.cpu


def _compare(name: str, answer: Answer, cost: float, bound: float) -> None:
    """Exit where HiGHS proves what our certificate denies."""
    allowed = 1e-5 * max(1.0, abs(cost)) if np.isfinite(cost) else 0.0
    if answer.cost < bound - allowed or answer.lower_bound > cost + allowed:
        raise SystemExit(f"{name}: {answer.certificate} against HiGHS's {cost}, {bound}")


if __name__ == "__main__":
    main()
