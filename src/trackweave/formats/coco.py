"""COCO-style JSON: boxes in images, as annotations or as results of a detector.

An object with ``images`` and ``annotations``, or a list of results with ``image_id`` and ``bbox``.
Images are in order of ``frame_id``, ``frame_index`` or else their number.
"""

import json
from typing import Any

import polars as pl

from trackweave.errors import DataFormatError
from trackweave.formats.format import Format, Option
from trackweave.formats.json_stream import finite, text_of
from trackweave.formats.lines import Document, rate_of

__all__ = ["FORMAT", "CocoDecoder"]

_USUAL_RATE = 25.0
_LARGEST = 1e7
_SCHEMA = {
    "time": pl.Float64, "x": pl.Float64, "y": pl.Float64, "strength": pl.Float64,
    "left": pl.Float64, "top": pl.Float64, "width": pl.Float64, "height": pl.Float64,
    "frame": pl.Int64, "class": pl.String, "target": pl.Int64,
}  # fmt: skip


class CocoDecoder(Document):
    """Turns boxes into their middles.

    Parameters
    ----------
    frame_rate
        Images a second; None for 25, with a note.
    """

    def __init__(self, frame_rate: float | None = None) -> None:
        super().__init__()
        self._rate, about = rate_of("coco", frame_rate, _USUAL_RATE, "images")
        self.facts.notes.append(f"{about} pixels are taken for metres, x to the right and y down")

    def _decoded(self, document: bytes) -> pl.DataFrame | None:
        try:
            value = json.loads(document)
        except (ValueError, RecursionError) as err:
            raise DataFormatError(f"no JSON ({str(err)[:80]})") from err
        told = value if isinstance(value, dict) else {"annotations": value}
        found = told.get("annotations")
        if not isinstance(found, list):
            raise DataFormatError("no list of annotations; expected one of COCO")
        kinds = {
            each.get("id"): text_of(each.get("name"))
            for each in _objects(told.get("categories"))
            if isinstance(each.get("id"), int | str)
        }
        frames = _frames(told.get("images"), found)
        rows = []
        for number, each in enumerate(found):
            row = self._row(each, frames, kinds)
            if row is None:
                self.skips.add(0, f"annotation {number}: no box, or of no image")
            else:
                rows.append(row)
        table = pl.DataFrame(rows, _SCHEMA, orient="row").sort("frame", maintain_order=True)
        said = [column.name for column in table.get_columns() if column.null_count() < len(table)]
        return table.select(said) if len(table) else None

    def _row(self, each: Any, frames: dict[Any, int], kinds: dict[Any, Any]) -> Any:
        if not isinstance(each, dict) or not isinstance(each.get("image_id"), int | str):
            return None
        box = each.get("bbox")
        cells = [finite(c, -_LARGEST, _LARGEST) for c in box] if isinstance(box, list) else []
        frame = frames.get(each["image_id"])
        if len(cells) != 4 or None in cells or frame is None:
            return None
        left, top, width, height = (float(cell or 0.0) for cell in cells)
        kind, track = each.get("category_id"), finite(each.get("track_id"), 0, 2**53)
        track = finite(each.get("instance_id"), 0, 2**53) if track is None else track
        return (
            round(frame / self._rate, 6), left + width / 2, top + height / 2,
            finite(each.get("score")), left, top, width, height, frame,
            kinds.get(kind, str(kind)[:64]) if isinstance(kind, int | str) else None,
            None if track is None else int(track),
        )  # fmt: skip


def _objects(value: Any) -> list[dict[str, Any]]:
    return [each for each in value if isinstance(each, dict)] if isinstance(value, list) else []


def _frames(images: Any, annotations: list[Any]) -> dict[Any, int]:
    """Return which image, counted from 0, each identifier is."""
    ordered = []
    for each in _objects(images):
        name = each.get("id")
        if isinstance(name, int | str):
            key = each.get("frame_id", each.get("frame_index", name))
            ordered.append((str(type(key).__name__), finite(key), str(key), name))
    if not ordered:
        names = {
            a["image_id"] for a in _objects(annotations) if isinstance(a.get("image_id"), int)
        }
        return {name: place for place, name in enumerate(sorted(names))}
    ordered.sort(key=lambda one: (one[0], one[1] is None, one[1] or 0.0, one[2]))
    return {name: place for place, (*_, name) in enumerate(ordered)}


def _recognise(head: bytes, name: str) -> bool:
    is_json = head.lstrip()[:1] in (b"{", b"[") and b'"image' in head
    return is_json and (b'"bbox"' in head or b'"images"' in head)


FORMAT = Format(
    name="coco",
    title="COCO-style JSON, annotations or results",
    endings=(".json",),
    carries="boxes (their middles as positions), score, class, image; track_id as target",
    loses="masks, keypoints, licences",
    recognise=_recognise,
    decoder=CocoDecoder,
    options=(Option("frame_rate", _USUAL_RATE, "images a second"),),
)
