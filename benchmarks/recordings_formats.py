"""Recordings in public formats, as the comparisons need them: reports, truth, what counts not."""

import json
from pathlib import Path

import polars as pl

from trackweave.formats.reading import load

BOX = ["left", "top", "right", "bottom"]
# KITTI judges neither for nor against who finds these instead.
LIKE = {"Car": ["Van"], "Pedestrian": ["Person_sitting"]}


def mot_detections(path: Path) -> pl.DataFrame:
    """Return boxes of a detection file."""
    return load(path).columns.select("time", "x", "y", "strength", "width", "height", "frame")


def mot_truth(path: Path) -> pl.DataFrame:
    """Return where everybody really was."""
    known = load(path).columns.filter(pl.col("target").is_not_null())
    return known.select("time", "target", "x", "y", "width", "height")


def kitti_detections(folder: Path, kind: str) -> pl.DataFrame:
    """Return one kind of object; the box in the image goes along."""
    found = load(folder / f"pointrcnn_{kind}.txt", f"kitti?kind={kind}").columns
    return found.select("time", "x", "y", "strength", *BOX, "frame")


def kitti_truth(folder: Path, kind: str) -> pl.DataFrame:
    """Return where each object of a kind really was, and its box in the image."""
    known = load(folder / "labels.txt", f"kitti?kind={kind}").columns
    return known.select("time", "target", "x", "y", *BOX, "frame", "truncated", "occluded")


def kitti_ignored(folder: Path, kind: str) -> pl.DataFrame:
    """Return boxes in the image in which a track is neither right nor wrong."""
    lines = [line.split() for line in (folder / "labels.txt").read_text().splitlines()]
    rows = [
        (int(cells[0]), *map(float, cells[6:10]), cells[2] == "DontCare")
        for cells in lines
        if cells[2] in {"DontCare", *LIKE.get(kind, [])}
    ]
    return pl.DataFrame(rows, ["frame", *BOX, "is_region"], orient="row")


def cells(folder: Path) -> tuple[pl.DataFrame, pl.DataFrame]:
    """Return positions of cells, each with the cell that it is of, and the truth."""
    table = pl.read_csv(folder / "test_data.csv", schema_overrides={"t": pl.Float64})
    known = json.loads((folder / "test_ground_truth.json").read_text(encoding="utf-8"))
    pairs = [(row, cell) for cell, rows in known.items() for row in rows]
    rows = pl.DataFrame(pairs, {"row": pl.UInt32, "target": pl.String}, orient="row")
    reports = table.with_row_index("row").join(rows, on="row", how="left").sort("row")
    reports = reports.select(pl.col("t").alias("time"), "x", "y", "target")
    return reports, reports.drop_nulls("target").select("time", "target", "x", "y")
