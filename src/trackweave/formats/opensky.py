"""OpenSky Network: state vectors of aircraft, as CSV (datasets) or JSON (the live API)."""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import polars as pl

from trackweave.formats.format import Facts, Format, Option, Skips
from trackweave.formats.json_stream import JsonStream, finite, text_of
from trackweave.formats.lines import LONGEST_LINE, Cells, Lines, table_of

__all__ = ["FORMAT", "OpenskyDecoder"]

_LATEST = 1e11
# Ours, their columns of CSV, their places in JSON.
_NUMBERS = (
    ("height_m", "baroaltitude", 7), ("geometric_height_m", "geoaltitude", 13),
    ("speed_mps", "velocity", 9), ("course_deg", "heading", 10), ("climb_mps", "vertrate", 11),
)  # fmt: skip
_TEXTS = (("callsign", "callsign", 1), ("squawk", "squawk", 14))
_NOWHERE = "states without a position, which report nothing"
_NEEDED = (b"icao24", b"lat", b"lon")
_STATE = re.compile(
    rb'\s*\[\s*(?:\[\s*)?"[0-9a-f]{6}"\s*,\s*(?:"[^"]{0,16}"|null)\s*,\s*(?:"[^"]{0,64}"|null)\s*,'
    rb"\s*(?:[0-9.]+|null)\s*,\s*[0-9.]+\s*,"
)
"""Address, callsign, country and two times: how a state begins that stands alone."""


class OpenskyDecoder:
    """Takes either kind, by its first line: a table names its columns there.

    Parameters
    ----------
    time
        What counts as a report's time: "state", that of the state vector, so that aircraft of one
        moment are one scan, or "position", when its position was heard.
    """

    def __init__(self, time: str = "state") -> None:
        self._of_position = time == "position"
        self._inner: _Csv | _Json | None = None
        self._blank, self._head = 0, b""

    @property
    def skips(self) -> Skips:
        """What could not be decoded."""
        return Skips() if self._inner is None else self._inner.skips

    @property
    def facts(self) -> Facts:
        """What is told beside the reports."""
        return Facts() if self._inner is None else self._inner.facts

    def feed(self, data: bytes) -> pl.DataFrame | None:
        """Return the reports that further bytes complete, None where there are none."""
        if self._inner is not None:
            return self._inner.feed(data)
        data = self._head + data
        head = self._head = data.lstrip(b" \t\r\n")
        self._blank += len(data) - len(head)
        is_known = head.startswith((b"{", b"[")) or b"\n" in head or len(head) > LONGEST_LINE
        return self._begin() if is_known else None

    def finish(self) -> pl.DataFrame | None:
        """Return what is left at the end."""
        return self.cut()

    def cut(self) -> pl.DataFrame | None:
        """Return what a datagram's last line holds: the next begins a line or an answer."""
        found = self._begin() if self._head else None
        last = None if self._inner is None else self._inner.cut()
        frames = [frame for frame in (found, last) if frame is not None]
        return pl.concat(frames, how="diagonal_relaxed") if frames else None

    def _begin(self) -> pl.DataFrame | None:
        """Choose what decodes by what has come, and hand it that."""
        kind = _Csv if _is_table(self._head) else _Json
        inner = self._inner = kind(self._blank, of_position=self._of_position)
        head, self._head = self._head, b""
        return inner.feed(head)


class _Csv(Lines):
    """Lines of a table with a header."""

    def __init__(self, offset: int, *, of_position: bool) -> None:
        super().__init__()
        self._offset = offset
        self._time = "lastposupdate" if of_position else "time"
        self._names: list[str] | None = None

    def _decoded(self, block: bytes, offset: int) -> pl.DataFrame | None:
        if self._names is None:
            header, _, block = block.partition(b"\n")
            names = header.decode("utf-8", "replace").removeprefix("\ufeff").split(",")
            self._names = [name.strip().strip('"').lower() for name in names]
            offset += len(header) + 1
        cells = Cells(block, offset, ",")
        north, east = self._numbers(cells, "lat"), self._numbers(cells, "lon")
        time = self._numbers(cells, self._time)
        address = self._texts(cells, "icao24")
        unsaid = [self._texts(cells, name).is_null().to_numpy() for name in ("lat", "lon")]
        unknown = unsaid[0] & unsaid[1]
        good = (cells.count == len(self._names)) & address.is_not_null().to_numpy()
        for numbers, low, high in ((north, -90, 90), (east, -180, 360), (time, 0, _LATEST)):
            good &= (numbers.is_between(low, high).fill_null(value=False)).to_numpy() | (
                unknown if numbers is not time else False
            )
        for place in np.flatnonzero(~good):
            self.skips.add(cells.offsets[place], "no state vector")
        rows = good & ~unknown
        self.facts.leave_out(_NOWHERE, (good & unknown).sum())
        if not rows.any():
            return None
        moment = (time * 1e6).round().cast(pl.Int64, strict=False).cast(pl.Datetime("us", "UTC"))
        columns = {"time": moment, "lat": north, "lon": east, "identity": address}
        columns |= {ours: self._numbers(cells, theirs) for ours, theirs, _ in _NUMBERS}
        columns |= {ours: self._texts(cells, theirs) for ours, theirs, _ in _TEXTS}
        return table_of(columns).filter(pl.Series(rows))

    def _place(self, name: str) -> int:
        assert self._names is not None
        return self._names.index(name) if name in self._names else len(self._names) + 1

    def _numbers(self, cells: Cells, name: str) -> pl.Series:
        return cells.number(self._place(name), within='"')

    def _texts(self, cells: Cells, name: str) -> pl.Series:
        text = cells.text(self._place(name)).str.strip_chars('" ').str.slice(0, 64)
        return text.set(text == "", None).str.strip_suffix(".0")


class _Json(JsonStream):
    """Answers of the API: an object with ``time`` and ``states``; or bare lists of states."""

    def __init__(self, offset: int, *, of_position: bool) -> None:
        super().__init__()
        self._begin, self._of_position = offset, of_position

    def feed(self, data: bytes) -> pl.DataFrame | None:
        """Return the reports that further bytes complete, None where there are none."""
        rows = [row for found in self.values(data) for row in self._rows(*found)]
        schema: dict[str, Any] = {
            "time": pl.Float64, "lat": pl.Float64, "lon": pl.Float64, "identity": pl.String,
            **{ours: pl.Float64 for ours, _, _ in _NUMBERS},
            **{ours: pl.String for ours, _, _ in _TEXTS},
        }  # fmt: skip
        if not rows:
            return None
        table = pl.DataFrame(rows, schema, orient="row")
        moment = (pl.col("time") * 1e6).round().cast(pl.Int64).cast(pl.Datetime("us", "UTC"))
        return table.with_columns(moment)

    def _rows(self, offset: int, value: Any) -> Iterator[tuple[Any, ...]]:
        if isinstance(value, list) and all(isinstance(each, dict) for each in value):
            for each in value:  # answers that somebody gathered
                yield from self._rows(offset, each)
            return
        states: Any
        if isinstance(value, list) and value:  # states alone, or one of them
            states, moment = value if isinstance(value[0], list) else [value], None
        else:
            states = value.get("states") if isinstance(value, dict) else None
            moment = value.get("time") if isinstance(value, dict) else None
        if not isinstance(states, list):
            if states is not None or not isinstance(value, dict) or "time" not in value:
                self.skips.add(offset, "no answer of OpenSky: time and states, or states alone")
            return
        for state in states:
            cells = [*state, *[None] * 17][:17] if isinstance(state, list) else [None] * 17
            # Without a time of the answer, that of the last message of the aircraft.
            told = cells[3] if self._of_position else cells[4] if moment is None else moment
            name, time = text_of(cells[0]), finite(told, 0.0, _LATEST)
            north, east = finite(cells[6], -90.0, 90.0), finite(cells[5], -180.0, 360.0)
            if name is not None and cells[5] is None and cells[6] is None:
                self.facts.leave_out(_NOWHERE)
                continue
            if None in (name, time, north, east):
                self.skips.add(offset, "no state vector")
                continue
            numbers = [finite(cells[place]) for _, _, place in _NUMBERS]
            yield (time, north, east, name, *numbers, *(text_of(cells[p]) for _, _, p in _TEXTS))


def _recognise(head: bytes, name: str) -> bool:
    if head.lstrip()[:1] in (b"{", b"["):
        return (b'"states"' in head[:4096] and b'"time"' in head) or bool(_STATE.match(head))
    return _is_table(head, (*_NEEDED, b"lastcontact"))


def _is_table(head: bytes, needed: tuple[bytes, ...] = _NEEDED) -> bool:
    """Tell whether the first line names columns."""
    first = head[:LONGEST_LINE].partition(b"\n")[0].lower().replace(b'"', b"").strip()
    return set(needed) <= set(first.removeprefix(b"\xef\xbb\xbf").split(b","))


FORMAT = Format(
    name="opensky",
    title="OpenSky Network state vectors, CSV and JSON",
    endings=(".json",),
    carries="positions, address as identity, heights, speed, course, callsign, squawk",
    loses="aircraft without a position, alerts, whether on the ground, who received it",
    recognise=_recognise,
    decoder=OpenskyDecoder,
    options=(
        Option("time", "state", "what counts as the time of a report", ("state", "position")),
    ),
)
