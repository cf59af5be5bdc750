"""Thousands of mangled tables: each gives reports or one DataFormatError, nothing else."""

import atexit
import gzip
import shutil
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trackweave.domain.reports import ReportTable
from trackweave.errors import DataFormatError
from trackweave.formats.reading import read_reports

pytestmark = pytest.mark.slow

FOLDER = Path(tempfile.mkdtemp(prefix="trackweave-mangled-"))
atexit.register(shutil.rmtree, FOLDER, ignore_errors=True)

HEADER = ["time", "sensor", "x", "y", "sigma_x", "sigma_y", "report", "scan", "target"]
ROWS = [[str(k), "ab"[k % 2], str(3 * k), "-2.5", "1", "2", f"r{k}", str(k), ""] for k in range(6)]
TEXT = "\n".join(",".join(row) for row in [HEADER, *ROWS]) + "\n"

nasty = st.sampled_from(
    [
        "", " ", "nan", "inf", "-inf", "1e12", "1e309", "-3.0", "0", "1e-320", "x", '"', '""',
        '"a', "a,b", ";", "\n", "\r", "\r\n\r\n", "2024-05-01", "2024-05-01T12:00:00+14:00", "é",
        "\ufeff",
        "\0", "٣", "1_000", "0x10", "True", "9" * 400, "1,5", "NULL", "=1+1", "\u2028", "1.0 ",
    ]
)  # fmt: skip
names = st.sampled_from(
    [
        *HEADER, "z", "lat", "lon", "alt_m", "sigma_z", "range_m", "", "X", "track",
        "identity", "probability",
    ]
)  # fmt: skip


def read_or_refuse(source, **options) -> ReportTable | None:
    """Return reports, or None after one clean refusal."""
    try:
        return read_reports(source, **options)
    except DataFormatError as err:
        message = str(err)
        assert "\n" not in message
        assert len(message) < 600
        return None


def assert_sound(reports: ReportTable | None) -> None:
    """Check what everything behind the reader relies on."""
    if reports is None:
        return
    n = len(reports)
    assert n > 0
    assert np.isfinite(reports.time).all()
    assert (np.diff(reports.time) >= 0).all()
    assert np.isfinite(reports.measurement).all()
    assert reports.measurement.shape in {(n, 2), (n, 3)}
    assert (np.isnan(reports.sigma) | (reports.sigma > 0)).all()
    assert len(set(reports.report.tolist())) == n
    assert all(len(column) == n for column in reports.carried.values())
    assert sum(len(scan) for scan in reports.scans()) == n


def read_text(data: bytes, **options) -> ReportTable | None:
    path = FOLDER / "r.csv"
    path.write_bytes(data)
    return read_or_refuse(path, **options)


def test_the_table_that_is_mangled_below_is_sound():
    assert read_text(TEXT.encode()) is not None


@settings(max_examples=700)
@given(
    edits=st.lists(
        st.tuples(
            st.integers(0, len(TEXT)),
            st.integers(0, 4),
            st.one_of(nasty.map(str.encode), st.binary(max_size=3)),
        ),
        min_size=1,
        max_size=4,
    ),
    skip=st.booleans(),
)
def test_bytes_put_in_taken_out_and_changed(edits, skip):
    data = TEXT.encode()
    for place, length, new in edits:
        data = data[:place] + new + data[place + length :]
    assert_sound(read_text(data, on_bad_row="skip" if skip else "fail"))


@settings(max_examples=700)
@given(
    needed=st.sampled_from(
        [
            "time x y",
            "y x time",
            "time x y z",
            "lon lat time",
            "lat lon alt_m time",
            "x y",
            "time x",
        ]
    ),
    more=st.lists(names, max_size=5, unique=True),
    doubled=st.sampled_from([False] * 9 + [True]),
    cells=st.dictionaries(st.tuples(st.integers(0, 5), st.integers(0, 8)), nasty, max_size=3),
    layout=st.sampled_from([(",", "\n"), (",", "\r\n"), (",", "\r"), (",", "\n\n"), (";", "\n")]),
    skip=st.booleans(),
)
def test_cells_and_names_exchanged(needed, more, doubled, cells, layout, skip):
    separator, line_end = layout
    header = needed.split()
    header += [name for name in more if doubled or name not in header]
    rows = [[cells.get((k, c), str(k + c)) for c in range(len(header))] for k in range(6)]
    text = line_end.join(separator.join(row) for row in [header, *rows])
    assert_sound(read_text(text.encode(), on_bad_row="skip" if skip else "fail"))


@settings(max_examples=300)
@given(
    cells=st.dictionaries(
        st.tuples(st.integers(0, 5), st.integers(0, len(HEADER) - 1)), nasty, max_size=3
    )
)
def test_skipping_leaves_exactly_the_rows_that_failing_would_name(cells):
    # Quoted, so that a nasty cell stays one cell.
    rows = [[cells.get((k, c), cell) for c, cell in enumerate(row)] for k, row in enumerate(ROWS)]
    lines = [
        ",".join('"' + cell.replace('"', '""').replace("\0", "") + '"' for cell in row)
        for row in [HEADER, *rows]
    ]
    data = "\n".join(lines).encode()
    strict, lenient = read_text(data), read_text(data, on_bad_row="skip")
    assert_sound(lenient)
    if lenient is None:
        assert strict is None
    else:
        assert (strict is None) == bool(lenient.skipped)
        assert len(lenient) + len(lenient.skipped) == len(ROWS)


@settings(max_examples=300)
@given(
    length=st.integers(0, 200),
    place=st.integers(0, 200),
    new=st.binary(max_size=2),
)
def test_gzip_data_cut_and_changed(length, place, new):
    whole = gzip.compress(TEXT.encode(), mtime=0)
    path = FOLDER / "r.csv.gz"
    data = whole[:length]
    path.write_bytes(data[:place] + new + data[place + len(new) :])
    assert_sound(read_or_refuse(path))


typed_cells = st.one_of(
    st.none(),
    st.integers(-(2**70), 2**70),
    st.floats(),
    st.booleans(),
    nasty,
    st.dates(),
    st.datetimes(),
    st.timedeltas(),
    st.binary(max_size=2),
    st.lists(st.integers(0, 3), max_size=2),
)


@settings(max_examples=300)
@given(columns=st.dictionaries(names, st.lists(typed_cells, min_size=3, max_size=3), max_size=8))
def test_tables_of_pandas_with_anything_in_them(columns):
    base = {"time": [0, 1, 2], "x": [0.0, 1.0, 2.0], "y": [3, 4, 5]}
    assert_sound(read_or_refuse(pd.DataFrame({**base, **columns}, dtype=object)))


@settings(max_examples=300)
@given(
    columns=st.dictionaries(
        names,
        st.sampled_from(
            [
                pl.Boolean, pl.Int8, pl.UInt64, pl.Float32, pl.Float64, pl.Decimal(10, 3),
                pl.String,
                pl.Date, pl.Datetime("ns"), pl.Datetime("ms", "Asia/Tokyo"), pl.Duration, pl.Time,
                pl.List(pl.Int64), pl.Struct({"a": pl.Int8}), pl.Categorical, pl.Binary, pl.Null,
            ]
        ),
        max_size=8,
    ),
    filled=st.booleans(),
    arrow=st.booleans(),
)  # fmt: skip
def test_typed_columns_of_every_kind(columns, filled, arrow):
    series = {name: typed(dtype, filled=filled) for name, dtype in columns.items()}
    base = {"time": [0, 1, 2], "x": [0.0, 1.0, 2.0], "y": [3, 4, 5]}
    frame = pl.DataFrame({**base, **series})
    reports = read_or_refuse(frame.to_arrow() if arrow else frame)
    frame.write_parquet(FOLDER / "r.parquet")
    again = read_or_refuse(FOLDER / "r.parquet")
    assert_sound(reports)
    assert (reports is None) == (again is None)


def typed(dtype: pl.DataType, *, filled: bool) -> pl.Series:
    values = [0, 1, 2] if filled else [1, None, 2]
    if dtype == pl.String or dtype == pl.Categorical:
        return pl.Series([None if v is None else str(v) for v in values], dtype=dtype)
    if dtype == pl.Binary:
        return pl.Series([None if v is None else bytes([v]) for v in values], dtype=dtype)
    if dtype == pl.List:
        return pl.Series([None if v is None else [v] for v in values], dtype=dtype)
    if dtype == pl.Struct:
        return pl.Series([None if v is None else {"a": v} for v in values], dtype=dtype)
    if dtype == pl.Null:
        return pl.Series([None] * 3)
    return pl.Series(values).cast(dtype)


def test_arrow_tables_with_nested_values_are_refused_where_a_number_is_wanted():
    table = pa.table({"time": [[0.0]], "x": [1.0], "y": [2.0]})
    assert read_or_refuse(table) is None
