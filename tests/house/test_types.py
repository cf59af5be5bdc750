"""What type checkers make of a user's code."""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
CODE = """
import pandas as pd
import polars as pl
import pyarrow as pa
import trackweave as tw

def of_pandas(df: pd.DataFrame) -> None:
    result = tw.track(df)
    reveal_type(result.tracks)
    reveal_type(result.reports)
    reveal_type(tw.fuse([df, df]).tracks)

def of_others(frame: pl.DataFrame, table: pa.Table) -> None:
    reveal_type(tw.track(frame, rng=3).assignments)
    reveal_type(tw.track(table).history)
    reveal_type(tw.track("reports.csv").reports)
    reveal_type(tw.fuse({"a": "a.csv", "b": "b.csv"}).associations)
    reveal_type(tw.evaluate(frame, tw.track(frame)))

tw.track(3)
"""
PANDAS, ARROW, POLARS = "pandas.DataFrame", "pyarrow.Table", "polars.dataframe.frame.DataFrame"
STUB = """
from typing import Any
class {name}:
    columns: Any
    def __len__(self) -> int: ...
    def drop(self, *args: Any, **options: Any) -> Any: ...
    def join(self, *args: Any, **options: Any) -> Any: ...
"""
STUBS = {"pandas": STUB.format(name="DataFrame"), "pyarrow": STUB.format(name="Table")}


@pytest.mark.slow
def test_tables_have_the_type_of_the_table_that_came_in(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    for name, text in STUBS.items():  # these libraries bring no types of their own
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.pyi").write_text(text)
    (tmp_path / "code.py").write_text(CODE)
    done = subprocess.run(
        [
            *(sys.executable, "-m", "mypy", "--follow-imports=silent", "--no-color-output"),
            *("--config-file=", "--ignore-missing-imports", "--cache-dir", tmp_path / "cache"),
            tmp_path / "code.py",
        ],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={"MYPYPATH": f"{tmp_path}:{ROOT / 'src'}", "PATH": ""},
        check=False,
    )
    lines = done.stdout.splitlines()
    revealed = [line.split('"')[1] for line in lines if "Revealed type" in line]
    assert revealed == [
        *(PANDAS, PANDAS, PANDAS, POLARS, ARROW, POLARS, POLARS),
        "trackweave.metrics.evaluate.Evaluation",
    ], done.stdout
    errors = [line for line in lines if " error: " in line]
    assert len(errors) == 1, done.stdout
    assert "track" in errors[0]
