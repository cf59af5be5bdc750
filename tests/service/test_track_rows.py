"""Rows of a service's tracks: each once, whatever the clock and the disk do."""

import errno
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.service.rows_due import RowsDue
from trackweave.service.spec import Spec
from trackweave.service.track_files import TrackFiles


def tracks_at(time: float) -> TrackTable:
    """Return three tracks at a time."""
    return TrackTable(
        time=np.full(3, time), track=np.arange(1, 4), status=np.full(3, CONFIRMED),
        hits=np.full(3, 5), score=np.full(3, -9.0), mean=np.full((3, 4), time),
        covariance=np.tile(np.eye(4), (3, 1, 1)), last_update=np.full(3, time),
    )  # fmt: skip


def told(rows: RowsDue) -> list[float]:
    return [float(table.time[0]) for table in rows.taken()]


def test_rows_of_a_time_are_written_once_though_a_wild_scan_was_put_aside() -> None:
    rows = RowsDue()
    for time in (1.0, 2.0):
        assert rows.wants(time)
        rows.add(tracks_at(time), time)
    # The wild scan is of far ahead; the tracker stays where it was.
    assert rows.wants(1000.0)
    rows.add(tracks_at(2.0), 2.0)
    rows.wants(3.0)
    rows.add(tracks_at(3.0), 3.0)
    rows.finish()
    assert told(rows) == [1.0, 2.0, 3.0]


@pytest.mark.parametrize("period", [None, 1.0])
def test_rows_go_on_where_the_clock_was_set_back(period: float | None) -> None:
    rows = RowsDue(period)
    for time in (5000.0, 5001.0):
        rows.wants(time)
        rows.add(tracks_at(time), time)
    rows.begin_anew()
    for time in (100.0, 101.0, 102.0):
        assert rows.wants(time)
        rows.add(tracks_at(time), time)
    assert told(rows) == [5000.0, 5001.0, 100.0, 101.0]


@pytest.fixture
def full(monkeypatch: pytest.MonkeyPatch) -> Callable[[bool], None]:
    """Let the disk be full, or not; a write that it refuses leaves half of it behind."""
    state, good = {"full": False}, Path.open

    def opened(path: Path, mode: str = "r", *more: Any, **named: Any) -> Any:
        file = good(path, mode, *more, **named)
        if state["full"] and mode in ("wb", "r+b"):
            write = file.write

            def refuse(data: bytes) -> int:
                write(data[: len(data) // 2])
                raise OSError(errno.ENOSPC, "No space left on device")

            file = _Refusing(file, refuse)
        return file

    monkeypatch.setattr(Path, "open", opened)
    return lambda is_full: state.update(full=is_full)


class _Refusing:
    def __init__(self, file: Any, write: Callable[[bytes], int]) -> None:
        self._file, self.write = file, write

    def __enter__(self) -> "_Refusing":
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def seek(self, place: int) -> None:
        self._file.seek(place)


@pytest.mark.parametrize("first", [1, 4])
def test_a_full_disk_keeps_rows_waiting_and_loses_none(
    tmp_path: Path, full: Callable[[bool], None], first: int
) -> None:
    spec, tables = Spec({}, dim=2), [tracks_at(float(time)) for time in range(12)]
    whole, files = TrackFiles(tmp_path / "whole"), TrackFiles(tmp_path / "full")
    for number, table in enumerate(tables, start=1):
        whole.add((table,), spec)
        full(first <= number < 9)
        files.add((table,), spec)
        full(False)
        assert files.is_behind == (first <= number < 9)
    assert files.place() == whole.place()
    written = (tmp_path / "full" / "tracks-00001.csv").read_bytes()
    assert written == (tmp_path / "whole" / "tracks-00001.csv").read_bytes()
    assert len(written.splitlines()) == 1 + sum(map(len, tables))


def test_no_rows_are_no_file(tmp_path: Path) -> None:
    files = TrackFiles(tmp_path)
    files.add((TrackTable.empty(2),), Spec({}, dim=2))
    assert list(tmp_path.iterdir()) == []


def test_a_part_that_somebody_took_away_is_followed_by_the_next(tmp_path: Path) -> None:
    spec, files = Spec({}, dim=2), TrackFiles(tmp_path)
    files.add((tracks_at(0.0),), spec)
    (tmp_path / "tracks-00001.csv").unlink()
    files.add((tracks_at(1.0),), spec)
    assert [path.name for path in tmp_path.iterdir()] == ["tracks-00002.csv"]
    lines = (tmp_path / "tracks-00002.csv").read_text().splitlines()
    assert len(lines) == 4
    assert lines[0].startswith("time,")
    assert not files.is_behind
