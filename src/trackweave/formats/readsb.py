"""readsb and dump1090: what aircraft say of themselves by ADS-B, as JSON.

Snapshots (``aircraft.json``, ``history_*.json``: an object with ``now`` and ``aircraft``), one
aircraft a line (``--json-port``), and traces (``trace_full_*.json``: an object with ``timestamp``
and ``trace``). Written is a snapshot of where each track was last.
"""

import json
from typing import Any

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray
from trackweave.formats.format import Format, Output
from trackweave.formats.json_stream import JsonStream, finite, text_of
from trackweave.formats.track_rows import EarthTrack, earth_tracks

__all__ = ["FORMAT", "ReadsbDecoder"]

_FOOT, _KNOT = 0.3048, 1852.0 / 3600.0
_LATEST = 1e11
_SCHEMA = {
    "time": pl.Float64, "lat": pl.Float64, "lon": pl.Float64, "identity": pl.String,
    "height_m": pl.Float64, "geometric_height_m": pl.Float64, "speed_mps": pl.Float64,
    "course_deg": pl.Float64, "callsign": pl.String, "squawk": pl.String,
    "source": pl.String,
}  # fmt: skip
Row = tuple[Any, ...]


class ReadsbDecoder(JsonStream):
    """Turns aircraft with a position into reports; a position that was told before counts once."""

    def __init__(self) -> None:
        super().__init__()
        self._last: dict[str, tuple[float, float, float]] = {}

    def feed(self, data: bytes) -> pl.DataFrame | None:
        """Return the reports that further bytes complete, None where there are none."""
        rows: list[Row] = []
        for offset, value in self.values(data):
            if not isinstance(value, dict):
                self.skips.add(offset, "no object of readsb")
            elif isinstance(value.get("trace"), list):
                rows += self._of_trace(offset, value)
            elif isinstance(value.get("aircraft"), list):
                for each in value["aircraft"]:
                    rows += self._of_aircraft(offset, each, value.get("now"))
            elif "hex" in value:
                rows += self._of_aircraft(offset, value, value.get("now"))
            else:
                self.skips.add(offset, "no object of readsb: neither aircraft, trace nor hex")
        if not rows:
            return None
        table = pl.DataFrame(rows, _SCHEMA, orient="row")
        moment = (pl.col("time") * 1e6).round().cast(pl.Int64).cast(pl.Datetime("us", "UTC"))
        return table.with_columns(moment)

    def finish(self) -> pl.DataFrame | None:
        """Note a value that does not end."""
        self.rest()
        return None

    def _of_aircraft(self, offset: int, each: Any, now: Any) -> list[Row]:
        name = text_of(each.get("hex"), 16) if isinstance(each, dict) else None
        if name is None:
            self.skips.add(offset, "an aircraft without an address")
            return []
        if "lat" not in each and "lon" not in each:
            self.facts.leave_out("aircraft without a position, which report nothing")
            return []
        age = finite(each.get("seen_pos"), 0.0, 1e6) or 0.0
        time, position = finite(now, 0.0, _LATEST), _position(each.get("lat"), each.get("lon"))
        if time is None or position is None:
            self.skips.add(offset, f"aircraft {name}: no time or no position")
            return []
        # A snapshot a second repeats what was heard some seconds ago.
        heard = round(time - age, 1)
        last = self._last.get(name)
        if last is not None and last[1:] == position and abs(heard - last[0]) < 1.0:
            self.facts.leave_out("positions that the snapshot before had told")
            return []
        self._remember(name, (heard, *position))
        ground = each.get("alt_baro", each.get("altitude"))
        return [
            (
                heard, *position, name.lower(),
                _scaled(ground, _FOOT), _scaled(each.get("alt_geom"), _FOOT),
                _scaled(each.get("gs", each.get("speed")), _KNOT),
                finite(each.get("track"), 0.0, 360.0),
                text_of(each.get("flight")), text_of(each.get("squawk")),
                text_of(each.get("type")),
            )
        ]  # fmt: skip

    def _of_trace(self, offset: int, value: dict[str, Any]) -> list[Row]:
        begin, name = finite(value.get("timestamp"), 0.0, _LATEST), text_of(value.get("icao"), 16)
        if begin is None or name is None:
            self.skips.add(offset, "a trace without timestamp or icao")
            return []
        rows: list[Row] = []
        for point in value["trace"]:
            cells = [*point, *[None] * 6][:6] if isinstance(point, list) else [None] * 6
            after, position = finite(cells[0], 0.0, 1e7), _position(cells[1], cells[2])
            if after is None or position is None:
                self.skips.add(offset, f"trace of {name}: a point without time or position")
                continue
            rows.append(
                (
                    begin + after, *position, name.lower(), _scaled(cells[3], _FOOT), None,
                    _scaled(cells[4], _KNOT), finite(cells[5], 0.0, 360.0), None, None, None,
                )
            )  # fmt: skip
        return rows

    def _remember(self, name: str, last: tuple[float, float, float]) -> None:
        if len(self._last) > 100_000:
            self._last.clear()
        self._last[name] = last


def _scaled(value: Any, unit: float) -> float | None:
    number = finite(value, -1e6, 1e6)
    return None if number is None else number * unit


def _position(latitude: Any, longitude: Any) -> tuple[float, float] | None:
    north, east = finite(latitude, -90.0, 90.0), finite(longitude, -180.0, 360.0)
    return None if north is None or east is None else (north, east)


def _write(output: Output) -> dict[str, bytes]:
    tracks = list(earth_tracks(output, "readsb"))
    now = max((float(each.seconds[-1]) for each in tracks), default=0.0)
    aircraft = [_aircraft(each, now) for each in tracks]
    snapshot = {"now": round(now, 3), "messages": 0, "aircraft": aircraft}
    text = json.dumps(snapshot, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return {"tracks.json": text.encode("utf-8")}


def _aircraft(track: EarthTrack, now: float) -> dict[str, Any]:
    seen = round(now - float(track.seconds[-1]), 3)
    told: dict[str, Any] = {
        "hex": f"~{track.track & 0xFFFFFF:06x}",  # no address of ICAO
        "type": "other",
        "flight": track.name,
        "lat": round(float(track.latitude[-1]), 7),
        "lon": round(float(track.longitude[-1]), 7),
        "seen": seen,
        "seen_pos": seen,
        "messages": len(track.seconds),
    }
    for key, values, unit in (
        ("gs", track.speed, _KNOT),
        ("track", track.course, 1.0),
        ("alt_geom", track.altitude, _FOOT),
    ):
        number = _last(values)
        if number is not None:
            told[key] = round(number / unit, 2)
    return told


def _last(values: FloatArray | None) -> float | None:
    return float(values[-1]) if values is not None and np.isfinite(values[-1]) else None


def _recognise(head: bytes, name: str) -> bool:
    begin = head.lstrip()[:1]
    named = (b'"aircraft"', b'"hex"', b'"trace"')
    return begin == b"{" and any(word in head for word in named) and b'"states"' not in head[:200]


FORMAT = Format(
    name="readsb",
    title="readsb and dump1090 JSON (aircraft.json, lines, traces)",
    endings=(".json",),
    carries="positions, address as identity, barometric and geometric height, speed, course, "
    "callsign, squawk, kind of message",
    loses="aircraft without a position, signal strength, intent; written: all but where tracks "
    "were last, and their uncertainty",
    recognise=_recognise,
    decoder=ReadsbDecoder,
    writer=_write,
)
