"""Tables and records become bytes: the same always the same bytes."""

import gzip
import json
import math
from collections.abc import Callable, Mapping
from enum import Enum
from io import BytesIO
from pathlib import Path, PurePath
from typing import Any

import numpy as np
import polars as pl

from trackweave.io.columns import iso_text
from trackweave.io.tables import file_ending

__all__ = ["encode_json", "encode_table", "to_native"]


def encode_table(frame: pl.DataFrame, file_name: str) -> bytes:
    """Return the content of a file of a table: .csv, .csv.gz or .parquet, as its name ends."""
    # Numbers are written with as many digits as it takes to read them back unchanged; what is not
    # finite becomes an empty cell. In CSV dates and durations become ISO 8601 text. There is no
    # time or name in the bytes.
    ending = file_ending(Path(file_name))
    if ending == ".parquet":
        buffer = BytesIO()
        # What is no type of Parquet's is told as text.
        _each(frame, lambda c: _as_text(c) if c.dtype == pl.Object else c).write_parquet(buffer)
        return buffer.getvalue()
    text = _each(frame, _printable).write_csv()
    data = text.encode("utf-8")
    return gzip.compress(data, compresslevel=6, mtime=0) if ending == ".csv.gz" else data


def to_native(frame: pl.DataFrame, kind: str) -> Any:
    """Return a table as one of "polars", "pandas" or "pyarrow", from which the reports came."""
    if kind == "pyarrow":
        return frame.to_arrow()
    return _to_pandas(frame) if kind == "pandas" else frame


def _to_pandas(frame: pl.DataFrame) -> Any:
    """Return a pandas data frame without the help of pyarrow, which a user need not have."""
    import pandas as pd

    columns: dict[str, Any] = {}
    for column in frame.get_columns():
        if isinstance(column.dtype, pl.Datetime):
            naive = column.dt.replace_time_zone(None).to_numpy()
            values = pd.Series(naive)
            columns[column.name] = (
                values.dt.tz_localize("UTC") if column.dtype.time_zone else values
            )
        elif column.dtype.is_integer() and column.null_count():
            columns[column.name] = pd.array(column.to_list(), dtype="Int64")
        elif column.dtype.is_numeric() or column.dtype == pl.Boolean:
            columns[column.name] = column.to_numpy()
        else:
            columns[column.name] = column.to_list()
    return pd.DataFrame(columns)


def _each(frame: pl.DataFrame, change: Callable[[pl.Series], pl.Series]) -> pl.DataFrame:
    # By name, because polars gives a name to a column without one when it comes in a list.
    return pl.DataFrame({column.name: change(column) for column in frame.get_columns()})


def _printable(column: pl.Series) -> pl.Series:
    if column.dtype.is_float():
        return column.set(~column.is_finite(), None)
    if isinstance(column.dtype, pl.Datetime):
        return iso_text(column.dt.cast_time_unit("us"))
    if isinstance(column.dtype, pl.Duration):
        return column.dt.to_string("iso")
    if column.dtype == pl.String:
        # Polars would write empty text as "", and emptiness is one thing here.
        return column.set(column == "", None)
    if column.dtype.is_nested() or column.dtype in {pl.Object, pl.Binary}:
        return _as_text(column)
    return column


def _as_text(column: pl.Series) -> pl.Series:
    texts = [None if value is None else str(value) for value in column.to_list()]
    return pl.Series(column.name, texts, dtype=pl.String)


def encode_json(document: Mapping[str, Any]) -> bytes:
    """Return a document as JSON text: the same document always the same bytes."""
    # Keys keep their order. Numbers that are not finite become null; NumPy's numbers and arrays,
    # enumerations and paths become numbers, lists and text. A list of objects, such as that of the
    # scans, takes one line per object.
    lines = [f"  {_dump(str(key))}: {_value(item)}" for key, item in document.items()]
    # Lone surrogates, which file names may have, survive only as escapes.
    return ("{\n" + ",\n".join(lines) + "\n}\n").encode("utf-8", "backslashreplace")


def _value(item: Any) -> str:
    # Object by object: a long run lists tens of thousands of scans.
    if isinstance(item, list) and item and all(isinstance(entry, Mapping) for entry in item):
        return "[\n    " + ",\n    ".join(_dump(_plain(entry)) for entry in item) + "\n  ]"
    plain = _plain(item)
    if isinstance(plain, dict) and plain:
        entries = [f"    {_dump(key)}: {_dump(entry)}" for key, entry in plain.items()]
        return "{\n" + ",\n".join(entries) + "\n  }"
    return _dump(plain)


_AS_IT_IS = frozenset({bool, int, str})
_dump = json.JSONEncoder(ensure_ascii=False, allow_nan=False).encode


def _plain(item: Any) -> Any:
    """Return the same value made of what JSON knows."""
    # What nearly everything is comes first: a long run lists a million numbers.
    if item is None or type(item) in _AS_IT_IS:
        return item
    if isinstance(item, Enum):
        return _plain(item.value)
    if isinstance(item, np.ndarray | np.generic):
        return _plain(item.tolist())
    if isinstance(item, float):
        return item if math.isfinite(item) else None
    if isinstance(item, (dict, Mapping)):
        return {str(_plain(key)): _plain(value) for key, value in item.items()}
    if isinstance(item, list | tuple):
        return [_plain(entry) for entry in item]
    if isinstance(item, set | frozenset):
        return sorted(_plain(entry) for entry in item)
    if isinstance(item, int | str):
        return item
    if isinstance(item, PurePath):
        return str(item)
    raise TypeError(f"{type(item).__name__}: expected something that JSON knows")
