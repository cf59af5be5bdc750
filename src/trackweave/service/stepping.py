"""Scans in order of time go to the tracker, and what it says becomes rows and names."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trackweave.arrays import IntArray
from trackweave.config.fill import Settings
from trackweave.domain.scans import Scan
from trackweave.errors import InvalidInputError, NumericalError
from trackweave.run.course import EARLY, PARTS
from trackweave.service.regions import RegionsTracker
from trackweave.service.rows_due import RowsDue
from trackweave.trackers.hypothesis import Hypothesis
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker

__all__ = ["Counts", "Names", "Stepper", "Tracker"]

Tracker = MultiHypothesisTracker | NearestNeighbourTracker | RegionsTracker
MOST_REGROWN = 20_000
"""Beyond so many sequences a scan that comes too late to be the last is left out: to put it into
its place all would grow anew, for which one scan of 4,000 aircraft took 17 s and gigabytes."""
MOST_NAMED = 50_000
"""Of so many tracks, and of so many reports, it is remembered whose they are."""


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


@dataclass(slots=True)
class Names:
    """Whom reports say that they are of and how high, and so whose the tracks are, and where."""

    codes: dict[str, int] = field(default_factory=dict)
    of_report: dict[int, int] = field(default_factory=dict)
    of_track: dict[int, int] = field(default_factory=dict)
    height_of_report: dict[int, float] = field(default_factory=dict)
    height_of_track: dict[int, float] = field(default_factory=dict)

    def note(self, hypothesis: Hypothesis, scans: list[Scan]) -> None:
        """Take in what reports say, and of which tracks they finally are."""
        for scan in scans:
            if scan.identity is not None:
                pairs = zip(scan.report.tolist(), scan.identity.tolist(), strict=True)
                self.of_report |= {number: code for number, code in pairs if code >= 0}
            if scan.height is not None:
                heights = zip(scan.report.tolist(), scan.height.tolist(), strict=True)
                self.height_of_report |= {n: height for n, height in heights if height == height}
        _settle(self.of_report, self.of_track, hypothesis)
        _settle(self.height_of_report, self.height_of_track, hypothesis)

    def told(self, tracks: IntArray, assigned: dict[int, int]) -> list[str | None] | None:
        """Return whose tracks are, with what reports are of by now; None where nobody says."""
        if not self.codes:
            return None
        who = dict(self.of_track)
        for number, track in assigned.items():
            if number in self.of_report:
                who[track] = self.of_report[number]
        names = list(self.codes)
        return [names[who[track]] if track in who else None for track in tracks.tolist()]

    def heights(self, tracks: IntArray, assigned: dict[int, int]) -> list[float | None] | None:
        """Return how high reports say that tracks are [m], as last told; None where none does."""
        known = dict(self.height_of_track)
        for number, track in assigned.items():
            if number in self.height_of_report:
                known[track] = self.height_of_report[number]
        return [known.get(track) for track in tracks.tolist()] if known else None


def _settle(of_report: dict[int, Any], of_track: dict[int, Any], hypothesis: Hypothesis) -> None:
    """Give tracks what their reports told, once it is final which these are."""
    final = hypothesis.final if of_report else None
    if final is not None:
        for number, track in zip(final.report.tolist(), final.track.tolist(), strict=True):
            told = of_report.pop(number, None)
            if told is not None and track >= 0:
                of_track.pop(track, None)
                of_track[track] = told
    for known in (of_track, of_report):
        while len(known) > MOST_NAMED:
            del known[next(iter(known))]


@dataclass(slots=True)
class Stepper:
    """A tracker, the rows that became due, and lone reports that are searched together.

    ``settings`` and ``counts`` are the engine's.
    """

    settings: Settings
    counts: Counts
    tracker: Tracker
    rng: np.random.Generator
    rows: RowsDue
    names: Names
    open: list[Scan] = field(default_factory=list)
    """What is gathered for the next step."""
    due: float = -np.inf
    """When rows are due, for lone reports that are gathered."""
    is_wanted: bool = True
    """Whether the last step's rows are among those due."""
    time: float | None = None
    gap: float | None = None
    told: tuple[str, ...] = ()
    """Whose scans of that time it has been given."""
    n_sequences: int = 0

    def given(
        self, scans: Iterator[Scan], now: Callable[[], float] | None = None
    ) -> Iterator[Scan]:
        """Give the tracker scans in order, lone reports several at once; yield those given.

        Parameters
        ----------
        scans
            The scans.
        now
            Returns up to when all was told [s]; None at the end, when nothing is gathered on.

        Yields
        ------
        Those that the tracker was given.
        """
        for scan in scans:
            if self.open and not self._belongs(scan):
                yield from self._step()
            self.open.append(scan)
            if not self._gathers():
                yield from self._step()
        if self.open:
            together = EARLY * (self.settings.together or 0.0)
            if now is None or now() >= self.open[0].time + together:
                yield from self._step()

    def finish(self) -> None:
        """Make the last rows due, whenever they are."""
        if not self.is_wanted and self.time is not None:
            self.rows.add(self.tracker.tracks(), self.time)
        self.rows.finish()

    def _gathers(self) -> bool:
        """Tell whether lone reports are searched several at once; see ``run.course``."""
        settings = self.settings
        looks = any(sensor.scans is not False for sensor in settings.sensors)
        is_whole = settings.tracker.kind == "multi-hypothesis"
        return bool(settings.together) and not looks and is_whole

    def _belongs(self, scan: Scan) -> bool:
        """Tell whether a scan is searched together with those before it."""
        first, last = self.open[0].time, self.open[-1].time
        if last >= self.due:
            self.due = last + (self.settings.period or 0.0)
            return False
        together = EARLY * (self.settings.together or 0.0)
        most = max(1, self.settings.window.depth // PARTS)
        return last < scan.time < first + together and len(self.open) < most

    def _step(self) -> Iterator[Scan]:
        """Take in what was gathered."""
        scans, self.open = self.open, []
        if self._is_too_late(scans[0]):
            self.counts.late += len(scans[0])
            scans = scans[1:]
        if not scans:
            return
        wanted = self.rows.wants(scans[-1].time)
        given: Any = scans[0] if len(scans) == 1 else tuple(scans)
        try:
            hypothesis = self.tracker.step(given, rng=self.rng, tracks=wanted)
        except (InvalidInputError, NumericalError):
            # As one of another number of dimensions than all others; the step was undone.
            self.counts.unfit += sum(map(len, scans))
            return
        self._note(hypothesis, scans)
        self.is_wanted = wanted
        if wanted:
            self.rows.add(hypothesis.tracks, hypothesis.time)
        yield from scans

    def _is_too_late(self, scan: Scan) -> bool:
        """Tell whether too much would have to be done again for a scan, or the rest of one."""
        if self.time is None or self.n_sequences <= MOST_REGROWN:
            return False
        return scan.time < self.time or (scan.time == self.time and scan.sensor in self.told)

    def _note(self, hypothesis: Hypothesis, scans: list[Scan]) -> None:
        counts = self.counts
        counts.scans += len(scans)
        counts.empty_scans += sum(len(scan) == 0 for scan in scans)
        counts.late += len(hypothesis.late)
        counts.set_aside += sum(len(scan.report) for scan in hypothesis.set_aside)
        counts.held = sum(len(scan.report) for scan in hypothesis.held)
        self.gap = hypothesis.certificate.gap
        before, self.n_sequences = self.time, hypothesis.n_sequences
        self.time = hypothesis.time if np.isfinite(hypothesis.time) else self.time
        if before is not None and self.time is not None and self.time < before:
            self.rows.begin_anew()
        known = self.told if self.time == before else ()
        self.told = (*known, *(scan.sensor for scan in scans if scan.time == self.time))
        self.names.note(hypothesis, scans)
