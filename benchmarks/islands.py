"""Islands: how much sooner two threads or processes reach a gap, and what sharing gains."""

import argparse
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from multiprocessing import active_children
from pathlib import Path
from typing import Any

import numpy as np
from solvers_families import (
    BEARINGS,
    ENDLESS,
    Clock,
    Family,
    Records,
    percent,
    warm_up,
)
from text_tables import command, heading, table

from trackweave import Annealing, Islands, TabuSearch, solve
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.engine import choice
from trackweave.engine.local import LocalHost
from trackweave.simulation.scenes import BearingKind

LARGE = Family("bearings 4×60, 2 mrad", BearingKind(4, 60, 0.002), (1,), 90.0)
SCENES = ((BEARINGS[2], 2, 0.003), (LARGE, 1, 0.005))
"""Families, seeds, and gaps to reach above the least cost known: hard enough to search for."""
MOST_EPOCHS = 40
"""Where islands do not reach the gap, all ways end with this epoch."""
ONE, TWO, PROCESSES = "1 thread", "2 threads", "2 processes"
WAYS: dict[str, dict[str, Any]] = {
    ONE: {"threads": 1},
    TWO: {"threads": 2},
    PROCESSES: {"engine": "local", "workers": 2},
}
ENDLESSLY: dict[str, Any] = {"epochs": ENDLESS, "patience": ENDLESS}
ALONE = {"evaluations": ENDLESS, "patience": ENDLESS}
CONTENDERS: dict[str, Any] = {
    "annealing alone": Annealing(**ALONE),
    "tabu search alone": TabuSearch(**ALONE),
    "4 islands of annealing": Islands((Annealing(),), threads=1, **ENDLESSLY),
    "4 islands of annealing and tabu search (the default)": Islands(threads=1, **ENDLESSLY),
    "the same, nothing sent": Islands(threads=1, neighbours=0, **ENDLESSLY),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=9, help="paired runs of each scene")
    parser.add_argument("--seconds", type=float, default=4.0, help="CPU time of each contender")
    parser.add_argument("--seeds", type=int, default=3, help="runs of each contender")
    arguments = parser.parse_args()
    choice.LocalHost = Traffic  # type: ignore[misc]
    warm_up(*(Islands(epochs=3, **way) for way in WAYS.values()))
    problems = {
        f"{family.name}, seed {seed}": _problem(family, seed) for family, seed, _ in SCENES
    }
    records = Records()
    shares = _shares(problems, records, arguments)
    rows = [
        _row(name, problems[name], gap, records, arguments.pairs)
        for name, (_, _, gap) in zip(problems, SCENES, strict=True)
    ]
    print(heading(command("islands.py")), end="\n\n")
    head = [
        "scene", "tuples", "gap to reach", "reached", "epochs", "evaluations",
        *(f"{way} s" for way in WAYS),
        *(f"{way}: {what}" for way in (TWO, PROCESSES)
          for what in ("times sooner (least to greatest)", "the islands alone")),
        "by CPU", "prices' share of 1 thread's time", "bytes an epoch, to processes and back",
    ]  # fmt: skip
    print(table(head, rows), end="\n\n")
    print(table([f"{arguments.seconds:g} CPU s, above the best known", *problems], shares))


def _problem(family: Family, seed: int) -> AssignmentProblem:
    scored = family.tuples(seed)
    return AssignmentProblem.from_tuples(scored.tuples, scored.costs)


@dataclass(frozen=True)
class Pair:
    """A search in each way: its answer, and the wall clocks in all and on islands.

    ``shares`` are one thread's CPU time and that of the driver and the busiest process, both on
    islands [s], ``sent`` the bytes to and from processes.
    """

    epochs: int
    answer: Answer
    walls: dict[str, tuple[float, float]]
    shares: tuple[float, float]
    sent: int


def _row(
    name: str, problem: AssignmentProblem, gap: float, records: Records, count: int
) -> list[Any]:
    """Return the row of a scene: each pair is of another seed, and ways begin by turns."""
    wanted = records.cost(name) + gap * abs(records.cost(name))
    pairs = [_pair(problem, wanted, seed) for seed in range(1, count + 1)]
    costs = np.array([pair.answer.cost for pair in pairs])
    for pair in pairs:
        records.enter(name, pair.answer.cost, pair.answer.lower_bound)
    walls = {way: np.array([pair.walls[way] for pair in pairs]).T for way in WAYS}
    sooner = [
        f"**{np.median(times):.2f}** ({times.min():.2f} to {times.max():.2f})"
        for way in (TWO, PROCESSES)
        for times in walls[ONE] / walls[way]
    ]
    epochs = [pair.epochs for pair in pairs]
    return [
        name, problem.n_nodes, percent(gap), f"{np.count_nonzero(costs <= wanted)} of {count}",
        f"{min(epochs)} to {max(epochs)}",
        int(np.median([pair.answer.evaluations for pair in pairs])),
        *(f"{np.median(walls[way][0]):.2f}" for way in WAYS), *sooner,
        f"{np.median([pair.shares[0] / pair.shares[1] for pair in pairs]):.2f}",
        percent(float(np.median(1 - walls[ONE][1] / walls[ONE][0]))),
        f"{np.median([pair.sent / pair.epochs for pair in pairs]) / 1e6:.1f} MB",
    ]  # fmt: skip


def _pair(problem: AssignmentProblem, wanted: float, seed: int) -> Pair:
    """Return the runs of a seed, to the epoch at which the answer costs no more than wanted."""
    solver = Islands(**ENDLESSLY)
    solver = replace(solver, epochs=_epochs_to_reach(solver, problem, seed, wanted))
    answers: dict[str, Answer] = {}
    walls: dict[str, tuple[float, float]] = {}
    cpu: dict[str, float] = {}
    sent = Traffic.n_bytes
    for way in list(WAYS) if seed % 2 else list(WAYS)[::-1]:
        answers[way], walls[way], cpu[way] = _timed(replace(solver, **WAYS[way]), problem, seed)
    sent = Traffic.n_bytes - sent
    if seed == 1:
        answers["4 threads"], *_ = _timed(replace(solver, threads=4), problem, seed)
    _require_same(list(answers.values()))
    return Pair(solver.epochs, answers[ONE], walls, (cpu[ONE], cpu[PROCESSES]), sent)


def _timed(
    solver: Islands, problem: AssignmentProblem, seed: int
) -> tuple[Answer, tuple[float, float], float]:
    """Return an answer, the wall clock that it took in all and on islands, and CPU there [s]."""
    # That of this process and of the busiest worker, which waits while this one packs.
    begun = time.perf_counter()
    state = solver.start(problem, rng=np.random.default_rng(seed))
    prepared, cpu, before = time.perf_counter(), time.process_time(), _cpu_of_workers()
    answer = solver.answer(solver.advance(state))
    ended, cpu = time.perf_counter(), time.process_time() - cpu
    spent = [after - before.get(pid, 0.0) for pid, after in _cpu_of_workers().items()]
    return answer, (ended - begun, ended - prepared), cpu + max(spent, default=0.0)


def _cpu_of_workers() -> dict[int, float]:
    """Return the CPU time of each process of this one [s]."""
    found = {}
    for child in active_children():
        fields = Path(f"/proc/{child.pid}/stat").read_text().rpartition(")")[2].split()
        found[child.pid] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return found


class Traffic(LocalHost):
    """Counts the bytes to and from processes, in place of what brings them."""

    n_bytes = 0

    def hire(self) -> Any:
        """Return a new process whose calls are counted."""
        process: Any = super().hire()
        send = process.send

        def counted(call: bytes) -> None:
            Traffic.n_bytes += len(call)
            send(call)

        process.send = counted
        return process

    def wait(self, workers: Any, seconds: float | None) -> Any:
        """Return replies and deaths, the former counted."""
        found = super().wait(workers, seconds)
        Traffic.n_bytes += sum(len(reply) for _, reply in found if isinstance(reply, bytes))
        return found


def _epochs_to_reach(solver: Islands, problem: AssignmentProblem, seed: int, cost: float) -> int:
    """Return after how many epochs the islands have an answer of this cost."""
    state, epoch = solver.start(problem, rng=np.random.default_rng(seed)), 0
    while epoch < MOST_EPOCHS and solver.answer(state).cost > cost:
        state = solver.advance(state, evaluations=20_000)
        epoch = MOST_EPOCHS if state.search is None else state.search.epoch
    return min(epoch + 1, MOST_EPOCHS)


def _require_same(answers: Sequence[Answer]) -> None:
    """Exit where answers differ."""
    told = {
        (answer.nodes.tobytes(), answer.certificate, answer.evaluations, answer.stop_reason)
        for answer in answers
    }
    if len(told) != 1:
        raise SystemExit("the number of threads or processes changed an answer")


def _shares(
    problems: dict[str, AssignmentProblem], records: Records, arguments: argparse.Namespace
) -> list[list[Any]]:
    """Return the gap that each contender comes to in the same CPU time, the median over seeds."""
    costs: dict[tuple[str, str], list[float]] = {}
    for name, problem in problems.items():
        for contender, solver in CONTENDERS.items():
            for seed in range(1, arguments.seeds + 1):
                rng = np.random.default_rng(seed)
                answer = solve(problem, solver, rng=rng, stop=Clock(arguments.seconds))
                records.enter(name, answer.cost, answer.lower_bound)
                costs.setdefault((contender, name), []).append(answer.cost)
    return [
        [contender, *(percent(records.gap(name, float(np.median(found)))) for name, found in own)]
        for contender in CONTENDERS
        for own in [[(name, costs[contender, name]) for name in problems]]
    ]


if __name__ == "__main__":
    main()
