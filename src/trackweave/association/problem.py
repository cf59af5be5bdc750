"""The assignment problem that every solver solves, and the answer with its certificate."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trackweave.arrays import FloatArray, IntArray, float_array, int_array
from trackweave.association._clusters import has_repeats
from trackweave.association.certificate import Certificate, Status
from trackweave.association.tuples import (
    LARGEST_SUM,
    GivenCosts,
    Requirement,
    numbered,
    parts_of_array,
    parts_of_tuples,
)
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_number
from trackweave.summaries import summary

__all__ = ["Answer", "AssignmentProblem", "Certificate", "Status"]


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
    node_probability
        How probable each node is to be chosen, shape (nodes,), from the solvers that tell; else
        None.
    problem
        What it answers.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> answer = tw.solve(problem, rng=np.random.default_rng(1))
    >>> answer.cost, answer.lower_bound, answer.gap  # nats
    (-7.0, -7.0, 0.0)
    >>> answer.tuples
    array([[1, 1],
           [2, 2]])
    """

    nodes: IntArray
    certificate: Certificate
    evaluations: int
    stop_reason: str
    prices: FloatArray
    node_probability: FloatArray | None = None
    problem: "AssignmentProblem | None" = None

    def __repr__(self) -> str:
        return (
            f"Answer(cost={self.cost:.10g}, lower_bound={self.lower_bound:.10g}, "
            f"gap={self.gap:.3g}, status={self.status.value!r}, {len(self.nodes)} sequences, "
            f"stop_reason={self.stop_reason!r})"
        )

    @property
    def tuples(self) -> NDArray[Any]:
        """The chosen tuples in the problem's own numbers or names, shape (chosen, lists).

        Rows as ``from_tuples`` had them, in their order; indices of the array of ``from_array``.
        Items that are left alone are not among them, nor is anything where the status is
        infeasible or unknown. Of a problem made of sequences: the items of each, -1 after the
        last.

        Raises
        ------
        InvalidInputError
            If the answer is of no problem.
        """
        if self.problem is None:
            raise InvalidInputError("tuples: the answer of no problem; expected one from a solver")
        nodes = self.nodes if np.isfinite(self.cost) else self.nodes[:0]
        return self.problem.tuples_of(nodes)

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
    requirement
        Further items that have to be covered, as ``from_tuples`` makes them; there may be no
        answer then.
    unit
        What size costs are of that matter: 1e-9 of it is rounding. None for what an item's
        cheapest sequence costs, at the median.
    table
        What each ``row`` was made of: a row for each candidate, a column for each list.
    given
        What rows and items cost as they were given, from which costs of answers are added up;
        None for by ``total`` and ``base_cost``, and dropped where these are others.

    Raises
    ------
    InvalidInputError
        If shapes do not fit, a parent does not stand before its child, an item is out of range
        or twice in a sequence, a cost is NaN or minus infinity, costs are too large to be added,
        or an item cannot be one that must be covered.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> # Three candidate pairs of an item of one list and one of another; costs in nats.
    >>> problem = tw.AssignmentProblem.from_tuples(
    ...     [["a", "x"], ["a", "y"], ["b", "y"]], [-4.0, -6.0, -3.0]
    ... )
    >>> problem.n_items
    4
    >>> tw.solve(problem, rng=np.random.default_rng(1)).tuples
    array([['a', 'x'],
           ['b', 'y']], dtype=object)
    """

    parent: IntArray
    item: IntArray
    cost: FloatArray
    total: FloatArray
    must_cover: NDArray[np.bool_]
    instant: IntArray
    base_cost: float = 0.0
    row: IntArray | None = None
    requirement: Requirement | None = None
    unit: float | None = None
    table: NDArray[Any] | None = None
    given: GivenCosts | None = None

    __repr__ = summary

    def __post_init__(self) -> None:
        # Cast here, once, so that kernels may count on types and order in memory.
        parent = int_array(self.parent, "parent", (None,))
        must_cover = float_array(self.must_cover, "must_cover", (None,)) != 0.0
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
        object.__setattr__(self, "base_cost", checked_number(self.base_cost, "base_cost"))
        if self.unit is not None:
            object.__setattr__(self, "unit", checked_number(self.unit, "unit"))
        if self.given is not None and not (
            self.row is not None and self.given.are_of(self.row, self.total, self.base_cost)
        ):
            object.__setattr__(self, "given", None)
        self._check_costs()
        self._check_forest()
        self._check_must_cover()

    def _check_costs(self) -> None:
        for name in ("cost", "total"):
            values = getattr(self, name)
            if np.any(np.isnan(values) | (values == -np.inf)):
                raise InvalidInputError(f"{name}: NaN or minus infinity; expected costs")
        if self.unit is not None and not self.unit > 0.0:
            raise InvalidInputError(f"unit: {self.unit}; expected a number > 0")
        size = float(np.abs(self.total[np.isfinite(self.total)]).max(initial=0.0))
        if size * self.n_nodes > LARGEST_SUM:
            raise InvalidInputError(
                f"total: a cost of size {size:.3g}; expected {self.n_nodes} that can be added"
            )

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

    def cost_of(self, nodes: IntArray) -> float:
        """Return what an answer costs; an item that has to be covered and is not, its penalty.

        Parameters
        ----------
        nodes
            The last node of each sequence, none of which share an item.

        Returns
        -------
        The cost [nats].
        """
        if self.given is not None and self.row is not None:
            cost = self.given.total(self.row[nodes])
            if np.isfinite(cost):
                return cost
        return self.base_cost + float(self.total[nodes].sum())

    def tuples_of(self, nodes: IntArray) -> NDArray[Any]:
        """Return what nodes stand for, in the problem's own numbers or names.

        Parameters
        ----------
        nodes
            Numbers of nodes.

        Returns
        -------
        As ``Answer.tuples``.
        """
        if self.table is not None and self.row is not None:
            rows = np.sort(self.row[nodes])
            return self.table[rows[rows >= 0]]
        sequences: list[list[int]] = []
        for node in nodes.tolist():
            sequences.append([])
            while node >= 0:
                sequences[-1].insert(0, int(self.item[node]))
                node = int(self.parent[node])
        table = np.full((len(sequences), max(map(len, sequences), default=0)), -1, dtype=np.int64)
        for place, items in enumerate(sequences):
            table[place, : len(items)] = items
        return table

    @classmethod
    def from_tuples(cls, tuples: ArrayLike, costs: ArrayLike, *, alone: ArrayLike = 0.0) -> Self:
        """Return the problem of choosing tuples that share no item.

        Parameters
        ----------
        tuples
            One row per candidate, one column per list, shape (rows, lists): the 1-based number
            of the item taken from each list, 0 for none; or its name, None or an empty text for
            none. A row with a single item is the price of leaving that item alone, 0 where there
            is none.
        costs
            Cost of each row, finite [nats]. Of equal rows the cheapest counts.
        alone
            What it costs to leave an item that no row prices: one number, or one for each item,
            list after list; infinite where the item has to be covered. A list's items are all
            numbers up to the greatest that stands in it, or all its names in the order in which
            they first come.

        Returns
        -------
        The problem; ``row`` tells which row each node is.

        Raises
        ------
        InvalidInputError
            If a number is negative or far too large, a row is empty, a cost is not finite, a
            price is NaN or minus infinity, or costs are too large to be added or are lost beside
            far larger ones.
        """
        table, numbers = numbered(tuples)
        return cls(**parts_of_tuples(numbers, costs, alone), table=table)

    @classmethod
    def from_array(cls, costs: ArrayLike, *, alone: ArrayLike = np.inf) -> Self:
        """Return the problem of choosing entries of an array that share no index of any axis.

        Parameters
        ----------
        costs
            What each tuple costs, shape (items of list 1, items of list 2, …) [nats]; infinite
            where it is not allowed.
        alone
            As in ``from_tuples``; by default every item has to be covered.

        Returns
        -------
        The problem; ``row`` counts the finite entries in the order of the array.

        Raises
        ------
        InvalidInputError
            If there are fewer than two axes, an entry or a price is NaN or minus infinity, or
            costs are too large to be added or are lost beside far larger ones.

        Examples
        --------
        >>> import numpy as np
        >>> import trackweave as tw
        >>> costs = np.array([[4.0, 1.0], [2.0, np.inf]])
        >>> problem = tw.AssignmentProblem.from_array(costs)  # every row and column once
        >>> answer = tw.solve(problem, rng=np.random.default_rng(1))
        >>> answer.tuples
        array([[0, 1],
               [1, 0]])
        >>> costs[tuple(answer.tuples.T)].sum()
        np.float64(3.0)
        """
        parts, indices = parts_of_array(costs, alone)
        return cls(**parts, table=indices)
