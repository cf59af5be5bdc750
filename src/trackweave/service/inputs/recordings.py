"""A recording's reports, handed on as if they came now."""

import time

import numpy as np
import polars as pl

from trackweave.formats.reading import load
from trackweave.io.tables import with_our_names
from trackweave.service.inputs.outbox import SOON, Outbox
from trackweave.service.inputs.source import Source

__all__ = ["replay"]

TOGETHER = 2_000
"""So many reports at once, where nothing waits for their times."""


def replay(source: Source, outbox: Outbox) -> None:
    """Hand a recording's reports on in order of time, so many times as fast as they came."""
    raw = with_our_names(load(source.path, source.told))
    table, facts = raw.columns, raw.facts
    if raw.is_text:
        from trackweave.io.columns import typed_column

        table = pl.DataFrame([typed_column(each) for each in table.get_columns()])
    if "time" in table.columns and table["time"].dtype == pl.String:
        table = table.with_columns(pl.col("time").str.to_datetime(time_zone="UTC"))
    table = table.sort("time", maintain_order=True)
    column = table["time"]
    if isinstance(column.dtype, pl.Datetime):
        column = column.dt.cast_time_unit("us").to_physical() / 1e6
    seconds = column.cast(pl.Float64).to_numpy()
    begun, first = time.monotonic(), float(seconds[0])
    done = 0
    while done < table.height:
        end = min(done + TOGETHER, table.height)
        if source.speed > 0.0:
            now = first + (time.monotonic() - begun) * source.speed
            due = int(np.searchsorted(seconds, now, side="right"))
            if due <= done:
                time.sleep(min(SOON / 2, (seconds[done] - now) / source.speed + 1e-3))
                continue
            end = min(due, end)
        outbox.add(table[done:end], facts)
        outbox.flush()
        done = end
