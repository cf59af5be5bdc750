"""Kills journal, snapshots and tracker at their critical moments, and looks whether all goes on.

Run ``python benchmarks/service_kills.py --kills 1000 --seed 1``. A process takes scans in as the
service does: a record for each, a sync for a few, the tracker's step, a snapshot now and then,
old segments forgotten. It ends by ``SIGKILL``: four times of five it kills itself at a moment
drawn beforehand (before, in the middle of or after a call to the file system, a step or a pack),
once it is killed after a time drawn. After half of the kills the power fails as well: a model of
the disk, which has followed every call, keeps any sectors of what was not synced, and the files
are made so. The next process recovers, and goes on where the journal ends.

Each time it is asked: are all acknowledged records there, byte for byte? Is the tracker after
recovery the one of a run that nobody disturbed, byte for byte? Ends with status 1 if not.
"""

import argparse
import hashlib
import os
import pickle
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import trackweave as tw
from trackweave.service.disk import Disk
from trackweave.service.journal import Journal
from trackweave.service.recovery import firsts_of, stored_records
from trackweave.service.snapshots import Snapshots
from trackweave.trackers.checkpoint import pack, unpack

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from oracles.disks import File, LossyDisk
from oracles.scenes import MOTION, scene, sensor

SCANS, BATCH, SNAPSHOT_EVERY, SEGMENT_BYTES = 90, 4, 9, 6_000
KIND = 1
MOMENTS = 160
"""A life is killed at one of its first so many moments, if it is not over before."""


def tracker() -> tw.MultiHypothesisTracker:
    views = [tw.FieldOfView(azimuth_deg=span) for span in ((0.0, 45.0), (45.0, 90.0))]
    both = [sensor(n, field_of_view=v) for n, v in zip(("a", "b"), views, strict=True)]
    return tw.MultiHypothesisTracker(motion=MOTION, sensors=both, window=3)


def payloads() -> list[bytes]:
    """Return the records' contents: scans, some of which come late."""
    scans = scene(5, objects=5, times=range(SCANS // 2), names=("a", "b"))
    for late in range(7, SCANS - 1, 11):
        scans[late], scans[late + 1] = scans[late + 1], scans[late]
    return [pack(each) for each in scans]


def digest(target: tw.MultiHypothesisTracker) -> str:
    return hashlib.sha256(pack(target)).hexdigest()


def undisturbed(records: list[bytes]) -> list[str]:
    """Return the digest of the tracker before the first record and after each."""
    target = tracker()
    digests = [digest(target)]
    for content in records:
        target.step(unpack(content))
        digests.append(digest(target))
    return digests


class Plan:
    """When a process kills itself: at a moment that it comes by."""

    def __init__(self, moment: int) -> None:
        self._left = moment

    def pass_by(self) -> bool:
        """Tell whether this is the moment."""
        self._left -= 1
        return self._left == 0


def die(log: "Log", where: str) -> None:
    log.put("died", where)
    os.kill(os.getpid(), signal.SIGKILL)


class Log:
    """What a process did, in a file that outlives it."""

    def __init__(self, path: Path) -> None:
        self._handle = os.open(path, os.O_CREAT | os.O_APPEND | os.O_WRONLY)

    def put(self, *entry: Any) -> None:
        """Append an entry."""
        os.write(self._handle, pickle.dumps(entry))

    @staticmethod
    def read(path: Path) -> Iterator[tuple[Any, ...]]:
        """Yield the entries of a file."""
        with path.open("rb") as file:
            while True:
                try:
                    yield pickle.load(file)
                except (EOFError, pickle.UnpicklingError):  # killed while it was written
                    return


class MortalDisk(Disk):
    """The real disk; logs what is done, and kills the process when its moment has come."""

    def __init__(self, log: Log, plan: Plan) -> None:
        self._log, self._plan = log, plan
        self._kinds: dict[int, str] = {}

    def _do(self, name: str, *given: Any) -> Any:
        kind = self._kinds.get(given[0]) or kind_of(given[0])
        where = f"{name} {kind}"
        if self._plan.pass_by():
            die(self._log, f"before {where}")
        # What may have been done is logged before, what is certain afterwards.
        is_promise = name in {"sync", "sync_folder"}
        if not is_promise:
            if name == "write" and self._plan.pass_by():
                handle, content, offset = given
                half = content[: len(content) // 2]
                self._log.put("call", None, name, handle, half, offset)
                Disk.write(self, handle, half, offset)
                die(self._log, f"in the middle of {where}")
            self._log.put("call", None, name, *given)
        found = getattr(Disk, name)(self, *given)
        if name in {"create", "open"}:
            self._kinds[found] = kind.removesuffix(".new")
        if is_promise or name in {"create", "open"}:
            self._log.put("call", found, name, *given)
        if self._plan.pass_by():
            die(self._log, f"after {where}")
        return found

    def create(self, path: Path) -> int:
        """Do `Disk.create`."""
        return int(self._do("create", path))

    def open(self, path: Path) -> int:
        """Do `Disk.open`."""
        return int(self._do("open", path))

    def write(self, handle: int, content: bytes, offset: int) -> None:
        """Do `Disk.write`."""
        self._do("write", handle, content, offset)

    def sync(self, handle: int) -> None:
        """Do `Disk.sync`."""
        self._do("sync", handle)

    def truncate(self, handle: int, size: int) -> None:
        """Do `Disk.truncate`."""
        self._do("truncate", handle, size)

    def rename(self, old: Path, new: Path) -> None:
        """Do `Disk.rename`."""
        self._do("rename", old, new)

    def remove(self, path: Path) -> None:
        """Do `Disk.remove`."""
        self._do("remove", path)

    def sync_folder(self, folder: Path) -> None:
        """Do `Disk.sync_folder`."""
        self._do("sync_folder", folder)


def empty_disk() -> LossyDisk:
    """Return a disk whose own handles are nobody else's."""
    disk = LossyDisk()
    disk.next_handle = 10**6
    return disk


def kind_of(given: Any) -> str:
    """Return of which kind a file is."""
    return "".join(given.suffixes) or given.name if isinstance(given, Path) else "?"


def live(folder: Path, log: Log, plan: Plan, records: list[bytes]) -> None:
    """Recover and go on, until killed or all is done."""
    disk = MortalDisk(log, plan)
    journal = Journal.open(folder, disk, segment_bytes=SEGMENT_BYTES)
    snapshots = Snapshots(folder, disk)
    found = snapshots.newest(journal.first, journal.last)
    target = tracker() if found is None else unpack(found.content)
    for record in journal.records(after=found.sequence if found else 0):
        target.step(unpack(record.payload))
    log.put("recovered", journal.last, digest(target), found is not None, journal.cut is not None)

    def at(name: str, act: Callable[[], Any]) -> Any:
        if plan.pass_by():
            die(log, f"before {name}")
        done = act()
        if plan.pass_by():
            die(log, f"after {name}")
        return done

    while journal.last < len(records):
        first = journal.last
        for content in records[first : first + 1 + first % BATCH]:
            journal.append(KIND, content)
        log.put("acknowledged", journal.sync())
        if plan.pass_by():
            die(log, "after an acknowledgement")
        for content in records[first : journal.synced]:
            at("a step", lambda content=content: target.step(unpack(content)))
        if first // SNAPSHOT_EVERY < journal.synced // SNAPSHOT_EVERY:
            snapshots.write(journal.synced, at("a pack", lambda: pack(target)))
            journal.forget(snapshots.covered)
    journal.close()
    log.put("done", journal.last, digest(target))


class Found(NamedTuple):
    """What is wrong after a kill, and what was seen."""

    wrong: list[str]
    seen: Counter[str]


class World:
    """A folder, the model of its disk, and what has been acknowledged."""

    def __init__(self, place: Path, records: list[bytes], seed: int) -> None:
        self.folder, self._log = place / "data", place / "log"
        self.records, self.digests = records, undisturbed(records)
        self.rng = np.random.default_rng(seed)
        self.begin()

    def begin(self) -> None:
        """Begin anew with an empty folder."""
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        self.disk, self.acknowledged, self.is_done = empty_disk(), 0, False

    def kill_once(self) -> Found:
        """Let a process live and die, and see what is left; nothing where it came to its end."""
        by_time = self.rng.random() < 0.2
        plan = Plan(0 if by_time else int(self.rng.integers(1, MOMENTS)))
        delay = float(self.rng.uniform(0.005, 0.6)) if by_time else None
        status = self._fork(plan, delay)
        seen, wrong = Counter[str](), list[str]()
        for what, *told in Log.read(self._log):
            self._hear(what, told, seen, wrong)
        was_killed = os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL
        if not was_killed:
            if os.WEXITSTATUS(status) or not self.is_done:
                wrong.append(f"ended by itself with status {status}")
            return Found(wrong, seen)
        seen["kills"] += 1
        if by_time:
            seen["died by the clock"] += 1
        self._after_kill(by_time, seen, wrong)
        self._check_records(wrong)
        return Found(wrong, seen)

    def _fork(self, plan: Plan, delay: float | None) -> int:
        self._log.unlink(missing_ok=True)
        self._log.touch()  # it may be killed before it writes one
        child = os.fork()
        if child == 0:
            status = 1
            try:
                live(self.folder, Log(self._log), plan, self.records)
                status = 0
            finally:
                os._exit(status)
        if delay is not None:
            time.sleep(delay)
            os.kill(child, signal.SIGKILL)
        return os.waitpid(child, 0)[1]

    def _hear(self, what: str, told: list[Any], seen: Counter[str], wrong: list[str]) -> None:
        """Take in what a process has logged."""
        if what == "call":
            self._model(*told)
        elif what == "died":
            seen[f"died {told[0]}"] += 1
        elif what == "acknowledged":
            self.acknowledged = told[0]
        else:
            last, found, *how = told
            if found != self.digests[last]:
                wrong.append(f"{what} at record {last}, and the tracker is another")
            if what == "done":
                self.is_done = True
            else:
                seen["recoveries"] += 1
                seen["from a snapshot"] += how[0]
                seen["with a torn end cut off"] += how[1]

    def _model(self, result: Any, name: str, *given: Any) -> None:
        """Do to the model what was done to the disk."""
        if name in {"create", "open"}:
            if result is not None:
                own = getattr(self.disk, name)(*given)
                self.disk.handles[result] = self.disk.handles.pop(own)
            return
        getattr(self.disk, name)(*given)

    def _after_kill(self, by_time: bool, seen: Counter[str], wrong: list[str]) -> None:
        """Let the power fail, or compare the model with the disk."""
        if self.rng.random() < 0.5:
            seen["power cuts"] += 1
            before = {path: bytes(file.seen) for path, file in self.disk.names_seen.items()}
            self.disk.power_cut(self.rng)
            after = {path: bytes(file.seen) for path, file in self.disk.names_seen.items()}
            seen["power cuts that lost something"] += before != after
            for path in self.folder.iterdir():
                path.unlink()
            for path, content in after.items():
                path.write_bytes(content)
            return
        self.disk.killed()
        real = {p: p.read_bytes() for p in self.folder.iterdir() if p.name != "lock"}
        if by_time:  # what the last call had done, only the disk knows
            self.disk = empty_disk()
            self.disk.names_seen = {path: File(content) for path, content in real.items()}
            self.disk.names_stored = dict(self.disk.names_seen)
        elif real != {path: bytes(file.seen) for path, file in self.disk.names_seen.items()}:
            wrong.append("the model of the disk is not the disk")

    def _check_records(self, wrong: list[str]) -> None:
        """See whether what was acknowledged is there."""
        firsts = firsts_of(self.folder, Disk())
        if not firsts:
            if self.acknowledged:
                wrong.append(f"{self.acknowledged} acknowledged, and no journal")
            return
        last = firsts[0] - 1
        try:
            for record in stored_records(self.folder, after=last):
                last += 1
                if record.sequence != last or record.payload != self.records[last - 1]:
                    wrong.append(f"record {last} is another")
        except tw.DataFormatError as err:
            wrong.append(str(err))
        if last < self.acknowledged:
            wrong.append(f"{self.acknowledged} acknowledged, and the journal ends with {last}")


def table(seen: Counter[str]) -> str:
    """Return where processes died, by count."""
    died = {name[5:]: count for name, count in seen.items() if name.startswith("died ")}
    rows = [f"| {name} | {count} |" for name, count in sorted(died.items(), key=lambda e: -e[1])]
    return "\n".join(["| killed | times |", "|---|---|", *rows])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, help="where to work; a disk's, not a memory's")
    options = parser.parse_args()
    total, wrong, n_worlds = Counter[str](), list[str](), 1
    with tempfile.TemporaryDirectory(dir=options.folder) as place:
        world = World(Path(place), payloads(), options.seed)
        while total["kills"] < options.kills and len(wrong) < 10:
            found = world.kill_once()
            total += found.seen
            wrong += [f"kill {total['kills']}: {each}" for each in found.wrong]
            if world.is_done or found.wrong:
                n_worlds += 1
                world.begin()
    print(table(total))
    named = ("kills", "power cuts", "power cuts that lost something", "recoveries",
             "from a snapshot", "with a torn end cut off")  # fmt: skip
    print("\n" + ", ".join(f"{name}: {total[name]}" for name in named))
    print(f"journals: {n_worlds}; acknowledged records lost or trackers changed: {len(wrong)}")
    for each in wrong:
        print(each)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
