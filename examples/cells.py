"""Cells under a microscope, found frame by frame → reports and truth.

    python examples/cells.py RECORDING OUT
    trackweave track OUT/reports.csv --out OUT/result

RECORDING holds test_data.csv of github.com/quantumjot/btrack (columns t, x, y, ...) and, for the
truth, test_ground_truth.json, which lists the rows that are of each cell. Times are frame
numbers and positions pixels; both are taken for seconds and metres.
"""

import argparse
import json
from pathlib import Path

import polars as pl


def read(folder: Path) -> tuple[pl.DataFrame, pl.DataFrame]:
    """Return reports, each with the cell that it is of, and the truth."""
    path = folder / "test_data.csv"
    if not path.exists():
        raise SystemExit(f"{path}: not there; expected a table with columns t, x and y")
    table = pl.read_csv(path, schema_overrides={"t": pl.Float64}).with_row_index("row")
    known = json.loads((folder / "test_ground_truth.json").read_text(encoding="utf-8"))
    rows = pl.DataFrame(
        [(row, cell) for cell, rows in known.items() for row in rows],
        {"row": pl.UInt32, "target": pl.String},
        orient="row",
    )
    reports = table.join(rows, on="row", how="left").sort("row")
    reports = reports.select(pl.col("t").alias("time"), "x", "y", "target")
    return reports, reports.drop_nulls("target").select("time", "target", "x", "y")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("recording", type=Path, help="folder with test_data.csv")
    parser.add_argument("out", type=Path, help="folder for reports.csv and truth.csv")
    arguments = parser.parse_args()
    reports, truth = read(arguments.recording)
    arguments.out.mkdir(parents=True, exist_ok=True)
    reports.write_csv(arguments.out / "reports.csv")
    truth.write_csv(arguments.out / "truth.csv")
    print(f"{len(reports)} reports of {reports['time'].n_unique()} frames")


if __name__ == "__main__":
    main()
