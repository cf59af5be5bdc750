"""The command ``solve``."""

from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from trackweave import solvers
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.cli.edge import Voice, shown
from trackweave.config.plugins import plugin_class
from trackweave.config.search import DEFAULT_METHOD, instead_of
from trackweave.errors import InvalidInputError
from trackweave.io.encoding import encode_table
from trackweave.io.output import OutputFile
from trackweave.io.problem_file import ProblemTable, answer_frame, read_problem
from trackweave.io.tables import file_ending
from trackweave.solvers import METHODS, Solver
from trackweave.solvers.protocol import require_solver
from trackweave.solvers.solving import patient
from trackweave.solvers.warming import warm_up

__all__ = ["run_solve"]


def run_solve(
    voice: Voice,
    file: Path,
    *,
    method: str | None = None,
    time_limit: float | None = None,
    seed: int | None = None,
    out: Path | None = None,
) -> dict[str, Any]:
    """Solve the problem in a file, within a time [s], and return what is known of the answer."""
    method, seed = DEFAULT_METHOD if method is None else method, seed or 0
    solver = _solver(method)
    if time_limit is not None:
        if not 0 <= time_limit < float("inf"):
            raise InvalidInputError(
                f"--time-limit: {time_limit}; expected a number ≥ 0 of seconds"
            )
        # Who sets a time means it to be used.
        solver = patient(solver)
    if out is not None:
        file_ending(out)
        OutputFile(out).check([file])
    table = read_problem(file)
    # What is compiled must not count as the search's time.
    warm_up(solver, np.random.default_rng(0))
    begin = perf_counter()
    problem = _problem(file, table)
    left = None if time_limit is None else max(0.0, time_limit - (perf_counter() - begin))
    answer = solvers.solve(problem, solver, rng=np.random.default_rng(seed), time_limit=left)
    time_s = perf_counter() - begin
    if out is not None:
        OutputFile(out).write(encode_table(answer_frame(table, problem, answer), out.name))
    found = _summary(table, answer) | {
        "time_s": time_s,
        "method": method,
        "seed": seed,
        "out": None if out is None else str(out),
    }
    voice.results("Answer", found, digits=10)
    if not voice.on_terminal:
        cost, bound = (shown(found[name], digits=10) for name in ("cost", "lower_bound"))
        voice.say(f"cost {cost}, lower bound {bound}, {found['status']}; --json tells all")
    if len(table) and not len(answer.nodes) and np.all(table.costs > 0.0):
        voice.say(
            "no tuple is chosen: each costs more than to leave its items alone, at "
            f"{shown(table.alone, digits=10)} each; what is worth taking costs less than that"
        )
    return found


def _solver(method: str) -> Solver:
    """Return the solver of a name."""
    foreign = None if method in METHODS else plugin_class("solvers", method, "--method")
    if foreign is not None:
        made = foreign()
        require_solver(made, f'--method: "{method}"')
        return made  # type: ignore[no-any-return]
    if method not in METHODS:
        raise InvalidInputError(
            f'--method: "{method}" is not known; {instead_of(method, list(METHODS))}'
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
