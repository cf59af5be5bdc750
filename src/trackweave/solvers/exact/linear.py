"""The linear relaxation of one component, solved by HiGHS and bounded by our own arithmetic."""

import functools
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.solvers._kernels import Component
from trackweave.solvers.exact._cuts import bound_of, columns_of, reduced_costs
from trackweave.solvers.protocol import Stop

__all__ = ["Fraction", "LinearProgram"]

BoolArray = NDArray[np.bool_]


class Fraction(NamedTuple):
    """A fractional answer: ``value`` of each ``column`` taken, and the ``bound`` it proves.

    ``price`` holds what the items are worth, ``excess`` how far each column's reduced cost lies
    above its family's least.
    """

    bound: float
    column: IntArray
    value: FloatArray
    price: FloatArray
    excess: FloatArray


class LinearProgram:
    """Columns are sequences that may end, rows are items, and cuts are added as they are found.

    A cut is three items: of the sequences with two or three of them an answer takes one at most,
    since any two share an item (subset-row inequalities, Jepsen et al. 2008, eq. 14). ``stop`` is
    asked at every simplex iteration.
    """

    def __init__(self, component: Component, stop: Stop | None) -> None:
        import highspy

        self._highs = highspy
        self.component = component
        self.node, self.start, self.items = columns_of(component)
        self.total = component.total[self.node]
        self.family = component.family[self.node]
        count = np.diff(self.start)
        by_item = np.argsort(self.items, kind="stable")
        self._with_item = np.repeat(np.arange(self.node.shape[0]), count)[by_item]
        self._item_start = np.searchsorted(self.items[by_item], np.arange(component.n_items + 1))
        self._shared = self._shared_items()
        self._cut_columns: list[IntArray] = []
        self._upper = np.ones(self.node.shape[0])
        # HiGHS's tolerances are absolute, and made for costs of some hundred.
        self._unit = float(np.abs(self.total).max(initial=0.0)) / 100.0 or 1.0
        self._solver = self._load(stop)

    def with_item(self, item: int) -> IntArray:
        """Return the columns that cover an item."""
        return self._with_item[self._item_start[item] : self._item_start[item + 1]]

    def solve(self, allowed: BoolArray) -> Fraction | None:
        """Return the best fractional answer over some columns; None when stopped or given up."""
        # Its bound is infinite where there is none.
        upper = allowed.astype(np.float64)
        changed = np.flatnonzero(upper != self._upper).astype(np.int32)
        if changed.size:
            self._solver.changeColsBounds(
                changed.size, changed, np.zeros(changed.size), upper[changed]
            )
            self._upper = upper
        self._solver.run()
        status = self._solver.getModelStatus()
        if status == self._highs.HighsModelStatus.kInfeasible:
            none = np.empty(0)
            return Fraction(np.inf, none.astype(np.int64), none, none, none)
        if status != self._highs.HighsModelStatus.kOptimal:
            return None
        solution = self._solver.getSolution()
        value = np.asarray(solution.col_value)
        taken = np.flatnonzero(value > 1e-7)
        return self._certified(np.asarray(solution.row_dual), allowed, taken, value[taken])

    def cut(self, triple: IntArray) -> None:
        """Let at most one sequence be taken of those with two or three of these items."""
        columns = np.concatenate([self.with_item(int(item)) for item in triple])
        found, count = np.unique(columns, return_counts=True)
        inside = found[count >= 2]
        self._cut_columns.append(inside)
        self._solver.addRow(
            -self._highs.kHighsInf, 1.0, inside.size, inside.astype(np.int32), np.ones(inside.size)
        )

    def _certified(
        self, dual: FloatArray, allowed: BoolArray, taken: IntArray, value: FloatArray
    ) -> Fraction:
        # Any prices prove a bound, so HiGHS's tolerances do not enter it.
        n_items = self.component.n_items
        worth = np.maximum(0.0, -dual * self._unit)
        price = np.where(self._shared, worth[:n_items], 0.0)
        reduced = reduced_costs(self.start, self.items, self.total, price)
        for columns, penalty in zip(self._cut_columns, worth[n_items:], strict=True):
            if penalty > 0.0:
                reduced[columns] += penalty
        least, best = bound_of(reduced, self.family, self.component.must, allowed)
        bound = float(least - price.sum() - worth[n_items:].sum())
        return Fraction(bound, taken, value, price, reduced - best[self.family])

    def _shared_items(self) -> BoolArray:
        """Return which items more than one family wants; prices of the others are of no use."""
        family = self.family[self._with_item]
        shared = np.zeros(self.component.n_items, dtype=np.bool_)
        inside = np.diff(self._item_start) > 0
        first = self._item_start[:-1][inside]
        shared[inside] = np.maximum.reduceat(family, first) != np.minimum.reduceat(family, first)
        return shared

    def _load(self, stop: Stop | None) -> Any:
        solver: Any = _silent_highs()()
        solver.setOptionValue("threads", 1)
        solver.passModel(self._model())
        if stop is not None:

            def ask(event: Any) -> None:
                if stop():
                    event.interrupt()

            solver.cbSimplexInterrupt.subscribe(ask)
        return solver

    def _model(self) -> Any:
        """Return the set packing of the columns, one row per item, in units of its own."""
        component, highs = self.component, self._highs
        lower = np.zeros(component.n_items)
        roots = component.members[component.start[:-1]]
        lower[component.item[roots[component.must]]] = 1.0
        model = highs.HighsLp()
        n_columns = self.node.shape[0]
        model.num_col_, model.num_row_ = n_columns, component.n_items
        model.col_cost_ = self.total / self._unit
        model.col_lower_, model.col_upper_ = np.zeros(n_columns), np.ones(n_columns)
        model.row_lower_, model.row_upper_ = lower, np.ones(component.n_items)
        model.a_matrix_.format_ = highs.MatrixFormat.kColwise
        model.a_matrix_.start_ = self.start.astype(np.int32)
        model.a_matrix_.index_ = self.items.astype(np.int32)
        model.a_matrix_.value_ = np.ones(self.items.shape[0])
        return model


@functools.cache
def _silent_highs() -> Any:
    """Return HiGHS's class, silenced before its constructor can greet on standard output."""
    # From 1.16 on it greets when the constructor enables callbacks, before any option can be set.
    import highspy

    class SilentHighs(highspy.Highs):
        def __init__(self) -> None:
            super().__init__()  # type: ignore[no-untyped-call]
            self.setOptionValue("output_flag", False)

        def enableCallbacks(self) -> None:  # noqa: N802 - HiGHS's own name
            self.setOptionValue("output_flag", False)
            super().enableCallbacks()  # type: ignore[no-untyped-call]

    return SilentHighs
