"""The long climb of one component's bound, in slices short enough to look at the clock."""

from collections.abc import Callable
from typing import NamedTuple

from trackweave.arrays import FloatArray, IntArray
from trackweave.solvers._ascent import Climb, begin_climb, deflect, smooth
from trackweave.solvers._dual import answer_at
from trackweave.solvers._kernels import Component
from trackweave.solvers.protocol import Stop

__all__ = ["Slopes"]

SLICE_WORK = 2_000_000
"""Sequences priced between two looks at the clock."""
SHARES = (0.3, 0.4, 0.3)
"""How the bounds are shared out to subgradients, the smoothed dual, and subgradients again."""
HOT, COLD = 2.0, 0.06
"""First and last temperature, in units of the gap per family."""


class Slopes(NamedTuple):
    """A component whose bound is to rise.

    ``price`` and ``selection`` are improved in place.
    """

    component: Component
    price: FloatArray
    selection: IntArray
    stop: Stop | None

    def climb(
        self, known: tuple[float, float], iterations: int, closing: float
    ) -> tuple[float, float, int]:
        """Return the cost and the bound after so many bounds, and how many were computed.

        Parameters
        ----------
        known
            Cost and bound so far.
        iterations
            Greatest number of bounds.
        closing
            Gap that is good enough.

        Returns
        -------
        The cost, the bound, and the number of bounds.
        """
        (upper, lower), done = known, 0
        for phase, share in enumerate(SHARES):
            count = int(share * iterations)
            if upper - lower <= closing or count < 2:
                break
            climb = begin_climb(self.component, self.price, lower, 1.0 if phase == 1 else 0.1)
            step = self._subgradients(climb, upper, count)
            if phase == 1:
                step = self._smoothed(climb, upper - lower, count)
            finished = self._slice_by_slice(step)
            done += int(climb.steps[0])
            lower = max(lower, float(climb.value[0]))
            upper = answer_at(self.component, self.price, self.selection, upper)
            if not finished:
                break
        return upper, lower, done

    def _subgradients(self, climb: Climb, target: float, count: int) -> Callable[[int], bool]:
        return lambda more: deflect(self.component, self.price, climb, target, more, count)

    def _smoothed(self, climb: Climb, gap: float, count: int) -> Callable[[int], bool]:
        unit = gap / max(1, self.component.must.shape[0])
        return lambda more: smooth(
            self.component, self.price, climb, HOT * unit, COLD * unit, more, count
        )

    def _slice_by_slice(self, step: Callable[[int], bool]) -> bool:
        """Take steps until they are over or a stop is asked for; tell which."""
        more = max(1, SLICE_WORK // self.component.parent.shape[0])
        while not step(more):
            if self.stop is not None and self.stop():
                return False
        return True
