"""JSON lines: an object a report, with the columns of a reports table."""

from typing import Any

import polars as pl

from trackweave.formats.format import Format, Output
from trackweave.formats.json_stream import JsonStream, finite, text_of

__all__ = ["FORMAT", "JsonlDecoder"]

_TIMES = {"time", "t", "timestamp", "datetime", "frame"}
_PLACES = {"x", "lat", "latitude", "range_m", "bearing_deg", "position_x"}
# Names, whatever they look like: a number of 17 digits would lose some.
_NAMES = {"sensor", "identity", "report", "target"}
_MOST_COLUMNS = 200
_BEYOND_WHOLE = 1 << 63


class JsonlDecoder(JsonStream):
    """Turns objects into rows; columns are those of the first objects."""

    by_line = True

    def __init__(self) -> None:
        super().__init__()
        self._kinds: dict[str, Any] = {}

    def feed(self, data: bytes) -> pl.DataFrame | None:
        """Return the reports that further bytes complete, None where there are none."""
        rows: list[dict[str, Any]] = []
        for offset, value in self.values(data):
            row = self._row(value) if isinstance(value, dict) else None
            if row is None:
                self.skips.add(
                    offset, "no report: an object with a time, or null, and a measurement"
                )
            else:
                rows.append(row)
        if not rows:
            return None
        for name, kind in self._kinds.items():
            if kind == pl.Float64:  # of numbers that began as whole ones, too
                for row in rows:
                    if row.get(name) is not None:
                        row[name] = float(row[name])
        return pl.DataFrame(rows, schema=dict(self._kinds))

    def finish(self) -> pl.DataFrame | None:
        """Note an object that does not end."""
        self.rest()
        return None

    def _row(self, value: dict[str, Any]) -> dict[str, Any] | None:
        names = set(value)
        if not names & _TIMES or not names & _PLACES:
            return None
        row: dict[str, Any] = {}
        kinds = dict(self._kinds)  # what is no report makes no column
        for key, cell in value.items():
            name = text_of(key)
            if name is None or cell is None:
                continue
            known = kinds.get(name)
            if known is None and len(kinds) < _MOST_COLUMNS:
                known = kinds[name] = _kind_of(name, cell)
            if known == pl.String:
                row[name] = text_of(cell if isinstance(cell, str) else str(cell), 256)
            elif known is not None:
                number = _as_number(cell)
                if number is None and (name in _TIMES or name in _PLACES):
                    return None
                if isinstance(number, float):
                    kinds[name] = pl.Float64
                row[name] = number
        self._kinds = kinds
        return row


def _kind_of(name: str, cell: Any) -> Any:
    if isinstance(cell, str) or name in _NAMES:
        return pl.String
    return pl.Int64 if isinstance(cell, int) and name not in _TIMES | _PLACES else pl.Float64


def _as_number(cell: Any) -> float | int | None:
    if isinstance(cell, str):
        try:
            return finite(float(cell))
        except ValueError:
            return None
    if isinstance(cell, int) and abs(cell) < _BEYOND_WHOLE:
        return int(cell)
    return finite(cell)


def _write(output: Output) -> dict[str, bytes]:
    from trackweave.io.columns import iso_text

    rows = output.tracks
    dated = [n for n, kind in rows.schema.items() if isinstance(kind, pl.Datetime)]
    rows = rows.with_columns(iso_text(rows[n].dt.cast_time_unit("us")).alias(n) for n in dated)
    return {"tracks.jsonl": rows.write_ndjson().encode("utf-8")}


def _recognise(head: bytes, name: str) -> bool:
    first = head.lstrip().partition(b"\n")[0].rstrip()
    keys = {b'"%s"' % key.encode() for key in _TIMES}
    return first[:1] == b"{" and first[-1:] == b"}" and any(key in first for key in keys)


FORMAT = Format(
    name="jsonl",
    title="JSON lines of reports, or of tracks",
    endings=(".jsonl", ".ndjson"),
    carries="every column; a column's kind is that of its first cell, and names are texts",
    loses="lists and objects inside of cells",
    recognise=_recognise,
    decoder=JsonlDecoder,
    writer=_write,
    takes_reports=True,
)
