"""A tracker of plots that several sensors make at one instant."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import ClassVar, Protocol

import numpy as np

from trackweave.arrays import IntArray, require_instance
from trackweave.association.problem import Certificate, Status
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.errors import InvalidInputError
from trackweave.randomness import RandomSource
from trackweave.solvers.protocol import Stop
from trackweave.summaries import summary
from trackweave.trackers._arguments import numbered, require_haste
from trackweave.trackers.clock_guard import MAX_AHEAD, Arrival, ClockGuard
from trackweave.trackers.hypothesis import Amendment, Assignments, Hypothesis, unchanged
from trackweave.trackers.live import LATE, Haste, LiveTracker, ScanByScan
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.plot_fusion import FusedPlots, PlotFuser
from trackweave.trackers.used_numbers import UsedNumbers

__all__ = ["FusedHypothesis", "FusedPlotsTracker", "ScanTracker"]

MOST_REMEMBERED = 5_000
"""Tracks whose plots are counted, unless they are live."""


class ScanTracker(Protocol):
    """Turns scans into tracks: ``MultiHypothesisTracker`` or another."""

    @property
    def doubts(self) -> dict[int, bool]:
        """Whether live tracks may as well be false alarms that came again."""
        ...

    def step(
        self,
        scan: Scan,
        *,
        rng: RandomSource = 0,
        deadline: float | None = None,
        stop: Stop | None = None,
        tracks: bool = True,
    ) -> Hypothesis:
        """Take in a scan and return the hypothesis after it."""
        ...

    def pending(self) -> Assignments:
        """Return the assignments that later scans may amend."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class FusedHypothesis(Hypothesis):
    """A hypothesis in terms of the plots, and what these were fused to.

    Parameters
    ----------
    n_tuples
        How many tuples of plots there were to choose from.
    n_fused
        How many fused reports the tracker got.
    is_complete
        Whether the tuples were all that lie in the gate; otherwise nothing is proven.
    """

    n_tuples: int = 0
    n_fused: int = 0
    is_complete: bool = True

    __repr__ = summary


class FusedPlotsTracker(LiveTracker):
    """Tracks objects by the reports that are fused of the plots of an instant.

    What belongs together at one instant is decided at once, plots against plots; what belongs
    together over time, by the tracker inside, which gets one scan of fused reports per instant.
    Everything that it says of a fused report is said of each plot that the report holds; a plot in
    none is a false alarm, finally.

    The certificate is that of the choice of tuples; with a ``MultiHypothesisTracker`` inside,
    whose window is chosen too, costs and bounds are the sums of both. Where tuples had to be left
    out, nothing is proven.

    Parameters
    ----------
    fuser
        Makes reports of plots.
    tracker
        Tracks the fused reports. Its sensors are ``fuser.fused_sensors(…)``.
    max_ahead
        An instant further ahead of all others than this is held back [s], as a scan is in
        `MultiHypothesisTracker`; what the tracker inside was told of it does not count.

    Raises
    ------
    InvalidInputError
        If the fuser is none, or the tracker has no ``step``.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> sensors = [tw.Sensor(name, sigma=5.0, scan_period=1.0) for name in ("A", "B")]
    >>> fuser = tw.PlotFuser(sensors, tw.PlotsRule(object_density=1e-6, lone_plots=True))
    >>> inside = tw.MultiHypothesisTracker(
    ...     motion=tw.ConstantVelocity(0.1, 30.0), sensors=fuser.fused_sensors(scan_period=1.0)
    ... )
    >>> tracker = tw.FusedPlotsTracker(fuser, inside)
    >>> scans = [tw.Scan(time=0.0, sensor=name, measurement=[[7.0, 3.0]]) for name in ("A", "B")]
    >>> hypothesis = tracker.step(scans, rng=np.random.default_rng(1))
    >>> hypothesis.n_tuples, hypothesis.n_fused
    (1, 1)
    """

    CHANGING: ClassVar = ("_members", "_more", "_used")
    SETTINGS: ClassVar = ("_fuser",)

    def __init__(
        self, fuser: PlotFuser, tracker: ScanTracker, *, max_ahead: float | None = MAX_AHEAD
    ) -> None:
        require_instance(fuser, PlotFuser, "fuser")
        if isinstance(tracker, type) or not callable(getattr(tracker, "step", None)):
            raise InvalidInputError(f"tracker: {tracker!r:.80}; expected a tracker of scans")
        self._fuser = fuser
        self._tracker = tracker
        # Instants are judged before they are fused, so that nothing is judged twice.
        self._guard = ClockGuard.of(max_ahead, fuser.sensors)
        self._used = UsedNumbers()
        self._last: FusedHypothesis | None = None
        self._tracks: TrackTable | None = None
        self._next_fused = 0
        self._members: dict[int, IntArray] = {}
        """The plots of each fused report that is not final yet."""
        self._more: dict[int, int] = {}
        """By how much each track's plots outnumber its fused reports, of the final ones."""

    def pending(self) -> Assignments:
        """Return the assignments of the plots that later instants may amend."""
        return self._spread(self._tracker.pending())

    def step(
        self,
        scans: Sequence[Scan],
        *,
        rng: RandomSource = 0,
        deadline: float | None = None,
        stop: Stop | None = None,
    ) -> FusedHypothesis:
        """Take in the scans of an instant and return the hypothesis after it.

        Parameters
        ----------
        scans
            One scan of each sensor that looked, empty where it saw nothing.
        rng
            The only source of randomness: a generator, or a seed, which draws the same numbers at
            each step.
        deadline
            Seconds of wall clock for both steps together, above 0; None for none.
        stop
            Asked every few milliseconds whether to end both searches; None for nothing to ask.

        Returns
        -------
        The hypothesis; an instant that came too late for the tracker inside, or that is held
        back, changes nothing.

        Raises
        ------
        InvalidInputError
            If an argument is of another kind than it has to be, scans are not of different known
            sensors, or the tracker refuses what came of them. After this or any other error all
            is as it was before the step; a tracker inside that is not of this library is what its
            own ``step`` leaves behind.
        """
        rng = require_haste(rng, deadline, stop)
        hypothesis = self._step(scans, Haste(rng, deadline, stop))
        assert isinstance(hypothesis, FusedHypothesis)
        return hypothesis

    def parts(self) -> tuple[LiveTracker, ...]:
        """Return this tracker and the one inside; see `LiveTracker`."""
        inside = self._tracker
        return (self, inside) if isinstance(inside, ScanByScan) else (self,)

    def checked(self, scans: Sequence[Scan]) -> Arrival:
        """Return an instant's scans in order, with numbers for their reports."""
        looked = self._fuser.checked(scans)
        report = numbered(np.concatenate([scan.report for scan in looked]), self._used)
        ends = np.cumsum([len(scan) for scan in looked])[:-1]
        return Arrival(
            tuple(
                replace(scan, report=own)
                for scan, own in zip(looked, np.split(report, ends), strict=True)
            )
        )

    def is_late(self, arrival: Arrival) -> bool:
        """Tell whether the tracker inside has no use for an instant; see `LiveTracker`."""
        inside = self._tracker
        return isinstance(inside, ScanByScan) and inside.is_late(arrival)

    def is_before_all(self, arrival: Arrival) -> bool:
        """Tell whether an instant lies before the tracks known beforehand; see `LiveTracker`."""
        inside = self._tracker
        return isinstance(inside, ScanByScan) and inside.is_before_all(arrival)

    def begin_anew(self, *, keeps_priors: bool) -> Assignments | None:
        """Forget all but which names and numbers were used; see `LiveTracker`."""
        if not isinstance(self._tracker, ScanByScan):
            return None
        final = self.pending()
        self._tracker.begin_anew(keeps_priors=keeps_priors)
        self._members, self._more, self._tracks = {}, {}, None
        return final

    def unchanged(self, arrival: Arrival, reason: str, *, tracks: bool) -> Hypothesis:
        """Return the last hypothesis again; see `LiveTracker`."""
        return unchanged(self._last, arrival.time, self._fuser.dim or 2, reason)

    def take(self, arrival: Arrival, haste: Haste) -> Hypothesis:
        """Take in an instant's checked scans whenever they are of; see `LiveTracker`."""
        end = None if haste.deadline is None else perf_counter() + haste.deadline
        fused = self._fuser(
            arrival.scans,
            rng=haste.rng,
            stop=_either(end, haste.stop),
            tracks=self._tracks,
            first_report=self._next_fused,
        )
        left = None if end is None else max(1e-6, end - perf_counter())
        found = self._followed(fused.scan, replace(haste, deadline=left))
        self._next_fused += len(fused)
        if found.stop_reason == LATE:
            every = np.concatenate([scan.report for scan in arrival.scans])
            return self._late(found, fused, every)
        self._members |= dict(zip(fused.scan.report.tolist(), fused.members, strict=True))
        self._last = self._told(found, fused)
        return self._last

    def _followed(self, scan: Scan, haste: Haste) -> Hypothesis:
        """Let the tracker inside take a step."""
        inside = self._tracker
        if isinstance(inside, ScanByScan):
            return inside.take(inside.checked((scan,)), haste)
        return inside.step(scan, rng=haste.rng, deadline=haste.deadline, stop=haste.stop)

    def _told(self, found: Hypothesis, fused: FusedPlots) -> FusedHypothesis:
        """Return what the tracker found, told of the plots."""
        amendments = tuple(
            Amendment(report, amendment.before, amendment.after)
            for amendment in found.amendments
            for report in self._members[amendment.report].tolist()
        )
        final = self._spread(found.final)
        self._count(found.final)
        for number in found.final.report.tolist():
            del self._members[number]
        self._tracks = found.tracks
        nobody = np.full(fused.alone.shape[0], -1, dtype=np.int64)
        final = Assignments(
            report=np.concatenate([final.report, fused.alone]),
            track=np.concatenate([final.track, nobody]),
            probability=np.concatenate([final.probability, np.full(nobody.shape[0], np.nan)]),
        )
        return _fused_hypothesis(
            found,
            fused,
            tracks=self._with_hits(found.tracks),
            amendments=amendments,
            final=final,
            certificate=self._certificate(found.certificate, fused.certificate),
            stop_reason=self._reason(found, fused),
            deadline_gap=self._deadline_gap(found, fused),
        )

    def _late(self, found: Hypothesis, fused: FusedPlots, every: IntArray) -> FusedHypothesis:
        """Return that an instant came too late."""
        return _fused_hypothesis(
            found, fused, tracks=self._with_hits(found.tracks), late=tuple(every.tolist())
        )

    def _spread(self, known: Assignments) -> Assignments:
        """Return what is said of fused reports, said of their plots."""
        members = [self._members[number] for number in known.report.tolist()]
        sizes = [each.shape[0] for each in members]
        return Assignments(
            report=np.concatenate([np.empty(0, dtype=np.int64), *members]),
            track=np.repeat(known.track, sizes),
            probability=np.repeat(known.probability, sizes),
        )

    def _count(self, final: Assignments) -> None:
        """Enter by how much the plots outnumber the fused reports that became final."""
        for number, track in zip(final.report.tolist(), final.track.tolist(), strict=True):
            if track >= 0:
                more = self._members[number].shape[0] - 1
                self._more[track] = self._more.get(track, 0) + more

    def _with_hits(self, tracks: TrackTable) -> TrackTable:
        """Return tracks whose hits count plots."""
        more = {track: self._more.get(track, 0) for track in tracks.track.tolist()}
        if len(self._more) > MOST_REMEMBERED:
            self._more = more.copy()
        pending = self._tracker.pending()
        for number, track in zip(pending.report.tolist(), pending.track.tolist(), strict=True):
            if track in more:
                more[track] += self._members[number].shape[0] - 1
        added = np.array([more[track] for track in tracks.track.tolist()], dtype=np.int64)
        return replace(tracks, hits=tracks.hits + added)

    def _certificate(self, tracked: Certificate, fused: Certificate) -> Certificate:
        if not isinstance(self._tracker, MultiHypothesisTracker):
            return fused
        is_proven = fused.status is Status.OPTIMAL and tracked.status in {
            Status.OPTIMAL, Status.OPTIMAL_AMONG_KEPT
        }  # fmt: skip
        return Certificate(
            fused.cost + tracked.cost,
            fused.lower_bound + tracked.lower_bound,
            tracked.status if is_proven else Status.FEASIBLE,
        )

    def _deadline_gap(self, found: Hypothesis, fused: FusedPlots) -> float | None:
        """Return the gap that either search left open because it had to stop."""
        gaps = [found.certificate.gap] if found.stop_reason == "stopped" else []
        if fused.stop_reason == "stopped":
            gaps.append(fused.certificate.gap)
        return None if found.deadline_gap is None else max(gaps, default=0.0)

    def _reason(self, found: Hypothesis, fused: FusedPlots) -> str:
        if (
            not isinstance(self._tracker, MultiHypothesisTracker)
            or found.stop_reason == fused.stop_reason
        ):
            return fused.stop_reason
        return f"{fused.stop_reason}; {found.stop_reason}"


def _either(end: float | None, stop: Stop | None) -> Stop | None:
    """Return what tells to stop at a time by the clock, or when another does."""
    if end is None:
        return stop
    return lambda: perf_counter() >= end or (stop is not None and stop())


def _fused_hypothesis(found: Hypothesis, fused: FusedPlots, **changed: object) -> FusedHypothesis:
    """Return a hypothesis of the tracker inside with what is told otherwise."""
    values = {name: getattr(found, name) for name in Hypothesis.__dataclass_fields__}
    values["evaluations"] = found.evaluations + fused.evaluations
    counts = {"n_tuples": fused.n_tuples, "n_fused": len(fused), "is_complete": fused.is_complete}
    return FusedHypothesis(**{**values, **changed, **counts})
