"""SBS, or BaseStation: what aircraft say of themselves by ADS-B, as lines of 22 cells.

Positions are in messages of type 2 (on the ground) and 3 (in the air). Times are those of the
receiver's clock, which is taken for UTC.
"""

import numpy as np
import polars as pl

from trackweave.formats.format import Format
from trackweave.formats.lines import Cells, Lines, most_lines, table_of

__all__ = ["FORMAT", "SbsDecoder"]

_FOOT, _KNOT = 0.3048, 1852.0 / 3600.0
_KINDS = ("MSG", "STA", "ID", "AIR", "SEL", "CLK")
_FEWEST = 16
_MESSAGES = tuple("12345678")


class SbsDecoder(Lines):
    """Turns messages with a position into reports; the address becomes ``identity``."""

    def _decoded(self, block: bytes, offset: int) -> pl.DataFrame | None:
        cells = Cells(block, offset, ",")
        kind, message = cells.text(0), cells.text(1)
        is_message = (kind == "MSG").to_numpy()
        is_whole = (cells.count >= 10) & message.is_in(_MESSAGES).to_numpy()
        known = kind.is_in(_KINDS).to_numpy() & (~is_message | is_whole)
        for place in np.flatnonzero(~known):
            self.skips.add(cells.offsets[place], "no SBS message")
        told = known & is_message & message.is_in(["2", "3"]).to_numpy()
        latitude, longitude = cells.number(14), cells.number(15)
        is_empty = (cells.text(14) == "").to_numpy() & (cells.text(15) == "").to_numpy()
        told &= ~is_empty | (cells.count < _FEWEST)
        address = cells.text(4).str.to_lowercase()
        good = (
            told & (cells.count >= _FEWEST) & address.str.contains(r"^~?[0-9a-f]{6}$").to_numpy()
        )
        good &= (latitude.abs() <= 90).fill_null(value=False).to_numpy()
        good &= (longitude.abs() <= 180).fill_null(value=False).to_numpy()
        for place in np.flatnonzero(told & ~good):
            self.skips.add(cells.offsets[place], "an SBS message without address or position")
        self.facts.leave_out(
            "messages without a position, which report nothing", (known & ~told).sum()
        )
        table = table_of(
            {
                "time": _moment(cells),
                "lat": latitude,
                "lon": longitude,
                "identity": address,
                "height_m": cells.number(11) * _FOOT,
                "speed_mps": cells.number(12) * _KNOT,
                "course_deg": cells.number(13),
                "callsign": cells.text(10).replace("", None),
                "squawk": cells.text(17).replace("", None),
            }
        ).filter(pl.Series(good))
        return table if len(table) else None


def _moment(cells: Cells) -> pl.Series:
    """Return when each message was made, or else logged; null where it does not say."""
    moments = [
        (cells.text(day) + " " + cells.text(day + 1))
        .str.replace_all("-", "/")
        .str.to_datetime("%Y/%m/%d %H:%M:%S%.f", time_unit="us", strict=False)
        .dt.replace_time_zone("UTC")
        for day in (6, 8)
    ]
    return moments[0].zip_with(moments[0].is_not_null(), moments[1])


def _recognise(head: bytes, name: str) -> bool:
    return most_lines(head, _is_message)


def _is_message(line: bytes) -> bool:
    cells = line.split(b",")
    return cells[0].decode("latin-1") in _KINDS and len(cells) >= 5


FORMAT = Format(
    name="sbs",
    title="SBS (BaseStation) messages of aircraft",
    endings=(".sbs",),
    carries="positions, address as identity, barometric height, speed, course, callsign, squawk",
    loses="messages without a position",
    recognise=_recognise,
    decoder=SbsDecoder,
)
