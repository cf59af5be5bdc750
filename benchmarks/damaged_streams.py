"""Damaged streams: what a decoder makes of them whole, in pieces, and before a sound one."""

import json
import xml.etree.ElementTree as ET
from collections import Counter
from typing import Any, NamedTuple

import numpy as np
import polars as pl
from damaged_kinds import damaged

from trackweave.errors import InvalidInputError
from trackweave.formats.registry import format_named

__all__ = ["LINES", "Decoded", "Sample", "ask_more", "decoded", "joined", "untold"]

LINES = {
    "sbs", "nmea", "nmea parts", "state table", "mot", "kitti detections", "kitti labels",
    "csv lines", "json lines", "aircraft lines",
}  # fmt: skip
"""Samples whose records are lines: many damaged ones are one stream."""
# One after the other they are no such file, or have a context of their own.
_NOT_APPENDED = {"trackmate", "coco"}
# What one snapshot repeats of the one before counts once.
_COUNTS_ONCE = {"aircraft", "aircraft lines"}
# Of a message several lines tell; lines say again what columns are called.
_NOT_COUNTED = {"nmea parts", "csv lines", "json lines", "aircraft lines"}


class Sample(NamedTuple):
    """What is damaged: its name, its format, its bytes."""

    name: str
    known: str
    data: bytes


class Decoded:
    """What a decoder makes of pieces: counts, places, whether the end cuts a record off."""

    def __init__(self, known: str, pieces: list[bytes]) -> None:
        form = format_named(known)
        assert form.decoder is not None
        decoder = form.decoder()
        frames = [decoder.feed(piece) for piece in pieces]
        before = decoder.skips.count
        frames.append(decoder.finish())
        tables = [frame for frame in frames if frame is not None]
        self.reports = sum(map(len, tables))
        self.skips = decoder.skips.count
        self.left_out = sum(decoder.facts.left_out.values())
        self.is_cut = decoder.skips.count > before
        self.places = [place for each in tables for place in _places(each)]
        self.offsets = [(skip.offset, skip.what) for skip in decoder.skips.listed]

    @property
    def told(self) -> tuple[Any, ...]:
        """What may not depend on how the bytes come in pieces; NaN is equal to itself."""
        return self.reports, self.skips, self.left_out, str(self.places), sorted(self.offsets)


def decoded(known: str, pieces: list[bytes]) -> Decoded | None:
    """Return what a format's decoder makes of pieces; None where the document is refused."""
    try:
        return Decoded(known, pieces)
    except InvalidInputError as err:
        if not str(err) or "\n" in str(err):
            raise AssertionError(f"a message of no line or of several: {str(err)!r:.80}") from err
        return None


def joined(sample: bytes, count: int, rng: np.random.Generator) -> bytes:
    """Return a stream of damaged samples, each of which begins a line."""
    return b"\n".join(damaged(sample, rng) for _ in range(count))


def ask_more(of: Sample, data: bytes, whole: Decoded | None, rng: np.random.Generator) -> None:
    """Ask whether pieces give the same, and whether what follows the damage is read or told."""
    name, known, sample = of
    ends = np.sort(rng.integers(0, len(data) + 1, 5)).tolist()
    pieces = [data[a:b] for a, b in zip([0, *ends], [*ends, len(data)], strict=True)]
    parts = decoded(known, pieces)
    if (parts and parts.told) != (whole and whole.told):
        raise AssertionError("pieces give other reports than the whole")
    if name in _NOT_APPENDED or whole is None:
        return
    alone, more = decoded(known, [sample]), decoded(known, [data, b"\n", sample])
    assert alone is not None
    # A record that the end cuts off is skipped, and takes with it what follows up to its end.
    if more is None or whole.is_cut or more.skips > whole.skips + alone.skips:
        return
    need, have = Counter(alone.places), Counter(more.places)
    if name in _COUNTS_ONCE:
        is_lost = bool(set(need) - set(have))
    else:
        is_lost = bool(need - (have - Counter(whole.places)))
    if is_lost:
        raise AssertionError(f"what follows is lost and not counted: {data!r:.60}")


def untold(name: str, data: bytes, found: Decoded) -> str:
    """Return what is neither a report nor counted as skipped or left out; empty for nothing."""
    told = found.reports + found.skips + found.left_out
    if name == "coco":
        value = json.loads(data)
        there = len(value["annotations"] if isinstance(value, dict) else value)
    elif name == "trackmate":
        there = sum(1 for _ in ET.fromstring(data).iter("Spot"))
    elif name in LINES and name not in _NOT_COUNTED:
        lines = [line for line in data.decode("utf-8", "replace").split("\n") if line.strip()]
        if name == "state table":
            names = data.partition(b"\n")[0].decode("utf-8", "replace").strip().split(",")
            if not {"icao24", "lat", "lon"} <= set(names):
                return ""  # no header of a table: it is read as JSON
            lines = lines[1:]
        there = len(lines) - sum("$PGHP" in line for line in lines)
        if "nmea" in name and there <= told <= len(lines):
            return ""
    else:
        return ""
    return "" if told == there else f"{there} records, {told} told"


def _places(found: pl.DataFrame) -> list[Any]:
    """Return the places of all reports, null where a column is not there: of a piece some are."""
    names = ("lat", "lon", "x", "y", "range_m", "azimuth_deg")
    none = pl.repeat(None, len(found), dtype=pl.Float64, eager=True)
    columns = [
        found[name].cast(pl.Float64, strict=False) if name in found.columns else none
        for name in names
    ]
    return list(zip(*(column.to_list() for column in columns), strict=True))
