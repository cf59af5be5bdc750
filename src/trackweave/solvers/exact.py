"""The optimum, by HiGHS."""

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from trackweave.arrays import IntArray
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
        reason = too_large = ""
        for index in components.open().tolist():
            component = components.component(index)
            if component.parent.shape[0] > self.max_sequences:
                too_large = "component too large"
                continue
            left = end - perf_counter()
            if left <= 0 or (stop is not None and stop()):
                reason = "time limit" if left <= 0 else "stopped"
                break
            cost, lower = _solve(component, components.taken[components.families(index)], left)
            components.cost[index] = cost
            components.lower[index] = max(lower, components.lower[index])
            evaluations += 1
        if components.open().size == 0:
            return components.answer(evaluations, "gap closed")
        return components.answer(evaluations, reason or too_large or "time limit")


def _solve(component: Component, selection: IntArray, time_limit: float) -> tuple[float, float]:
    """Improve a component's selection in place; return its cost and bound."""
    import highspy

    known = float(component.total[selection[selection >= 0]].sum())
    columns = np.flatnonzero(np.isfinite(component.total))
    # HiGHS's tolerances are absolute, and made for costs of some hundred.
    unit = float(np.abs(component.total[columns]).max(initial=0.0)) / 100.0 or 1.0
    solver: Any = highspy.Highs()  # type: ignore[no-untyped-call]
    options = {"output_flag": False, "threads": 1, "mip_rel_gap": 0.0, "mip_abs_gap": 1e-9}
    for name, value in options.items():
        solver.setOptionValue(name, value)
    solver.setOptionValue("time_limit", float(time_limit))
    solver.passModel(_model(component, columns, unit))
    solver.run()
    values = np.asarray(solver.getSolution().col_value)
    if solver.getInfo().primal_solution_status == 2:
        chosen = columns[values > 0.5]
        cost = float(component.total[chosen].sum())
        if cost < known:
            selection[:] = -1
            selection[component.family[chosen]] = chosen
            known = cost
    if solver.getModelStatus() == highspy.HighsModelStatus.kOptimal:
        return known, known
    bound = float(solver.getInfo().mip_dual_bound) * unit
    return known, min(bound, known) if np.isfinite(bound) else -np.inf


def _model(component: Component, columns: IntArray, unit: float) -> Any:
    """Return the set packing of the sequences that may end, one row per item, in these units."""
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
    model.col_cost_ = component.total[columns] / unit
    model.col_lower_, model.col_upper_ = np.zeros(len(columns)), np.ones(len(columns))
    model.row_lower_, model.row_upper_ = lower, np.ones(component.n_items)
    model.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    model.a_matrix_.start_ = np.array(start)
    model.a_matrix_.index_ = np.array(index)
    model.a_matrix_.value_ = np.ones(len(index))
    model.integrality_ = [highspy.HighsVarType.kInteger] * len(columns)
    return model
