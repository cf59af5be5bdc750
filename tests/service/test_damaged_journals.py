"""A write that was torn is cut off; what has rotted or is missing is named and refused."""

import pytest

from oracles.disks import File, LossyDisk
from oracles.journals import FOLDER, expected, fill, opened
from trackweave.errors import DataFormatError
from trackweave.service.recovery import MARK, stored_records
from trackweave.service.segments import DamagedJournalError, Record


def segments(disk):
    return [FOLDER / name for name in disk.names(FOLDER) if name.endswith(".journal")]


def written(count=9, segment_bytes=2**25, batch=3):
    """Return a disk with a journal that was killed, and without the mark's evidence."""
    disk = LossyDisk()
    fill(opened(disk, segment_bytes=segment_bytes), count, batch)
    disk.killed()
    disk.remove(FOLDER / MARK)
    return disk


def test_a_torn_last_write_is_cut_off_and_told():
    whole = written()
    (path,) = segments(whole)
    content = bytes(whole.names_seen[path].seen)
    begin = content.rindex(b"\xd7TWr")
    for end in range(begin + 1, len(content)):
        disk = LossyDisk()
        disk.names_seen = {path: File(content[:end])}
        journal = opened(disk)
        assert (journal.cut.offset, journal.cut.n_bytes, journal.cut.after) == (
            begin,
            end - begin,
            8,
        )
        assert journal.last == 8
        fill(journal, 1)
        assert list(journal.records()) == expected(1, 9)
        journal.close()
        assert opened(disk).cut is None


def test_rot_before_the_last_write_is_named_and_refused():
    whole = written()
    (path,) = segments(whole)
    content = bytes(whole.names_seen[path].seen)
    starts = [place for place in range(len(content)) if content.startswith(b"\xd7TWr", place)]
    assert len(starts) == 9
    for place in range(40, starts[6]):
        disk = written()
        (path,) = segments(disk)
        disk.names_seen[path].seen[place] ^= 0x10
        sequence = sum(start <= place for start in starts)
        with pytest.raises(DamagedJournalError) as caught:
            opened(disk)
        assert caught.value.path == path
        assert (caught.value.offset, caught.value.sequence) == (starts[sequence - 1], sequence)
        said = f"{path}, byte {starts[sequence - 1]}, record {sequence}: damaged; expected"
        assert str(caught.value).startswith(said)
        with pytest.raises(DamagedJournalError):
            list(stored_records(FOLDER, disk))


def test_rot_in_an_older_segment_is_named_when_it_is_read():
    disk = written(20, segment_bytes=200)
    first, *_, last = segments(disk)
    assert first != last
    disk.names_seen[first].seen[50] ^= 1
    journal = opened(disk)
    with pytest.raises(DamagedJournalError, match=f"^{first}, byte 40, record 1: damaged"):
        list(journal.records())
    assert next(journal.records(after=19)) == expected(20, 20)[0]


@pytest.mark.parametrize("place", [0, 17, 22, 30, 38])
def test_a_damaged_header_is_named(place):
    disk = written()
    (path,) = segments(disk)
    disk.names_seen[path].seen[place] ^= 1
    with pytest.raises(DataFormatError, match=f"^{path}"):
        opened(disk)


def test_a_segment_that_is_missing_is_named():
    disk = written(20, segment_bytes=200)
    _, second, third, *_ = segments(disk)
    disk.remove(second)
    journal = opened(disk)
    with pytest.raises(DamagedJournalError, match=f"record {int(second.stem)}: missing; expected"):
        list(journal.records())
    assert int(third.stem) > int(second.stem)


def test_the_mark_is_evidence_against_an_end_that_was_lost():
    disk = LossyDisk()
    fill(opened(disk), 9)
    disk.killed()
    (path,) = segments(disk)
    whole = bytes(disk.names_seen[path].seen)
    del disk.names_seen[path].seen[-5:]
    with pytest.raises(DamagedJournalError, match="record 9: damaged"):
        opened(disk)
    disk.names_seen[path].seen[:] = whole[: whole.rindex(b"\xd7TWr")]
    with pytest.raises(DamagedJournalError, match="record 9: missing"):
        opened(disk)
    disk.remove(path)
    with pytest.raises(DamagedJournalError, match=r"0001\.journal, byte 0, record 1: missing"):
        opened(disk)
    assert disk.locked == set()


def test_a_record_within_a_record_proves_nothing():
    """What senders send cannot make a torn end look like rot."""
    disk = LossyDisk()
    journal = opened(disk)
    inner = written()
    (path,) = segments(inner)
    hostile = bytes(inner.names_seen[path].seen)
    journal.append(1, hostile)
    journal.sync()
    journal.append(2, hostile)
    journal._write([Record(2, 2, hostile)])
    disk.killed()
    disk.remove(FOLDER / MARK)
    (path,) = segments(disk)
    second = disk.names_seen[path].seen.index(hostile[:40], 100)
    disk.names_seen[path].seen[second + 41] ^= 1
    found = opened(disk)
    assert found.last == 1
    assert found.cut is not None
