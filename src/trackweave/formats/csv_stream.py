"""Comma-separated values that come as a stream: the header first, then a report a line."""

import csv
from typing import Any

import numpy as np
import polars as pl

from trackweave.errors import DataFormatError
from trackweave.formats.lines import Lines
from trackweave.io.columns import read_numbers, read_text, read_times
from trackweave.io.tables import OURS, RawTable, with_our_names

__all__ = ["CsvDecoder"]

_PLACES = ("x", "lat", "range_m", "bearing_deg")
# Columns of ours that are no numbers.
_TEXTS = {"sensor", "identity", "report", "target", "track", "status"}
_MOST_COLUMNS = 200
NO_HEADER = (
    "rows came before any header; expected the line of columns' names first (among them x, lat, "
    "range_m or bearing_deg), on each connection and from each sender, or in each datagram"
)


class CsvDecoder(Lines):
    """Turns lines into reports; whatever line names columns is the header from there on."""

    def __init__(self) -> None:
        super().__init__()
        self._names: list[str] = []
        # It decides between seconds and dates for the whole stream, whatever headers follow.
        self._first_time = ""
        self.complaint = ""
        """Why nothing at all can be read at present; empty where something can."""

    def _decoded(self, block: bytes, offset: int) -> pl.DataFrame | None:
        found: list[pl.DataFrame] = []
        rows: list[list[str]] = []
        begins: list[int] = []
        for line in block.split(b"\n"):
            begin, offset = offset, offset + len(line) + 1
            cells = self._cells(line, begin)
            if not cells:
                continue
            names = _names_in(cells)
            if names and names == self._names:
                continue  # said again, as in each datagram
            if names:
                found += self._table(rows, begins)
                rows, begins = [], []
                self._names, self.complaint = names, ""
            elif not self._names:
                self.skips.add(begin, "no header yet; expected columns' names")
                self.complaint = NO_HEADER
            elif len(cells) != len(self._names):
                self.skips.add(begin, f"{len(cells)} cells; expected {len(self._names)}")
            else:
                rows.append(cells)
                begins.append(begin)
        found += self._table(rows, begins)
        return pl.concat(found, how="diagonal_relaxed") if found else None

    def _cells(self, line: bytes, begin: int) -> list[str]:
        """Return a line's cells without blanks around them, none where it is blank or no text."""
        try:
            text = line.decode("utf-8").strip("\r\ufeff")
        except UnicodeDecodeError:
            text = "\0"
        if "\0" in text:
            self.skips.add(begin, "no text in UTF-8")
            return []
        if not text.strip():
            return []
        # Tabs stand for commas where there are none, as in files.
        separator = "\t" if "\t" in text and "," not in text else ","
        if '"' in text:
            try:
                return [cell.strip() for cell in next(csv.reader([text], delimiter=separator))]
            except csv.Error:  # as of a carriage return amid a cell
                self.skips.add(begin, "no line of comma-separated values")
                return []
        return [cell.strip() for cell in text.split(separator)]

    def _table(self, rows: list[list[str]], begins: list[int]) -> list[pl.DataFrame]:
        """Return the reports in rows of one header: a table, or none."""
        if not rows:
            return []
        columns = pl.DataFrame(rows, schema=dict.fromkeys(self._names, pl.String), orient="row")
        typed: dict[str, pl.Series] = {}
        good = np.ones(len(rows), dtype=np.bool_)
        for column in columns.get_columns():
            if column.name == "time":
                typed["time"], is_bad = self._times(column)
            elif column.name in OURS and column.name not in _TEXTS:
                typed[column.name], is_bad = _numbers(column)
            else:
                typed[column.name], is_bad = read_text(column), np.zeros(len(rows), np.bool_)
            self._skip(begins, good & is_bad, f"{column.name}: no number or time")
            good &= ~is_bad
        places = [typed[name].is_not_null().to_numpy() for name in _PLACES if name in typed]
        is_there = np.any(places, axis=0)
        self._skip(begins, good & ~is_there, "no measurement")
        good &= is_there
        if "time" not in typed:
            typed["time"] = pl.Series("time", [None] * len(rows), dtype=pl.Float64)
        return [pl.DataFrame(list(typed.values())).filter(pl.Series(good))] if good.any() else []

    def _times(self, column: pl.Series) -> tuple[pl.Series, Any]:
        """Return times, seconds or dates as the first of the stream was."""
        column = column.set(column == "", None)
        if not self._first_time:
            for text in column.drop_nulls().to_list():
                first = read_times(pl.Series([text]))
                if np.isfinite(first.numbers.values[0]):
                    self._first_time = text
                    break
            else:  # of none it can be told which they are
                return pl.Series("time", [None] * len(column)), column.is_not_null().to_numpy()
        told = read_times(pl.concat([pl.Series("time", [self._first_time]), column]))
        seconds = told.numbers.values[1:]
        is_bad = ~told.numbers.missing[1:] & ~np.isfinite(seconds)
        values = pl.Series("time", seconds, nan_to_null=True).set(pl.Series(is_bad), None)
        if told.iso:
            values = (values * 1e6).round().cast(pl.Int64).cast(pl.Datetime("us", "UTC"))
        return values, is_bad

    def _skip(self, begins: list[int], which: Any, what: str) -> None:
        for place in np.flatnonzero(which):
            self.skips.add(begins[place], what)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _names_in(cells: list[str]) -> list[str]:
    """Return what the columns that cells name are called here, none where they name no report."""
    if any(map(_is_number, cells)) or not len(set(cells)) == len(cells) <= _MOST_COLUMNS:
        return []
    table = pl.DataFrame(schema=dict.fromkeys(cells, pl.String))
    try:
        names = with_our_names(RawTable("stream", table, np.empty(0, np.int64))).columns.columns
    except DataFormatError:  # two columns are the same of ours
        return []
    return names if any(name in _PLACES for name in names) else []


def _numbers(column: pl.Series) -> tuple[pl.Series, Any]:
    """Return numbers, null where there is none, and where something else stands."""
    found = read_numbers(column)
    is_bad = ~found.missing & ~np.isfinite(found.values)
    return pl.Series(column.name, found.values, nan_to_null=True), is_bad
