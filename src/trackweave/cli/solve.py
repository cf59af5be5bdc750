"""The command ``solve``."""

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from trackweave import solvers
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.cli.edge import Voice, telling_compiling
from trackweave.config.messages import suggest
from trackweave.config.search import DEFAULT_METHOD, METHODS
from trackweave.errors import InvalidInputError
from trackweave.io.encoding import encode_table
from trackweave.io.output import OutputFile
from trackweave.io.problem_file import ProblemTable, answer_frame, read_problem
from trackweave.io.tables import file_ending
from trackweave.solvers import Solver
from trackweave.solvers.solve import patient
from trackweave.solvers.warming import warm_up

__all__ = ["SolveRequest", "run_solve"]


@dataclass(frozen=True, slots=True)
class SolveRequest:
    """What the command was asked for.

    Parameters
    ----------
    problem
        File of the problem.
    method
        Name of a solver; None for the default.
    time_limit
        Time for solving [s]; None for as long as it takes.
    seed
        Seed of the random numbers.
    out
        File for the answer; None for none.
    """

    problem: Path
    method: str | None = None
    time_limit: float | None = None
    seed: int = 0
    out: Path | None = None


@telling_compiling
def run_solve(request: SolveRequest, voice: Voice) -> dict[str, Any]:
    """Solve the problem in a file and return what is known of the answer."""
    method = DEFAULT_METHOD if request.method is None else request.method
    solver, limit = _solver(method), request.time_limit
    if limit is not None:
        if not 0 <= limit < float("inf"):
            raise InvalidInputError(f"--time-limit: {limit}; expected a number ≥ 0 of seconds")
        # Who sets a time means it to be used.
        solver = patient(solver)
    if request.out is not None:
        file_ending(request.out)
        OutputFile(request.out).check([request.problem])
    table = read_problem(request.problem)
    # What is compiled must not count as the search's time.
    warm_up(solver, np.random.default_rng(0))
    begin = perf_counter()
    problem = _problem(request.problem, table)
    left = None if limit is None else max(0.0, limit - (perf_counter() - begin))
    rng = np.random.default_rng(request.seed)
    answer = solvers.solve(problem, solver, rng=rng, time_limit=left)
    time_s = perf_counter() - begin
    if request.out is not None:
        frame = answer_frame(table, problem, answer)
        OutputFile(request.out).write(encode_table(frame, request.out.name))
    found = _summary(table, answer) | {
        "time_s": time_s,
        "method": method,
        "seed": request.seed,
        "out": None if request.out is None else str(request.out),
    }
    voice.table("Answer", [(name.replace("_", " "), _shown(v)) for name, v in found.items()])
    return found


def _solver(method: str) -> Solver:
    """Return the solver of a name."""
    if method not in METHODS:
        raise InvalidInputError(
            f'--method: "{method}" is not known; {suggest(method, list(METHODS))}'
        )
    solver: Solver = getattr(solvers, METHODS[method])()
    return solver


def _problem(source: Path, table: ProblemTable) -> AssignmentProblem:
    """Return the problem of a table; what is wrong with all costs together names the file."""
    try:
        return table.problem()
    except InvalidInputError as err:
        raise InvalidInputError(f"{source}: {err}") from err


def _summary(table: ProblemTable, answer: Answer) -> dict[str, Any]:
    return {
        "cost": answer.cost,
        "lower_bound": answer.lower_bound,
        "gap": answer.gap,
        "status": answer.status.value,
        "stop_reason": answer.stop_reason,
        "evaluations": answer.evaluations,
        "tuples": len(table),
        "items": table.n_items,
    }


def _shown(value: Any) -> str:
    if value is None or (isinstance(value, float) and not isfinite(value)):
        return "–"
    return f"{value:.10g}" if isinstance(value, float) else str(value)
