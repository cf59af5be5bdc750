"""What is acknowledged is there again, whatever ends the process or the power."""

import errno
import os
import subprocess
import sys
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from oracles.disks import LossyDisk
from oracles.journals import FOLDER, expected, fill, opened, payload
from trackweave.errors import InvalidInputError, OutputError
from trackweave.service import journal as journals
from trackweave.service.disk import Disk
from trackweave.service.journal import Journal, Retention
from trackweave.service.recovery import stored_records
from trackweave.service.segments import MOST_PAYLOAD


@pytest.fixture(params=["memory", "files"])
def place(request, tmp_path):
    """Return a folder and its disk."""
    return (FOLDER, LossyDisk()) if request.param == "memory" else (tmp_path / "a" / "b", Disk())


@pytest.mark.parametrize("segment_bytes", [100, 2**25])
def test_gives_back_what_was_synced_over_any_number_of_lives(place, segment_bytes):
    folder, disk = place
    for life in range(4):
        journal = Journal.open(folder, disk, segment_bytes=segment_bytes)
        assert journal.cut is None
        assert journal.last == journal.synced == 10 * life
        fill(journal, 10)
        assert list(journal.records()) == expected(1, 10 * life + 10)
        assert list(journal.records(after=7)) == expected(8, 10 * life + 10)
        journal.close()
    assert list(stored_records(folder, disk)) == expected(1, 40)
    assert list(stored_records(folder, disk, after=39)) == expected(40, 40)
    assert list(stored_records(folder, disk, after=50)) == []


def test_nothing_counts_before_it_is_synced():
    disk = LossyDisk()
    journal = opened(disk)
    fill(journal, 3)
    journal.append(1, b"on its way")
    assert (journal.last, journal.synced) == (4, 3)
    assert list(journal.records()) == expected(1, 3)
    assert journal.sync() == journal.synced == 4


def test_only_one_process_has_a_folder(tmp_path):
    journal = Journal.open(tmp_path)
    with pytest.raises(OutputError, match="another service writes here"):
        Journal.open(tmp_path)
    code = f"from trackweave.service.journal import Journal; Journal.open({str(tmp_path)!r})"
    command = [
        sys.executable,
        "-c",
        f"from pathlib import Path as P; {code.replace('(', '(P(', 1).replace(')', '))', 1)}",
    ]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=env)
    assert "another service writes here" in done.stderr
    journal.close()
    Journal.open(tmp_path).close()


LIVES = st.lists(
    st.tuples(
        st.lists(st.integers(0, 6), max_size=8),  # records before each sync
        st.integers(0, 3),  # records after the last
        st.sampled_from(["close", "kill", "power", "power", "full", "sync fails"]),
    ),
    max_size=8,
)


@given(LIVES, st.sampled_from([60, 400, 2**25]), st.integers(0, 2**32))
@settings(max_examples=200)
def test_no_acknowledged_record_is_ever_lost_or_changed(lives, segment_bytes, seed):
    rng, disk = np.random.default_rng(seed), LossyDisk()
    stored: dict[int, bytes] = {}
    acknowledged = 0
    for batches, rest, end in lives:
        journal = opened(disk, segment_bytes=segment_bytes)
        found = list(journal.records())
        assert [record.sequence for record in found] == list(range(1, journal.last + 1))
        assert journal.synced == journal.last >= acknowledged
        assert all(stored[record.sequence] == record.payload for record in found)
        acknowledged = journal.last
        for count in [*batches, rest]:
            for _ in range(0 if journal._lost else count):
                content = rng.bytes(int(rng.integers(0, 700)))
                stored[journal.append(1, content)] = content
            if end == "full":
                disk.space = int(rng.integers(0, 1500))
            disk.failing["sync"] = int(end == "sync fails" and rng.random() < 0.4)
            disk.failing["truncate"] = int(end == "sync fails" and rng.random() < 0.1)
            try:
                acknowledged = journal.sync()
            except OutputError:
                assert journal.synced == acknowledged
        disk.space, disk.failing["sync"], disk.failing["truncate"] = None, 0, 0
        assert [r.payload for r in journal.records()] == [
            stored[number] for number in range(1, acknowledged + 1)
        ]
        if end == "close":
            journal.close()
            acknowledged = journal.synced
        elif end == "power":
            disk.power_cut(rng)
        else:
            disk.killed()


def test_a_full_disk_takes_nothing_in_and_goes_on_when_there_is_room():
    disk = LossyDisk()
    journal = opened(disk)
    fill(journal, 5)
    disk.space = 30
    journal.append(6 % 7, payload(6))
    for _ in range(2):
        with pytest.raises(OutputError, match=r"/service: cannot be written \(No space left"):
            journal.sync()
        assert (journal.synced, journal.last) == (5, 6)
        assert list(journal.records()) == expected(1, 5)
    journal.append(7 % 7, payload(7))
    disk.space = None
    assert journal.sync() == 7
    assert list(journal.records()) == expected(1, 7)
    journal.close()
    assert list(stored_records(FOLDER, disk)) == expected(1, 7)


def test_a_full_disk_begins_no_segment_and_spoils_none():
    disk = LossyDisk()
    journal = opened(disk, segment_bytes=50)
    fill(journal, 4)
    disk.space = 10
    journal.append(5, payload(5))
    with pytest.raises(OutputError):
        journal.sync()
    disk.space = None
    assert journal.sync() == 5
    journal.close()
    assert list(stored_records(FOLDER, disk)) == expected(1, 5)


def test_what_waits_for_a_full_disk_is_bounded(monkeypatch):
    monkeypatch.setattr(journals, "MOST_WAITING", 100)
    disk = LossyDisk()
    journal = opened(disk)
    disk.space = 0
    for _ in range(10):
        journal.append(1, b"ten bytes.")
    with pytest.raises(OutputError, match="100 bytes wait for the disk"):
        journal.append(1, b"ten bytes.")
    disk.space = None
    assert journal.sync() == 10
    assert journal.append(1, b"ten bytes.") == 11


def test_a_sync_that_fails_is_not_believed_when_it_succeeds_the_second_time():
    disk = LossyDisk()
    journal = opened(disk)
    fill(journal, 3)
    journal.append(4, payload(4))
    disk.failing["sync"] = 1
    with pytest.raises(OutputError, match="Input/output error"):
        journal.sync()
    assert journal.sync() == 4
    disk.power_cut(np.random.default_rng(1))
    assert opened(disk).last == 4


def test_a_write_that_cannot_be_undone_ends_the_journal():
    disk = LossyDisk()
    journal = opened(disk)
    fill(journal, 3)
    journal.append(4, payload(4))
    disk.failing.update(sync=1, truncate=1)
    with pytest.raises(OutputError):
        journal.sync()
    for call in (journal.sync, lambda: journal.append(1, b"")):
        with pytest.raises(OutputError, match=r"cannot be undone .*expected it to be opened"):
            call()
    journal.close()
    # It may be seen, and will never be stored: it must not count before it is.
    again = opened(disk)
    count = again.last
    assert count in {3, 4}
    disk.power_cut(np.random.default_rng(1))
    assert opened(disk).last == count


def test_a_disk_that_may_only_be_read_is_read(place):
    folder, disk = FOLDER, LossyDisk()
    journal = opened(disk)
    fill(journal, 4)
    journal.close()
    disk.is_read_only = True
    with pytest.raises(OutputError, match=r"/service: cannot be written \(Read-only file system"):
        opened(disk)
    assert list(stored_records(folder, disk)) == expected(1, 4)


def segments(disk):
    return [FOLDER / name for name in disk.names(FOLDER) if name.endswith(".journal")]


def test_forgets_whole_segments_that_are_covered():
    disk = LossyDisk()
    journal = opened(disk, segment_bytes=200)
    fill(journal, 30)
    firsts = [int(path.stem) for path in segments(disk)]
    assert journal.forget(firsts[2] - 2) == journal.first == firsts[1]
    assert journal.forget(firsts[2] - 1) == firsts[2]
    assert journal.forget(10**6) == firsts[-1]
    assert [int(path.stem) for path in segments(disk)] == firsts[-1:]
    with pytest.raises(InvalidInputError, match="were forgotten; expected"):
        list(journal.records())
    journal.close()
    again = opened(disk)
    assert again.first == firsts[-1]
    assert list(again.records(after=firsts[-1] - 1)) == expected(firsts[-1], 30)
    with pytest.raises(InvalidInputError, match="were forgotten"):
        list(stored_records(FOLDER, disk))


def test_forgets_only_as_much_as_is_wanted(tmp_path):
    journal = Journal.open(tmp_path, segment_bytes=200)
    fill(journal, 30)
    files = sorted(tmp_path.glob("*.journal"))
    now = files[0].stat().st_mtime
    assert journal.forget(30, Retention(), now) == 1
    assert journal.forget(30, Retention(most_seconds=60.0), now + 50.0) == 1
    assert journal.forget(30, Retention(most_seconds=60.0), now - 3600.0) == 1
    total = sum(file.stat().st_size for file in files)
    assert journal.forget(30, Retention(most_bytes=total - 1), now) == int(files[1].stem)
    assert journal.forget(30, Retention(most_seconds=60.0), now + 100.0) == int(files[-1].stem)
    journal.close()


@pytest.mark.parametrize(("kind", "length"), [(-1, 0), (2**32, 0), (1, MOST_PAYLOAD + 1)])
def test_refuses_what_no_record_holds(kind, length):
    journal = opened(LossyDisk())
    with pytest.raises(
        InvalidInputError, match=f"record of kind {kind}, {length} bytes; expected"
    ):
        journal.append(kind, bytes(length))
    assert journal.last == 0


def test_a_folder_without_a_journal_is_refused_where_one_is_to_be_read(tmp_path):
    with pytest.raises(InvalidInputError, match="no journal"):
        list(stored_records(tmp_path))
    with pytest.raises(OutputError, match=r"cannot be read \(No such file"):
        list(stored_records(tmp_path / "none"))


def test_a_closed_journal_takes_nothing_in(tmp_path):
    journal = Journal.open(tmp_path)
    journal.append(1, b"last words")
    journal.close()
    journal.close()
    with pytest.raises(OutputError, match="closed; expected it to be opened again"):
        journal.append(1, b"")
    assert [record.payload for record in stored_records(tmp_path)] == [b"last words"]


def test_records_come_in_while_others_go_to_the_disk():
    class Slow(LossyDisk):
        def sync(self, handle):
            self.waits.wait(10.0)
            super().sync(handle)

    disk = Slow()
    disk.waits = threading.Event()
    disk.waits.set()
    journal = opened(disk)
    disk.waits.clear()
    journal.append(1, payload(1))
    writer = threading.Thread(target=journal.sync)
    writer.start()
    while journal._waiting:
        pass
    assert journal.append(2, payload(2)) == 2
    assert journal.synced == 0
    disk.waits.set()
    writer.join()
    assert journal.synced == 1
    assert journal.sync() == 2


def test_every_system_call_that_fails_is_an_error_of_ours():
    calls = ("create", "open", "write", "sync", "rename", "sync_folder", "lock", "read", "remove")
    failed = 0
    for call in calls:
        for nth in range(3):
            disk = LossyDisk()
            fill(opened(disk, segment_bytes=60), 4)
            disk.killed()
            real, count = getattr(disk, call), [0]

            def broken(*given, real=real, count=count, nth=nth):
                count[0] += 1
                if count[0] == nth + 1:
                    raise OSError(errno.EIO, "Input/output error")
                return real(*given)

            setattr(disk, call, broken)
            journal = None
            try:
                journal = opened(disk, segment_bytes=60)
                fill(journal, 4)
                journal.forget(6)
            except OutputError as err:
                failed += 1
                assert "Input/output error" in str(err)
            setattr(disk, call, real)
            disk.killed()
            again = opened(disk, segment_bytes=60)
            assert again.last >= (journal.synced if journal else 4)
            assert next(again.records(after=again.last - 1)).sequence == again.last
    assert failed > 10
