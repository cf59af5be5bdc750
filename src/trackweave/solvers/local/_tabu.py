"""Tabu search and annealing over moves. Nothing here checks or raises."""

import math

import numpy as np

from trackweave._loops import overwrite
from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.solvers.local._moves import (
    Moves,
    cost_of,
    draw_item,
    draw_near,
    hold,
    limit_of,
    log_room,
    move,
    undo,
)

REPAIR_WINDOW = 3.0
"""Excess of what repairs a move, in windows or temperatures."""


@jit
def is_tabu(until: IntArray, iteration: int, log: IntArray, entries: int) -> bool:
    """Tell whether a move brings or sends off a candidate that has to stay as it is."""
    for place in range(entries):
        entry = log[place]
        if until[entry if entry >= 0 else -1 - entry] > iteration:
            return True
    return False


@jit
def seek(
    moves: Moves,
    windows: FloatArray,
    links: int,
    sample: int,
    tenure: int,
    span: tuple[int, int],
    rng: np.random.Generator,
    until: IntArray,
    holder: IntArray,
    current: float,
    best_holder: IntArray,
    best: float,
) -> tuple[float, float]:
    """Make the iterations from the first of ``span`` to before the last.

    Each tries ``sample`` moves and makes the best that is not tabu, however much it adds to the
    cost; a tabu move may be made when it leads to a new best. What came may not be sent off, nor
    what went come back, for ``tenure`` to twice as many iterations. The window of an iteration
    is drawn between the two of ``windows``, evenly in its logarithm. Returns the cost then, and
    the best; writes ``until``, ``holder``, and ``best_holder`` where it is better.
    """
    cost, excess, start, item = moves.cost, moves.excess, moves.start, moves.item
    list_start, listed, anchor = moves.list_start, moves.listed, moves.anchor
    n_items = holder.shape[0]
    idle, log = np.empty(n_items, dtype=np.int64), log_room(n_items, links)
    kept = log.copy()
    for iteration in range(span[0], span[1]):
        window = windows[0] * (windows[1] / windows[0]) ** rng.random()
        n_kept, least = 0, math.inf
        for _ in range(sample):
            wanting = draw_item(moves.worth, excess, window, holder, rng)
            forced = draw_near(
                excess, listed, list_start[wanting], list_start[wanting + 1], window, rng
            )
            if forced < 0 or holder[wanting] == forced:
                continue
            limit = limit_of(excess, REPAIR_WINDOW * window, rng)
            change, entries = move(
                cost, excess, start, item, list_start, listed, anchor, forced, limit, 0.0,
                links, window, rng, holder, idle, log,
            )  # fmt: skip
            undo(start, item, holder, log, entries)
            if change >= least:
                continue
            if current + change < best or not is_tabu(until, iteration, log, entries):
                kept[:entries] = log[:entries]
                n_kept, least = entries, change
        if n_kept == 0:
            continue
        for place in range(n_kept):
            entry = kept[place]
            candidate = entry if entry >= 0 else -1 - entry
            hold(start, item, candidate, entry if entry >= 0 else -1, holder)
            until[candidate] = iteration + 1 + tenure + int((tenure + 1) * rng.random())
        current += least
        if current < best:
            # Added up anew, so that rounding neither gathers nor passes for a gain.
            current = cost_of(moves, holder)
            if current < best:
                best = current
                overwrite(best_holder, holder)
    return current, best


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
