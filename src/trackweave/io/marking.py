"""The table of reports that came in goes back, with what was found of each of its rows."""

from typing import Any

import numpy as np
import polars as pl

from trackweave.arrays import IntArray
from trackweave.domain.reports import ReportTable
from trackweave.io.columns import typed_column
from trackweave.io.encoding import to_native
from trackweave.io.frames_out import reports_frame, ways_out
from trackweave.io.tables import RawTable

__all__ = ["marked", "notes_on_names", "table_of", "with_index"]

FOUND = ("track", "probability")


def table_of(raw: RawTable) -> pl.DataFrame:
    """Return a file's table record for record, those of the wrong length empty."""
    frame = raw.columns
    if raw.is_text:
        frame = pl.DataFrame({each.name: typed_column(each) for each in frame.get_columns()})
    last = max([0, *raw.row[-1:].tolist(), *(bad.row for bad in raw.skipped)])
    if last == frame.height:
        return frame
    place = np.full(last, -1, dtype=np.int64)
    place[raw.row - 1] = np.arange(frame.height)
    return frame[pl.Series(place).set(pl.Series(place < 0), None)]


def notes_on_names(reports: ReportTable) -> list[str]:
    """Return a sentence for each column that came in and is called as one of ours."""
    return [
        f"column {name}: is called {other} in reports and assignments, where {name} is what was "
        "found"
        for name, other in ways_out(FOUND, reports.carried).items()
    ]


def marked(came: Any, reports: ReportTable, assignments: pl.DataFrame) -> Any:
    """Return the table that came in with the columns ``track`` and ``probability`` added."""
    # It is left as it is; None where the reports did not come as a table. The same rows in the
    # same order, with the same index and columns: one that is called as those added keeps its
    # values under another name. ``assignments`` are in the order in which the reports came.
    found = assignments.select(FOUND)
    if came is None:
        # What the reports are written as has no rows but theirs.
        return to_native(_with_columns(reports_frame(reports), found), reports.kind)
    if len(found) < len(came):
        found = found[_place_of_rows(reports, len(came))]
    if isinstance(came, pl.DataFrame):
        return _with_columns(came, found)
    if hasattr(came, "append_column"):
        ways = ways_out(FOUND, came.column_names)
        table = came.rename_columns([ways.get(name, name) for name in came.column_names])
        for name in FOUND:
            table = table.append_column(name, found[name].to_arrow())
        return table
    return _marked_pandas(came, found)


def with_index(assignments: Any, came: Any, reports: ReportTable) -> Any:
    """Return assignments with pandas' index of the table that came, where it has one."""
    if not hasattr(came, "iloc") or reports.kind != "pandas":
        return assignments
    every = len(assignments) == len(came)
    return assignments.set_axis(came.index if every else came.index[_rows(reports) - 1], axis=0)


def _place_of_rows(reports: ReportTable, n_rows: int) -> pl.Series:
    """Return where among the reports, in the order in which they came, each row stands if any."""
    place, rows = pl.Series([None], dtype=pl.Int64).new_from_index(0, n_rows), _rows(reports)
    return place.scatter(rows - 1, np.arange(rows.size))


def _rows(reports: ReportTable) -> IntArray:
    """Return the numbers of the rows with a report, ascending."""
    rows = reports.rows_told()
    assert rows is not None
    return np.sort(rows)


def _with_columns(frame: pl.DataFrame, found: pl.DataFrame) -> pl.DataFrame:
    return frame.rename(ways_out(FOUND, frame.columns)).hstack(found)


def _marked_pandas(came: Any, found: pl.DataFrame) -> Any:
    import pandas as pd

    # A copy, so that subclasses of pandas' frames stay what they are.
    table = came.copy()
    ways = ways_out(FOUND, [str(name) for name in came.columns])
    if ways:
        table.columns = table.columns.map(lambda name: ways.get(str(name), name))
    none = found["track"].is_null().to_numpy()
    table["track"] = pd.arrays.IntegerArray(found["track"].fill_null(0).to_numpy().copy(), none)
    table["probability"] = found["probability"].to_numpy()
    return table
