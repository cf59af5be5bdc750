"""From the plots of several sensors at one instant to tuples that one object may have made.

A tuple takes at most one plot of each sensor. Its position is the most likely one given all its
plots: for positions that is a Kalman filter without motion; a bearing has no position until
another plot gives it one, and then Gauss-Newton steps find the position that fits all the set's
plots best. A plot joins a set if it lies in the gate about the position of the set so far.

Two bearings have a position where they cross, if that is in front of both sensors by more than
the gate leaves open: nearly parallel ones are no tuple, but a third plot may give them a
position. Bearings that cross behind a sensor are refused, and so is every position that may be
behind one of its bearings' sensors, as far as the gate can tell: close to a sensor, its bearings
say little.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from trackweave.arrays import (
    FloatArray,
    IntArray,
    float_array,
    require_finite,
)
from trackweave.association._plot_sets import PlotLimits
from trackweave.association.plot_growth import grow_nearest, grow_tuples
from trackweave.association.plot_tables import common_dimension, plot_table, views_of
from trackweave.association.problem import AssignmentProblem
from trackweave.association.sensor_plots import SensorPlots, scene_plots
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_members, settle
from trackweave.keys import DENSITY, POSITIVE, Key
from trackweave.summaries import summary

__all__ = ["PlotsRule", "ScoredTuples", "SensorPlots", "scene_plots"]

PlotCost = Literal["evidence", "equation-1"]
Overflow = Literal["refuse", "thin"]


@dataclass(frozen=True, slots=True, eq=False)
class ScoredTuples:
    """Tuples of plots that one object may have made.

    Parameters
    ----------
    tuples
        The 1-based number of the plot of each sensor, 0 for none, shape (tuples, sensors).
    costs
        What each costs against its plots being false alarms [nats].
    positions
        The most likely position [m], shape (tuples, dimensions).
    covariances
        How certain it is [m²], shape (tuples, dimensions, dimensions).
    is_complete
        Whether no tuple was left out for being one too many. Where some were, the bound of an
        answer to the problem does not cover them.
    """

    tuples: IntArray
    costs: FloatArray
    positions: FloatArray
    covariances: FloatArray
    is_complete: bool = True

    __repr__ = summary

    def __len__(self) -> int:
        return int(self.costs.shape[0])

    def problem(self) -> AssignmentProblem:
        """Return the problem of choosing tuples that share no plot; a plot left alone is free."""
        return AssignmentProblem.from_tuples(self.tuples, self.costs)


@dataclass(frozen=True, slots=True)
class PlotsRule:
    """Which tuples are worth considering, and what each costs.

    Parameters
    ----------
    object_density
        Objects expected per m² (m³), for the evidence.
    cost
        What a tuple of plots costs: by its evidence, or by eq. 1 of Wiranto and Bonok.

        ``"evidence"``: minus the logarithm of how much more probable the plots are if an
        object, wherever it is, made them than if all are false alarms; where bearings are in the
        tuple, by Laplace's approximation. ``"equation-1"``: the cost of [1]_, eq. 1, which takes
        the most likely position as known and one false alarm in the whole field of view.
    gate
        Greatest squared distance of a plot from the tuple that it joins.
    negative_only
        Whether to leave out tuples that cost nothing or more: no best answer needs them.
    lone_plots
        Whether to price positions that stand alone, as objects that one sensor saw; otherwise
        they are false alarms, which cost nothing. Bearings that stand alone always are.
    max_tuples
        Greatest number of tuples at one instant; where there would be more, far plots are left
        out.

        See ``overflow``.
    area
        Least and greatest coordinates of where objects can be [m]; None for anywhere. Matters
        for bearings, which may cross far away, where the evidence takes more objects to be.
    overflow
        What to do about more than ``max_tuples``: ``"refuse"``, or ``"thin"``, which joins each
        set of plots with the nearest few of each further sensor only, as few as it takes.

    References
    ----------
    .. [1] Wiranto and Bonok, 2018, eq. (1).

    Raises
    ------
    InvalidInputError
        If a value is out of range.

    Examples
    --------
    >>> import trackweave as tw
    >>> plots = [
    ...     tw.SensorPlots([[x, 0.0], [x + 500.0, 0.0]], sigma=10.0, volume=1e8, false_alarms=0.1)
    ...     for x in (0.0, 6.0)
    ... ]
    >>> found = tw.PlotsRule(object_density=1e-6)(plots)  # objects per m²
    >>> found.tuples  # number of each sensor's plot, 0 for none
    array([[1, 1],
           [2, 2]])
    >>> found.costs.round(1)  # nats
    array([-20.2, -20.2])
    """

    object_density: Annotated[float | None, DENSITY.said("a number > 0 per m² (m³)")] = None
    cost: Annotated[PlotCost, Key()] = "evidence"
    gate: Annotated[float, POSITIVE] = 16.0
    negative_only: bool = False
    lone_plots: bool = False
    max_tuples: Annotated[int, Key("a whole number from 1 to 10000000", 1, 10**7)] = 100_000
    area: tuple[Sequence[float], Sequence[float]] | None = None
    overflow: Overflow = "refuse"

    def __post_init__(self) -> None:
        settle(self)
        if self.object_density is None and self.cost == "evidence":
            raise InvalidInputError("object_density: None; expected objects per m² for evidence")
        if self.area is not None:
            corners = float_array(self.area, "area", (2, None))
            require_finite(corners, "area")
            if not np.all(corners[0] < corners[1]):
                raise InvalidInputError(f"area: {self.area!r:.80}; expected low before high")

    def __call__(self, sensors: Sequence[SensorPlots]) -> ScoredTuples:
        """Return every tuple within the gate, or the nearest, if these are too many.

        Parameters
        ----------
        sensors
            The sensors' plots; all positions of two dimensions or all of three, and bearings
            only with two.

        Returns
        -------
        The tuples, each sensor's plots numbered as they came.

        Raises
        ------
        InvalidInputError
            If dimensions differ, or there are more than ``max_tuples``, though thinned.
        """
        sensors = checked_members(sensors, SensorPlots, "sensors")
        dim = common_dimension(sensors)
        table = plot_table(sensors, dim, with_evidence=self.cost == "evidence")
        views, limits = views_of(sensors), self._limits(dim)
        if self.overflow == "thin":
            rows, is_complete = grow_nearest(table, views, limits, self.max_tuples)
            return ScoredTuples(rows.plot, rows.cost, rows.mean, rows.covariance, is_complete)
        every = grow_tuples(table, views, limits, self.max_tuples)
        if every is None:
            raise InvalidInputError(
                f"plots: more than {self.max_tuples} tuples lie in the gate; expected fewer "
                "plots, a smaller gate, a greater max_tuples or, to thin them, overflow='thin'"
            )
        return ScoredTuples(every.plot, every.cost, every.mean, every.covariance)

    def _limits(self, dim: int) -> PlotLimits:
        low, high = np.full(dim, -np.inf), np.full(dim, np.inf)
        if self.area is not None:
            low, high = float_array(self.area, "area", (2, dim))
        with_evidence = self.cost == "evidence"
        base_cost = 0.0
        if with_evidence and self.object_density is not None:
            base_cost = -math.log(self.object_density) - 0.5 * dim * math.log(2.0 * math.pi)
        return PlotLimits(
            gate=float(self.gate),
            with_evidence=with_evidence,
            base_cost=base_cost,
            max_cost=0.0 if self.negative_only else math.inf,
            with_lone=self.lone_plots,
            low=low,
            high=high,
            most=0,
            is_chain=False,
            stride=1,
        )
