"""From a decoding process to the service: tables as they go into the journal, and how it is."""

import json
import os
import struct
import threading
import time
from collections import deque
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

import numpy as np
import polars as pl

from trackweave.domain.facts import Facts
from trackweave.errors import DataFormatError
from trackweave.io.columns import read_times
from trackweave.io.reports import ONLY_SENSOR
from trackweave.io.tables import RawTable, with_our_names
from trackweave.service.delays import STRANGE
from trackweave.service.records import packed_reports

__all__ = ["FRAME", "MARKS", "REPORTS", "STATE", "Outbox", "completed", "framed", "told_times"]

FRAME = struct.Struct("<BII")
"""What a message is of, and how long its two parts are: words in JSON, then bytes."""
REPORTS, STATE, MARKS = 1, 2, 3
MOST_WAITING = 20_000
"""So many reports wait for the service; of what comes then, nothing is taken."""
SOON = 0.1
"""So long reports are gathered before they are handed on [s]."""
BEAT = 1.0
"""Seconds between two messages on how the input is."""
_DATE = pl.Datetime("us", "UTC")


@dataclass
class Outbox:
    """Hands tables on, in order; what overflows is dropped and counted.

    A thread writes, so that a service that does not read makes nobody wait: beyond
    ``MOST_WAITING`` reports, the newest are dropped. Where ``patient``, ``add`` waits instead,
    as for a file that can be read later as well as now.
    """

    handle: int
    source: str
    sensor: str | None = None
    patient: bool = False
    dropped: int = 0
    skipped: int = 0
    clients: int = 0
    message: str = ""
    is_listening: bool = False
    """Whether what senders send from now on is heard."""
    _parts: list[tuple[pl.DataFrame, Facts]] = field(default_factory=list)
    _gathered: int = 0
    _since: float = 0.0
    _queue: deque[tuple[int, bytes]] = field(default_factory=deque)
    _waiting: int = 0
    _changed: threading.Condition = field(default_factory=threading.Condition)
    _is_closed: bool = False

    def __post_init__(self) -> None:
        self._writer = threading.Thread(target=self._write, daemon=True)
        self._writer.start()

    def add(self, table: pl.DataFrame | None, facts: Facts) -> None:
        """Take a decoder's table; it is handed on with what comes in the next moments."""
        if table is None or table.is_empty():
            return
        with self._changed:
            if self._parts and not _fit(self._parts[-1][0], table):
                self.flush()
            while self.patient and self._waiting > MOST_WAITING and not self._is_closed:
                self._changed.wait()
            if self._waiting + self._gathered + table.height > MOST_WAITING and self._waiting:
                self.dropped += table.height
                return
            if not self._parts:
                self._since = time.monotonic()
            self._parts.append((table, facts))
            self._gathered += table.height
        self.flush(at_once=False)

    def flush(self, *, at_once: bool = True) -> None:
        """Hand on what was gathered, where it has waited long enough."""
        with self._changed:
            is_due = at_once or time.monotonic() - self._since >= SOON
            if not self._parts or not is_due:
                return
            parts, self._parts, self._gathered = self._parts, [], 0
            table = pl.concat([part for part, _ in parts], how="diagonal_relaxed")
            facts = parts[-1][1]
            for _, others in parts[:-1]:
                facts.places |= {k: v for k, v in others.places.items() if k not in facts.places}
            table = completed(table, self.sensor)
            words = {"reports": table.height, "told": told_times(table)}
            self._put(table.height, framed(REPORTS, words, self._packed(table, facts)))

    def mark(self, times: dict[str, float]) -> None:
        """Hand on what was gathered, and then when sensors' beams came by somewhere [s]."""
        with self._changed:
            self.flush()
            self._put(0, framed(MARKS, {"marks": times}))

    def listens(self) -> None:
        """Tell at once that what senders send from now on is heard."""
        with self._changed:
            self.is_listening = True
            self._put(0, framed(STATE, self._state()))

    def close(self) -> None:
        """Hand on what is left, and end once it is written."""
        self.flush()
        with self._changed:
            self.is_listening = False
            self._put(0, framed(STATE, {**self._state(), "ended": True}))
            self._is_closed = True
            self._changed.notify_all()
        self._writer.join()

    def _packed(self, table: pl.DataFrame, facts: Facts) -> bytes:
        return packed_reports(table, self.source, facts)

    def _state(self) -> dict[str, Any]:
        return {
            "dropped": self.dropped, "skipped": self.skipped, "clients": self.clients,
            "message": self.message, "listening": self.is_listening,
        }  # fmt: skip

    def _put(self, count: int, message: bytes) -> None:
        self._queue.append((count, message))
        self._waiting += count
        self._changed.notify_all()

    def _write(self) -> None:
        beat = time.monotonic()
        while True:
            with self._changed:
                if not self._queue and not self._is_closed:
                    self._changed.wait(BEAT)
                if time.monotonic() - beat >= BEAT:
                    # It also tells whether anybody is there to read it.
                    self._put(0, framed(STATE, self._state()))
                    beat = time.monotonic()
                if not self._queue:
                    if self._is_closed:
                        return
                    continue
                count, message = self._queue.popleft()
            try:
                _write_all(self.handle, message)
            except OSError:
                os._exit(0)  # the service is gone
            with self._changed:
                self._waiting -= count
                self._changed.notify_all()


def _fit(table: pl.DataFrame, other: pl.DataFrame) -> bool:
    """Tell whether two tables can become one: seconds and dates are no common column."""
    kinds = {type(each["time"].dtype) for each in (table, other) if "time" in each.columns}
    return len(kinds) < 2


def completed(table: pl.DataFrame, sensor: str | None = None) -> pl.DataFrame:
    """Return reports with a sensor and a time each: without any, that of receipt."""
    with suppress(DataFormatError):  # who tells a column twice is refused where rows are checked
        table = with_our_names(RawTable("reports", table, np.arange(table.height))).columns
    if "sensor" not in table.columns:
        table = table.with_columns(sensor=pl.lit(sensor or ONLY_SENSOR))
    elif table["sensor"].dtype == pl.String:
        table = table.with_columns(pl.col("sensor").fill_null(sensor or ONLY_SENSOR))
    now = time.time()
    if "time" not in table.columns or table["time"].dtype == pl.Null:
        return table.with_columns(time=pl.lit(now * 1e6).cast(pl.Int64).cast(_DATE))
    column = table["time"]
    if column.null_count() and column.dtype.is_numeric():
        return table.with_columns(column.fill_null(now))
    if column.null_count() and isinstance(column.dtype, pl.Datetime):
        stamp = pl.Series([int(now * 1e6)]).cast(pl.Datetime("us"))
        zone = column.dtype.time_zone
        stamp = stamp if zone is None else stamp.dt.replace_time_zone(zone)
        return table.with_columns(column.fill_null(stamp[0]))
    return table.with_columns(_stamped(column, now)) if column.dtype == pl.String else table


def _stamped(column: pl.Series, now: float) -> pl.Series:
    """Return times as text with that of receipt where cells are empty, a date among dates."""
    is_empty = column.str.strip_chars().fill_null("") == ""
    if not is_empty.any():
        return column
    told = column.filter(~is_empty)
    with suppress(DataFormatError):  # what is neither is refused where rows are checked
        dated = told.is_empty() or read_times(told).iso
        stamp = datetime.fromtimestamp(now, UTC).isoformat() if dated else f"{now:.6f}"
        return column.zip_with(~is_empty, pl.Series([stamp]))
    return column


def told_times(table: pl.DataFrame) -> dict[str, list[float]]:
    """Return what each sensor has told of times: the first, the last [s], how many, the course."""
    # The course is how long it went on without a gap of a minute [s]: a time that is off by an
    # hour is none.
    seconds = read_times(table["time"]).numbers.values
    frame = pl.DataFrame({"sensor": table["sensor"].cast(pl.String), "time": seconds})
    grouped = frame.drop_nulls().drop_nans().group_by("sensor").agg(
        pl.col("time").min().alias("first"),
        pl.col("time").max().alias("last"),
        pl.len(),
        _course(pl.col("time")).alias("course"),
    )  # fmt: skip
    return {
        name: [first, last, count, course]
        for name, first, last, count, course in grouped.sort("sensor").iter_rows()
        if np.isfinite(first) and np.isfinite(last)
    }


def _course(time: pl.Expr) -> pl.Expr:
    gaps = time.sort().diff()
    return gaps.filter(gaps < STRANGE).sum()


def framed(kind: int, words: dict[str, Any], body: bytes = b"") -> bytes:
    """Return a message."""
    text = json.dumps(words, separators=(",", ":")).encode()
    return FRAME.pack(kind, len(text), len(body)) + text + body


def _write_all(handle: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(handle, view) :]
