"""From tables of tuples and dense arrays of costs to the parts of an assignment problem."""

from math import fsum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trackweave.arrays import (
    FloatArray,
    IntArray,
    float_array,
    int_array,
    n_axes,
    require_finite,
)
from trackweave.association._tuples import build_trie, cost_shares
from trackweave.errors import InvalidInputError

__all__ = [
    "LARGEST_SUM",
    "MAX_ITEMS",
    "GivenCosts",
    "Requirement",
    "numbered",
    "parts_of_array",
    "parts_of_tuples",
    "usual_size",
]

MAX_ITEMS = 10_000_000
"""Greatest number of an item in a list; a larger one is a mistake that would fill the memory."""

LARGEST_SUM = 1e306
"""Sums of costs beyond this are too near to overflow [nats]."""
COARSE = 1e-6
"""A cost may lose this part of itself, or of the usual one, beside the prices of its items."""


class Requirement(NamedTuple):
    """Items that an answer has to cover, though no sequence alone is sure to.

    The totals of a problem are less by ``penalty`` for each such ``item`` that they cover, and
    its base cost is more by the penalty for each. The penalty exceeds what any two answers
    differ by, so leaving one uncovered never pays. No answer that covers them all costs more
    than ``ceiling`` [nats].
    """

    item: IntArray
    penalty: float
    ceiling: float


class GivenCosts(NamedTuple):
    """What tuples cost before the prices of their items were taken off them [nats].

    Far larger prices take digits with them: an answer's cost is added up from what was given.
    ``row`` holds what each row costs, ``item`` the items of each, shape (rows, lists), -1 for
    none; ``alone`` what it costs to leave an item, infinite where it has to be covered; ``extra``
    and ``base`` what was made of them, the totals of rows and the base cost.
    """

    row: FloatArray
    item: IntArray
    alone: FloatArray
    extra: FloatArray
    base: float

    def are_of(self, row: IntArray, total: FloatArray, base: float) -> bool:
        """Tell whether nodes of these rows still have the totals that were made of them."""
        ends = row >= 0
        return base == self.base and np.array_equal(total[ends], self.extra[row[ends]])

    def total(self, rows: IntArray) -> float:
        """Return what an answer of these rows costs, the nearest number to the true sum."""
        # One more entry takes what -1 for none writes.
        is_left = np.ones(self.alone.shape[0] + 1, dtype=np.bool_)
        is_left[self.item[rows]] = False
        return fsum([*self.row[rows].tolist(), *self.alone[is_left[:-1]].tolist()])


def numbered(tuples: ArrayLike) -> tuple[NDArray[Any], ArrayLike]:
    """Return a table of tuples as an array, and with numbers for its items."""
    # Each list's names are numbered from 1 in the order in which they first come, 0 for None or
    # ""; a table without names is itself.
    try:
        table = np.asarray(tuples)
        if table.dtype.kind in "US":
            # Text of one length for all would cut nothing here, but turns None into a name.
            table = np.asarray(tuples, dtype=object)
    except ValueError as err:
        raise InvalidInputError(
            f"tuples: {tuples!r:.80}; expected rows of one length, of numbers or names"
        ) from err
    if table.dtype.kind == "T":
        table = table.astype(object)
    if table.dtype.kind != "O" or table.ndim != 2 or not _has_names(table):
        return table, table
    numbers = np.zeros(table.shape, dtype=np.int64)
    for place in range(table.shape[1]):
        known: dict[str, int] = {}
        for row, name in enumerate(table[:, place].tolist()):
            if _is_none(name):
                continue
            if not isinstance(name, str):
                raise InvalidInputError(
                    f"tuples[{row}, {place}]: {name!r:.80}; expected a name as the others, or None"
                )
            numbers[row, place] = known.setdefault(name, len(known) + 1)
    return table, numbers


def _is_none(name: object) -> bool:
    """Tell whether an entry stands for no item, in any of the ways that tables know."""
    is_nan = isinstance(name, float) and name != name
    return name is None or is_nan or type(name).__name__ == "NAType" or name == ""


def _has_names(table: NDArray[Any]) -> bool:
    return any(isinstance(entry, str) for entry in table.ravel().tolist())


def parts_of_tuples(
    tuples: ArrayLike, costs: ArrayLike, alone: ArrayLike, sizes: tuple[int, ...] | None = None
) -> dict[str, Any]:
    """Return the fields of the problem of choosing tuples that share no item."""
    # A list of no size has as many items as the greatest number in it.
    table = int_array(tuples, "tuples", (None, None))
    cost = float_array(costs, "costs", (table.shape[0],))
    require_finite(cost, "costs")
    size = _list_sizes(table) if sizes is None else np.array(sizes, dtype=np.int64)
    offset = np.concatenate([[0], np.cumsum(size)]).astype(np.int64)
    items = np.where(table > 0, table + offset[:-1] - 1, -1)
    count = np.count_nonzero(table, axis=1)
    is_single = count == 1
    price = _prices_alone(items[is_single].max(axis=1, initial=-1), cost[is_single], alone, offset)
    rows = np.flatnonzero(~is_single)
    # What is too large overflows here, and is refused below.
    with np.errstate(over="ignore", invalid="ignore"):
        requirement = _requirement(items[rows], cost[rows], price)
        worth = price
        if requirement is not None:
            worth = price.copy()
            worth[requirement.item] = requirement.penalty
        base = float(worth.sum())
        # One more entry, so that -1 for none is worth nothing.
        shift = np.append(worth, 0.0)[items].sum(axis=1)
        extra = cost - shift
    unit = usual_size(items[rows], cost[rows], price)
    _require_digits(cost[rows], shift[rows], base, unit)
    trie = build_trie(items, extra, rows[_sorted_rows(table[rows], size)])
    return {
        **trie._asdict(),
        "must_cover": np.zeros(price.shape[0], dtype=np.bool_),
        "instant": np.repeat(np.arange(size.shape[0]), size),
        "base_cost": base,
        "requirement": requirement,
        "unit": unit,
        "given": GivenCosts(cost, items, price, extra, base),
    }


def usual_size(items: IntArray, cost: FloatArray, price: FloatArray) -> float:
    """Return the size, above 0, of an item's cheapest sequence, at the median over the items."""
    # A few dear sequences, which nobody would take, leave it as it is. Items are those of each
    # sequence, -1 for none. A cost is infinite where a sequence may not be taken, a price where an
    # item may not be left. It is 1 where nothing costs anything.
    size = np.where(cost == 0.0, np.inf, np.abs(cost))
    # One more entry takes what -1 for none writes.
    least = np.append(np.where(price == 0.0, np.inf, np.abs(price)), np.inf)
    for column in range(items.shape[1]):
        np.minimum.at(least, items[:, column], size)
    known = np.sort(least[:-1][np.isfinite(least[:-1])])
    return float(known[known.size // 2]) if known.size else 1.0


def parts_of_array(costs: ArrayLike, alone: ArrayLike) -> tuple[dict[str, Any], IntArray]:
    """Return the fields of the problem of choosing entries of an array, and those allowed."""
    # These are told by their indices.
    n_lists = n_axes(costs, "costs")
    cost = float_array(costs, "costs", (None,) * n_lists)
    if n_lists < 2:
        raise InvalidInputError(
            f"costs: an array of shape {cost.shape}; expected one axis per list, at least two"
        )
    if np.any(np.isnan(cost) | (cost == -np.inf)):
        raise InvalidInputError("costs: NaN or minus infinity; expected costs, or infinity")
    allowed = np.argwhere(np.isfinite(cost))
    parts = parts_of_tuples(allowed + 1, cost[tuple(allowed.T)], alone, cost.shape)
    return parts, allowed.astype(np.int64, copy=False)


def _list_sizes(table: IntArray) -> IntArray:
    """Return the greatest number in each column of a table of tuples, once it is found sound."""
    if np.any(table < 0):
        raise InvalidInputError("tuples: a negative number; expected 0 for none, or 1 and up")
    if np.any(~table.any(axis=1)):
        raise InvalidInputError("tuples: a row without items; expected at least one")
    size: IntArray = table.max(axis=0, initial=0)
    if np.any(size > MAX_ITEMS):
        raise InvalidInputError(
            f"tuples: the number {size.max()}; expected items numbered from 1 up to {MAX_ITEMS}"
        )
    return size


def _prices_alone(
    item: IntArray, cost: FloatArray, alone: ArrayLike, offset: IntArray
) -> FloatArray:
    """Return what it costs to leave each item: its own row's cost, or what is said of all."""
    n_items = int(offset[-1])
    default = float_array(alone, "alone", () if n_axes(alone, "alone") == 0 else (n_items,))
    if np.any(np.isnan(default) | (default == -np.inf)):
        raise InvalidInputError("alone: NaN or minus infinity; expected prices, or infinity")
    own = np.full(n_items, np.inf)
    np.minimum.at(own, item, cost)
    price: FloatArray = np.where(np.isinf(own), default, own)
    return price


def _requirement(items: IntArray, cost: FloatArray, price: FloatArray) -> Requirement | None:
    """Return what is said of the items whose price is infinite; None where there is none."""
    required = np.flatnonzero(np.isinf(price))
    if not required.size:
        return None
    # Each tuple's cost is shared out over its items, so an answer's is a sum over the items.
    least = np.where(np.isinf(price), np.inf, price)
    greatest = np.where(np.isinf(price), -np.inf, price)
    cost_shares(items, cost, least, greatest)
    least[np.isinf(least)] = greatest[np.isinf(greatest)] = 0.0
    ceiling = float(greatest.sum())
    spread = ceiling - float(np.minimum(least, 0.0).sum())
    if not spread < LARGEST_SUM:
        raise InvalidInputError("costs: too large to be added; expected smaller numbers")
    # A power of two takes no digits from whole costs.
    # Of the size of the costs, so that small ones keep their digits.
    size = max(spread, float(np.abs(cost).max(initial=0.0))) or 1.0
    return Requirement(required, 2.0 ** float(np.ceil(np.log2(4.0 * size))), ceiling)


def _require_digits(cost: FloatArray, shift: FloatArray, base: float, unit: float) -> None:
    """Refuse costs that overflow, or whose digits are lost, once prices are taken off them."""
    if not (np.abs(base) < LARGEST_SUM and np.all(np.abs(shift) < LARGEST_SUM)):
        raise InvalidInputError("costs: too large to be added; expected smaller numbers")
    lost = np.abs(((cost - shift) + shift) - cost) > COARSE * np.maximum(unit, np.abs(cost))
    if np.any(lost):
        place = int(np.flatnonzero(lost)[0])
        raise InvalidInputError(
            f"costs: {cost[place]} is lost beside {abs(shift[place]):.3g}, the prices of leaving "
            "its items or what other costs make of them; expected costs and prices of like size, "
            "and infinity where a tuple is not allowed or an item has to be covered"
        )


def _sorted_rows(table: IntArray, size: IntArray) -> NDArray[np.intp]:
    """Return the order of the rows by their first column, then the second, and so on."""
    key = np.zeros(table.shape[0], dtype=np.int64)
    if np.prod(size.astype(np.float64) + 1.0) < 2.0**62:
        for column in range(table.shape[1]):
            key = key * (size[column] + 1) + table[:, column]
        return np.argsort(key, kind="stable")
    return np.lexsort(table.T[::-1])
