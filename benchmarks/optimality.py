"""Solvers against the proven optimum of random windows, and what pruning the tree loses.

The optimum is that of scipy's integer programming over all sequences at once, so that no solver
of ours judges another.
"""

import argparse
import time
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csc_array
from text_tables import heading, table
from windows import Place, grown, scans_of

from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.problem import Answer, AssignmentProblem, Status
from trackweave.solvers import Auto, Dual, Exact, Genetic, Greedy, Solver

DEPTH = 5
REFERENCE = "scipy's MIP, all at once"
EQUAL = 1e-9
# A proof by HiGHS is only as sharp as its own tolerances.
BELOW = 1e-6
SOLVERS: dict[str, Solver] = {
    "Auto, the default": Auto(),
    "Exact": Exact(),
    "Genetic": Genetic(),
    "Genetic, unseeded": Genetic(seeded=False),
    "Dual": Dual(),
    "Greedy": Greedy(),
}
# Wide enough for small windows; a wider one does not fit into memory or patience.
WIDE = GrowthLimits(
    margin=40.0, keep=20_000, new_margin=40.0, new_keep=2_000, new_ceiling=16.0,
    max_nodes=400_000,
)  # fmt: skip


@dataclass
class Tally:
    """What was found of a solver over the windows."""

    equal: int = 0
    below: int = 0
    proven: int = 0
    loss: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)

    def add(self, cost: float, best: float, cpu: float, *, proven: bool) -> None:
        """Enter an answer's cost for a window whose optimum is known, and the time it took [s]."""
        scale = max(1.0, abs(best))
        self.equal += abs(cost - best) <= EQUAL * scale
        self.below += cost < best - BELOW * scale
        self.proven += proven
        self.loss.append((cost - best) / scale)
        self.cpu.append(1e3 * cpu)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--windows", type=int, default=300)
    parser.add_argument("--small-windows", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    print(heading("python benchmarks/optimality.py"), end="\n\n")
    print(solvers_table(arguments.windows, arguments.seed), end="\n\n")
    print(pruning_table(arguments.small_windows, arguments.seed))


def solvers_table(n_windows: int, seed: int) -> str:
    """Return how the solvers do against the optimum over the same trees."""
    rng = np.random.default_rng(seed)
    tallies = {name: Tally() for name in (REFERENCE, *SOLVERS)}
    n_unproven, sizes = 0, []
    grown(Place(5, 1, 500.0, 5), scans_of(Place(5, 1, 500.0, 5), rng), DEPTH, GrowthLimits())
    for number in range(n_windows + 1):
        problem = _window(rng)
        if number == 0:
            # The first window only compiles.
            for solver in SOLVERS.values():
                _timed(solver, problem)
            continue
        begun = time.process_time()
        best = _optimum(problem)
        cpu = time.process_time() - begun
        if best is None:
            n_unproven += 1
            continue
        sizes.append(problem.n_nodes)
        tallies[REFERENCE].add(best, best, cpu, proven=True)
        for name, solver in SOLVERS.items():
            answer, cpu = _timed(solver, problem)
            cost = _recomputed(problem, answer)
            tallies[name].add(cost, best, cpu, proven=answer.status == Status.OPTIMAL)
    rows = [_row(name, tally) for name, tally in tallies.items()]
    head = ["solver", "equal to the optimum", "below it", "proven by itself", "mean loss",
            "worst loss", "CPU ms, median", "95 %", "worst"]  # fmt: skip
    text = (
        f"{len(sizes)} windows (5–20 targets in a square of 300–1000 m, 1–3 sensors, {DEPTH} "
        f"scans; {np.median(sizes):.0f} sequences in the median, {max(sizes)} at most); "
        f"{n_unproven} more without a proven optimum in a minute are left out."
    )
    return text + "\n\n" + table(head, rows)


def pruning_table(n_windows: int, seed: int) -> str:
    """Return what the default limits of growth lose against wide ones."""
    rng = np.random.default_rng(seed + 1000)
    losses, ratio, pruned = [], [], []
    while len(losses) < n_windows:
        place = Place(int(rng.integers(3, 9)), 1, float(rng.uniform(200, 600)), DEPTH)
        scans = scans_of(place, rng)
        narrow, _ = grown(place, scans, DEPTH, GrowthLimits())
        wide, n_pruned = grown(place, scans, DEPTH, WIDE, estimate="best")
        best, _ = _timed(Exact(max_sequences=WIDE.max_nodes), wide)
        usual, _ = _timed(Exact(), narrow)
        losses.append(usual.cost - best.cost)
        ratio.append(wide.n_nodes / narrow.n_nodes)
        pruned.append(n_pruned)
    loss = np.maximum(np.array(losses), 0.0)
    same = np.abs(losses) <= 1e-6
    rows = [
        [
            len(losses), f"{100 * same.mean():.1f} %", f"{loss.mean():.4f}", f"{loss.max():.3f}",
            f"{np.min(losses):.1e}", f"{np.mean(ratio):.0f} ×",
            f"{100 * np.mean(np.array(pruned) == 0):.0f} %",
        ]
    ]  # fmt: skip
    head = ["small windows", "same optimum", "mean loss, nats", "worst", "least",
            "sequences, wide against default", "wide trees that left nothing out"]  # fmt: skip
    return table(head, rows)


def _window(rng: np.random.Generator) -> AssignmentProblem:
    """Return the problem of a window in the middle of a run, with tracks from before it."""
    place = Place(
        int(rng.integers(5, 21)), int(rng.integers(1, 4)), float(rng.uniform(300, 1000)), 8
    )
    return grown(place, scans_of(place, rng), DEPTH, GrowthLimits())[0]


def _timed(solver: Solver, problem: AssignmentProblem) -> tuple[Answer, float]:
    begun = time.process_time()
    answer = solver(problem, rng=np.random.default_rng(1))
    return answer, time.process_time() - begun


def _optimum(problem: AssignmentProblem) -> float | None:
    """Return the least cost of a problem, None where a minute does not prove it."""
    columns = np.flatnonzero(np.isfinite(problem.total))
    node, rows, places = columns.copy(), [], []
    while np.any(node >= 0):
        at = np.flatnonzero(node >= 0)
        rows.append(problem.item[node[at]])
        places.append(at)
        node[at] = problem.parent[node[at]]
    row, column = np.concatenate(rows), np.concatenate(places)
    covers = csc_array((np.ones(row.size), (row, column)), shape=(problem.n_items, columns.size))
    found = milp(
        problem.total[columns],
        integrality=np.ones(columns.size),
        bounds=Bounds(0, 1),
        constraints=LinearConstraint(covers, problem.must_cover.astype(float), 1.0),
        options={"time_limit": 60.0, "mip_rel_gap": 0.0},
    )
    if found.status != 0:
        return None
    return problem.base_cost + float(problem.total[columns[found.x > 0.5]].sum())


def _recomputed(problem: AssignmentProblem, answer: Answer) -> float:
    """Return what an answer's sequences cost, which share no report and leave no track out."""
    used = np.zeros(problem.n_items, dtype=np.int64)
    for leaf in answer.nodes.tolist():
        node = leaf
        while node >= 0:
            used[problem.item[node]] += 1
            node = int(problem.parent[node])
    if used.max(initial=0) > 1 or np.any(used[problem.must_cover] == 0):
        raise SystemExit("an answer breaks a rule")
    return problem.base_cost + float(problem.total[answer.nodes].sum())


def _row(name: str, tally: Tally) -> list[object]:
    n = len(tally.loss)
    return [
        name, f"{100 * tally.equal / n:.1f} %", tally.below, f"{100 * tally.proven / n:.1f} %",
        f"{100 * np.mean(tally.loss):.4f} %", f"{100 * np.max(tally.loss):.3f} %",
        float(np.median(tally.cpu)), float(np.percentile(tally.cpu, 95)), float(np.max(tally.cpu)),
    ]  # fmt: skip


if __name__ == "__main__":
    main()
