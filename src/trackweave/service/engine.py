"""The tracks as a pure function of the journal's records: no clock, no thread, no other order."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from trackweave.arrays import IntArray
from trackweave.config.fill import Settings
from trackweave.domain.facts import Facts, Place
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TENTATIVE, TrackTable
from trackweave.models.sensors import Sensor
from trackweave.randomness import generator_of
from trackweave.run.course import tracker_of
from trackweave.run.held import HeldLook, HeldPlaces
from trackweave.run.regions.cutting import Region
from trackweave.service.blocks import Block, blocks_of
from trackweave.service.cutting import Cutter, SensorCut
from trackweave.service.live_region import Here, House
from trackweave.service.records import Arrived, Kind, arrived, from_json, packed_reports
from trackweave.service.regions import RegionsTracker
from trackweave.service.rows_due import RowsDue
from trackweave.service.shared_tracks import SharedTracks
from trackweave.service.sorting_in import sorted_in
from trackweave.service.spec import Spec
from trackweave.service.stepping import Counts, Names, Stepper, Tracker
from trackweave.solvers.auto import Auto
from trackweave.trackers.checkpoint import pack, unpack
from trackweave.trackers.clock_guard import farthest

__all__ = ["Change", "Engine"]

_CLASSES = (
    Counts, Names, Cutter, SensorCut, HeldPlaces, HeldLook, Block, RowsDue, Facts, Place, Region,
    RegionsTracker, SharedTracks,
)  # fmt: skip
"""Whose objects a snapshot holds, beside those of the tracker."""
_STEPPER = (
    "tracker", "rng", "rows", "names", "open", "due", "is_wanted", "time", "gap", "told",
    "n_sequences",
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """What a record has changed.

    Parameters
    ----------
    sequence
        The record's.
    rows
        Rows of the tracks file that became due, in order.
    scans
        The scans that were taken in.
    strange
        Reports of unknown sensors in it, by sensor.
    unfit
        Reports that measure otherwise than is known of their sensor, by sensor.
    """

    sequence: int
    rows: tuple[TrackTable, ...] = ()
    scans: tuple[Scan, ...] = ()
    strange: Mapping[str, int] = field(default_factory=dict)
    unfit: Mapping[str, int] = field(default_factory=dict)


@dataclass(slots=True)
class _Running:
    """What there is once it is known with what to run."""

    spec: Spec
    settings: Settings
    cutter: Cutter
    stepper: Stepper
    sensors: Mapping[str, Sensor]
    reach: float
    """How far times may go on from report to report [s]."""


class Engine:
    """Takes records in the order of their sequences and holds the tracks that follow.

    Two engines that took the same records are equal in all they say, whatever lay between.

    Parameters
    ----------
    house
        Where regions are, if records say that there are some; left out, in this process.
    """

    def __init__(self, house: House | None = None) -> None:
        self.house = house or Here()
        self.sequence = 0
        self.counts = Counts()
        self.facts = Facts()
        self.configured_by = 0
        """The record with what it runs, 0 before the first."""
        self._number = 0
        self._heard: list[Arrived] = []
        self._running: _Running | None = None

    @property
    def spec(self) -> Spec | None:
        """With what it runs; None until it was told."""
        return None if self._running is None else self._running.spec

    @property
    def is_configured(self) -> bool:
        """Whether it has been told with what to run."""
        return self._running is not None

    @property
    def heard(self) -> tuple[Arrived, ...]:
        """What waits until it is told with what to run."""
        return tuple(self._heard)

    @property
    def time(self) -> float | None:
        """Up to when scans were taken in [s]; None before the first."""
        return None if self._running is None else self._running.stepper.time

    @property
    def gap(self) -> float | None:
        """The gap of the last answer to its bound; None before the first."""
        return None if self._running is None else self._running.stepper.gap

    @property
    def sensors(self) -> Mapping[str, Sensor]:
        """The sensors that it knows."""
        return {} if self._running is None else self._running.sensors

    def told(self) -> dict[str, float]:
        """Return the latest time that each sensor has told and that was believed [s]."""
        if self._running is None:
            return {}
        known = self._running.cutter.sensors
        return {name: cut.told for name, cut in known.items() if np.isfinite(cut.told)}

    def tracks(self) -> TrackTable:
        """Return the live tracks, tentative ones too."""
        if self._running is None:
            return TrackTable.empty(2)
        return self._running.stepper.tracker.tracks()

    def track_of(self) -> dict[int, int]:
        """Return the track of each report that later ones may still amend, by its number."""
        if self._running is None:
            return {}
        known = self._running.stepper.tracker.pending()
        return dict(zip(known.report.tolist(), known.track.tolist(), strict=True))

    def identities_of(self, tracks: IntArray) -> list[str | None] | None:
        """Return whom the reports of tracks say that they are of; None where none says so."""
        if self._running is None or not self._running.stepper.names.codes:
            return None
        return self._running.stepper.names.told(tracks, self.track_of())

    def heights_of(self, tracks: IntArray) -> list[float | None] | None:
        """Return how high reports last said that tracks are [m]; None where none says so."""
        if self._running is None:
            return None
        return self._running.stepper.names.heights(tracks, self.track_of())

    def take(self, sequence: int, kind: int, payload: bytes) -> Change:
        """Take the next record in.

        Parameters
        ----------
        sequence
            Its number, greater than that of the one before.
        kind
            One of ``Kind``; others change nothing.
        payload
            Its content.

        Returns
        -------
        What it has changed.
        """
        self.sequence = sequence
        self.house.look()
        ways: dict[int, Callable[[bytes], Change]] = {
            Kind.REPORTS: self._reports,
            Kind.CONFIGURE: self._configure,
            Kind.CLOSE: self._close,
            Kind.BOUND: self._bound,
            Kind.DROP: self._drop,
        }
        way = ways.get(kind)
        return Change(sequence) if way is None else way(payload)

    def finish(self) -> Change:
        """Return what the end of everything brings, as that of a recording does."""
        running = self._running
        if running is None:
            return Change(self.sequence)
        scans = list(running.stepper.given(running.cutter.rest()))
        running.stepper.finish()
        return self._changed(running, scans)

    def pack(self) -> bytes:
        """Return all that it knows, from which another goes on as if it were this one."""
        running = self._running
        state: dict[str, Any] = {
            "sequence": self.sequence,
            "counts": self.counts,
            "facts": self.facts,
            "number": self._number,
            "configured_by": self.configured_by,
            "heard": [packed_reports(h.table, h.source, h.facts) for h in self._heard],
            "spec": None,
        }
        if running is not None:
            state |= {"spec": running.spec.payload(), "cutter": running.cutter}
            state["stepper"] = {name: getattr(running.stepper, name) for name in _STEPPER}
        return pack(state, _CLASSES)

    @classmethod
    def unpack(cls, content: bytes, house: House | None = None) -> "Engine":
        """Return the engine that `pack` was asked of.

        Parameters
        ----------
        content
            What `pack` gave.
        house
            Where regions are from now on, wherever they were.

        Returns
        -------
        The engine.

        Raises
        ------
        DataFormatError
            If it is foreign, damaged or of another layout.
        """
        state, engine = unpack(content, _CLASSES), cls(house)
        engine.sequence, engine.counts = state["sequence"], state["counts"]
        engine.facts, engine._number = state["facts"], state["number"]
        engine.configured_by = state["configured_by"]
        engine._heard = [arrived(payload) for payload in state["heard"]]
        if state["spec"] is not None:
            spec = Spec.of(state["spec"])
            settings = _settings_of(spec)
            stepper = Stepper(settings, engine.counts, **state["stepper"])
            if isinstance(stepper.tracker, RegionsTracker):
                engine.house.prepare(spec)
                stepper.tracker.rise(engine.house)
            engine._running = _running(spec, settings, state["cutter"], stepper)
        return engine

    def _reports(self, payload: bytes) -> Change:
        came = arrived(payload)
        self.counts.reports += came.table.height
        self.facts.places |= came.facts.places
        self.facts.scan_periods |= came.facts.scan_periods
        if self._running is None:
            self._heard.append(came)
            return Change(self.sequence)
        return self._tracked(self._running, came)

    def _tracked(self, running: _Running, came: Arrived) -> Change:
        found = sorted_in(came.table, running.spec, running.sensors)
        self.counts.refused += len(found.refused)
        self.counts.strange += sum(found.strange.values())
        self.counts.unfit += sum(found.unfit.values())
        scans = [] if found.reports is None else list(self._in_time(running, found.reports))
        return replace(self._changed(running, scans), strange=found.strange, unfit=found.unfit)

    def _in_time(self, running: _Running, reports: ReportTable) -> Iterator[Scan]:
        """Take reports in; those that jump ahead of all others go to the tracker's judgement."""
        numbers = np.arange(self._number, self._number + len(reports), dtype=np.int64)
        self._number += len(reports)
        cutter, begin, count = running.cutter, 0, len(reports)
        while begin < count:
            latest = cutter.latest
            before = latest if np.isfinite(latest) else reports.time[begin]
            times = np.maximum.accumulate(np.r_[before, reports.time[begin:]])
            jumps = np.flatnonzero(np.diff(times) > running.reach)
            end = begin + int(jumps[0]) if jumps.size else count
            if end > begin:
                cutter.feed(_blocks(running, reports, np.arange(begin, end), numbers))
                yield from running.stepper.given(cutter.ready(), cutter.now)
            else:
                same = (reports.time == reports.time[begin]) & (
                    reports.sensor == reports.sensor[begin]
                )
                # Reports are in order of time, then sensor: those of one scan are together.
                rows = np.flatnonzero(same[begin:]) + begin
                end = int(rows[-1]) + 1
                yield from _strayed(running, _blocks(running, reports, rows, numbers))
            begin = end

    def _configure(self, payload: bytes) -> Change:
        spec, before = Spec.of(payload), self._running
        self.configured_by = self.sequence
        settings, priors, names = _settings_of(spec), None, Names()
        cutter, rows = (
            Cutter.of(settings.sensors, spec.dim, is_on_earth=spec.frame is not None),
            tuple[TrackTable, ...](),
        )
        if before is not None:
            names = before.stepper.names
            cutter.follow(before.cutter, spec.unchanged(before.spec))
            before.stepper.finish()
            rows = before.stepper.rows.taken()
            is_same_plane = (spec.dim, spec.frame) == (before.spec.dim, before.spec.frame)
            known = before.stepper.tracker.tracks()
            known = known.at(np.flatnonzero(known.status != TENTATIVE))
            priors = known if len(known) and is_same_plane else None
        rng = generator_of(settings.values.get("seed") or 0)
        tracker: Tracker
        if spec.regions is not None:
            self.house.prepare(spec)
            tracker = RegionsTracker(spec, settings, priors, rng, self.house)
        else:
            tracker = tracker_of(
                settings, settings.sensors, spec.dim, priors=priors, max_ahead=settings.max_ahead
            )
        stepper = Stepper(
            settings, self.counts, tracker, rng, RowsDue(settings.period), names,
            time=None if before is None else before.stepper.time,
        )  # fmt: skip
        running = _running(spec, settings, cutter, stepper)
        self._running = running
        heard, self._heard = self._heard, []
        parts = [self._tracked(running, each) for each in heard]
        rows = (*rows, *(table for part in parts for table in part.rows))
        return Change(self.sequence, rows, tuple(s for part in parts for s in part.scans))

    def _close(self, payload: bytes) -> Change:
        running = self._running
        if running is None:
            return Change(self.sequence)
        cutter = running.cutter
        for name, until in from_json(payload)["until"].items():
            cutter.close(float(until), (name,) if name else ())
        return self._changed(running, list(running.stepper.given(cutter.ready(), cutter.now)))

    def _bound(self, payload: bytes) -> Change:
        said, running = from_json(payload), self._running
        if running is None or running.settings.tracker.kind != "multi-hypothesis":
            return Change(self.sequence)
        search, limits = running.settings.search or Auto(), running.settings.growth
        if said["nodes"] is not None:
            keep, new = said["keep"]
            limits = replace(
                limits,
                max_nodes=min(limits.max_nodes, int(said["nodes"])),
                keep=min(limits.keep, keep),
                new_keep=min(limits.new_keep, new),
            )
            search = Auto(evaluations=said["evaluations"], branches=said["branches"])
        running.stepper.tracker.bound(search, limits)
        return Change(self.sequence)

    def _drop(self, payload: bytes) -> Change:
        self.counts.dropped += int(from_json(payload)["reports"])
        return Change(self.sequence)

    def _changed(self, running: _Running, scans: list[Scan]) -> Change:
        return Change(self.sequence, running.stepper.rows.taken(), tuple(scans))


def _settings_of(spec: Spec) -> Settings:
    return replace(spec.settings(), together=spec.together)


def _running(spec: Spec, settings: Settings, cutter: Cutter, stepper: Stepper) -> _Running:
    reach = farthest(settings.max_ahead, [each.scan_period for each in settings.sensors])
    sensors = {sensor.name: sensor for sensor in settings.sensors}
    return _Running(spec, settings, cutter, stepper, sensors, reach)


def _strayed(running: _Running, blocks: Mapping[str, Block]) -> Iterator[Scan]:
    """Give the tracker a scan whose time jumps ahead, and follow it where it is believed."""
    stepper, (block,) = running.stepper, blocks.values()
    yield from stepper.given(running.cutter.rest())
    lone = Cutter.of(
        running.settings.sensors, running.spec.dim, is_on_earth=running.spec.frame is not None
    )
    lone.feed(blocks)
    yield from stepper.given(lone.rest())
    if stepper.time is not None and stepper.time >= float(block.time[0]):
        running.cutter.jumped(stepper.time)


def _blocks(
    running: _Running, reports: ReportTable, rows: IntArray, numbers: IntArray
) -> dict[str, Block]:
    """Return some of a table's reports by sensor."""
    part = reports if len(rows) == len(reports) else reports.part(rows)
    found = blocks_of(part, numbers[rows], running.stepper.names.codes)
    return {name: block for name, block in found.items() if len(block.time)}
