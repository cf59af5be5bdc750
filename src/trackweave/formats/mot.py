"""MOTChallenge: boxes in the frames of a video, ``det.txt`` and ``gt.txt``.

A line is a box: frame (from 1), identity (-1 for none), left, top, width, height [pixels],
confidence, and up to three numbers more; of the truth the seventh says whether the box is to be
judged, the eighth its class, the ninth how much of it is visible.
"""

import numpy as np
import polars as pl

from trackweave.formats.format import Format, Option, Output
from trackweave.formats.lines import Cells, Lines, most_lines, rate_of, table_of
from trackweave.formats.track_rows import boxed_rows

__all__ = ["FORMAT", "MotDecoder"]

_FEWEST, _MOST = 6, 10
_NAMES = ("left", "top", "width", "height")
_USUAL_RATE = 25.0
_LARGEST = 1e7  # pixels, or frames
_UNJUDGED = "boxes with an identity and a confidence of 0, which are not to be judged"


class MotDecoder(Lines):
    """Turns boxes into positions.

    Parameters
    ----------
    frame_rate
        Frames a second; None for 25, with a note.
    point
        Which point of a box is its object's place: "centre", or "foot" for its lower edge.
    """

    def __init__(self, frame_rate: float | None = None, point: str = "centre") -> None:
        super().__init__()
        self._rate, about = rate_of("mot", frame_rate, _USUAL_RATE, "frames")
        # People stand on their feet, but a box's centre jumps less than its lower edge.
        self._down = 1.0 if point == "foot" else 0.5
        self.facts.notes.append(f"{about} pixels are taken for metres, x to the right and y down")

    def _decoded(self, block: bytes, offset: int) -> pl.DataFrame | None:
        cells = Cells(block, offset, ",")
        frame, name = cells.number(0), cells.number(1)
        boxes = {column: cells.number(2 + place) for place, column in enumerate(_NAMES)}
        # Results say -1 for a confidence that they do not know.
        strength = cells.number(6)
        strength = strength.set((strength == -1) & (name >= 0), None)
        good = (cells.count >= _FEWEST) & name.is_not_null().to_numpy()
        good &= frame.is_between(0, 1e12).fill_null(value=False).to_numpy()
        for column in _NAMES:
            good &= (boxes[column].abs() < _LARGEST).fill_null(value=False).to_numpy()
        for place in np.flatnonzero(~good):
            self.skips.add(cells.offsets[place], "no box: frame,identity,left,top,width,height")
        time = ((frame - 1) / self._rate).round(6)
        table = table_of(
            {
                "time": time,
                "x": (boxes["left"] + boxes["width"] / 2).round(3),
                "y": (boxes["top"] + boxes["height"] * self._down).round(3),
                "strength": strength,
                **boxes,
                "frame": frame.cast(pl.Int64, strict=False),
                "target": name.cast(pl.Int64, strict=False).set(name < 0, None),
                "class": cells.number(7).cast(pl.Int64, strict=False).set(name < 0, None),
            }
        ).filter(pl.Series(good))
        judged = table["target"].is_null() | (table["strength"].fill_null(1.0) != 0)
        self.facts.leave_out(_UNJUDGED, int((~judged).sum()))
        table = table.filter(judged)
        # What no line says is no column: a column target of nothing would mean false alarms.
        said = [column.name for column in table.get_columns() if column.null_count() < len(table)]
        return table.select(said) if len(table) else None


def _recognise(head: bytes, name: str) -> bool:
    # A table of anything else has a first line that names its columns.
    return _is_box(head.lstrip().partition(b"\n")[0]) and most_lines(head, _is_box)


def _is_box(line: bytes) -> bool:
    cells = line.split(b",")
    try:
        numbers = [float(cell) for cell in cells]
    except ValueError:
        return False
    is_whole = all(number == int(number) for number in numbers[:2] if abs(number) < 1e15)
    return _FEWEST < len(cells) <= _MOST and is_whole and numbers[0] >= 0 and numbers[1] >= -1


def _write(output: Output) -> dict[str, bytes]:
    """Return boxes with their tracks, as results are handed in."""
    rows = boxed_rows(output, _NAMES, "mot")
    if rows["frame"].dtype.is_numeric() and len(rows) and rows["frame"].min() == 0:
        rows = rows.with_columns(pl.col("frame") + 1)
    strength = pl.col("strength") if "strength" in rows.columns else pl.lit(1.0)
    table = rows.select(
        pl.col("frame").cast(pl.Int64),
        pl.col("track").cast(pl.Int64),
        *(pl.col(name).cast(pl.Float64).round(3) for name in _NAMES),
        strength.cast(pl.Float64).fill_null(1.0).round(6).alias("strength"),
        *(pl.lit(-1).alias(f"none_{axis}") for axis in "xyz"),
    )
    return {"tracks.mot.txt": table.write_csv(include_header=False).encode("ascii")}


FORMAT = Format(
    name="mot",
    title="MOTChallenge det.txt, gt.txt and results",
    endings=(".mot.txt", ".txt"),
    carries="frame, box (its point as position), confidence, class; identities as target",
    loses="the world's coordinates of 3-D results",
    recognise=_recognise,
    decoder=MotDecoder,
    options=(
        Option("frame_rate", _USUAL_RATE, "frames a second"),
        Option("point", "centre", "which point of a box is the place", ("centre", "foot")),
    ),
    writer=_write,
)
