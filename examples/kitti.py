"""KITTI: cars or people that a car's laser scanner finds in 3-D → reports and truth.

    python examples/kitti.py RECORDING/0000 OUT --kind Car
    trackweave track OUT/reports.csv --out OUT/result

RECORDING holds a folder a sequence, each with detections as github.com/xinshuoweng/AB3DMOT gives
them (pointrcnn_Car.txt, pointrcnn_Pedestrian.txt) and KITTI's labels (labels.txt). Positions are
those that the moving car sees: x to its right, y ahead of it. Its own motion is not in these
files, so that parked cars seem to move; objects are tracked relative to it.
"""

import argparse
from pathlib import Path

import polars as pl

FRAME_RATE = 10.0
# Of detections: 2-D box [pixels], score, size [m], place [m], heading about the vertical, angle.
DETECTION = [
    "frame", "kind", "left", "top", "right", "bottom", "strength",
    "size_h", "size_w", "size_l", "right_m", "down_m", "ahead_m", "heading", "alpha",
]  # fmt: skip
LABEL = [
    "frame", "target", "kind", "truncated", "occluded", "alpha", "left", "top", "right", "bottom",
    "size_h", "size_w", "size_l", "right_m", "down_m", "ahead_m", "heading",
]  # fmt: skip
BOX = ["left", "top", "right", "bottom"]
# KITTI judges neither for nor against who finds these instead.
LIKE = {"Car": ["Van"], "Pedestrian": ["Person_sitting"]}


def read_detections(folder: Path, kind: str) -> pl.DataFrame:
    """Return reports of one kind of object; the box in the image goes along."""
    path = _existing(folder / f"pointrcnn_{kind}.txt")
    table = pl.read_csv(path, has_header=False, new_columns=DETECTION, infer_schema_length=None)
    return _placed(table).select("time", "x", "y", "strength", *BOX, "frame")


def read_truth(folder: Path, kind: str) -> pl.DataFrame:
    """Return where each object of a kind really was, and its box in the image."""
    labels = _labels(folder).filter(pl.col("kind") == kind)
    return _placed(labels).select(
        "time", "target", "x", "y", *BOX, "frame", "truncated", "occluded"
    )


def read_ignored(folder: Path, kind: str) -> pl.DataFrame:
    """Return boxes in the image in which a track is neither right nor wrong."""
    labels = _labels(folder).filter(pl.col("kind").is_in(["DontCare", *LIKE.get(kind, [])]))
    return labels.select("frame", *BOX, (pl.col("kind") == "DontCare").alias("is_region"))


def _labels(folder: Path) -> pl.DataFrame:
    path = _existing(folder / "labels.txt")
    return pl.read_csv(
        path, has_header=False, separator=" ", new_columns=LABEL, infer_schema_length=None
    )


def _placed(table: pl.DataFrame) -> pl.DataFrame:
    return table.with_columns(
        (pl.col("frame") / FRAME_RATE).round(6).alias("time"),
        pl.col("right_m").alias("x"),
        pl.col("ahead_m").alias("y"),
    ).sort("frame", maintain_order=True)


def _existing(path: Path) -> Path:
    if not path.exists():
        raise SystemExit(f"{path}: not there; expected the folder of a sequence")
    return path


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("recording", type=Path, help="folder of a sequence")
    parser.add_argument("out", type=Path, help="folder for reports.csv and truth.csv")
    parser.add_argument("--kind", choices=list(LIKE), default="Car")
    arguments = parser.parse_args()
    reports = read_detections(arguments.recording, arguments.kind)
    arguments.out.mkdir(parents=True, exist_ok=True)
    reports.write_csv(arguments.out / "reports.csv")
    read_truth(arguments.recording, arguments.kind).write_csv(arguments.out / "truth.csv")
    print(f"{len(reports)} reports of {reports['time'].n_unique()} frames")


if __name__ == "__main__":
    main()
