"""A snapshot of tracks as readsb's, read back by our reader of it."""

import json

import polars as pl
import pytest

from oracles.serving import FRAME, tracks_table
from trackweave.formats.format import Output
from trackweave.formats.readsb import ReadsbDecoder
from trackweave.formats.registry import format_named


def test_where_each_track_was_last_comes_back() -> None:
    table = tracks_table(6).with_columns(alt_m=pl.Series([1000.0, None, 2.0, 3.0, 4.0, 5.0]))
    earlier = table.with_columns(pl.col("time") - pl.duration(seconds=4), lat=pl.lit(0.0))
    writer = format_named("readsb", writes=True).writer
    assert writer is not None
    [data] = writer(Output(pl.concat([table, earlier]), frame=FRAME)).values()
    snapshot = json.loads(data)
    assert snapshot["now"] == 1_700_000_000.25
    assert snapshot["aircraft"][0]["alt_geom"] == pytest.approx(1000 / 0.3048, abs=0.01)
    assert "alt_geom" not in snapshot["aircraft"][1]
    found = ReadsbDecoder().feed(data)
    assert found is not None
    shown = table.filter(pl.col("status") != "tentative")
    assert found["lat"].to_list() == pytest.approx(shown["lat"].to_list(), abs=1e-6)
    assert found["lon"].to_list() == pytest.approx(shown["lon"].to_list(), abs=1e-6)
    speed = (shown["vx"] ** 2 + shown["vy"] ** 2).sqrt().to_list()
    assert found["speed_mps"].to_list() == pytest.approx(speed, abs=0.01)
    assert len(found["identity"].unique()) == 4
