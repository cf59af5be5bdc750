"""MOT: people or cars found in a video, as boxes in the image → reports and truth.

    python examples/mot.py TUD-Campus/det/det.txt OUT --truth TUD-Campus/gt/gt.txt
    trackweave track OUT/reports.csv --out OUT/result

Files are in the format of motchallenge.net: frame, identity, left, top, width, height,
confidence, in pixels. Pixels are taken for metres, x to the right and y down, as in the image.
A box's size goes along to the assignments, where one can pick it up again.
"""

import argparse
from pathlib import Path

import polars as pl

NAMES = ["frame", "identity", "left", "top", "width", "height", "strength"]
FRAME_RATE = 25.0  # frames a second; the files do not say


def read_detections(
    path: Path, frame_rate: float = FRAME_RATE, point: str = "centre"
) -> pl.DataFrame:
    """Return reports of a detection file: where the boxes are, how large and how sure."""
    return _boxes(path, frame_rate, point).select(
        "time", "x", "y", "strength", "width", "height", "frame"
    )


def read_truth(path: Path, frame_rate: float = FRAME_RATE, point: str = "centre") -> pl.DataFrame:
    """Return where everybody really was; boxes with confidence 0 are not to be judged."""
    boxes = _boxes(path, frame_rate, point).filter(pl.col("strength") > 0)
    return boxes.select(
        "time", pl.col("identity").cast(pl.Int64).alias("target"), "x", "y", "width", "height"
    )


def _boxes(path: Path, frame_rate: float, point: str) -> pl.DataFrame:
    if not path.exists():
        raise SystemExit(f"{path}: not there; expected a file in the MOT format")
    table = pl.read_csv(path, has_header=False, infer_schema_length=None)
    if table.width < len(NAMES):
        raise SystemExit(f"{path}: {table.width} columns; expected {', '.join(NAMES)}")
    boxes = table[:, : len(NAMES)].cast(pl.Float64)
    boxes.columns = NAMES
    # People stand on their feet, but a box's centre jumps less than its lower edge.
    down = 1.0 if point == "foot" else 0.5
    return boxes.with_columns(
        pl.col("frame").cast(pl.Int64),
        ((pl.col("frame") - 1) / frame_rate).round(6).alias("time"),
        (pl.col("left") + pl.col("width") / 2).round(3).alias("x"),
        (pl.col("top") + pl.col("height") * down).round(3).alias("y"),
    ).sort("frame", maintain_order=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("recording", type=Path, help="detections, such as det/det.txt")
    parser.add_argument("out", type=Path, help="folder for reports.csv and truth.csv")
    parser.add_argument("--truth", type=Path, help="where everybody was, such as gt/gt.txt")
    parser.add_argument("--frame-rate", type=float, default=FRAME_RATE, help="frames a second")
    parser.add_argument("--point", choices=["centre", "foot"], default="centre")
    arguments = parser.parse_args()
    choice = (arguments.frame_rate, arguments.point)
    reports = read_detections(arguments.recording, *choice)
    arguments.out.mkdir(parents=True, exist_ok=True)
    reports.write_csv(arguments.out / "reports.csv")
    print(f"{len(reports)} reports of {reports['time'].n_unique()} frames")
    if arguments.truth is not None:
        read_truth(arguments.truth, *choice).write_csv(arguments.out / "truth.csv")


if __name__ == "__main__":
    main()
