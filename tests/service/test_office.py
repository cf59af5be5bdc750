"""When a service draws and when it writes snapshots, and that it is back where it was."""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import polars as pl
import pytest

from service.recordings import positions
from trackweave.domain.facts import Facts
from trackweave.service import office as module
from trackweave.service.board import Board
from trackweave.service.office import SPENT_S, Office, Order
from trackweave.service.records import Kind, packed_reports
from trackweave.service.repeating import repeated
from trackweave.service.spec import Spec


class _Clock:
    """Seconds as a test tells them."""

    def __init__(self) -> None:
        self.now = 100.0

    def monotonic(self) -> float:
        return self.now

    def thread_time(self) -> float:
        return self.now

    def time(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> _Clock:
    found = _Clock()
    monkeypatch.setattr(module, "time", found)
    return found


def orders(office: Office) -> Iterator[list[Order]]:
    """Yield a recording's reports, a quarter of a turn each, once they are in the journal."""
    frame, configuration = positions()
    payloads = [(Kind.CONFIGURE, Spec(configuration).payload())]
    for part in frame.filter(pl.col("time") < 60.0).partition_by("time", maintain_order=True):
        payloads.append((Kind.REPORTS, packed_reports(part, "test", Facts())))
    for kind, payload in payloads:
        sequence = office.journal.append(kind, payload)
        office.journal.sync()
        yield [Order(sequence, kind, payload)]


def test_a_picture_waits_for_records_on_their_way_but_not_for_long(
    tmp_path: Path, clock: _Clock
) -> None:
    office, board = Office.open(tmp_path), Board()
    *_, last = (office.take(batch, board) and batch for batch in orders(office))
    assert last
    clock.now += 1.0
    office.take([], board)
    frame, _ = positions()
    later = frame.filter(pl.col("time").is_between(60.0, 80.0))
    for part in later.partition_by("time", maintain_order=True):
        clock.now += 1.0
        batch = [Order(0, Kind.REPORTS, packed_reports(part, "test", Facts()))]
        assert office.take(batch, board, more=lambda: True).drawn is None
        clock.now += 0.11
        assert office.take([], board, more=lambda: True).drawn is not None
        assert office.take([], board).drawn is None
    office.close()


def test_two_pictures_may_follow_at_once_and_the_third_waits(
    tmp_path: Path, clock: _Clock
) -> None:
    office, board, drawn = Office.open(tmp_path), Board(), []
    for batch in orders(office):
        clock.now += 0.02
        if office.take(batch, board).drawn is not None:
            drawn.append(clock.now)
    gaps = [later - before for before, later in pairwise(drawn)]
    pairs = [later - before for before, later in zip(drawn, drawn[2:], strict=False)]
    assert min(gaps) < 0.1
    assert min(pairs) > 0.199
    office.close()


def test_a_snapshot_is_due_by_what_a_restart_would_repeat(tmp_path: Path, clock: _Clock) -> None:
    office, board = Office.open(tmp_path), Board()
    office._kept = clock.now
    for batch in orders(office):
        office.take(batch, board)
    assert not office.is_snapshot_due(is_idle=True)
    office.spent = SPENT_S
    assert office.is_snapshot_due(is_idle=True)
    assert not office.is_snapshot_due(is_idle=False)
    office.keep(*office.packed())
    assert office.spent == 0.0
    # Of nothing new there is none, however long ago the last was.
    clock.now += 1000.0
    assert not office.is_snapshot_due(is_idle=False)
    office.close()


def test_it_is_back_where_it_was_and_replay_writes_the_same(tmp_path: Path) -> None:
    office, board = Office.open(tmp_path / "data"), Board()
    for number, batch in enumerate(orders(office)):
        office.take(batch, board)
        if number in (20, 30):
            office.keep(*office.packed())
    office.close()
    again = Office.open(tmp_path / "data")
    assert again.engine.pack() == office.engine.pack()
    assert again.files.place() == office.files.place()
    again.close()
    repeated(tmp_path / "data", tmp_path / "out")
    for path in (tmp_path / "out").iterdir():
        assert path.read_bytes() == (tmp_path / "data" / "tracks" / path.name).read_bytes()
