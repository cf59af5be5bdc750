"""How good an answer is, proven."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

__all__ = ["Certificate", "Status", "relative_gap"]


class Status(StrEnum):
    """What is known of an answer.

    Examples
    --------
    >>> import trackweave as tw
    >>> tw.Status.OPTIMAL == "optimal"
    True
    >>> [status.value for status in tw.Status]
    ['optimal', 'optimal among kept', 'feasible', 'infeasible', 'unknown']
    """

    OPTIMAL = "optimal"
    """The bound proves that no answer costs less."""
    OPTIMAL_AMONG_KEPT = "optimal among kept"
    """The same of what a tracker kept: it left out more than 1 % of a track's probability, or
    nobody knows how much."""
    FEASIBLE = "feasible"
    """Every rule is kept; the certificate's gap says how much better an answer could be."""
    INFEASIBLE = "infeasible"
    """Proven: no answer covers every item that has to be covered."""
    UNKNOWN = "unknown"
    """No answer that covers every item that has to be was found; there may be one."""


def relative_gap(cost: float, lower_bound: float) -> float:
    """Return (cost − bound) / abs(cost), the relative gap as HiGHS and Gurobi define it."""
    # It is 0 where both are zero; infinite where the cost alone is zero, and where there is no
    # answer.
    if cost == np.inf:
        return np.inf
    distance = max(0.0, cost - lower_bound)
    if distance == 0.0 or cost == 0.0:
        return np.inf if distance else 0.0
    return distance / abs(cost)


@dataclass(frozen=True, slots=True)
class Certificate:
    """How good an answer is, proven.

    Parameters
    ----------
    cost
        What the answer costs [nats]; infinite where none was found.
    lower_bound
        No answer over the same sequences costs less [nats]; infinite where there is none.
    status
        Whether that proves the answer best, but for rounding: 1e-9 of what its sequences cost.

    Examples
    --------
    >>> import trackweave as tw
    >>> certificate = tw.Certificate(-200.0, -220.0, tw.Status.FEASIBLE)  # nats
    >>> certificate.gap  # (cost − bound) / abs(cost)
    0.1
    >>> tw.Certificate(0.0, -1.0, tw.Status.FEASIBLE).gap
    inf
    """

    cost: float
    lower_bound: float
    status: Status

    @property
    def gap(self) -> float:
        """Distance from the bound relative to the cost, (cost − bound) / abs(cost).

        Infinite where no answer was found, and where the cost is zero but the bound is not.
        """
        return relative_gap(self.cost, self.lower_bound)
