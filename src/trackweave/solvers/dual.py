"""Prices, a lower bound, and an answer by reduced cost."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.randomness import RandomSource
from trackweave.solvers._ascent import begin_climb, deflect, smooth
from trackweave.solvers._dual import NARROWING, answer_at, ascend, begin_ascent, solve_components
from trackweave.solvers._enumeration import enumerate_open
from trackweave.solvers._reduction import narrowed, whole, write_taken
from trackweave.solvers.components import Components
from trackweave.solvers.protocol import Hint, Stop, require_stop
from trackweave.solvers.relaxation import Relaxation

__all__ = ["STRETCHES", "Dual", "Stretch", "climb"]

STRETCH_WORK = 2_000_000
"""Sequences priced between two looks at the clock."""
HOT, COLD = 2.0, 0.06
"""First and last temperature of the smoothed dual, in units of the gap per family."""
BETWEEN_ANSWERS = 25
"""How many bounds are computed before an answer is made at the prices as they are."""
IMPROVEMENTS = 3
"""How often the last answer is improved locally."""
FACTOR = 0.1
"""First step of the subgradients, as a part of Polyak's."""


class Stretch(NamedTuple):
    """So many bounds, by deflected subgradients or on the smoothed dual."""

    bounds: int
    is_smooth: bool


# Early answers and reductions pay: where prices alone can prove an answer, they mostly have
# after the second stretch. The smoothed dual is slow, and goes on where subgradients stall.
STRETCHES = (
    Stretch(150, False),
    Stretch(150, False),
    Stretch(300, False),
    Stretch(800, True),
    Stretch(500, False),
)


def climb(
    components: Components, index: int, stretch: Stretch, stop: Stop | None
) -> tuple[int, bool]:
    """Raise a component's bound and answer it, in place; return bounds computed, if stopped."""
    component = components.component(index)
    price = components.price[components.items(index)]
    selection = components.taken[components.families(index)]
    upper, lower = float(components.cost[index]), float(components.lower[index])
    start = begin_climb(component, price, lower, 1.0 if stretch.is_smooth else FACTOR)
    unit = (upper - lower) / max(1, component.must.shape[0])
    more = max(1, min(BETWEEN_ANSWERS, STRETCH_WORK // component.parent.shape[0]))
    over = stopped = False
    while not over and not stopped:
        if stretch.is_smooth:
            heat = HOT * unit, COLD * unit
            over = smooth(component, price, start, *heat, more, stretch.bounds)
        else:
            over = deflect(component, price, start, upper, more, stretch.bounds)
        upper = answer_at(component, start.current, selection, upper, 0)
        stopped = stop is not None and stop()
    upper = answer_at(component, price, selection, upper, IMPROVEMENTS)
    components.cost[index] = upper
    components.lower[index] = min(upper, max(lower, float(start.value[0])))
    return int(start.steps[0]), stopped


STALLED = 0.02
"""A stretch that closes no more of the gap than this is the last."""
QUICK = 100
"""Bounds after which a component that is still open is reduced before it climbs on."""
SLICE_NODES = 2_000
"""Sequences of components that are bounded between two looks at the clock."""
SLICE_WORK = 200_000
"""Sequences priced between two looks at the clock, in a component that is larger."""
TOLERANCE = 1e-9
"""A gap below this part of the usual cost is rounding."""


@dataclass(frozen=True, slots=True)
class Dual:
    """Lagrangian relaxation: every item gets a price, and the prices a bound.

    A hundred subgradient steps on the prices [1]_, with answers made greedily by reduced cost
    and improved locally; after every twenty, sequences that the prices exclude are left out.
    Where a gap remains, the others make a smaller problem, which falls into smaller components;
    these are bounded anew, and enumerated, which proves the answer when it completes. What is
    open then climbs by deflected subgradients [2]_ and on the dual smoothed by a falling
    temperature [3]_, is reduced again and enumerated.

    Parameters
    ----------
    iterations
        Greatest number of bounds, at least 1: the first 100 per component, then in stretches of
        150 and more while they raise the bound.
    visits
        Greatest number of steps of the enumeration per component; 0 for none.

    Raises
    ------
    InvalidInputError
        If a number is out of range.

    References
    ----------
    .. [1] M. Held, P. Wolfe, H. Crowder, *Validation of subgradient optimization*, 1974, eq. 4.
       doi:10.1007/BF01580223
    .. [2] F. Barahona, R. Anbil, *The volume algorithm*, 2000. doi:10.1007/s101070050002
    .. [3] Y. Nesterov, *Smooth minimization of non-smooth functions*, 2005.
       doi:10.1007/s10107-004-0552-5

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> answer = tw.solve(problem, tw.Dual(), rng=np.random.default_rng(1))
    >>> answer.cost, answer.lower_bound
    (-7.0, -7.0)
    >>> answer.tuples
    array([[1, 1],
           [2, 2]])
    """

    iterations: int = 2_000
    visits: int = 20_000

    def __post_init__(self) -> None:
        settle(self)
        if self.iterations < 1 or self.visits < 0:
            raise InvalidInputError(
                f"Dual: {self.iterations} iterations, {self.visits} visits; expected ≥ 1 and ≥ 0"
            )

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: RandomSource = 0,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Answer:
        """Return the answer by reduced cost; see ``Solver``."""
        relaxation, evaluations, stopped = self.relax(Relaxation.of(problem, hint), stop)
        return relaxation.answer(evaluations, "stopped" if stopped else "bound stalled")

    def relax(self, relaxation: Relaxation, stop: Stop | None) -> tuple[Relaxation, int, bool]:
        """Bound and answer what is open, and reduce it to what the bounds leave open.

        Parameters
        ----------
        relaxation
            A problem taken apart; its answers and bounds are improved in place.
        stop
            Asked every few milliseconds whether to stop.

        Returns
        -------
        The relaxation with further levels, how many bounds were computed and steps of the
        enumeration taken, and whether it was stopped.
        """
        require_stop(stop)
        evaluations, stopped = self.bound(relaxation.rest, stop)
        left = self.iterations - QUICK
        for turn, stretch in enumerate(STRETCHES):
            if stopped or not relaxation.rest.open().size:
                break
            relaxation = relaxation.reduced()
            if turn == 0:
                more, stopped = self.bound(relaxation.rest, stop)
                evaluations += more
            elif self.visits:
                more, stopped = self._enumerate(relaxation.rest, stop)
                evaluations += more
            if stopped or left < stretch.bounds:
                break
            left -= stretch.bounds
            more, progress, stopped = self._climb(relaxation.rest, stretch, stop)
            evaluations += more
            if turn > 1 and progress < STALLED:
                break
        return relaxation, evaluations, stopped

    def _climb(
        self, components: Components, stretch: Stretch, stop: Stop | None
    ) -> tuple[int, float, bool]:
        """Climb with the open components; return bounds, part of the gap closed, if stopped."""
        candidates = components.open()
        before = float((components.cost - components.lower)[candidates].sum())
        evaluations, stopped = 0, False
        for index in candidates.tolist():
            more, stopped = climb(components, index, stretch, stop)
            evaluations += more
            if stopped:
                break
        gap = float((components.cost - components.lower)[candidates].sum())
        return evaluations, 1.0 - gap / max(before, TOLERANCE), stopped

    def _enumerate(self, components: Components, stop: Stop | None) -> tuple[int, bool]:
        """Search the open components through; return how many visits, and if it was stopped."""
        visits = 0
        for index in components.inexact().tolist():
            if stop is not None and stop():
                return visits, True
            cost, complete, tried = enumerate_open(
                components.component(index),
                components.price[components.items(index)],
                components.taken[components.families(index)],
                float(components.cost[index]),
                self.visits,
            )
            components.cost[index] = cost
            if complete:
                components.lower[index] = cost
            visits += tried
        return visits, False

    def bound(self, components: Components, stop: Stop | None) -> tuple[int, bool]:
        """Bound and answer every component, in place.

        Parameters
        ----------
        components
            A problem taken apart. After a stop those that remain get one greedy answer and the
            bound at the prices that they came with.
        stop
            Asked every few milliseconds whether to stop.

        Returns
        -------
        How many bounds were computed and steps of the enumeration taken; whether it was stopped.
        """
        evaluations, first, stopped = 0, 0, False
        starts = components.parts.node_start
        while first < len(components):
            # A slice of components worth a few milliseconds, so that a stop is seen in time.
            last = int(np.searchsorted(starts, starts[first] + SLICE_NODES, side="right")) - 1
            last = min(max(last, first + 1), len(components))
            stopped = stopped or (stop is not None and stop())
            if stop is not None and not stopped and starts[last] - starts[first] > SLICE_NODES:
                done, stopped = self._bound_large(components, first, stop)
                evaluations += done
            else:
                effort = 1 if stopped else min(QUICK, self.iterations)
                evaluations += solve_components(
                    components.parts, first, last, components.price, components.taken,
                    components.cost, components.lower, effort, TOLERANCE,
                )  # fmt: skip
            first = last
        if self.visits and not stopped:
            # Most windows leave nothing open, and do not even compile what searches it.
            more, stopped = self._enumerate(components, stop)
            evaluations += more
        return evaluations, stopped

    def _bound_large(self, components: Components, index: int, stop: Stop) -> tuple[int, bool]:
        """Bound and answer a component that takes long, as ``solve_components`` would."""
        component = components.component(index)
        price = components.price[components.items(index)]
        selection = components.taken[components.families(index)]
        known = float(components.cost[index]), float(components.lower[index])
        ascent, left = begin_ascent(price, *known), whole(component, selection)
        last = min(QUICK, self.iterations)
        over = stopped = False
        while not over and not stopped:
            done = int(ascent.iteration[0]) % NARROWING
            if done == 0 and ascent.iteration[0] > 0:
                left = narrowed(left, price, float(ascent.value[0]))
            more = max(1, SLICE_WORK // left.component.parent.shape[0])
            more = min(more, NARROWING - done)
            over = ascend(left.component, price, left.taken, ascent, more, last, TOLERANCE)
            stopped = stop()
        upper, lower = float(ascent.value[0]), float(ascent.value[1])
        evaluations = int(ascent.iteration[0])
        write_taken(left, selection)
        components.cost[index], components.lower[index] = upper, min(lower, upper)
        return evaluations, stopped
