"""Tables of pandas, polars and Arrow become raw columns."""

from typing import Any

import narwhals as nw
import numpy as np
import polars as pl

from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.io.tables import RawTable

__all__ = ["from_native", "native_of"]

_NAME = "table"


def from_native(source: Any) -> RawTable:
    """Return the columns of a table in memory, which is not changed; rows count from 1."""
    if isinstance(source, pl.LazyFrame):
        raise InvalidInputError("a lazy table; expected one in memory (call .collect() first)")
    try:
        frame = nw.from_native(source, eager_only=True)
    except TypeError as err:
        raise InvalidInputError(
            f"{type(source).__name__}: not a table; expected a path to a .csv, .csv.gz or "
            ".parquet file, or a pandas, polars or Arrow table"
        ) from err
    except Exception as err:  # each library tells of repeated names in its own way
        _require_different(_column_names(nw.to_native(source, pass_through=True)))
        raise DataFormatError(f"{_NAME}: {err}") from err
    native = frame.to_native()
    names = [str(name) for name in _column_names(native)]
    _require_different(names)
    try:
        columns = _columns(native, names)
    except Exception as err:  # a foreign library's trouble with its own values
        raise DataFormatError(f"{_NAME}: cannot be read ({err})") from err
    kind = frame.implementation.value
    kind = kind if kind in {"pandas", "pyarrow"} else "polars"
    return RawTable(_NAME, columns, np.arange(1, columns.height + 1), kind=kind)


def native_of(source: Any) -> Any:
    """Return a table in memory as its own library has it; narwhals' wrapping is taken off."""
    return nw.to_native(source, pass_through=True)


def _require_different(names: list[Any]) -> None:
    named = [str(name) for name in names]
    for name in named:
        if named.count(name) > 1:
            raise DataFormatError(f"{_NAME}, column {name}: twice; expected each name once")


def _column_names(native: Any) -> list[Any]:
    names = getattr(native, "column_names", None)
    return list(native.columns if names is None else names)


def _columns(native: Any, names: list[str]) -> pl.DataFrame:
    if isinstance(native, pl.DataFrame):
        return native
    if hasattr(native, "iloc"):
        return pl.DataFrame(
            {name: _pandas_column(native.iloc[:, place]) for place, name in enumerate(names)}
        )
    frame = pl.from_arrow(native)
    assert isinstance(frame, pl.DataFrame)
    return frame


def _pandas_column(column: Any) -> pl.Series:
    """Return a pandas column without the help of pyarrow, which a user need not have."""
    if getattr(column.dtype, "tz", None) is not None:
        utc = column.dt.tz_convert("UTC").dt.tz_localize(None)
        return pl.Series(utc.to_numpy()).dt.replace_time_zone("UTC")
    if isinstance(column.dtype, np.dtype) and column.dtype.kind in "biufM":
        return pl.Series(column.to_numpy(), nan_to_null=True)
    missing = column.isna().to_numpy()
    values = [
        None if gone else value for value, gone in zip(column.tolist(), missing, strict=True)
    ]
    try:
        return pl.Series(values, strict=True)
    except (TypeError, OverflowError, pl.exceptions.PolarsError):  # values of several types
        return pl.Series([None if value is None else str(value) for value in values])
