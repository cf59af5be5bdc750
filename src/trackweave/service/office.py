"""Journal, engine and files of one service, and how they are brought back to where they were."""

import logging
import struct
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from trackweave.config import Configuration, load_configuration
from trackweave.config.fill import ANY_SENSOR
from trackweave.domain.scans import Scan
from trackweave.errors import InvalidInputError, OutputError, TrackweaveError
from trackweave.service.board import Board, Drawn
from trackweave.service.delays import Delays
from trackweave.service.engine import Change, Engine
from trackweave.service.journal import Journal, Retention
from trackweave.service.learning import Learned, is_enough, learned, left_open
from trackweave.service.live_region import House
from trackweave.service.log import say
from trackweave.service.pacing import Pace
from trackweave.service.places import places_of
from trackweave.service.records import Arrived, arrived
from trackweave.service.snapshots import Snapshots
from trackweave.service.spec import Spec
from trackweave.service.track_files import TrackFiles, WritingPlace
from trackweave.trackers.checkpoint import pack, unpack

__all__ = ["Office", "Order", "Outcome", "restored", "unpacked"]

MOST_AT_ONCE = 2_000
"""So many reports the tracker takes in before others have their turn."""
PICTURE_S = 0.1
"""Least time between pictures [s]; one more may follow at once, as sectors of two radars do."""
SPENT_S, MOST_SPENT_S = 1.0, 4.0
"""CPU of the tracker after which a snapshot is due, which a restart would take again: where there
is time for one, and where there is not [s]."""
OLD_S, OLDEST_S = 10.0, 30.0
"""The same by the clock, for a tracker that has little to do [s]."""
REST = 4.0
"""A snapshot that took long to write is followed by so many times that without one."""
IDLE_S = 120.0
"""After so long a silence of all sensors the clock closes nothing any more [s]."""
MOST_STRANGE = 20_000

_LENGTH = struct.Struct("<I")
_log = logging.getLogger("trackweave.service")


@dataclass(frozen=True, slots=True)
class Order:
    """A record on its way to the tracker."""

    sequence: int
    kind: int
    payload: bytes
    reports: int = 0
    arrived: float = 0.0
    """By the monotonic clock [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What came of some records."""

    drawn: Drawn | None = None
    seen: tuple[Any, ...] = ()
    """Reports for the page: x, y, sensor, track."""
    time: float | None = None
    reports: int = 0
    latency: float = 0.0
    """Seconds from the arrival of the oldest until now."""
    cpu: float = 0.0


@dataclass(slots=True)
class Office:
    """Everything of a service that is not the network.

    Parameters
    ----------
    folder
        Where journal, snapshots and tracks are.
    journal, snapshots
        What is on the disk.
    engine, files
        Where they were when it was closed or killed.
    retention
        How much is kept of what a snapshot covers.
    """

    folder: Path
    journal: Journal
    snapshots: Snapshots
    engine: Engine
    files: TrackFiles
    retention: Retention = field(default_factory=Retention)
    delays: Delays = field(default_factory=Delays)
    pace: Pace = field(default_factory=Pace)
    missing: str = ""
    """What only a person can tell, without which nothing can be tracked."""
    most_regions: int | None = None
    """Into how many regions the plane may be cut; None for one tracker."""
    spent: float = 0.0
    """CPU that the tracker has taken since the last snapshot [s]."""
    unfit: set[str] = field(default_factory=set)
    """Sensors of which reports measured otherwise than is known of them."""
    _strange: list[Arrived] = field(default_factory=list)
    _tried: int = 0
    _drawn: deque[float] = field(default_factory=lambda: deque((-np.inf, -np.inf), 2))
    _undrawn: float | None = -np.inf
    """When the first scan came that no picture has shown, None for none [s]."""
    _kept: float = field(default_factory=time.monotonic)
    _kept_sequence: int = 0
    _writing_s: float = 0.0

    @classmethod
    def open(
        cls, folder: Path, retention: Retention | None = None, house: House | None = None
    ) -> "Office":
        """Return the office of a folder as it was: newest snapshot, then the journal after it."""
        journal = Journal.open(folder / "journal")
        try:
            snapshots, begun = Snapshots(folder / "journal"), time.thread_time()
            engine, files = restored(journal, snapshots, folder / "tracks", house)
        except BaseException:
            journal.close()
            raise
        office = cls(folder, journal, snapshots, engine, files, retention or Retention())
        office._kept_sequence = engine.sequence
        # A service that is killed again and again does not repeat ever more.
        office.spent = office.engine.house.cpu + time.thread_time() - begun
        return office

    def close(self) -> None:
        """Give the folder back."""
        self.engine.house.close()
        self.journal.close()

    def batch(self, ready: "deque[Order]") -> list[Order]:
        """Take out as many records as the tracker takes in at once."""
        found: list[Order] = []
        count = 0
        while ready and (not found or count + ready[0].reports <= MOST_AT_ONCE):
            found.append(ready.popleft())
            count += found[-1].reports
        return found

    def take(
        self,
        batch: Sequence[Order],
        board: Board,
        *,
        wants_reports: bool = False,
        more: Callable[[], bool] = lambda: False,
    ) -> Outcome:
        """Let the engine take records in; draw where that is due.

        Parameters
        ----------
        batch
            The records.
        board
            What is drawn on.
        wants_reports
            Whether somebody wants to see reports too.
        more
            Tells whether other records wait: then they are taken in first, for a moment.

        Returns
        -------
        What came of them.
        """
        begun, scans, house = time.thread_time(), list[Scan](), self.engine.house
        begun -= house.cpu
        for order in batch:
            change = self.engine.take(order.sequence, order.kind, order.payload)
            self._write(change)
            scans += change.scans
            if change.strange:
                self._note_strange(order, change)
            self._note_unfit(change)
        self.spent += house.cpu + time.thread_time() - begun
        drawn, now = None, time.monotonic()
        if scans and self._undrawn is None:
            self._undrawn = now
        if self._is_picture_due(now, more):
            drawn, self._undrawn = board.draw(self.engine), None
            # Where drawing takes long, it is done more rarely.
            self._drawn.append(time.monotonic() + 4.0 * (time.monotonic() - now))
        oldest = min((order.arrived for order in batch), default=now)
        return Outcome(
            drawn,
            self._seen(scans) if wants_reports else (),
            self.engine.time,
            sum(order.reports for order in batch),
            max(0.0, time.monotonic() - oldest),
            house.cpu + time.thread_time() - begun,
        )

    def _is_picture_due(self, now: float, more: Callable[[], bool]) -> bool:
        """Tell whether to draw: sectors of two radars that end together make one picture."""
        if self._undrawn is None or now - self._drawn[0] < 2.0 * PICTURE_S:
            return False
        return now - self._undrawn >= PICTURE_S or not more()

    def closing(self, now: float) -> dict[str, float]:
        """Return up to when nothing is waited for any more, by sensor [s]; nothing to say so."""
        heard = self.delays.heard
        if not self.engine.is_configured or now - max(heard.values(), default=-np.inf) > IDLE_S:
            return {}
        return self.delays.closed(self.engine.told(), now)

    def wants_to_learn(self) -> bool:
        """Tell whether a configuration can perhaps be found now."""
        engine = self.engine
        waiting = self._strange if engine.is_configured else engine.heard
        count = sum(each.table.height for each in waiting)
        # What failed is tried again with half as much more.
        return bool(count) and count >= 1.5 * self._tried

    def learn(self, configuration: Configuration, anew: bool) -> Learned | None:
        """Return with what to run from here on; None as long as that is not known."""
        engine = self.engine
        if engine.spec is not None and anew:
            return self._reloaded(configuration)
        known, heard = engine.spec, list(engine.heard)
        if known is not None:
            heard = self._strange
            configuration = _for_others(known, configuration)
        is_cut = known is None and self.most_regions is not None
        if not heard or (
            not is_enough(heard, engine.facts) and (is_cut or left_open(configuration, heard))
        ):
            return None
        try:
            found = learned(
                configuration, heard, engine.facts, known, most_regions=self.most_regions
            )
        except TrackweaveError as err:
            self.missing = str(err)
            found = None
        self._tried = 0 if found else sum(each.table.height for each in heard)
        if found is not None:
            self.missing, self._strange = "", []
            (self.folder / "tracker.toml").write_text(found.text, encoding="utf-8")
        return found

    def prepare(self, spec: Spec) -> None:
        """Have workers that are ready for the regions of a configuration."""
        self.engine.house.prepare(spec)

    def _reloaded(self, configuration: Configuration) -> Learned | None:
        """Return what runs now with what the user tells otherwise."""
        spec = self.engine.spec
        assert spec is not None
        values = {**spec.configuration}
        for key, told in configuration.values.items():
            if key == "sensors":
                usual = told.get("default", {})
                values["sensors"] = {
                    name: {**own, **usual, **told.get(name, {})}
                    for name, own in values["sensors"].items()
                }
            else:
                values[key] = {**values.get(key, {}), **told} if isinstance(told, dict) else told
        changed = replace(spec, configuration=values)
        try:
            changed.settings()
        except InvalidInputError as err:
            self.missing = str(err)
            return None
        self.unfit.clear()
        return Learned(changed, "", ())

    def is_snapshot_due(self, *, is_idle: bool) -> bool:
        """Tell whether a snapshot is to be written, where there is time for one or none."""
        if self.engine.sequence <= self._kept_sequence or self.files.is_behind:
            return False
        age = time.monotonic() - self._kept
        spent, old = (SPENT_S, OLD_S) if is_idle else (MOST_SPENT_S, OLDEST_S)
        return age >= REST * self._writing_s and (self.spent >= spent or age >= old)

    def packed(self) -> tuple[int, bytes]:
        """Return all that the engine knows, and up to which record."""
        self._kept, self._kept_sequence = time.monotonic(), self.engine.sequence
        self.spent = 0.0
        place = pack(self.files.place())
        content = b"".join((_LENGTH.pack(len(place)), place, self.engine.pack()))
        return self._kept_sequence, content

    def keep(self, sequence: int, content: bytes) -> None:
        """Write a snapshot, and forget what nobody needs any more; a disk may refuse that."""
        retention, begun = self.retention, time.monotonic()
        try:
            self.snapshots.write(sequence, content)
            if retention.most_bytes is not None or retention.most_seconds is not None:
                self.journal.forget(self.snapshots.covered, retention, time.time())
        except OutputError as err:
            say(_log, logging.WARNING, "snapshot refused", message=str(err))
        self._writing_s = time.monotonic() - begun

    def _write(self, change: Change) -> None:
        if change.rows and self.engine.spec is not None:
            self.files.add(change.rows, self.engine.spec)

    def _note_strange(self, order: Order, change: Change) -> None:
        came = arrived(order.payload)
        names = pl.Series(list(change.strange))
        if sum(each.table.height for each in self._strange) < MOST_STRANGE:
            rows = came.table.filter(pl.col("sensor").is_in(names.implode()))
            self._strange.append(replace(came, table=rows))

    def _note_unfit(self, change: Change) -> None:
        for name in sorted(change.unfit.keys() - self.unfit):
            self.unfit.add(name)
            say(_log, logging.WARNING, "reports left out as unfit", sensor=name)

    def _seen(self, scans: Sequence[Scan]) -> tuple[Any, ...]:
        """Return reports as the page draws them: place, sensor, track."""
        spec, sensors = self.engine.spec, self.engine.sensors
        track, found = self.engine.track_of(), list[Any]()
        for scan in scans:
            places = places_of(scan, sensors[scan.sensor])
            if places is None or not len(places):
                continue
            if spec is not None and spec.frame is not None:
                latitude, longitude, _ = spec.frame.to_geodetic(places)
                shown = np.round(np.stack([longitude, latitude], axis=-1), 6).tolist()
            else:
                shown = np.round(places, 2).tolist()
            for number, (x, y) in zip(scan.report.tolist(), shown, strict=True):
                of = track.get(number, -1)
                found.append([x, y, scan.sensor, str(of) if of >= 0 else None])
        return tuple(found)


def restored(
    journal: Journal, snapshots: Snapshots, tracks: Path | None, house: House | None = None
) -> tuple[Engine, TrackFiles]:
    """Return engine and files as they were after the last record.

    Parameters
    ----------
    journal
        The records.
    snapshots
        Where to begin, if any is there.
    tracks
        Where tracks files are; None to write none.
    house
        Where regions are; left out, in this process.

    Returns
    -------
    Both.
    """
    engine, files = Engine(house), TrackFiles(tracks)
    newest = snapshots.newest(journal.first, journal.last)
    if newest is not None:
        engine, place = unpacked(newest.content, house)
        files.go_on(place)
    else:
        files.go_on((0, 0, 0, ()))
    for record in journal.records(after=engine.sequence):
        change = engine.take(record.sequence, record.kind, record.payload)
        if change.rows and engine.spec is not None:
            files.add(change.rows, engine.spec)
    return engine, files


def unpacked(content: bytes, house: House | None = None) -> tuple[Engine, WritingPlace]:
    """Return the engine of a snapshot's content, and where the tracks files were."""
    begin = _LENGTH.size
    end = begin + _LENGTH.unpack_from(content)[0]
    return Engine.unpack(content[end:], house), unpack(content[begin:end])


def _for_others(known: Spec, told: Configuration) -> Configuration:
    """Return with what sensors are added: what runs, and what a user tells of any or of them."""
    sensors = {
        name: own
        for name, own in told.table("sensors").items()
        if name == ANY_SENSOR or name not in known.configuration["sensors"]
    }
    values = {**known.configuration, "sensors": sensors}
    return replace(load_configuration(values), plugins=told.plugins)
