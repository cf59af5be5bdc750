"""A problem taken apart into components, and an answer put together from theirs."""

from dataclasses import dataclass, replace
from math import frexp, ldexp
from typing import Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray, float_array, require_finite, require_instance
from trackweave.association._clusters import Partition, partition
from trackweave.association.problem import Answer, AssignmentProblem, Certificate, Status
from trackweave.association.tuples import usual_size
from trackweave.solvers._kernels import Component, part_of
from trackweave.solvers.protocol import Hint

__all__ = ["Components"]

TOLERANCE = 1e-9
"""A component whose gap is below this part of the usual cost needs no further search."""
NOISE = 1e-13
"""A gap below this part of what a component costs is rounding."""
LARGEST_WHOLE = 2.0**36
"""Beyond this, prices and bounds are not exact enough to tell whole numbers apart."""
FAR = 1e3
"""Prices of a hint are cut to so many times what the dearest sequence costs."""
COARSE = 1e-6
"""Rounding beyond this part of what the whole costs leaves an answer unproven."""
MOST_BITS, GREATEST = 1020, 1e250
"""Scaling by a larger power of two, or beyond this, could overflow."""


@dataclass(frozen=True, slots=True, eq=False)
class Components:
    """The components of a problem with the best known answer and bound of each.

    Totals, prices, costs and bounds are multiplied by ``scale``, a power of two, which takes no
    digits, so that the usual cost is near one: what is small, kernels measure by constants.
    ``price`` is of each item, in the order of ``parts.item_of``; ``taken`` holds for each family
    the node that it takes, numbered within its component, -1 for none. Of each component ``cost``
    and ``lower`` are the cost of what is taken and a lower bound, and ``step`` is what its
    answers' costs are multiples of, 0 where nothing is known.
    """

    problem: AssignmentProblem
    scale: float
    parts: Partition
    price: FloatArray
    taken: IntArray
    cost: FloatArray
    lower: FloatArray
    step: FloatArray

    @classmethod
    def of(cls, problem: AssignmentProblem, hint: Hint | None, *, whole: bool = False) -> Self:
        """Take a problem apart, or take it as one; nothing is chosen yet, no bound is known."""
        require_instance(problem, AssignmentProblem, "problem")
        if hint is not None:
            require_instance(hint, Hint, "hint")
        scale = _scale(problem)
        total = problem.total * scale
        parts = partition(problem.parent, problem.item, total, problem.must_cover, whole)
        n_components = parts.node_start.shape[0] - 1
        prices = np.zeros(problem.n_items)
        if hint is not None and hint.prices is not None:
            given = float_array(hint.prices, "hint.prices", (problem.n_items,))
            require_finite(given, "hint.prices")
            # Beyond what sequences cost, sums of prices would only lose the digits of bounds.
            known = np.abs(total)
            reach = FAR * float(np.max(known, where=np.isfinite(known), initial=1.0))
            prices = np.minimum(np.maximum(given, 0.0), reach / scale) * scale
        return cls(
            problem=problem,
            scale=scale,
            parts=parts,
            price=prices[parts.item_of],
            taken=np.full(parts.must.shape[0], -1, dtype=np.int64),
            cost=np.full(n_components, np.inf),
            lower=np.full(n_components, -np.inf),
            step=_steps(parts),
        )

    def __len__(self) -> int:
        return int(self.cost.shape[0])

    def component(self, index: int) -> Component:
        """Return one component, as views."""
        return part_of(self.parts, index)

    def families(self, index: int) -> slice:
        """Return where a component's families stand in ``taken``."""
        return slice(int(self.parts.family_start[index]), int(self.parts.family_start[index + 1]))

    def items(self, index: int) -> slice:
        """Return where a component's items stand in ``price`` and ``parts.item_of``."""
        return slice(int(self.parts.item_start[index]), int(self.parts.item_start[index + 1]))

    def copy(self) -> Self:
        """Return components whose answers and bounds can change apart from these."""
        return replace(
            self,
            price=self.price.copy(),
            taken=self.taken.copy(),
            cost=self.cost.copy(),
            lower=self.lower.copy(),
        )

    def selection_of(self, nodes: IntArray) -> IntArray:
        """Return nodes of the problem as a selection; of two of one family the later counts."""
        parts = self.parts
        place = np.empty(self.problem.n_nodes, dtype=np.int64)
        place[parts.node] = np.arange(parts.node.shape[0])
        component = np.searchsorted(parts.node_start, place[nodes], side="right") - 1
        family = parts.family[place[nodes]] + parts.family_start[component]
        selection = np.full(parts.must.shape[0], -1, dtype=np.int64)
        selection[family] = place[nodes] - parts.node_start[component]
        return selection

    def closing(self, index: int) -> float:
        """Return the gap at which a component's answer is proven best."""
        return float(_closing(self.cost[index : index + 1], self.step[index : index + 1])[0])

    def is_closed(self, index: int, cost: float) -> bool:
        """Tell whether an answer of this cost is proven best for a component."""
        gap = cost - self.lower[index]
        return bool(gap <= _closing(np.array([cost]), self.step[index : index + 1])[0])

    def open(self) -> IntArray:
        """Return the components whose answer is not proven best, those of widest gap first."""
        gap = self.cost - self.lower
        is_open = ~np.isfinite(gap)
        known = ~is_open
        is_open[known] = gap[known] > _closing(self.cost[known], self.step[known])
        candidates = np.flatnonzero(is_open)
        return candidates[np.argsort(-gap[candidates], kind="stable")]

    def sure(self) -> FloatArray:
        """Return what each component costs at least, whole costs and rounding considered."""
        gap = self.cost - self.lower
        # Not what is merely near enough to be closed: that stays to be seen in the bound.
        limit = np.where(self.step > 0.0, _closing(self.cost, self.step), _noise(self.cost))
        known: FloatArray = np.where(gap <= limit, self.cost, self.lower)
        return known

    def inexact(self) -> IntArray:
        """Return the components whose answer is not proven best to the last digit."""
        return np.flatnonzero(self.sure() != self.cost)

    def nodes(self) -> IntArray:
        """Return the problem's nodes that are taken, in ascending order."""
        parts = self.parts
        first_node = np.repeat(parts.node_start[:-1], np.diff(parts.family_start))
        used = self.taken >= 0
        return np.sort(parts.node[self.taken[used] + first_node[used]])

    def answer(self, evaluations: int, stop_reason: str) -> Answer:
        """Return the answer of the whole problem."""
        nodes = self.nodes()
        cost = self.problem.cost_of(nodes)
        slack = float(np.maximum(self.cost - self.sure(), 0.0).sum()) / self.scale
        proven = self.open().shape[0] == 0
        # Where far larger costs cancel, rounding may hide a better answer.
        rounding = float(_noise(self.cost[self.step == 0.0]).sum()) / self.scale if proven else 0.0
        if rounding > COARSE * max(1.0 / self.scale, abs(cost)):
            proven, slack, stop_reason = False, slack + rounding, "rounding"
        status = Status.OPTIMAL if proven else Status.FEASIBLE
        certificate = Certificate(cost, cost - slack, status)
        prices = np.zeros(self.problem.n_items)
        prices[self.parts.item_of] = self.price / self.scale
        if not self._is_complete(nodes):
            certificate = self._without_answer(certificate)
            if certificate.status is Status.INFEASIBLE:
                stop_reason = "gap closed"
        return Answer(nodes, certificate, evaluations, stop_reason, prices, problem=self.problem)

    def _is_complete(self, nodes: IntArray) -> bool:
        """Tell whether the nodes' sequences cover every item that is required."""
        problem = self.problem
        if problem.requirement is None:
            return True
        covered = np.zeros(problem.n_items, dtype=np.bool_)
        while nodes.size:
            covered[problem.item[nodes]] = True
            nodes = problem.parent[nodes]
            nodes = nodes[nodes >= 0]
        return bool(covered[problem.requirement.item].all())

    def _without_answer(self, relaxed: Certificate) -> Certificate:
        """Return what is known when the best found leaves a required item uncovered."""
        requirement = self.problem.requirement
        none_exists = relaxed.status is Status.OPTIMAL
        if requirement is not None:
            # What covers them all costs at most the ceiling; rounding must not exclude it.
            none_exists |= relaxed.lower_bound > requirement.ceiling + 0.25 * requirement.penalty
        if none_exists:
            return Certificate(np.inf, np.inf, Status.INFEASIBLE)
        return Certificate(np.inf, relaxed.lower_bound, Status.UNKNOWN)


def _scale(problem: AssignmentProblem) -> float:
    """Return the power of two that brings a problem's usual cost near one."""
    unit = problem.unit
    if unit is None:
        free = np.full(problem.n_items, np.inf)
        unit = usual_size(problem.item[:, None], problem.total, free)
    size = float(np.max(np.abs(problem.total), where=np.isfinite(problem.total), initial=0.0))
    bits = min(max(1 - frexp(unit)[1], -MOST_BITS), MOST_BITS)
    if size and bits + frexp(size)[1] > frexp(GREATEST)[1]:
        bits = -frexp(size)[1]
    return ldexp(1.0, bits)


def _noise(cost: FloatArray) -> FloatArray:
    """Return how far apart two costs of this size may be by rounding alone."""
    noise: FloatArray = NOISE * np.where(np.isfinite(cost), np.abs(cost), 0.0)
    return noise


def _closing(cost: FloatArray, step: FloatArray) -> FloatArray:
    """Return the gap at which an answer of this cost is proven best."""
    # Whole costs leave no room for a better answer when the gap is less than one.
    rounding = np.maximum(TOLERANCE, _noise(cost))
    closing: FloatArray = np.where(step > 0.0, step * (1.0 - 1e-6), rounding)
    return closing


def _steps(parts: Partition) -> FloatArray:
    """Return the power of two that a component's costs are multiples of, 0 for rounding."""
    if not parts.total.size:
        return np.zeros(parts.node_start.shape[0] - 1)
    total = np.where(np.isfinite(parts.total), np.abs(parts.total), 0.0)
    largest = np.maximum.reduceat(total, parts.node_start[:-1])
    # Most costs have more digits than that: those need not be looked at one by one.
    coarse = np.ldexp(LARGEST_WHOLE, -np.frexp(largest)[1])
    parted = total * np.repeat(coarse, np.diff(parts.node_start))
    may_step = np.logical_and.reduceat(parted == np.floor(parted), parts.node_start[:-1])
    if not may_step.any():
        return np.zeros(largest.shape[0])
    mantissa, exponent = np.frexp(total)
    digits = np.ldexp(mantissa, 53).astype(np.int64)
    # The last binary digit of each; where all is zero, any step will do.
    own = np.where(total > 0.0, np.ldexp((digits & -digits).astype(float), exponent - 53), np.inf)
    step: FloatArray = np.minimum.reduceat(own, parts.node_start[:-1])
    step[largest == 0.0] = 1.0
    step[~may_step] = 0.0
    return step
