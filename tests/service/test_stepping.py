"""Scans that come too late to be the last: put into their place, unless that takes too long."""

import polars as pl
import pytest

from service.recordings import positions
from trackweave.domain.facts import Facts
from trackweave.service import stepping
from trackweave.service.engine import Engine
from trackweave.service.records import Kind, as_json, packed_reports
from trackweave.service.spec import Spec


def after_a_late_rest() -> Engine:
    """Return an engine that was told the rest of a sensor's scan after its other half."""
    frame, configuration = positions()
    *scans, last = frame.partition_by("time", "sensor", maintain_order=True)[:30]
    half = last.height // 2
    assert half
    engine = Engine()
    given = [(Kind.CONFIGURE, Spec(configuration).payload())]
    given += [(Kind.REPORTS, packed_reports(part, "test", Facts())) for part in scans]
    until = as_json({"until": {"": float(last["time"][0])}})
    for part in (last[:half], last[half:]):
        given += [(Kind.REPORTS, packed_reports(part, "test", Facts())), (Kind.CLOSE, until)]
    for kind, payload in given:
        engine.take(engine.sequence + 1, kind, payload)
    assert engine.time == last["time"][0]
    return engine


def test_the_rest_of_a_scan_is_put_into_its_place() -> None:
    engine = after_a_late_rest()
    assert engine.counts.late == 0


def test_where_too_many_sequences_would_grow_anew_it_is_left_out_and_counted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    n_scans = after_a_late_rest().counts.scans
    monkeypatch.setattr(stepping, "MOST_REGROWN", 0)
    engine = after_a_late_rest()
    frame, _ = positions()
    last = frame.partition_by("time", "sensor", maintain_order=True)[29]
    assert engine.counts.late == last.height - last.height // 2
    assert engine.counts.scans == n_scans - 1
    # A snapshot remembers whose scans of the last time there were.
    again = Engine.unpack(engine.pack())
    # A copy of what was taken is no report, nor late.
    late = packed_reports(last[:1].with_columns(pl.col("x") + 1.0), "test", Facts())
    for each in (engine, again):
        each.take(each.sequence + 1, Kind.REPORTS, late)
        until = as_json({"until": {"": float(last["time"][0])}})
        each.take(each.sequence + 1, Kind.CLOSE, until)
    assert again.pack() == engine.pack()
    assert again.counts.late == engine.counts.late > last.height - last.height // 2
