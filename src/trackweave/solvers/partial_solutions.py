"""The cheapest selections of one component, as pieces that go with each other in any way."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import prod
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.solvers._enumeration import (
    Options,
    Walk,
    begin_walk,
    go_on,
    open_options,
)
from trackweave.solvers._kernels import Component
from trackweave.solvers._pricing import bound_at
from trackweave.solvers.protocol import Stop

__all__ = ["Enumeration", "PartialSolutions", "Piece", "combine"]

NARROW = 1.0 / 64.0
"""The narrowest gap of a component, as a part of the margin, if it has more than these nodes."""
SMALL = 500
WIDENING = 4.0
"""Each gap is so many times the one before."""
SLICE = 200_000
"""Options visited between two looks at the clock: a few milliseconds."""


class Piece(NamedTuple):
    """The cheapest selections of some families.

    ``node`` has a row for each selection and a column for each family, -1 for none; ``cost``
    ascends.
    """

    family: IntArray
    node: IntArray
    cost: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class PartialSolutions:
    """The cheapest selections of a component: one of each piece, which have all families.

    No other selection costs less than ``ceiling``, but those that come after as many as were asked
    for; ``is_all`` tells whether there is no other.
    """

    pieces: tuple[Piece, ...]
    ceiling: float
    is_all: bool

    @property
    def best(self) -> IntArray:
        """The cheapest selection: each family's node, -1 for none."""
        selection = np.full(sum(piece.family.shape[0] for piece in self.pieces), -1)
        for piece in self.pieces:
            selection[piece.family] = piece.node[0]
        return selection

    @property
    def cost(self) -> float:
        """What the cheapest selection costs."""
        return float(sum(piece.cost[0] for piece in self.pieces))

    def count(self) -> int:
        """Return how many selections the pieces make."""
        return prod(piece.cost.shape[0] for piece in self.pieces)

    def cost_of_best(self, rank: int) -> float:
        """Return what the selection of a rank, from 1 on, costs; infinite where there is none."""
        if rank == 1:
            return self.cost
        rows = combine(self.pieces, rank)[rank - 1 :].tolist()
        costs = [
            sum(piece.cost[row] for piece, row in zip(self.pieces, combination, strict=True))
            for combination in rows
        ]
        return float(costs[0]) if costs else np.inf

    def within(self, width: float) -> "PartialSolutions":
        """Return the pieces without selections that cost that much more than their best."""
        pieces = []
        for piece in self.pieces:
            count = int(np.searchsorted(piece.cost, piece.cost[0] + width, side="right"))
            pieces.append(Piece(piece.family, piece.node[:count], piece.cost[:count]))
        return PartialSolutions(tuple(pieces), self.ceiling, self.is_all)

    @classmethod
    def single(
        cls, component: Component, selection: IntArray, ceiling: float
    ) -> "PartialSolutions":
        """Return the pieces that make one known selection."""
        taken = selection[selection >= 0]
        cost = np.array([component.total[taken].sum()])
        piece = Piece(np.arange(selection.shape[0]), selection[None].copy(), cost)
        return cls((piece,), ceiling, False)


class Enumeration(NamedTuple):
    """The search of a component's cheapest selections, gap by gap.

    ``price`` are the items' prices. A piece has ``most`` selections at most, up to ``margin``
    dearer than the best [nats]; dearer ones only if it takes them to make ``least`` selections of
    the component. Beyond ``widest`` there are none. ``visits`` is the greatest number of options
    tried.
    """

    component: Component
    price: FloatArray
    most: int
    least: int
    margin: float
    widest: float
    visits: int
    stop: Stop | None

    def run(self, known: float) -> tuple[PartialSolutions | None, int]:
        """Return the pieces of the widest gap within the budget, and how many options it took."""
        # None where even the narrowest gap takes too long. ``known`` is what some selection costs.
        bound = bound_at(self.component, self.price)
        slack = 1e-9 * max(1.0, abs(known), abs(bound))
        is_small = self.component.parent.shape[0] <= SMALL
        margin = min(self.margin if is_small else self.margin * NARROW, self.widest)
        found, visits = None, 0
        while self.stop is None or not self.stop():
            limit = known + margin + slack
            options = open_options(self.component, self.price, limit - bound)
            pieces, tried = self._explore(options, limit, self.visits - visits)
            visits += tried
            if not pieces:
                break
            is_open = margin >= self.widest
            is_all = is_open and all(piece.cost.shape[0] < self.most for piece in pieces)
            found = PartialSolutions(tuple(pieces), np.inf if is_open else limit - slack, is_all)
            dearest = found.cost_of_best(self.least)
            if is_open or (margin >= self.margin and dearest <= limit):
                break
            margin = max(WIDENING * margin, options.further - (known - bound))
            if np.isfinite(dearest):
                # What these pieces make bounds how dear the last one asked for can be.
                margin = max(min(margin, self.margin), dearest - known)
            margin = min(margin, self.widest)
        return found, visits

    def _explore(self, options: Options, limit: float, visits: int) -> tuple[list[Piece], int]:
        """Return the pieces of all selections up to a cost, none if that takes too long."""
        component, is_fixed = self.component, options.group < 0
        if np.any(component.must & is_fixed & (options.fixed < 0)):
            return [], 0
        taken = options.fixed[is_fixed]
        cost = float(component.total[taken[taken >= 0]].sum())
        pieces = [Piece(np.flatnonzero(is_fixed), taken[None], np.array([cost]))]
        walks = self._walks(options)
        # What the others cost at least is known better with each that is done.
        floor, tried = cost + sum(float(walk.limit[0]) for walk in walks), 0
        for walk in walks:
            walk.limit[1] = limit - floor + walk.limit[0]
            tried += self._finish(options, walk, visits - tried)
            n_kept = int(walk.tally[2])
            if walk.tally[0] >= 0 or n_kept == 0:
                return [], tried
            ranks = np.argsort(walk.kept_cost[:n_kept], kind="stable")
            pieces.append(Piece(walk.order, walk.kept[ranks], walk.kept_cost[ranks]))
            floor += float(pieces[-1].cost[0] - walk.limit[0])
        return pieces, tried

    def _walks(self, options: Options) -> list[Walk]:
        """Return the enumeration of each group."""
        order = np.argsort(options.group, kind="stable")
        group = options.group[order]
        starts = np.searchsorted(group, np.arange(group.max(initial=-1) + 2))
        return [
            begin_walk(self.component, self.price, options, order[first:last], self.most)
            for first, last in pairwise(starts.tolist())
        ]

    def _finish(self, options: Options, walk: Walk, visits: int) -> int:
        """Go through a group, or as far as the budget goes; return how many options it took."""
        while not go_on(
            self.component, self.price, options, walk, min(SLICE, visits - int(walk.tally[1]))
        ):
            if walk.tally[1] >= visits or (self.stop is not None and self.stop()):
                break
        return int(walk.tally[1])


def combine(pieces: Sequence[Piece], most: int) -> IntArray:
    """Return the cheapest combinations of one selection of each piece, a row of each."""
    # At most so many, the cheapest first, shape (combinations, pieces).
    # The k-th best takes the i-th of one and the j-th of the other with i j ≤ k.
    count = most // np.arange(1, most + 1)
    left = np.repeat(np.arange(most), count)
    right = np.arange(left.shape[0]) - np.repeat(np.cumsum(count) - count, count)
    rows, cost = np.zeros((1, len(pieces)), dtype=np.int64), np.zeros(1)
    for place, piece in enumerate(pieces):
        if piece.cost.shape[0] == 1:
            cost = cost + piece.cost[0]
            continue
        is_pair = (left < cost.shape[0]) & (right < piece.cost.shape[0])
        total = cost[left[is_pair]] + piece.cost[right[is_pair]]
        best = np.argsort(total, kind="stable")[:most]
        rows, cost = rows[left[is_pair][best]], total[best]
        rows[:, place] = right[is_pair][best]
    return rows
