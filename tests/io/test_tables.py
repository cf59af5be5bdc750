"""Files of every kind, and what is wrong with them."""

import gzip
import os

import polars as pl
import pytest

from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.io.tables import load_table

TEXT = b"time,x,y\n0,1,2\n1,2,3\n"


def refusal(source) -> str:
    with pytest.raises(DataFormatError) as caught:
        load_table(source)
    return str(caught.value)


@pytest.mark.parametrize("name", ["r.csv", "R.CSV"])
def test_reads_csv_by_the_ending_in_upper_or_lower_case(tmp_path, name):
    (tmp_path / name).write_bytes(TEXT)
    assert load_table(str(tmp_path / name)).columns["x"].to_list() == ["1", "2"]


def test_reads_gzip_also_of_several_members(tmp_path):
    path = tmp_path / "r.csv.gz"
    path.write_bytes(gzip.compress(TEXT) + gzip.compress(b"2,3,4\n"))
    assert load_table(path).columns["x"].to_list() == ["1", "2", "3"]


def test_reads_parquet_with_its_types(tmp_path):
    pl.DataFrame({"time": [0.5], "x": [1]}).write_parquet(tmp_path / "r.parquet")
    assert load_table(tmp_path / "r.parquet").columns.rows() == [(0.5, 1)]


def test_a_name_with_wildcards_means_one_file(tmp_path):
    (tmp_path / "r1.csv").write_bytes(TEXT)
    (tmp_path / "r*.csv").write_bytes(TEXT + b"2,3,4\n")
    assert len(load_table(tmp_path / "r*.csv")) == 3


def test_names_a_file_that_is_not_there(tmp_path):
    path = tmp_path / "r.csv"
    assert refusal(path) == f"{path}: no such file"


def test_names_a_directory(tmp_path):
    path = tmp_path / "r.csv"
    path.mkdir()
    assert refusal(path) == f"{path}: a directory; expected a file"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no pipes with names")
def test_does_not_wait_for_a_pipe(tmp_path):
    path = tmp_path / "r.csv"
    os.mkfifo(path)
    assert refusal(path) == f"{path}: not a regular file; expected a file, or - for standard input"


def test_names_a_file_that_may_not_be_read(tmp_path, monkeypatch):
    path = tmp_path / "r.csv"
    path.write_bytes(TEXT)

    def refuse(self):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(type(path), "read_bytes", refuse)
    assert refusal(path) == f"{path}: no permission to read the file"


def test_names_a_file_that_a_failing_disk_holds(tmp_path, monkeypatch):
    path = tmp_path / "r.csv"
    path.write_bytes(TEXT)

    def fail(self):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(type(path), "read_bytes", fail)
    assert refusal(path) == f"{path}: cannot be read (Input/output error)"


@pytest.mark.parametrize("name", ["a\0b.csv", "x" * 300 + ".csv"])
def test_refuses_what_cannot_be_a_file_name(name):
    assert refusal(name)


def test_names_the_endings_that_it_knows(tmp_path):
    path = tmp_path / "r.xlsx"
    path.write_bytes(TEXT)
    assert refusal(path) == f"{path}: unknown file ending; expected .csv, .csv.gz, .parquet"


def test_tells_of_gzip_data_that_end_too_early(tmp_path):
    path = tmp_path / "r.csv.gz"
    whole = gzip.compress(TEXT * 1000)
    path.write_bytes(whole[: len(whole) // 2])
    assert refusal(path) == f"{path}: gzip data end too early; expected a whole file"


@pytest.mark.parametrize("damage", [b"no gzip", b"\x1f\x8b\x08\0\0\0\0\0\0\0garbage", b""])
def test_tells_of_damaged_gzip_data(tmp_path, damage):
    path = tmp_path / "r.csv.gz"
    path.write_bytes(damage)
    assert refusal(path).startswith(f"{path}: ")


def test_tells_of_gzip_data_under_a_plain_name(tmp_path):
    path = tmp_path / "r.csv"
    path.write_bytes(gzip.compress(TEXT))
    expected = "gzip data; expected text, or a name that ends in .csv.gz"
    assert refusal(path) == f"{path}: {expected}"


def test_tells_of_parquet_data_that_end_too_early(tmp_path):
    path = tmp_path / "r.parquet"
    pl.DataFrame({"time": [0.5] * 50, "x": list(range(50))}).write_parquet(path)
    whole = path.read_bytes()
    for length in range(0, len(whole), 50):
        path.write_bytes(whole[:length])
        assert refusal(path) == f"{path}: damaged or no Parquet data; expected a whole file"


def test_tells_of_parquet_data_without_sense(tmp_path):
    path = tmp_path / "r.parquet"
    path.write_bytes(b"PAR1" + b"nonsense" * 9 + b"\x20\0\0\0PAR1")
    assert refusal(path).startswith(f"{path}: damaged Parquet data")


def test_refuses_a_table_without_rows_unless_told_otherwise(tmp_path):
    path = tmp_path / "r.csv"
    path.write_bytes(b"time,x,y\n")
    assert refusal(path) == f"{path}: no data rows; expected at least one"
    assert len(load_table(path, may_be_empty=True)) == 0


def test_refuses_what_is_no_table():
    with pytest.raises(InvalidInputError, match="list: not a table; expected a path"):
        load_table([1, 2])
