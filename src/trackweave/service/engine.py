"""The tracks as a pure function of the journal's records: no clock, no thread, no order but theirs."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from trackweave.arrays import IntArray
from trackweave.association.growth_limits import GrowthLimits
from trackweave.config.fill import Settings
from trackweave.domain.facts import Facts, Place
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TENTATIVE, TrackTable
from trackweave.errors import InvalidInputError
from trackweave.models.sensors import Sensor
from trackweave.run.course import EARLY, PARTS, tracker_of
from trackweave.service.blocks import Block, blocks_of
from trackweave.service.cutting import Cutter, SensorCut
from trackweave.service.records import Arrived, Kind, arrived, from_json, packed_reports
from trackweave.service.rows_due import RowsDue
from trackweave.service.sorting_in import SortedIn, sorted_in
from trackweave.service.spec import Spec
from trackweave.solvers.auto import Auto
from trackweave.trackers.checkpoint import pack, unpack
from trackweave.trackers.clock_guard import farthest

if TYPE_CHECKING:
    from trackweave.trackers.hypothesis import Hypothesis
    from trackweave.trackers.live import ScanByScan

__all__ = ["Change", "Counts", "Engine"]



@dataclass(slots=True)
class Counts:
    """What became of the reports so far."""

    reports: int = 0
    """Rows in the journal."""
    refused: int = 0
    """Rows that are no reports."""
    strange: int = 0
    """Reports of sensors that the configuration does not know."""
    unfit: int = 0
    """Reports that measure otherwise than the configuration says."""
    late: int = 0
    """Reports that came too late for the window."""
    set_aside: int = 0
    """Reports of scans whose times cannot be."""
    held: int = 0
    """Reports of scans that are held back now because of their times."""
    dropped: int = 0
    """Reports that were not taken, because more came than can be."""
    scans: int = 0
    empty_scans: int = 0


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
    gap
        The gap of the last answer to its bound; None where there was none.
    strange
        Reports of unknown sensors in it, by sensor.
    """

    sequence: int
    rows: tuple[TrackTable, ...] = ()
    scans: tuple[Scan, ...] = ()
    gap: float | None = None
    strange: Mapping[str, int] = field(default_factory=dict)


_CLASSES = (Counts, Cutter, SensorCut, Block, RowsDue, Facts, Place)
# What a snapshot holds, beside what follows from the configuration.
_ALWAYS = (
    "sequence", "counts", "facts", "gap", "_identities", "_named", "_who", "_open",
    "_is_wanted",
)  # fmt: skip
_CONFIGURED = ("_number", "_time", "_tracker", "_rng", "_cutter", "_rows", "_due")


MOST_NAMED = 50_000
"""Of so many tracks it is remembered whose they are."""


class Engine:
    """Takes records in the order of their sequences and holds the tracks that follow.

    Two engines that took the same records are equal in all they say, whatever lay between.
    """

    def __init__(self) -> None:
        self.sequence = 0
        self.counts = Counts()
        self.spec: Spec | None = None
        self.facts = Facts()
        self.gap: float | None = None
        self._heard: list[Arrived] = []
        self._identities: dict[str, int] = {}
        self._named: dict[int, int] = {}
        self._who: dict[int, int] = {}
        self._open: list[Scan] = []
        self._is_wanted = True

    @property
    def is_configured(self) -> bool:
        """Whether it has been told with what to run."""
        return self.spec is not None

    @property
    def heard(self) -> tuple[Arrived, ...]:
        """What waits until it is told with what to run."""
        return tuple(self._heard)

    @property
    def latest(self) -> float:
        """The latest time that sensors have told [s], -inf before the first report."""
        return self._cutter.latest if self.is_configured else -np.inf

    @property
    def time(self) -> float | None:
        """Up to when scans were taken in [s]; None before the first."""
        return self._time if self.is_configured else None

    @property
    def settings(self) -> Settings:
        """With what it runs."""
        return self._settings

    @property
    def sensors(self) -> Mapping[str, Sensor]:
        """The sensors that it knows."""
        return self._sensors if self.is_configured else {}

    def tracks(self) -> TrackTable:
        """Return the live tracks, tentative ones too."""
        return self._tracker.tracks() if self.is_configured else TrackTable.empty(2)

    def track_of(self) -> dict[int, int]:
        """Return the track of each report that later ones may still amend, by its number."""
        if not self.is_configured:
            return {}
        known = self._tracker.pending()
        return dict(zip(known.report.tolist(), known.track.tolist(), strict=True))

    def identities_of(self, tracks: IntArray) -> list[str | None] | None:
        """Return whom the reports of tracks say that they are of; None where none says so."""
        if not self._identities:
            return None
        who = dict(self._who)
        for number, track in self.track_of().items():
            if number in self._named:
                who[track] = self._named[number]
        names = list(self._identities)
        return [names[who[track]] if track in who else None for track in tracks.tolist()]

    def sensors_heard(self) -> dict[str, float]:
        """Return up to when each sensor that was heard has told [s]."""
        if not self.is_configured:
            return {}
        cuts = self._cutter.sensors.values()
        return {cut.name: cut.told for cut in cuts if np.isfinite(cut.told)}

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
        if not self.is_configured:
            return Change(self.sequence)
        scans = list(self._stepped(self._cutter.rest(), at_end=True))
        if not self._is_wanted:
            self._rows.add(self._tracker.tracks(), cast("float", self._time))
        self._rows.finish()
        return self._changed(scans)

    def pack(self) -> bytes:
        """Return all that it knows, from which another goes on as if it were this one."""
        state: dict[str, Any] = {name: getattr(self, name) for name in _ALWAYS}
        state["heard"] = [packed_reports(h.table, h.source, h.facts) for h in self._heard]
        state["spec"] = None
        if self.spec is not None:
            state["spec"] = self.spec.payload()
            state |= {name: getattr(self, name) for name in _CONFIGURED}
        return pack(state, _CLASSES)

    @classmethod
    def unpack(cls, content: bytes) -> "Engine":
        """Return the engine that `pack` was asked of.

        Parameters
        ----------
        content
            What `pack` gave.

        Returns
        -------
        The engine.

        Raises
        ------
        DataFormatError
            If it is foreign, damaged or of another layout.
        """
        state, engine = unpack(content, _CLASSES), cls()
        engine._heard = [arrived(payload) for payload in state.pop("heard")]
        spec = state.pop("spec")
        for name, value in state.items():
            setattr(engine, name, value)
        if spec is not None:
            engine._run_with(Spec.of(spec))
        return engine

    def _reports(self, payload: bytes) -> Change:
        came = arrived(payload)
        self.counts.reports += came.table.height
        self.facts.places |= came.facts.places
        self.facts.scan_periods |= came.facts.scan_periods
        if self.spec is None:
            self._heard.append(came)
            return Change(self.sequence)
        return self._tracked(came)

    def _tracked(self, came: Arrived) -> Change:
        assert self.spec is not None
        found = sorted_in(came.table, self.spec, self._sensors)
        self._count(found)
        scans: list[Scan] = []
        if found.reports is not None:
            for part in self._in_time(found.reports):
                scans += part
        return self._changed(scans, found.strange)

    def _count(self, found: SortedIn) -> None:
        self.counts.refused += len(found.refused)
        self.counts.strange += sum((found.strange or {}).values())
        self.counts.unfit += found.unfit

    def _in_time(self, reports: ReportTable) -> Iterator[list[Scan]]:
        """Take reports in; those that jump ahead of all others go to the tracker's judgement."""
        numbers = np.arange(self._number, self._number + len(reports), dtype=np.int64)
        self._number += len(reports)
        begin, count = 0, len(reports)
        while begin < count:
            latest = self._cutter.latest
            before = latest if np.isfinite(latest) else reports.time[begin]
            times = np.maximum.accumulate(np.r_[before, reports.time[begin:]])
            jumps = np.flatnonzero(np.diff(times) > self._reach)
            end = begin + int(jumps[0]) if jumps.size else count
            if end > begin:
                rows = np.arange(begin, end)
                self._cutter.feed(self._blocks(reports, rows, numbers))
                yield list(self._stepped(self._cutter.ready()))
                begin = end
            else:
                same = (reports.time == reports.time[begin]) & (
                    reports.sensor == reports.sensor[begin]
                )
                rows = np.flatnonzero(same[begin:]) + begin
                # Reports are in order of time, then sensor: those of one scan are together.
                begin = int(rows[-1]) + 1
                yield list(self._strayed(reports, rows, numbers))

    def _strayed(
        self, reports: ReportTable, rows: np.ndarray, numbers: np.ndarray
    ) -> Iterator[Scan]:
        """Give the tracker a scan whose time jumps ahead, and follow it where it is believed."""
        yield from self._stepped(self._cutter.rest(), at_end=True)
        lone = Cutter.of(self._settings.sensors, cast("Spec", self.spec).dim)
        lone.feed(self._blocks(reports, rows, numbers))
        time = float(reports.time[rows[0]])
        yield from self._stepped(lone.rest(), at_end=True)
        if self._time is not None and self._time >= time:
            self._cutter.jumped(self._time)

    def _blocks(
        self, reports: ReportTable, rows: np.ndarray, numbers: np.ndarray
    ) -> dict[str, Block]:
        part = reports if len(rows) == len(reports) else reports.part(rows)
        found = blocks_of(part, numbers[rows], self._identities)
        return {name: block for name, block in found.items() if len(block.time)}

    def _configure(self, payload: bytes) -> Change:
        before, spec = self.spec, Spec.of(payload)
        priors = None
        if before is not None:
            known = self._tracker.tracks()
            priors = known.at(np.flatnonzero(known.status != TENTATIVE))
            if not len(priors) or spec.dim != before.dim or spec.frame != before.frame:
                priors = None
        else:
            self._number, self._time = 0, None
        settings = self._run_with(spec)
        self._tracker = cast(
            "ScanByScan",
            tracker_of(
                settings, settings.sensors, spec.dim, priors=priors, max_ahead=settings.max_ahead
            ),
        )
        seed = settings.values.get("seed")
        self._rng = np.random.default_rng(0 if seed is None else seed)
        self._cutter = Cutter.of(settings.sensors, spec.dim)
        self._rows, self._due, self._open = RowsDue(settings.period), -np.inf, []
        heard, self._heard = self._heard, []
        parts = [self._tracked(each) for each in heard]
        rows = tuple(table for part in parts for table in part.rows)
        return Change(self.sequence, rows, tuple(s for part in parts for s in part.scans), self.gap)

    def _run_with(self, spec: Spec) -> Settings:
        settings = replace(spec.settings(), together=spec.together)
        self.spec, self._settings = spec, settings
        self._sensors = {sensor.name: sensor for sensor in settings.sensors}
        self._reach = farthest(settings.max_ahead, [s.scan_period for s in settings.sensors])
        return settings

    def _close(self, payload: bytes) -> Change:
        if self.spec is None:
            return Change(self.sequence)
        said = from_json(payload)
        for name, until in said["until"].items():
            self._cutter.close(float(until), (name,) if name else ())
        return self._changed(list(self._stepped(self._cutter.ready())))

    def _bound(self, payload: bytes) -> Change:
        said = from_json(payload)
        if self.spec is None or self._settings.tracker.kind != "multi-hypothesis":
            return Change(self.sequence)
        search, limits = self._settings.search or Auto(), self._settings.growth
        if said["nodes"] is not None:
            limits = replace(limits, max_nodes=min(limits.max_nodes, int(said["nodes"])))
            keep, new = said["keep"]
            limits = replace(
                limits, keep=min(limits.keep, keep), new_keep=min(limits.new_keep, new)
            )
            search = Auto(evaluations=said["evaluations"], branches=said["branches"])
        self._tracker.bound(search, limits)
        return Change(self.sequence)

    def _drop(self, payload: bytes) -> Change:
        self.counts.dropped += int(from_json(payload)["reports"])
        return Change(self.sequence)

    def _stepped(self, scans: Iterator[Scan], *, at_end: bool = False) -> Iterator[Scan]:
        """Give the tracker scans in order, lone reports several at once; yield those given."""
        for scan in scans:
            if self._open and not self._belongs(scan):
                yield from self._step()
            self._open.append(scan)
            if not self._gathers():
                yield from self._step()
        if self._open and (at_end or not self._waits()):
            yield from self._step()

    def _gathers(self) -> bool:
        """Tell whether lone reports are searched several at once; see ``run.course``."""
        settings = self._settings
        looks = any(sensor.scans is not False for sensor in settings.sensors)
        return bool(settings.together) and not looks and isinstance(settings.growth, GrowthLimits)

    def _belongs(self, scan: Scan) -> bool:
        """Tell whether a scan is searched together with those before it."""
        first, last = self._open[0].time, self._open[-1].time
        if last >= self._due:
            self._due = last + (self._settings.period or 0.0)
            return False
        together = EARLY * (self._settings.together or 0.0)
        most = max(1, self._settings.window.depth // PARTS)
        return last < scan.time < first + together and len(self._open) < most

    def _waits(self) -> bool:
        """Tell whether another scan may still belong to those that are gathered."""
        together = EARLY * (self._settings.together or 0.0)
        until = max((cut.until for cut in self._cutter.sensors.values()), default=-np.inf)
        return max(self._cutter.latest, until) < self._open[0].time + together

    def _step(self) -> Iterator[Scan]:
        """Take in what was gathered."""
        scans, self._open = self._open, []
        end = scans[-1].time
        wanted = self._rows.wants(end)
        given: Any = scans[0] if len(scans) == 1 else tuple(scans)
        try:
            hypothesis = self._tracker.step(given, rng=self._rng, tracks=wanted)
        except InvalidInputError:
            # As one of another number of dimensions than all others; the step was undone.
            self.counts.unfit += sum(map(len, scans))
            return
        self._note(hypothesis, scans)
        self._name(hypothesis, scans)
        self._is_wanted = wanted
        if wanted:
            self._rows.add(hypothesis.tracks, hypothesis.time)
        yield from scans

    def _note(self, hypothesis: "Hypothesis", scans: list[Scan]) -> None:
        counts = self.counts
        counts.scans += len(scans)
        counts.empty_scans += sum(len(scan) == 0 for scan in scans)
        counts.late += len(hypothesis.late)
        counts.set_aside += sum(len(scan.report) for scan in hypothesis.set_aside)
        counts.held = sum(len(scan.report) for scan in hypothesis.held)
        self.gap = hypothesis.certificate.gap
        self._time = hypothesis.time if np.isfinite(hypothesis.time) else self._time

    def _name(self, hypothesis: "Hypothesis", scans: list[Scan]) -> None:
        """Take in whom reports say that they are of, and of which tracks they finally are."""
        for scan in scans:
            if scan.identity is not None:
                pairs = zip(scan.report.tolist(), scan.identity.tolist(), strict=True)
                self._named |= {number: code for number, code in pairs if code >= 0}
        if not self._named:
            return
        final = hypothesis.final
        for number, track in zip(final.report.tolist(), final.track.tolist(), strict=True):
            code = self._named.pop(number, None)
            if code is not None and track >= 0:
                self._who.pop(track, None)
                self._who[track] = code
        while len(self._who) > MOST_NAMED:
            del self._who[next(iter(self._who))]

    def _changed(self, scans: list[Scan], strange: Mapping[str, int] | None = None) -> Change:
        rows = self._rows.taken()
        return Change(self.sequence, rows, tuple(scans), self.gap, strange or {})
