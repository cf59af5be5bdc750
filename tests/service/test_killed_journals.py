"""A journal that is killed at any of its calls, and whose power fails thereafter."""

from oracles.disks import LossyDisk
from oracles.journals import FOLDER, expected, fill, opened, payload
from trackweave.service.recovery import MARK


class Killed(BaseException):
    """What no cleaning up comes after."""


def mortal(name):
    """Return a call to a disk that its process may be killed before or after."""

    def call(self, *given):
        for act in (lambda: None, lambda: getattr(LossyDisk, name)(self, *given)):
            found = act()
            self.left -= 1
            if self.left == 0:
                raise Killed
        return found

    return call


CALLS = ("create", "open", "write", "sync", "truncate", "rename", "remove", "sync_folder")
MortalDisk = type(
    "MortalDisk", (LossyDisk,), {"left": -1} | {name: mortal(name) for name in CALLS}
)


def test_killed_at_any_call_and_then_the_power_fails():
    """Whatever one process left unsynced, the next must not build on it before it is synced."""
    for moment in range(1, 200):
        disk = MortalDisk()
        fill(opened(disk, segment_bytes=100), 6)
        disk.killed()
        disk.left, journal = moment, None
        try:
            journal = opened(disk, segment_bytes=100)
            fill(journal, 6)
            journal.forget(9)
        except Killed:
            disk.left = -1
            disk.killed()
        else:
            break
        stored = journal.synced if journal else 6
        # No new segment: its sync of the folder would bring all names to the disk.
        again = opened(disk)
        assert again.last >= stored
        fill(again, 4)
        disk.lose_all()
        found = opened(disk)
        assert found.last == again.last
        assert list(found.records(found.first - 1)) == expected(found.first, found.last)
    assert moment > 50


def test_what_was_acknowledged_is_never_written_over():
    """Whatever a recovery had begun to write is rubbish, and the mark of before is lost."""
    for moment in range(1, 100):
        disk = MortalDisk()
        fill(opened(disk, segment_bytes=100), 8, batch=4)
        disk.killed()
        disk.names_seen[FOLDER / MARK].seen.clear()
        disk.names_seen[FOLDER / MARK].stored.clear()
        disk.left = moment
        try:
            journal = opened(disk)
            journal.append(1, payload(3))
            journal.sync()
        except Killed:
            disk.left = -1
            disk.lose_all(spoils=True)
        else:
            break
        assert list(opened(disk).records())[:8] == expected(1, 8)
    assert moment > 20
