"""KITTI tracking: labels of objects around a car, and detections as AB3DMOT gives them.

Labels have cells with blanks between: frame, track, kind, truncated, occluded, angle, box in the
image, size [m], place [m], heading, and of results a score. Detections have 15 cells with commas:
frame, kind as a number, box in the image, score, size, place, heading, angle. The place is seen
from the moving car: x to its right, y ahead. The car's own motion is not in these files.
"""

from typing import Any

import numpy as np
import polars as pl

from trackweave.formats.format import Format, Option, Output
from trackweave.formats.lines import Cells, Lines, most_lines, rate_of, table_of
from trackweave.formats.track_rows import boxed_rows, chosen_rows

__all__ = ["FORMAT", "KittiDecoder"]

_KINDS = {1.0: "Pedestrian", 2.0: "Car", 3.0: "Cyclist"}
_BOX = ("left", "top", "right", "bottom")
_SOLID = ("size_h", "size_w", "size_l")
# Where each thing stands in labels, and in detections.
_LABEL = {"frame": 0, "track": 1, "kind": 2, "box": 6, "solid": 10, "place": 13, "score": 17}
_FOUND = {"frame": 0, "track": None, "kind": 1, "box": 2, "score": 6, "solid": 7, "place": 10}
_NOWHERE = -1000.0
_USUAL_RATE = 10.0
_FARTHEST = 1e5  # metres; what KITTI does not know is -1000


class KittiDecoder(Lines):
    """Turns labels and detections into positions on the ground.

    Parameters
    ----------
    frame_rate
        Frames a second; None for 10, with a note.
    kind
        Which objects count, such as "Car"; "all" for all.
    """

    def __init__(self, frame_rate: float | None = None, kind: str = "all") -> None:
        super().__init__()
        self._rate, about = rate_of("kitti", frame_rate, _USUAL_RATE, "frames")
        self._kind = kind
        self.facts.notes.append(
            f"{about} positions are relative to the moving car, x to its right and y ahead"
        )

    def _decoded(self, block: bytes, offset: int) -> pl.DataFrame | None:
        tables = []
        for separator, layout, fewest in ((",", _FOUND, 15), (" ", _LABEL, 17)):
            cells = Cells(block, offset, separator)
            mine = cells.count >= fewest
            if separator == " ":
                for place in np.flatnonzero(~mine & (Cells(block, offset, ",").count < 15)):
                    self.skips.add(cells.offsets[place], "no label and no detection of KITTI")
            if mine.any():
                tables.append(self._of(cells, layout, mine))
        found = pl.concat(tables, how="diagonal_relaxed") if tables else pl.DataFrame()
        return found if len(found) else None

    def _of(self, cells: Cells, layout: dict[str, Any], mine: np.ndarray) -> pl.DataFrame:
        box = [cells.number(layout["box"] + place) for place in range(4)]
        solid = [cells.number(layout["solid"] + place) for place in range(3)]
        right, down, ahead = (cells.number(layout["place"] + place) for place in range(3))
        frame, kind = cells.number(layout["frame"]), cells.text(layout["kind"])
        if layout is _FOUND:
            kind = cells.number(layout["kind"]).replace_strict(
                _KINDS, default="", return_dtype=pl.String
            )
        columns = {
            "time": (frame / self._rate).round(6),
            "x": right,
            "y": ahead,
            "strength": cells.number(layout["score"]),
            "class": kind,
            **dict(zip(_BOX, box, strict=True)),
            **dict(zip(_SOLID, solid, strict=True)),
            "down_m": down,
            "heading": cells.number(layout["place"] + 3),
            "frame": frame.cast(pl.Int64, strict=False),
        }
        if layout["track"] is not None:
            columns["target"] = cells.number(layout["track"]).cast(pl.Int64, strict=False)
            columns["truncated"], columns["occluded"] = cells.number(3), cells.number(4)
        good = mine & frame.is_between(0, 1e12).fill_null(value=False).to_numpy()
        for numbers in (right, ahead):
            good &= (numbers.abs() < _FARTHEST).fill_null(value=False).to_numpy()
        good &= (kind != "").to_numpy()
        for place in np.flatnonzero(mine & ~good):
            self.skips.add(cells.offsets[place], "no label and no detection of KITTI")
        table = table_of(columns).filter(pl.Series(good))
        is_region, count = table["class"] == "DontCare", len(table)
        self.facts.leave_out("regions DontCare, which are no objects", int(is_region.sum()))
        # What a detector of images alone says of places.
        unplaced = ~is_region & (table["x"] == _NOWHERE) & (table["y"] == _NOWHERE)
        self.facts.leave_out("boxes without a place on the ground", int(unplaced.sum()))
        table, count = table.filter(~unplaced), count - int(unplaced.sum())
        if self._kind != "all":
            table = table.filter(pl.col("class") == self._kind)
            others = count - int(is_region.sum()) - len(table)
            self.facts.leave_out(f"objects of other kinds than {self._kind}", others)
        table = table.filter(pl.col("class") != "DontCare")
        said = [column.name for column in table.get_columns() if column.null_count() < len(table)]
        return table.select(said)


def _recognise(head: bytes, name: str) -> bool:
    return most_lines(head, lambda line: _is_label(line) or _is_found(line))


def _is_label(line: bytes) -> bool:
    cells = line.split(b" ")
    numbers = [*cells[:2], *cells[3:]]
    return len(cells) in (17, 18) and _are_numbers(numbers) and not _are_numbers(cells[2:3])


def _is_found(line: bytes) -> bool:
    cells = line.split(b",")
    return len(cells) == 15 and _are_numbers(cells)


def _are_numbers(cells: list[bytes]) -> bool:
    try:
        return all(float(cell) < 1e12 for cell in cells)
    except ValueError:
        return False


def _write(output: Output) -> dict[str, bytes]:
    """Return boxes with their tracks, as results are handed in; what is not known is -10 or -1."""
    rows = boxed_rows(output, _BOX, "kitti")
    places = chosen_rows(output).select("time", "track", "x", "y")
    rows = rows.drop("x", "y", strict=False).join(places, on=["time", "track"], how="left")
    rows = rows.sort("frame", "track", maintain_order=True)

    def told(name: str, otherwise: float) -> pl.Expr:
        known = pl.col(name) if name in rows.columns else pl.lit(None)
        return known.cast(pl.Float64).fill_null(otherwise).round(6).alias(name)

    if "down_m" not in rows.columns:
        rows = rows.drop("x", "y", strict=False)  # a place in the image, none on the ground
    kind = pl.col("class") if "class" in rows.columns else pl.lit("Car")
    table = rows.select(
        pl.col("frame").cast(pl.Int64),
        pl.col("track").cast(pl.Int64),
        kind.cast(pl.String).fill_null("Car").alias("class"),
        pl.lit(-1).alias("truncated"),
        pl.lit(-1).alias("occluded"),
        pl.lit(-10).alias("alpha"),
        *(told(name, -1.0) for name in (*_BOX, *_SOLID)),
        told("x", -1000.0), told("down_m", -1000.0), told("y", -1000.0), told("heading", -10.0),
        told("strength", 1.0),
    )  # fmt: skip
    text = table.write_csv(include_header=False, separator=" ")
    return {"tracks.kitti.txt": text.encode("utf-8")}


FORMAT = Format(
    name="kitti",
    title="KITTI tracking labels, results and detections (AB3DMOT)",
    endings=(".kitti.txt", ".txt"),
    carries="place on the ground, box in the image, size, heading, score, kind; identities as "
    "target",
    loses="the moving car's own path, which is in other files",
    recognise=_recognise,
    decoder=KittiDecoder,
    options=(
        Option("frame_rate", _USUAL_RATE, "frames a second"),
        Option("kind", "all", "which objects count, such as Car"),
    ),
    writer=_write,
)
