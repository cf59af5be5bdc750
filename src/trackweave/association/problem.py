"""The assignment problem that every solver solves, and the answer with its certificate."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trackweave.arrays import FloatArray, IntArray, float_array, int_array, require_finite
from trackweave.association._clusters import has_repeats
from trackweave.errors import InvalidInputError

__all__ = ["Answer", "AssignmentProblem", "Certificate", "Status"]

MAX_ITEMS = 10_000_000
"""Greatest number of an item in a list; a larger one is a mistake that would fill the memory."""


class Status(StrEnum):
    """What is known of an answer."""

    OPTIMAL = "optimal"
    """The bound proves that no answer costs less."""
    FEASIBLE = "feasible"
    """Every rule is kept; the certificate's gap says how much better an answer could be."""


@dataclass(frozen=True, slots=True)
class Certificate:
    """How good an answer is, proven.

    Parameters
    ----------
    cost
        What the answer costs [nats].
    lower_bound
        No answer over the same sequences costs less [nats].
    status
        Whether that proves the answer best.
    """

    cost: float
    lower_bound: float
    status: Status

    @property
    def gap(self) -> float:
        """Distance from the bound relative to the cost, (cost − bound) / max(1, |cost|)."""
        return max(0.0, self.cost - self.lower_bound) / max(1.0, abs(self.cost))


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """A choice of disjoint sequences.

    Parameters
    ----------
    nodes
        The last node of each chosen sequence, in ascending order.
    certificate
        Cost, bound and status.
    evaluations
        How many complete or partial answers were tried.
    stop_reason
        Why the search ended, in words.
    prices
        What each item is worth to who covers it [nats], for a start next time; zero where
        nothing is known.
    """

    nodes: IntArray
    certificate: Certificate
    evaluations: int
    stop_reason: str
    prices: FloatArray

    @property
    def cost(self) -> float:
        """What the answer costs."""
        return self.certificate.cost

    @property
    def lower_bound(self) -> float:
        """No answer over the same sequences costs less."""
        return self.certificate.lower_bound

    @property
    def gap(self) -> float:
        """Distance from the bound relative to the cost."""
        return self.certificate.gap

    @property
    def status(self) -> Status:
        """Whether the answer is proven best."""
        return self.certificate.status


@dataclass(frozen=True, slots=True, eq=False)
class AssignmentProblem:
    """Choose disjoint sequences of least total cost from a forest of scored sequences.

    Each node is a sequence: its parent's, and then its own item. Items that no chosen sequence
    covers cost nothing.

    Parameters
    ----------
    parent
        The node of the sequence before the last item, shape (nodes,); -1 where there is none.
        A parent stands before its children.
    item
        Last item of each sequence, shape (nodes,), 0 to items − 1.
    cost
        What the sequence costs while it may still grow, shape (nodes,).
    total
        What it costs if it ends here, shape (nodes,); infinite where it may not end.
    must_cover
        Which items have to be covered, shape (items,); only an item that stands nowhere but at
        one root, which may end there, can be such. So there is always an answer.
    instant
        Rank of each item in time, shape (items,); items of one rank may join a sequence in any
        order.
    base_cost
        Added to the cost of every answer.
    row
        The row of ``from_tuples`` that each node stands for, -1 where none.

    Raises
    ------
    InvalidInputError
        If shapes do not fit, a parent does not stand before its child, an item is out of range
        or twice in a sequence, a cost is NaN or minus infinity, or an item cannot be one that
        must be covered.
    """

    parent: IntArray
    item: IntArray
    cost: FloatArray
    total: FloatArray
    must_cover: NDArray[np.bool_]
    instant: IntArray
    base_cost: float = 0.0
    row: IntArray | None = None

    def __post_init__(self) -> None:
        # Cast here, once, so that kernels may count on types and order in memory.
        parent = int_array(self.parent, "parent", (None,))
        must_cover = np.ascontiguousarray(self.must_cover, dtype=np.bool_)
        n_nodes, n_items = parent.shape[0], must_cover.shape[0]
        cast: dict[str, Any] = {
            "parent": parent,
            "must_cover": must_cover,
            "item": int_array(self.item, "item", (n_nodes,)),
            "cost": float_array(self.cost, "cost", (n_nodes,)),
            "total": float_array(self.total, "total", (n_nodes,)),
            "instant": int_array(self.instant, "instant", (n_items,)),
        }
        if self.row is not None:
            cast["row"] = int_array(self.row, "row", (n_nodes,))
        for name, values in cast.items():
            object.__setattr__(self, name, values)
        self._check_costs()
        self._check_forest()
        self._check_must_cover()

    def _check_costs(self) -> None:
        for name in ("cost", "total"):
            values = getattr(self, name)
            if np.any(np.isnan(values) | (values == -np.inf)):
                raise InvalidInputError(f"{name}: NaN or minus infinity; expected costs")
        if not np.isfinite(self.base_cost):
            raise InvalidInputError(f"base_cost: {self.base_cost}; expected a finite number")

    def _check_forest(self) -> None:
        if np.any(self.parent >= np.arange(self.n_nodes)) or np.any(self.parent < -1):
            raise InvalidInputError("parent: expected each parent before its children")
        if self.n_nodes and (self.item.min() < 0 or self.item.max() >= self.n_items):
            raise InvalidInputError(f"item: expected numbers from 0 to {self.n_items - 1}")
        if has_repeats(self.parent, self.item):
            raise InvalidInputError("item: a sequence has an item twice; expected once")

    def _check_must_cover(self) -> None:
        is_root = self.parent < 0
        inside = np.zeros(self.n_items, dtype=np.bool_)
        inside[self.item[~is_root]] = True
        n_roots = np.bincount(self.item[is_root], minlength=self.n_items)
        ends = np.zeros(self.n_items, dtype=np.bool_)
        ends[self.item[is_root & np.isfinite(self.total)]] = True
        if np.any(self.must_cover & (inside | (n_roots != 1) | ~ends)):
            raise InvalidInputError(
                "must_cover: expected only items that stand nowhere but at one root, "
                "which may end there"
            )

    @property
    def n_nodes(self) -> int:
        """Number of sequences."""
        return int(self.parent.shape[0])

    @property
    def n_items(self) -> int:
        """Number of items."""
        return int(self.must_cover.shape[0])

    @classmethod
    def from_tuples(cls, tuples: ArrayLike, costs: ArrayLike) -> Self:
        """Return the problem of choosing tuples that share no item.

        Parameters
        ----------
        tuples
            One row per candidate, one column per list, shape (rows, lists): the 1-based number
            of the item taken from each list, 0 for none. A row with a single item is the price
            of leaving that item alone, 0 where there is none.
        costs
            Cost of each row, finite.

        Returns
        -------
        The problem; ``row`` tells which row each node is.

        Raises
        ------
        InvalidInputError
            If a number is negative or far too large, a row is empty or a cost is not finite.
        """
        table = int_array(tuples, "tuples", (None, None))
        cost = float_array(costs, "costs", (table.shape[0],))
        require_finite(cost, "costs")
        size = _list_sizes(table)
        offset = np.concatenate([[0], np.cumsum(size)])
        items = np.where(table > 0, table + offset[:-1] - 1, -1)
        is_single = np.count_nonzero(table, axis=1) == 1
        alone = np.full(int(offset[-1]), np.inf)
        np.minimum.at(alone, items[is_single].max(axis=1, initial=-1), cost[is_single])
        alone[np.isinf(alone)] = 0.0
        # One more entry, so that -1 for none is worth nothing.
        extra = cost - np.append(alone, 0.0)[items].sum(axis=1)
        return cls(
            **_trie(items, extra, np.flatnonzero(~is_single)),
            must_cover=np.zeros(alone.shape[0], dtype=np.bool_),
            instant=np.repeat(np.arange(size.shape[0]), size),
            base_cost=float(alone.sum()),
        )


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


def _trie(item_rows: IntArray, extra: FloatArray, rows: IntArray) -> dict[str, Any]:
    """Return nodes for the rows and their prefixes, by the names of a problem's fields."""
    # A prefix that is no row itself may not end; while it grows it costs as little as the
    # cheapest row below it, or nothing.
    number: dict[tuple[int, int], int] = {}
    parent: list[int] = []
    item: list[int] = []
    row_of: list[int] = []
    total: list[float] = []
    for row in rows.tolist():
        node = -1
        for value in item_rows[row].tolist():
            if value < 0:
                continue
            key = (node, value)
            if key not in number:
                number[key] = len(parent)
                parent.append(node)
                item.append(value)
                row_of.append(-1)
                total.append(np.inf)
            node = number[key]
        if extra[row] < total[node]:
            total[node], row_of[node] = float(extra[row]), row
    cost = np.array(total, dtype=np.float64)
    for node in range(len(parent) - 1, -1, -1):
        if parent[node] >= 0:
            cost[parent[node]] = min(cost[parent[node]], cost[node])
    return {
        "parent": np.array(parent, dtype=np.int64),
        "item": np.array(item, dtype=np.int64),
        "cost": np.minimum(cost, 0.0),
        "total": np.array(total, dtype=np.float64),
        "row": np.array(row_of, dtype=np.int64),
    }
