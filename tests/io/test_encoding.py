"""Data frames as bytes."""

import gzip
from datetime import UTC, datetime

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackweave.errors import DataFormatError
from trackweave.io.csv_text import parse_csv
from trackweave.io.encoding import encode_table, to_native
from trackweave.io.tables import load_table

FRAME = pl.DataFrame(
    {
        "time": [datetime(2024, 5, 1, tzinfo=UTC), datetime(2024, 5, 1, 0, 0, 1, tzinfo=UTC)],
        "track": [1, None],
        "status": ["confirmed", None],
        "x": [1 / 3, float("nan")],
    }
)


def test_writes_csv_as_people_read_it():
    assert encode_table(FRAME, "t.csv").decode() == (
        "time,track,status,x\n"
        "2024-05-01T00:00:00Z,1,confirmed,0.3333333333333333\n"
        "2024-05-01T00:00:01Z,,,\n"
    )


@pytest.mark.parametrize("name", ["t.csv", "t.csv.gz", "t.parquet"])
def test_the_same_table_gives_the_same_bytes(name, monkeypatch):
    first = encode_table(FRAME, name)
    monkeypatch.setattr("time.time", lambda: 2e9)
    assert encode_table(FRAME.clone(), name) == first


def test_gzip_holds_the_csv():
    assert gzip.decompress(encode_table(FRAME, "t.csv.gz")) == encode_table(FRAME, "t.csv")


def test_parquet_keeps_types(tmp_path):
    (tmp_path / "t.parquet").write_bytes(encode_table(FRAME, "t.parquet"))
    columns = load_table(tmp_path / "t.parquet").columns
    assert columns.schema == FRAME.schema


def test_knows_three_endings():
    with pytest.raises(DataFormatError, match=r"t\.txt: unknown file ending"):
        encode_table(FRAME, "t.txt")


@pytest.mark.parametrize("name", ["t.csv", "t.parquet"])
def test_writes_whatever_was_carried(name):
    odd = pl.DataFrame(
        {
            "": [1, 2],
            "list": [[1], None],
            "struct": [{"a": 1}, None],
            "binary": [b"1", None],
            "object": pl.Series([object, None], dtype=pl.Object),
            "naive": [datetime(2024, 5, 1), None],
        }
    )
    assert encode_table(odd, name)


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=20))
def test_numbers_read_back_to_the_last_bit(values):
    data = encode_table(pl.DataFrame({"x": values, "y": 0}), "t.csv")
    again = parse_csv(data, "t.csv").columns["x"].cast(pl.Float64).to_numpy()
    np.testing.assert_array_equal(again, values)


@pytest.mark.slow
@given(
    st.lists(
        st.tuples(st.text(alphabet='ab,"\n\r; \té', max_size=5), st.text(max_size=3)),
        min_size=1,
        max_size=6,
    )
)
def test_text_reads_back_as_it_was(rows):
    rows = [tuple(cell.replace("\0", "") for cell in row) for row in rows]
    frame = pl.DataFrame(rows, schema={"a": pl.String, "b": pl.String}, orient="row")
    again = parse_csv(encode_table(frame, "t.csv"), "t.csv").columns
    assert again.rows() == [tuple(cell or None for cell in row) for row in rows]


def test_results_go_back_in_the_kind_that_came():
    assert to_native(FRAME, "polars") is FRAME
    assert isinstance(to_native(FRAME, "pyarrow"), pa.Table)
    table = to_native(FRAME, "pandas")
    assert isinstance(table, pd.DataFrame)
    assert table["time"].dt.tz is not None
    assert table["track"].tolist()[0] == 1
    assert table["track"].isna().tolist() == [False, True]
    assert table["status"].tolist()[0] == "confirmed"
    assert table["x"].dtype == np.float64


def test_an_empty_table_goes_back_with_its_columns():
    table = to_native(FRAME.clear(), "pandas")
    assert list(table.columns) == FRAME.columns
    assert len(table) == 0
