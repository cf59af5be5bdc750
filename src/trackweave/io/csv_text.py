"""Text of comma-separated values becomes columns of text.

Polars reads plain text, in which counting lines and commas proves that every row is a line with
its number of cells: it is silent about blank lines, short rows and quotation marks out of place.
Anything else Python's own reader takes record by record, which can say which row is wrong.
"""

import csv
import io
import re
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import polars as pl

from trackweave.domain.facts import Facts
from trackweave.domain.reports import BadRow
from trackweave.errors import DataFormatError
from trackweave.io.tables import RawTable

__all__ = ["parse_csv", "parse_csv_carefully"]

_CHUNK_ROWS = 65_536
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
# A comma of a cell that is a number without another one, as 1.234,5 is not.
_DECIMAL_COMMA = re.compile(rb"(?<![\d.,])\d+,(?=\d+(?:[eE][+-]?\d+)?(?:[\t;\r\n]|$))")


def parse_csv(data: bytes, name: str) -> RawTable:
    """Return the columns of a CSV file as text, null where a cell is empty."""
    # UTF-8, with or without a byte order mark. Blank lines are no records: they are passed over
    # and not counted. Rows with too few or too many cells are in ``skipped``.
    data = data.removeprefix(_BYTE_ORDER_MARK).strip(b"\r\n")
    _require_text(data, name)
    data, note = _with_commas(data)
    plain = _parse_plain(data, name)
    table = plain if plain is not None else parse_csv_carefully(data, name)
    return replace(table, facts=Facts(notes=[note])) if note else table


def _with_commas(data: bytes) -> tuple[bytes, str]:
    """Return text with commas for the tabs or semicolons between columns, and what was assumed."""
    # Where there is a quotation mark, or a comma in the header, commas part them.
    head, _, body = data.partition(b"\n")
    mark = next((mark for mark in (b"\t", b";") if mark in head), b"")
    if not mark or b"," in head or b'"' in data:
        return data, ""
    n_commas = body.count(b",")
    if len(_DECIMAL_COMMA.findall(body)) != n_commas:
        return data, ""
    note = ""
    if n_commas:
        words = {b"\t": "tabs", b";": "semicolons"}[mark]
        note = f"{words} part columns, and commas are taken for decimal points"
    return data.replace(b",", b".").replace(mark, b","), note


def parse_csv_carefully(data: bytes, name: str) -> RawTable:
    """Return what ``parse_csv`` does, reading the text record by record."""
    records = _records(data.decode("utf-8"), name)
    header = next(records, None)
    if header is None:
        raise DataFormatError(f"{name}: no header, the file is empty; expected columns' names")
    names = _require_names(header, name)
    chunks, numbers, skipped = [], [], []
    chunk: list[list[str]] = []
    for number, cells in enumerate(records, start=1):
        if len(cells) != len(names):
            wanted = f"{len(names)} as in the header"
            skipped.append(BadRow(number, None, _count(len(cells)), wanted))
            continue
        chunk.append(cells)
        numbers.append(number)
        if len(chunk) == _CHUNK_ROWS:
            chunks.append(_text_frame(chunk, names))
            chunk = []
    chunks.append(_text_frame(chunk, names))
    row = np.asarray(numbers, dtype=np.int64)
    return RawTable(name, pl.concat(chunks), row, tuple(skipped), is_text=True)


def _require_text(data: bytes, name: str) -> None:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise DataFormatError(f"{name}: UTF-16 text; expected UTF-8")
    if b"\0" in data:
        row = data.count(b"\n", 0, data.index(b"\0"))
        raise DataFormatError(f"{name}, {_line_name(row)}: a NUL byte; expected text in UTF-8")
    if data.isascii():
        return
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as err:
        row = data.count(b"\n", 0, err.start)
        found = f"byte 0x{data[err.start]:02x}, which is not UTF-8"
        raise DataFormatError(f"{name}, {_line_name(row)}: {found}; expected UTF-8") from err


def _line_name(row: int) -> str:
    return f"row {row}" if row else "header"


def _count(n_cells: int) -> str:
    return "1 cell" if n_cells == 1 else f"{n_cells} cells"


def _parse_plain(data: bytes, name: str) -> RawTable | None:
    """Return the columns of text whose rows are lines, None where the careful parser is needed."""
    if b'"' in data or data.count(b"\r") != data.count(b"\r\n"):
        return None
    head, _, body = data.partition(b"\n")
    n_commas, n_rows = head.count(b","), body.count(b"\n") + 1
    if not head.strip() or not body or not n_commas or body.count(b",") != n_rows * n_commas:
        return None
    names = _require_names(head.decode("utf-8").rstrip("\r").split(","), name)
    try:
        schema = {column: pl.String for column in names}
        frame = pl.read_csv(body, has_header=False, schema=schema, quote_char=None)
    except pl.exceptions.PolarsError:
        return None
    if frame.height != n_rows:
        return None
    return RawTable(name, frame, np.arange(1, n_rows + 1), is_text=True)


def _records(text: str, name: str) -> Iterator[list[str]]:
    """Yield the cells of each record, the header first, without blank lines."""
    number = 0
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        for cells in reader:
            if len(cells) > 1 or (cells and cells[0].strip()):
                yield cells
                number += 1
    except csv.Error as err:
        trouble = str(err)
        if "unexpected end" in trouble:
            found, expected = "a quotation mark that is never closed", "a closing one"
        elif "field limit" in trouble:
            found = f"a cell of more than {csv.field_size_limit()} characters"
            expected = "shorter ones; is a quotation mark never closed?"
        else:
            found = "text after a closing quotation mark"
            expected = 'a comma there, and quotation marks inside a cell doubled ("")'
        place = f"{name}, {_line_name(number)}"
        raise DataFormatError(f"{place}: {found}; expected {expected}") from err


def _text_frame(rows: list[list[str]], names: list[str]) -> pl.DataFrame:
    columns = zip(*rows, strict=True) if rows else [()] * len(names)
    frame = pl.DataFrame(
        {
            column: pl.Series(cells, dtype=pl.String)
            for column, cells in zip(names, columns, strict=True)
        }
    )
    return frame.with_columns(pl.all().replace("", None))


def _require_names(cells: list[str], name: str) -> list[str]:
    names = [cell.strip() for cell in cells]
    if not any(names):
        raise DataFormatError(f"{name}: no names in the header; expected columns' names")
    if len(names) == 1 and any(mark in names[0] for mark in ";\t|"):
        raise DataFormatError(
            f"{name}, header: one column {names[0]!r:.60}; expected columns separated by commas"
        )
    seen: set[str] = set()
    for column in names:
        if column in seen:
            raise DataFormatError(
                f"{name}, column {column or '(without a name)'}: twice in the header; "
                "expected each name once"
            )
        seen.add(column)
    return names
