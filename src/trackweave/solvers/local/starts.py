"""What local searches begin with."""

from typing import NamedTuple

import numpy as np

from trackweave.arrays import IntArray
from trackweave.solvers._kernels import Component, cheapest_first, repair
from trackweave.solvers.lists import Lists, lists_of
from trackweave.solvers.local._moves import (
    Moves,
    begin_holding,
    cost_of,
    list_moves,
    selection_of,
    typical_excess,
)
from trackweave.solvers.resumable import Start, View

__all__ = ["CHUNK", "SearchStart", "search_start"]

CHUNK = 2_000
"""Moves tried between two looks at the clock: a few milliseconds, however large the component."""
RANK = 10
"""The excess of an item's candidate of this rank is typical of what moves cost."""


class SearchStart(NamedTuple):
    """What a local search of a component stands on.

    ``scale`` is the typical excess of a move [nats], ``holder`` the best answer known
    beforehand, and ``cost`` what it costs.
    """

    moves: Moves
    lists: Lists
    scale: float
    holder: IntArray
    cost: float

    def holding(self, component: Component, selection: IntArray | None) -> IntArray:
        """Return who holds what in a selection; None for nothing taken."""
        nothing = np.full(component.must.shape[0], -1, dtype=np.int64)
        return begin_holding(self.moves, component, nothing if selection is None else selection)

    def selection(self, component: Component, holder: IntArray) -> IntArray:
        """Return the selection in which these candidates hold the items."""
        selection = np.empty(component.must.shape[0], dtype=np.int64)
        selection_of(self.moves, component, holder, selection)
        return selection

    def held(
        self, component: Component, selection: IntArray, cost: float, best: float
    ) -> tuple[IntArray, float] | None:
        """Return who holds what in another's answer, and its cost; None if no better than best."""
        if cost >= best:
            return None
        holder = self.holding(component, selection)
        # Another number by rounding, or because it stands on candidates that are none here.
        cost = cost_of(self.moves, holder)
        return (holder, cost) if cost < best else None


def search_start(view: View, start: Start, *, seeded: bool) -> SearchStart:
    """Return the candidates that a better answer may have, and the best known answer."""
    component = view.component
    # Better prices make for better moves.
    price = view.price if seeded else np.zeros(component.n_items)
    selection, cost = start.selection.copy(), start.cost
    trial, owner = np.empty_like(selection), np.empty(component.n_items, dtype=np.int64)
    if not np.isfinite(cost):
        cost, _ = cheapest_first(component, selection)
    for seed in start.seeds:
        # Seeds may share items, so the cheapest sequences go first.
        taken = np.where(seed >= 0, component.total[seed], np.inf)
        order = np.argsort(taken, kind="stable")
        known = repair(component, order, seed, component.total, trial, owner)
        if known < cost:
            selection, cost = trial.copy(), known
    moves = list_moves(component, price, cost)
    holder = begin_holding(moves, component, selection)
    lists = lists_of(component, view.instant)
    return SearchStart(moves, lists, typical_excess(moves, RANK), holder, cost_of(moves, holder))
