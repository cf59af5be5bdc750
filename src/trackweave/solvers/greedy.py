"""The cheapest sequence first."""

from dataclasses import dataclass

from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.randomness import RandomSource
from trackweave.solvers._kernels import cheapest_first
from trackweave.solvers.components import Components
from trackweave.solvers.protocol import Hint, Stop

__all__ = ["Greedy"]


@dataclass(frozen=True, slots=True)
class Greedy:
    """Take the sequence of least total cost, strike what it excludes, and go on.

    Items that must be covered and are left at the end take their cheapest free sequence. The
    bound is what every family could have alone.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> answer = tw.solve(problem, tw.Greedy(), rng=np.random.default_rng(1))
    >>> answer.cost, answer.lower_bound
    (-6.0, -9.0)
    >>> answer.tuples
    array([[1, 2]])
    """

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: RandomSource = 0,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Answer:
        """Return the greedy answer; see ``Solver``."""
        components = Components.of(problem, None)
        for index in range(len(components)):
            families = components.families(index)
            components.cost[index], components.lower[index] = cheapest_first(
                components.component(index), components.taken[families]
            )
        reason = "gap closed" if components.open().size == 0 else "one pass"
        return components.answer(len(components), reason)
