r"""AIS: what ships say of themselves by radio, as NMEA sentences (ITU-R M.1371, IEC 61162).

A sentence does not say when it was received. Receivers write that before it, as a tag block
(``\c:1609841515*5A\!AIVDM,...``), a line of its own (``$PGHP,...``) or a Unix time or date, or
behind it (``...*5C,1609841515``); rows of sentences without any have no time.
"""

import re
from collections import OrderedDict
from datetime import UTC, datetime

import numpy as np
import polars as pl

from trackweave.formats.ais_messages import positions_in
from trackweave.formats.format import Format
from trackweave.formats.lines import Lines

__all__ = ["FORMAT", "AisDecoder"]

_MOST_PENDING = 1024  # messages whose other parts have not come
_INCOMPLETE = "an AIS message of several sentences, some of which are missing"
_SENTENCE = (
    r"^(?P<head>[^!]*)!(?P<body>(?:[A-Z]{2})VD[MO],(?P<count>[1-9]),(?P<number>[1-9]),"
    r"(?P<sequence>[0-9]?),(?P<channel>[^,*]{0,2}),(?P<payload>[0-W`-w]*),(?P<fill>[0-5]))"
    r"\*(?P<sum>[0-9A-Fa-f]{2})(?P<tail>[^*]*)$"
)
_LOOKS = re.compile(rb"![A-Z]{2}VD[MO],\d,\d,")
_PGHP = re.compile(r"^\$PGHP,\d*,(\d+),(\d+),(\d+),(\d+),(\d+),(\d+),(\d+)")
# Digits of other scripts are digits to a pattern, and no numbers.
_TAG_TIME = r"\\(?:[^\\]*,)?c:([0-9]{1,16})"
_STATION = r"\\(?:[^\\]*,)?s:([^,*\\]{1,64})"
_LEADING = r"^\s*\[?\(?([0-9]{4}-[0-9]{2}-[0-9]{2}[T ][0-9]{2}:[0-9]{2}:[0-9]{2}(?:\.[0-9]{1,6})?)"
_LEADING_S = r"^\s*([0-9]{9,10}(?:\.[0-9]{1,6})?|[0-9]{12,13})\s*[:;, ]"
_TRAILING_S = r",([0-9]{9,10}(?:\.[0-9]{1,6})?|[0-9]{12,13})\s*$"

_LATEST = 1e11
"""Times beyond are no seconds."""


class AisDecoder(Lines):
    """Turns sentences into positions of ships, whose number, the MMSI, becomes ``identity``."""

    def __init__(self) -> None:
        super().__init__()
        self._pending: OrderedDict[tuple[str, str, str], dict[int, tuple[str, int]]]
        self._pending = OrderedDict()
        # Time and station of the first part, and where it begins.
        self._received: dict[tuple[str, str, str], tuple[float | None, str | None, int]] = {}
        self._announced: float | None = None

    def finish(self) -> pl.DataFrame | None:
        """Return what the last line holds; messages whose parts are missing are skipped."""
        last = super().finish()
        for _, _, offset in self._received.values():
            self.skips.add(offset, _INCOMPLETE)
        self._pending.clear()
        self._received.clear()
        return last

    def _decoded(self, block: bytes, offset: int) -> pl.DataFrame | None:
        lines = block.split(b"\n")
        lengths = np.fromiter(map(len, lines), np.int64, len(lines)) + 1
        text = pl.Series("line", block.decode("utf-8", "replace").split("\n")).str.strip_chars()
        table = pl.DataFrame({"line": text, "offset": offset + np.cumsum(lengths) - lengths})
        ours = table["line"].str.contains(r"VD[MO],|^\$PGHP")
        self.facts.leave_out(
            "lines without an AIS sentence", int(((table["line"] != "") & ~ours).sum())
        )
        table = table.filter(ours)
        table = table.with_columns(announced=self._announcements(table["line"]))
        table = table.filter(pl.col("line").str.contains(r"VD[MO],"))
        if table.is_empty():
            return None
        found = table["line"].str.extract_groups(_SENTENCE).struct.unnest()
        table = table.hstack(found)
        good = found["sum"].is_not_null() & pl.Series(_sums_agree(found))
        for where in table.filter(~good)["offset"].to_list():
            self.skips.add(where, "no AIS sentence, or its checksum is wrong")
        table = _with_times(table.filter(good))
        single = table.filter(pl.col("count") == "1").select(
            "offset", "payload", pl.col("fill").cast(pl.Int64), "time", "station"
        )
        several = self._assembled(table.filter(pl.col("count") != "1"))
        return self._positions(pl.concat([single, several]).sort("offset"))

    def _announcements(self, lines: pl.Series) -> pl.Series:
        """Return the time that the line before each announces, if it is one that does."""
        told = lines.str.starts_with("$PGHP").to_numpy()
        announced: list[float | None] = [None] * len(lines)
        last = self._announced
        if last is None and not told.any():
            return pl.Series(announced, dtype=pl.Float64)
        for place, line in enumerate(lines.to_list()):
            if told[place]:
                last = _time_of_wrapper(line)
            else:
                announced[place], last = last, None
        self._announced = last
        return pl.Series(announced, dtype=pl.Float64)

    def _assembled(self, parts: pl.DataFrame) -> pl.DataFrame:
        """Return the messages of several sentences that these complete."""
        rows = []
        columns = ("offset", "count", "number", "sequence", "channel", "payload", "fill")
        for row in parts.select(*columns, "time", "station").iter_rows():
            where, count, number, sequence, channel, payload, fill, time, station = row
            key = (count, sequence, channel)
            if number == "1" or key not in self._pending:
                if key in self._pending:
                    self.skips.add(self._received[key][2], _INCOMPLETE)
                self._pending[key], self._received[key] = {}, (time, station, where)
                self._pending.move_to_end(key)
            self._pending[key][int(number)] = (payload, int(fill))
            if len(self._pending[key]) == int(count):
                whole = [part for _, part in sorted(self._pending.pop(key).items())]
                received = self._received.pop(key)[:2]
                text = "".join(part for part, _ in whole)
                rows.append((where, text, whole[-1][1], *received))
            if len(self._pending) > _MOST_PENDING:
                oldest, _ = self._pending.popitem(last=False)
                self.skips.add(self._received.pop(oldest)[2], _INCOMPLETE)
        schema = {
            "offset": pl.Int64, "payload": pl.String, "fill": pl.Int64, "time": pl.Float64,
            "station": pl.String,
        }  # fmt: skip
        return pl.DataFrame(rows, schema, orient="row")

    def _positions(self, messages: pl.DataFrame) -> pl.DataFrame | None:
        """Return the positions that messages tell."""
        positions, place, short = positions_in(messages["payload"], messages["fill"].to_numpy())
        for each in short:
            self.skips.add(messages["offset"][int(each)], "an AIS message that ends too early")
        others = len(messages) - len(positions) - len(short)
        self.facts.leave_out("messages of kinds that are not read", others)
        if positions.is_empty():
            return None
        received = messages.select("time", "station")[place]
        time = (received["time"] * 1e6).round().cast(pl.Int64).cast(pl.Datetime("us", "UTC"))
        found = pl.DataFrame([time.alias("time")]).hstack(positions)
        if received["station"].null_count() < len(received):
            found = found.with_columns(received["station"])
        return found


def _sums_agree(found: pl.DataFrame) -> np.ndarray:
    """Return for each sentence whether its bytes, all xor-ed, are its checksum."""
    bodies = [body.encode() for body in found["body"].fill_null("!").to_list()]
    every = np.frombuffer(b"".join(bodies), np.uint8)
    ends = np.cumsum(np.fromiter(map(len, bodies), np.int64, len(bodies)))
    sums = np.bitwise_xor.reduceat(every, np.r_[0, ends[:-1]])
    told = found["sum"].fill_null("00").str.to_integer(base=16, strict=False).fill_null(-1)
    agree: np.ndarray = sums == told.to_numpy()
    return agree


def _with_times(table: pl.DataFrame) -> pl.DataFrame:
    """Return sentences with the time of their receipt [s], null where nothing tells it."""
    head, tail = pl.col("head"), pl.col("tail")
    leading = head.str.extract(_LEADING).str.replace("T", " ")
    table = table.with_columns(
        tag=_in_seconds(head.str.extract(_TAG_TIME)),
        seconds=_in_seconds(head.str.extract(_LEADING_S)),
        behind=_in_seconds(tail.str.extract(_TRAILING_S)),
        dated=leading.str.to_datetime("%Y-%m-%d %H:%M:%S%.f", strict=False).dt.epoch("us") / 1e6,
        station=head.str.extract(_STATION),
    )
    return table.with_columns(time=pl.coalesce("tag", "announced", "seconds", "dated", "behind"))


def _in_seconds(text: pl.Expr) -> pl.Expr:
    """Return Unix times [s]; some receivers write milliseconds. Null beyond all calendars."""
    time = text.cast(pl.Float64)
    time = pl.when(time > _LATEST).then(time / 1e3).otherwise(time)
    return pl.when(time <= _LATEST).then(time)


def _time_of_wrapper(line: str) -> float | None:
    """Return the time [s] that a line of Gatehouse's receivers announces."""
    found = _PGHP.match(line)
    if found is None:
        return None
    year, month, day, hour, minute, second, milli = (int(part[:4]) for part in found.groups())
    try:
        when = datetime(year, month, day, hour, minute, second, tzinfo=UTC)
    except ValueError:
        return None
    return when.timestamp() + min(milli, 999) / 1e3


def _recognise(head: bytes, name: str) -> bool:
    return _LOOKS.search(head[:8192]) is not None and b"\0" not in head[:8192]


FORMAT = Format(
    name="ais",
    title="AIS, NMEA sentences of ships",
    endings=(".nmea", ".ais"),
    carries="positions (messages 1, 2, 3, 9, 18, 19, 27), MMSI as identity, time of receipt, "
    "speed, course, heading, station",
    loses="names, voyages, aids to navigation, base stations",
    recognise=_recognise,
    decoder=AisDecoder,
)
