"""Simulated annealing over moves. Nothing here checks or raises."""

import math

import numpy as np

from trackweave._loops import overwrite
from trackweave.arrays import IntArray
from trackweave.jit import jit
from trackweave.solvers.local._moves import (
    Moves,
    cost_of,
    draw_item,
    draw_near,
    limit_of,
    log_room,
    move,
    undo,
)

REPAIR_WINDOW = 3.0
"""Excess of what repairs a move, in temperatures."""


@jit
def anneal(
    moves: Moves,
    temperature: float,
    links: int,
    count: int,
    rng: np.random.Generator,
    holder: IntArray,
    current: float,
    best_holder: IntArray,
    best: float,
) -> tuple[float, float]:
    """Try so many moves at a temperature; return the cost then, and the best.

    A move that adds d to the cost is accepted with probability exp(−d / T). Writes ``holder``,
    and ``best_holder`` where it is better.
    """
    cost, excess, start, item = moves.cost, moves.excess, moves.start, moves.item
    list_start, listed, anchor = moves.list_start, moves.listed, moves.anchor
    n_items = holder.shape[0]
    idle, log = np.empty(n_items, dtype=np.int64), log_room(n_items, links)
    for _ in range(count):
        wanting = draw_item(moves.worth, excess, temperature, holder, rng)
        forced = draw_near(
            excess, listed, list_start[wanting], list_start[wanting + 1], temperature, rng
        )
        if forced < 0 or holder[wanting] == forced:
            continue
        limit = limit_of(excess, REPAIR_WINDOW * temperature, rng)
        threshold = -temperature * math.log(1.0 - rng.random())
        change, entries = move(
            cost, excess, start, item, list_start, listed, anchor, forced, limit, threshold,
            links, temperature, rng, holder, idle, log,
        )  # fmt: skip
        if change > threshold:
            undo(start, item, holder, log, entries)
            continue
        current += change
        if current < best:
            # Added up anew, so that rounding neither gathers nor passes for a gain.
            current = cost_of(moves, holder)
            if current < best:
                best = current
                overwrite(best_holder, holder)
    return current, best
