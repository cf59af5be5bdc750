"""Tables of reports as bytes of the journal, and back: the same table, whatever is installed."""

import json
import struct
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
import polars as pl

from trackweave.errors import DataFormatError

__all__ = ["packed_table", "unpacked_table"]

_LENGTH = struct.Struct("<I")
_LEVEL = 1
# Kinds by a letter: numbers, whole numbers, dates [µs from 1970 UTC], truths, texts.
_FORMS = {"f": "<f8", "i": "<i8", "t": "<i8", "b": "|u1"}


def packed_table(table: pl.DataFrame, told: Mapping[str, Any]) -> bytes:
    """Return a table, and what is told beside it, as bytes.

    Parameters
    ----------
    table
        Numbers, dates, truths and texts; of other columns the text of each cell is kept.
    told
        What JSON can hold.

    Returns
    -------
    The bytes; the same table and the same words always give the same.
    """
    columns, parts = [], []
    for column in table.get_columns():
        letter, body = _body(column)
        gaps = column.is_null().to_numpy()
        mask = np.packbits(gaps).tobytes() if gaps.any() else b""
        columns.append([column.name, letter, len(body), len(mask)])
        parts += [body, mask]
    head = {"rows": table.height, "columns": columns, "told": told}
    text = json.dumps(head, separators=(",", ":"), sort_keys=True, ensure_ascii=False).encode()
    return _LENGTH.pack(len(text)) + text + zlib.compress(b"".join(parts), _LEVEL)


def unpacked_table(data: bytes) -> tuple[pl.DataFrame, dict[str, Any]]:
    """Return the table that bytes hold, and what is told beside it.

    Parameters
    ----------
    data
        As ``packed_table`` made them.

    Returns
    -------
    Both.

    Raises
    ------
    DataFormatError
        If they hold none.
    """
    try:
        begin = _LENGTH.size + _LENGTH.unpack_from(data)[0]
        head = json.loads(data[_LENGTH.size : begin])
        body, at, columns = zlib.decompress(data[begin:]), 0, []
        for name, letter, size, n_mask in head["columns"]:
            series = _series(body[at : at + size], letter, head["rows"]).alias(name)
            mask = np.frombuffer(body, np.uint8, n_mask, at + size)
            if n_mask:
                told = pl.lit(pl.Series(~np.unpackbits(mask)[: head["rows"]].astype(bool)))
                kept = series.to_frame().select(pl.when(told).then(pl.first()).alias(name))
                series = kept.to_series()
            columns.append(series)
            at += size + n_mask
    except (struct.error, zlib.error, ValueError, KeyError, TypeError) as err:
        raise DataFormatError(f"a table of the journal: damaged ({err})") from err
    return pl.DataFrame(columns), head["told"]


def _body(column: pl.Series) -> tuple[str, bytes]:
    kind = column.dtype
    if isinstance(kind, pl.Datetime):
        dates = column.dt.cast_time_unit("us")
        return "t", dates.to_physical().fill_null(0).to_numpy().astype("<i8").tobytes()
    if kind == pl.Boolean:
        return "b", column.fill_null(value=False).to_numpy().astype(np.uint8).tobytes()
    if kind.is_integer() and kind not in (pl.UInt64, pl.Int128):
        return "i", column.fill_null(0).to_numpy().astype("<i8").tobytes()
    if kind.is_numeric() or kind == pl.Null:
        return "f", column.cast(pl.Float64).fill_null(np.nan).to_numpy().astype("<f8").tobytes()
    texts = [_text(cell).encode("utf-8", "replace") for cell in column.to_list()]
    ends = np.cumsum([len(text) for text in texts], dtype=np.int64)
    return "s", ends.astype("<i8").tobytes() + b"".join(texts)


def _text(cell: Any) -> str:
    return "" if cell is None else str(cell)


def _series(body: bytes, letter: str, rows: int) -> pl.Series:
    if letter == "s":
        ends = np.frombuffer(body, "<i8", rows).tolist()
        text = body[8 * rows :]
        cells = [
            text[begin:end].decode("utf-8")
            for begin, end in zip([0, *ends[:-1]], ends, strict=False)
        ]
        return pl.Series(cells, dtype=pl.String)
    numbers = np.frombuffer(body, _FORMS[letter], rows)
    if letter == "b":
        return pl.Series(numbers.astype(bool))
    series = pl.Series(numbers.copy())
    return series.cast(pl.Datetime("us")).dt.replace_time_zone("UTC") if letter == "t" else series
