"""Pheromone on the options of families, as a value."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.solvers._kernels import Component
from trackweave.solvers._pricing import price_nodes
from trackweave.solvers.ants._trails import Options, deposit, improve_selection, list_options
from trackweave.solvers.resumable import Start

__all__ = ["TrailSearch", "Trails", "make_trails", "typical_excess"]

GAIN = 1e-12
"""A smaller gain is rounding."""
WORK = 2_000_000
"""How many nodes one improvement looks at: a few milliseconds."""
STRIDE = 61
"""How many families further on the next iteration's improvement begins."""


@dataclass(frozen=True, slots=True, eq=False)
class Trails:
    """What ants choose from and what they see of it.

    Parameters
    ----------
    options
        The candidates of each family.
    visibility
        How attractive each is without pheromone.
    least
        The lower limit of pheromone, in units of the upper one.
    """

    options: Options
    visibility: FloatArray
    least: float

    def narrowed(self, component: Component) -> Component:
        """Return the component with the candidates alone as members of their families.

        Parameters
        ----------
        component
            What is searched.

        Returns
        -------
        The component; its nodes are all there.
        """
        start, node, _ = self.options
        family = np.repeat(np.arange(start.shape[0] - 1), np.diff(start))[node >= 0]
        narrow_start = np.searchsorted(family, np.arange(start.shape[0]))
        return component._replace(members=node[node >= 0], start=narrow_start)


def make_trails(
    component: Component,
    price: FloatArray,
    candidates: int,
    temperature: float,
    best_probability: float,
) -> Trails:
    """Return the trails over a component's candidates of least reduced cost.

    Parameters
    ----------
    component
        What is searched.
    price
        Of each item.
    candidates, temperature, best_probability
        See ``MaxMinAntSystem``.

    Returns
    -------
    The trails.
    """
    priced, reduced = np.empty_like(component.total), np.empty_like(component.total)
    price_nodes(component, price, priced, reduced)
    options = list_options(component, reduced, candidates)
    visibility = np.exp(-options.excess / (temperature * typical_excess(options)))
    # Stützle & Hoos (2000), eq. 11: with n choices, of half the options each on average.
    n_families = component.must.shape[0]
    root = best_probability ** (1.0 / n_families)
    average = 0.5 * options.node.shape[0] / n_families
    least = (1.0 - root) / (max(average - 1.0, 1.0) * root)
    return Trails(options, visibility, min(1.0, float(least)))


@dataclass(frozen=True, slots=True, eq=False)
class TrailSearch:
    """Where a search stands; it is replaced, never changed.

    ``position`` ants of the present iteration have chosen, ``sent`` in all; ``present`` is the
    best choice of the iteration. ``lasting`` is the best since trails were last laid anew,
    ``idle`` iterations ago.
    """

    trails: Trails
    pheromone: FloatArray
    position: int
    sent: int
    iteration: int
    present: IntArray
    present_cost: float
    lasting: IntArray
    lasting_cost: float
    idle: int
    selection: IntArray
    best: float
    rng: np.random.Generator

    @classmethod
    def begin(cls, trails: Trails, start: Start) -> Self:
        """Return a search before its first ant; what is known beforehand lays pheromone too.

        Parameters
        ----------
        trails
            What ants choose from.
        start
            What is known beforehand.

        Returns
        -------
        The search, with pheromone at its upper limit.
        """
        known = start.selection.copy()
        return cls(
            trails=trails,
            pheromone=np.ones(trails.visibility.shape[0]),
            position=0,
            sent=0,
            iteration=0,
            present=known,
            present_cost=np.inf,
            lasting=known,
            lasting_cost=start.cost,
            idle=0,
            selection=known,
            best=start.cost,
            rng=start.rng,
        )

    @property
    def evaluations(self) -> int:
        """How many ants chose."""
        return self.sent

    @property
    def at_rest(self) -> bool:
        """Whether an iteration is complete."""
        return self.position == 0 and self.iteration > 0

    def improved(self, component: Component) -> "TrailSearch":
        """Return the search with the best choice of its iteration improved locally.

        Parameters
        ----------
        component
            What is searched.

        Returns
        -------
        The search. Candidates alone are tried first, and all sequences where that promises a
        better answer.
        """
        present = self.present.copy()
        first = self.iteration * STRIDE % present.shape[0]
        narrow = self.trails.narrowed(component)
        cost = improve_selection(narrow, component, present, first, WORK)
        if cost < self.lasting_cost - GAIN:
            cost = improve_selection(component, component, present, first, WORK)
        return replace(self, present=present, present_cost=cost)

    def renewed(self, persistence: float, patience: int) -> "TrailSearch":
        """Return the search at the beginning of its next iteration, pheromone laid.

        Parameters
        ----------
        persistence, patience
            See ``MaxMinAntSystem``.

        Returns
        -------
        The search.
        """
        lasting, lasting_cost, idle = self.lasting, self.lasting_cost, self.idle + 1
        if self.present_cost < lasting_cost - GAIN:
            lasting, lasting_cost, idle = self.present, self.present_cost, 0
        is_better = lasting_cost < self.best - GAIN
        pheromone = self.pheromone.copy()
        if idle < patience:
            layer = lasting if self.iteration % 2 == 0 else self.present
            deposit(self.trails.options, layer, persistence, self.trails.least, pheromone)
        else:
            pheromone[:] = 1.0
            lasting_cost, idle = np.inf, 0
        return replace(
            self,
            pheromone=pheromone,
            position=0,
            iteration=self.iteration + 1,
            present_cost=np.inf,
            lasting=lasting,
            lasting_cost=lasting_cost,
            idle=idle,
            selection=lasting if is_better else self.selection,
            best=min(self.best, lasting_cost) if is_better else self.best,
        )

    def admit(self, selection: IntArray, cost: float) -> "TrailSearch":
        """Return the search with another's answer taken in, if it is better than its own.

        Parameters
        ----------
        selection, cost
            The other's answer.

        Returns
        -------
        The search with that as the best since trails were laid anew, which lays pheromone.
        """
        if cost >= self.lasting_cost - GAIN:
            return self
        is_better = cost < self.best - GAIN
        return replace(
            self,
            lasting=selection,
            lasting_cost=cost,
            idle=0,
            selection=selection if is_better else self.selection,
            best=cost if is_better else self.best,
        )


def typical_excess(options: Options) -> float:
    """Return what the second choice of a family typically costs above the first.

    Parameters
    ----------
    options
        What families choose from.

    Returns
    -------
    The median over the families; where that is nothing or rounding, the mean excess of all that
    is not least, and 1 where all is.
    """
    second = options.start[:-1][np.diff(options.start) > 1] + 1
    median = float(np.median(options.excess[second])) if second.size else 0.0
    positive = options.excess[options.excess > 0.0]
    mean = float(positive.mean()) if positive.size else 1.0
    return median if median > 1e-6 * mean else mean
