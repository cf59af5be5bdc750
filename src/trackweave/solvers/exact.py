"""The optimum, by HiGHS."""

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.solvers._kernels import Component
from trackweave.solvers.components import Components
from trackweave.solvers.dual import Dual
from trackweave.solvers.protocol import Hint, Stop

__all__ = ["Exact"]


@dataclass(frozen=True, slots=True)
class Exact:
    """Integer programming by HiGHS, component by component.

    Starts from the answer of ``Dual`` without enumeration, and solves what that leaves open. A
    component of more sequences than ``max_sequences`` keeps that answer and its gap, because
    HiGHS can overrun its time limit there.

    Parameters
    ----------
    time_limit
        Seconds for all components together. Must be positive.
    max_sequences
        Greatest number of sequences of a component that is solved.

    Raises
    ------
    InvalidInputError
        If a number is out of range.
    """

    time_limit: float = 60.0
    max_sequences: int = 50_000

    def __post_init__(self) -> None:
        if not self.time_limit > 0 or self.max_sequences < 1:
            raise InvalidInputError(
                f"Exact: time_limit {self.time_limit}, max_sequences {self.max_sequences}; "
                "expected both positive"
            )

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: np.random.Generator,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Answer:
        """Return the best answer found in the time; see ``Solver``."""
        end = perf_counter() + self.time_limit
        components = Components.of(problem, hint)
        evaluations, _ = Dual(iterations=50, visits=0).bound(components, stop)
        reason = "gap closed"
        for index in components.open():
            component = components.component(int(index))
            if component.parent.shape[0] > self.max_sequences:
                reason = "component too large"
                continue
            left = end - perf_counter()
            if left <= 0 or (stop is not None and stop()):
                reason = "time limit" if left <= 0 else "stopped"
                break
            families = components.families(int(index))
            cost, lower = _solve(component, components.taken[families], left)
            components.cost[index] = cost
            components.lower[index] = max(lower, components.lower[index])
            evaluations += 1
        if reason == "gap closed" and components.open().size:
            reason = "time limit"
        return components.answer(evaluations, reason)


def _solve(component: Component, selection: Any, time_limit: float) -> tuple[float, float]:
    """Improve a component's selection in place; return its cost and bound."""
    import highspy

    known = float(component.total[selection[selection >= 0]].sum())
    solver = highspy.Highs()
    solver.setOptionValue("output_flag", False)
    solver.setOptionValue("threads", 1)
    solver.setOptionValue("time_limit", float(time_limit))
    solver.setOptionValue("mip_rel_gap", 0.0)
    solver.setOptionValue("mip_abs_gap", 1e-9)
    columns = np.flatnonzero(np.isfinite(component.total))
    solver.passModel(_model(component, columns))
    solver.run()
    info = solver.getInfo()
    values = np.asarray(solver.getSolution().col_value)
    bound = float(info.mip_dual_bound)
    if values.shape[0] == columns.shape[0] and info.primal_solution_status == 2:
        chosen = columns[values > 0.5]
        cost = float(component.total[chosen].sum())
        if cost < known:
            selection[:] = -1
            selection[component.family[chosen]] = chosen
            known = cost
    # HiGHS proves its optimum to its own tolerances, a little wider than ours.
    if known - bound <= 1e-6 * max(1.0, abs(known)):
        bound = known
    return known, bound if np.isfinite(bound) else -np.inf


def _model(component: Component, columns: Any) -> Any:
    """Return the set packing of the sequences that may end, one row per item."""
    import highspy

    index: list[int] = []
    start = [0]
    for node in columns.tolist():
        while node >= 0:
            index.append(int(component.item[node]))
            node = int(component.parent[node])
        start.append(len(index))
    lower = np.zeros(component.n_items)
    roots = component.members[component.start[:-1]]
    lower[component.item[roots[component.must]]] = 1.0
    model = highspy.HighsLp()
    model.num_col_, model.num_row_ = len(columns), component.n_items
    model.col_cost_ = component.total[columns]
    model.col_lower_, model.col_upper_ = np.zeros(len(columns)), np.ones(len(columns))
    model.row_lower_, model.row_upper_ = lower, np.ones(component.n_items)
    model.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    model.a_matrix_.start_ = np.array(start)
    model.a_matrix_.index_ = np.array(index)
    model.a_matrix_.value_ = np.ones(len(index))
    model.integrality_ = [highspy.HighsVarType.kInteger] * len(columns)
    return model
