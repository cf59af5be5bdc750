"""Assignment problems from files, and answers as tables."""

import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.problem import Answer, AssignmentProblem, Status
from trackweave.association.tuples import MAX_ITEMS
from trackweave.errors import DataFormatError
from trackweave.io.checks import Range, RowChecks
from trackweave.io.columns import cell_text, read_numbers
from trackweave.io.csv_text import parse_csv
from trackweave.io.tables import ENDINGS, TableSource, load_table, read_bytes

__all__ = ["ProblemTable", "answer_frame", "read_problem"]

# Beyond it the small costs beside a large one would drown in rounding.
_LARGEST_COST = 1e12
_COST = Range(-_LARGEST_COST, _LARGEST_COST)
_ITEM = Range(0, MAX_ITEMS, expected="a whole number from 1 up, or 0 for none")
_AXIAL_ENDING = ".txt"
# Eight million costs; the tuples of more would fill the memory.
_MOST_AXIAL_ITEMS = 200


@dataclass(frozen=True, slots=True, eq=False)
class ProblemTable:
    """Candidate tuples of items and their costs, as a file has them."""

    # One row per candidate, one column per list, shape (rows, lists): the 1-based number of the
    # item taken from each list, 0 for none.
    tuples: IntArray
    costs: FloatArray  # Cost of each row, shape (rows,)
    # What it costs to leave an item alone for which no row of a single item says so; infinite
    # where every item has to be covered.
    alone: float = 0.0

    def __len__(self) -> int:
        return len(self.costs)

    @property
    def n_lists(self) -> int:
        """Number of lists."""
        return int(self.tuples.shape[1])

    @property
    def n_items(self) -> int:
        """Number of items that stand in some row."""
        return sum(len(_items_of(self.tuples[:, place])) for place in range(self.n_lists))

    def problem(self) -> AssignmentProblem:
        """Return the problem of choosing rows that share no item, for a solver."""
        return AssignmentProblem.from_tuples(self.tuples, self.costs, alone=self.alone)


def read_problem(source: TableSource) -> ProblemTable:
    """Read an assignment problem and check every value.

    A table has the columns ``i1,…,iS,cost``: a row is a candidate tuple, with the 1-based number
    of the item taken from each list, 0 for none. A row with a single item is the price of
    leaving that item alone, 0 where there is none. Of equal rows the cheapest counts. A table
    without rows is an empty problem.

    A file that ends in .txt may also hold an axial problem of three lists of n items: a line
    ``n n n``, perhaps after a line ``3``, then n³ costs between blanks or line breaks, the third
    item's number running fastest. Every item is then covered exactly once.

    Parameters
    ----------
    source
        A path that ends in .csv, .csv.gz, .parquet or .txt, or a pandas, polars or Arrow table.

    Returns
    -------
    The rows in their order.

    Raises
    ------
    InvalidInputError
        If the source is no table.
    DataFormatError
        If the table is no assignment problem, or has a bad row; the message names file, row (or
        line) and column, what was there and what was expected.

    Examples
    --------
    >>> import polars as pl
    >>> import trackweave as tw
    >>> table = tw.read_problem(pl.DataFrame({"i1": [1, 1], "i2": [1, 2], "cost": [-4.0, -6.0]}))
    >>> len(table), table.n_items
    (2, 3)
    >>> table.problem().n_items
    3
    """
    if not isinstance(source, str | os.PathLike):
        return _from_columns(RowChecks(load_table(source, may_be_empty=True)))
    path = Path(source)
    if path.name.lower().endswith(_AXIAL_ENDING):
        return _read_text(path)
    if path.is_file() and not path.name.lower().endswith(ENDINGS):
        known = ", ".join((*ENDINGS, _AXIAL_ENDING))
        raise DataFormatError(f"{path}: unknown file ending; expected {known}")
    return _from_columns(RowChecks(load_table(path, may_be_empty=True)))


def answer_frame(table: ProblemTable, problem: AssignmentProblem, answer: Answer) -> pl.DataFrame:
    """Return an answer as a data frame, with the columns of an assignment problem."""
    # The chosen tuples, sorted, and then the items that are left alone, list after list, each with
    # its price. No rows where the answer does not cover what it must. ``problem`` is as
    # ``table.problem()`` gave it.
    rows = np.zeros(0, dtype=np.int64)
    if problem.row is not None and answer.status in {Status.OPTIMAL, Status.FEASIBLE}:
        rows = problem.row[answer.nodes]
    rows = rows[rows >= 0]
    rows = rows[np.count_nonzero(table.tuples[rows], axis=1) > 1]
    order = np.lexsort(table.tuples[rows].T[::-1])
    chosen, costs = table.tuples[rows[order]], table.costs[rows[order]]
    if answer.status in {Status.OPTIMAL, Status.FEASIBLE}:
        lone, prices = _left_alone(table, chosen)
        chosen, costs = np.concatenate([chosen, lone]), np.concatenate([costs, prices])
    columns = [pl.Series(f"i{k + 1}", chosen[:, k]) for k in range(table.n_lists)]
    return pl.DataFrame([*columns, pl.Series("cost", costs, dtype=pl.Float64)])


def _left_alone(table: ProblemTable, chosen: IntArray) -> tuple[IntArray, FloatArray]:
    """Return a row for each item that no chosen tuple holds, and its price."""
    is_single = np.count_nonzero(table.tuples, axis=1) == 1
    rows, prices = [], []
    for place in range(table.n_lists):
        items = _items_of(table.tuples[:, place])
        price = np.full(items.max(initial=0) + 1, np.inf)
        own = is_single & (table.tuples[:, place] > 0)
        np.minimum.at(price, table.tuples[own, place], table.costs[own])
        price[np.isinf(price)] = table.alone
        left = np.setdiff1d(items, chosen[:, place], assume_unique=False)
        row = np.zeros((len(left), table.n_lists), dtype=np.int64)
        row[:, place] = left
        rows.append(row)
        prices.append(price[left])
    return np.concatenate(rows), np.concatenate(prices)


def _items_of(column: IntArray) -> IntArray:
    """Return the different items in a column of tuples, in ascending order."""
    return np.flatnonzero(np.bincount(column, minlength=1)[1:]) + 1


def _from_columns(checks: RowChecks) -> ProblemTable:
    names = _list_columns(checks)
    columns = [checks.whole_numbers(name, _ITEM) for name in names]
    costs = checks.numbers("cost", _COST)
    # NaN stands in bad rows only, and counts as filled.
    tuples = np.stack(columns, axis=1)
    where = f"an item in one of {names[0]} to {names[-1]}" if len(names) > 1 else "an item"
    checks.refuse(names[0], np.all(tuples == 0, axis=1), f"{where}, numbered from 1 up")
    checks.finish("fail")
    return ProblemTable(tuples.astype(np.int64), np.array(costs))


def _list_columns(checks: RowChecks) -> list[str]:
    """Return the names of the lists' columns, i1 to iS; other columns are mistakes."""
    checks.require("i1", "the number of the first list's item")
    checks.require("cost", "the cost of each tuple")
    n_lists = sum(re.fullmatch(r"i[1-9][0-9]*", name) is not None for name in checks.names)
    names = [f"i{place}" for place in range(1, n_lists + 1)]
    for name in names:
        checks.require(name, "a column for each list, numbered from 1 without a gap")
    for name in checks.names:
        if name not in {*names, "cost"}:
            shown = repr(name)[1:-1] or "(without a name)"
            raise DataFormatError(
                f"{checks.name}, column {shown:.60}: unknown; expected i1, i2 and so on, and cost "
                f"({checks.listed_columns})"
            )
    return names


def _read_text(path: Path) -> ProblemTable:
    """Return what a .txt file holds, an axial problem or comma-separated values."""
    name, data = str(path), read_bytes(path)
    text = data.decode("utf-8-sig", "replace").lstrip()
    if not text:
        raise DataFormatError(f"{name}: the file is empty; expected a line n n n, then n³ costs")
    if re.match(r'"?i1\b|[^\n]*,', text):
        return _from_columns(RowChecks(parse_csv(data, name)))
    return _parse_axial(data.decode("utf-8-sig", "replace"), name)


def _parse_axial(text: str, name: str) -> ProblemTable:
    lines = ((number, line) for number, line in enumerate(text.split("\n"), 1) if line.strip())
    number, head = next(lines)
    n_before = len(head.split())
    if head.split() == ["3"]:
        number, head = next(lines, (number + 1, ""))
        n_before += len(head.split())
    n = _axial_size(head, f"{name}, line {number}")
    cells = pl.Series("cost", text.split()[n_before:], dtype=pl.String)
    if len(cells) != n**3:
        raise DataFormatError(f"{name}: {len(cells)} costs; expected {n}³ = {n**3}")
    costs = np.array(read_numbers(cells).values)
    bad = np.flatnonzero(~(np.abs(costs) <= _LARGEST_COST))
    if bad.size:
        place = int(bad[0])
        expected = _COST.expected if np.isnan(costs[place]) else _COST.limits
        line = _line_of(text, n_before + place)
        raise DataFormatError(
            f"{name}, line {line}: {cell_text(cells, place)}; expected {expected}"
        )
    tuples = np.indices((n, n, n)).reshape(3, -1).T + 1
    return ProblemTable(np.ascontiguousarray(tuples), costs, alone=np.inf)


def _axial_size(head: str, place: str) -> int:
    """Return the number of items per list that the line ``n n n`` tells."""
    words = head.split()
    is_size = len(words) == 3 and len(set(words)) == 1 and re.fullmatch("[0-9]{1,18}", words[0])
    if not is_size:
        found = cell_text(pl.Series([head.strip()]), 0)
        raise DataFormatError(
            f"{place}: {found}; expected the number of items in each of three lists, "
            "as in 10 10 10, or the columns i1,…,iS,cost"
        )
    if int(words[0]) > _MOST_AXIAL_ITEMS:
        raise DataFormatError(
            f"{place}: {words[0]} items; expected at most {_MOST_AXIAL_ITEMS} in each list"
        )
    return int(words[0])


def _line_of(text: str, word: int) -> int:
    """Return the number of the line, from 1, in which a word stands, the first being 0."""
    for number, line in enumerate(text.split("\n"), 1):
        word -= len(line.split())
        if word < 0:
            return number
    return text.count("\n") + 1
