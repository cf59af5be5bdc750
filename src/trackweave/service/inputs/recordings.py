"""A recording's reports, handed on as if they came now."""

import os
import time
from datetime import timedelta

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray
from trackweave.domain.facts import Facts
from trackweave.formats.reading import load
from trackweave.io.columns import typed_column
from trackweave.io.tables import with_our_names
from trackweave.service.inputs.outbox import SOON, Outbox
from trackweave.service.inputs.source import Source

__all__ = ["replay"]

TOGETHER = 2_000
"""So many reports at once, where nothing waits for their times."""


def replay(source: Source, outbox: Outbox) -> None:
    """Hand a recording's reports on in order of time, so many times as fast as they came.

    It begins once standard input ends: then the service is ready.
    """
    raw = with_our_names(load(source.path, source.told))
    table, facts = raw.columns, raw.facts
    if raw.is_text:
        table = pl.DataFrame([typed_column(each) for each in table.get_columns()])
    if table["time"].dtype == pl.String:
        table = table.with_columns(pl.col("time").str.to_datetime(time_zone="UTC"))
    table = table.sort("time", maintain_order=True)
    seconds = _seconds(table["time"])
    gap = float(np.median(np.diff(np.unique(seconds)))) if len(seconds) > 1 else 1.0
    os.read(0, 1)
    begun, lap = time.monotonic(), float(np.ptp(seconds)) + gap
    if source.speed:
        begun -= source.ahead / source.speed
    _hand_on(table, seconds, (source.speed, begun), outbox, facts)
    while source.loop:
        begun += lap / source.speed if source.speed else 0.0
        table = table.with_columns(_later(table["time"], lap))
        _hand_on(table, seconds, (source.speed, begun), outbox, facts)


def _hand_on(
    table: pl.DataFrame,
    seconds: FloatArray,
    pace: tuple[float, float],
    outbox: Outbox,
    facts: Facts,
) -> None:
    """Hand a table on, its first row when the clock says ``begun``."""
    (speed, begun), done = pace, 0
    while done < table.height:
        end = min(done + TOGETHER, table.height)
        if speed > 0.0:
            now = float(seconds[0]) + (time.monotonic() - begun) * speed
            due = int(np.searchsorted(seconds, now, side="right"))
            if due <= done:
                time.sleep(min(SOON / 2, max(0.0, (seconds[done] - now) / speed) + 1e-3))
                outbox.flush(at_once=False)
                continue
            end = min(due, end)
        outbox.add(table[done:end], facts)
        done = end
    outbox.flush()


def _seconds(column: pl.Series) -> FloatArray:
    if isinstance(column.dtype, pl.Datetime):
        column = column.dt.cast_time_unit("us").to_physical() / 1e6
    return column.cast(pl.Float64).to_numpy()


def _later(column: pl.Series, lap: float) -> pl.Series:
    if isinstance(column.dtype, pl.Datetime):
        return column + timedelta(seconds=lap)
    return column + lap
