"""The newest snapshot that can be read is the one to go on from."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from oracles.disks import LossyDisk
from trackweave.errors import DataFormatError, OutputError
from trackweave.service.disk import Disk
from trackweave.service.journal import Journal
from trackweave.service.snapshots import BLOCK_BYTES, Snapshot, Snapshots

FOLDER = Path("/service")


def named(disk):
    return [name for name in disk.names(FOLDER) if "snapshot" in name]


def two():
    """Return a disk with two snapshots, and their files."""
    disk = LossyDisk()
    snapshots = Snapshots(FOLDER, disk)
    for sequence in (3, 5, 8):
        snapshots.write(sequence, b"state %d" % sequence)
    return disk, [FOLDER / name for name in named(disk)]


def test_there_is_none_in_a_new_folder(tmp_path):
    snapshots = Snapshots(tmp_path)
    assert snapshots.newest(1, 0) is None
    assert snapshots.covered == 0


@pytest.mark.parametrize("on_files", [False, True])
def test_the_newest_comes_back_and_two_are_kept(tmp_path, on_files):
    folder, disk = (tmp_path, Disk()) if on_files else (FOLDER, LossyDisk())
    snapshots = Snapshots(folder, disk)
    for sequence, covered in ((3, 0), (5, 3), (8, 5), (8, 5)):
        snapshots.write(sequence, b"state %d" % sequence)
        assert snapshots.covered == covered
        again = Snapshots(folder, disk)
        assert again.newest(1, 10) == Snapshot(sequence, b"state %d" % sequence)
        assert (again.covered, again.unreadable) == (covered, ())
    assert [int(name.split(".")[0]) for name in disk.names(folder)] == [5, 8]


def test_of_one_that_cannot_be_read_the_one_before_is_taken_and_it_is_told():
    for place in range(0, 60, 3):
        disk, (_, newest) = two()
        content = disk.names_seen[newest].seen
        content[place % len(content)] ^= 4
        snapshots = Snapshots(FOLDER, disk)
        assert snapshots.newest(1, 10) == Snapshot(5, b"state 5")
        assert len(snapshots.unreadable) == 1
        assert snapshots.unreadable[0].startswith(str(newest))
        # The other is no longer what is fallen back to: nothing before it may be forgotten.
        assert snapshots.covered == 0


@pytest.mark.parametrize("size", [0, 1, BLOCK_BYTES - 1, BLOCK_BYTES, 3 * BLOCK_BYTES + 5])
def test_what_shrinks_is_deflated_and_every_size_comes_back(size):
    disk, rng = LossyDisk(), np.random.default_rng(1)
    snapshots = Snapshots(FOLDER, disk)
    for sequence, content in enumerate((bytes(size), rng.bytes(size)), start=1):
        snapshots.write(sequence, content)
        assert Snapshots(FOLDER, disk).newest(1, 10) == Snapshot(sequence, content)
    plain, noise = (len(disk.names_seen[FOLDER / name].seen) for name in named(disk))
    assert plain <= 100 + size // 100
    assert noise <= 100 + size + size // 100


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (b"", "begins with b''; expected a snapshot"),
        (b"somebody else's file of many bytes, of which none is ours", "expected a snapshot"),
    ],
)
def test_says_what_is_wrong_with_a_file(content, what):
    disk, (_, newest) = two()
    disk.names_seen[newest].seen[:] = content
    snapshots = Snapshots(FOLDER, disk)
    snapshots.newest(1, 10)
    assert what in snapshots.unreadable[0]


def test_one_of_a_later_record_than_the_journal_holds_is_proof_of_a_loss():
    disk, _ = two()
    with pytest.raises(DataFormatError, match="proves that record 8 was stored, and the journal"):
        Snapshots(FOLDER, disk).newest(1, 7)


def test_without_one_a_journal_that_has_forgotten_is_refused():
    disk, files = two()
    for file in files:
        disk.names_seen[file].seen[20] ^= 1
    assert Snapshots(FOLDER, disk).newest(1, 10) is None
    with pytest.raises(DataFormatError, match="begins with record 4, and no snapshot can be read"):
        Snapshots(FOLDER, disk).newest(4, 10)
    # Nor is one of use that ends before what the journal has kept.
    disk, _ = two()
    assert Snapshots(FOLDER, disk).newest(7, 10) == Snapshot(8, b"state 8")
    with pytest.raises(DataFormatError, match="begins with record 10"):
        Snapshots(FOLDER, disk).newest(10, 12)


def test_a_full_disk_leaves_those_there_were():
    disk, _ = two()
    snapshots = Snapshots(FOLDER, disk)
    snapshots.newest(1, 10)
    before = named(disk)
    for space in (0, 10, 60):
        disk.space = space
        with pytest.raises(OutputError, match=r"009\.snapshot: cannot be written \(No space left"):
            snapshots.write(9, b"another state, and a long one")
        assert named(disk) == before
        assert snapshots.newest(1, 10) == Snapshot(8, b"state 8")
    disk.space = None
    disk.create(FOLDER / "00000000000000000004.snapshot.new")
    snapshots.write(9, b"another state, and a long one")
    assert snapshots.newest(1, 10).sequence == 9
    assert not [name for name in named(disk) if name.endswith(".new")]


def test_what_is_on_a_disk_that_may_only_be_read_can_be_read():
    disk, _ = two()
    disk.create(FOLDER / "00000000000000000009.snapshot.new")
    disk.is_read_only = True
    snapshots = Snapshots(FOLDER, disk)
    assert snapshots.newest(1, 10) == Snapshot(8, b"state 8")
    with pytest.raises(OutputError, match="Read-only file system"):
        snapshots.write(9, b"")


@given(st.integers(0, 2**32), st.integers(1, 6), st.sampled_from(["sync", "rename", "write", ""]))
def test_after_a_power_cut_at_any_moment_one_of_two_is_there(seed, count, breaks):
    rng, disk = np.random.default_rng(seed), LossyDisk()
    snapshots = Snapshots(FOLDER, disk)
    for sequence in range(1, count + 1):
        snapshots.write(sequence, bytes([sequence]) * int(rng.integers(2000)))
    if breaks:
        disk.failing[breaks] = 1
        with pytest.raises(OutputError):
            snapshots.write(count + 1, bytes(1000))
    else:
        path = FOLDER / f"{count + 1:020d}.snapshot"
        handle = disk.create(path.with_name(path.name + ".new"))
        disk.write(handle, bytes(1000), 0)
    disk.power_cut(rng)
    found = Snapshots(FOLDER, disk).newest(1, count + 1)
    assert found.sequence == count
    assert set(found.content) <= {count}


def test_journal_and_snapshots_go_together_through_retention():
    """Whatever is forgotten, both snapshots that are kept can be gone on from."""
    disk = LossyDisk()
    journal = Journal.open(FOLDER, disk, segment_bytes=100)
    snapshots = Snapshots(FOLDER, disk)
    for number in range(1, 41):
        journal.append(1, b"%d" % number)
        journal.sync()
        if number % 7 == 0:
            snapshots.write(number, b"sum %d" % sum(range(number + 1)))
            journal.forget(snapshots.covered)
    assert journal.first > 7
    for damaged in (None, 35):
        if damaged:
            disk.names_seen[FOLDER / f"{damaged:020d}.snapshot"].seen[50] ^= 1
        sequence, content = Snapshots(FOLDER, disk).newest(journal.first, journal.last)
        assert sequence == (28 if damaged else 35)
        total = int(content[4:]) + sum(int(each.payload) for each in journal.records(sequence))
        assert total == sum(range(41))
