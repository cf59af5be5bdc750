"""Data frames become bytes: the same frame always the same bytes."""

import gzip
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import polars as pl

from trackweave.io.tables import file_ending
from trackweave.io.times import iso_text

__all__ = ["encode_table", "to_native"]


def encode_table(frame: pl.DataFrame, file_name: str) -> bytes:
    """Return the content of a file that holds a table.

    Numbers are written with as many digits as it takes to read them back unchanged; what is not
    finite becomes an empty cell. In CSV dates and durations become ISO 8601 text.

    Parameters
    ----------
    frame
        The table.
    file_name
        The file's name; its ending says how it is written: .csv, .csv.gz or .parquet.

    Returns
    -------
    The file's bytes, without any time or name in them.

    Raises
    ------
    DataFormatError
        If the ending is another one.
    """
    ending = file_ending(Path(file_name))
    if ending == ".parquet":
        buffer = BytesIO()
        _each(frame, _storable).write_parquet(buffer)
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


def _storable(column: pl.Series) -> pl.Series:
    return _as_text(column) if column.dtype == pl.Object else column


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
