"""What live trackers share: stray stamps held back, steps whole or not at all, copies apart."""

import copy
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.inactive import InactiveClusters
from trackweave.association.tree import AssociationTree
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.models.sensors import Sensor
from trackweave.solvers.protocol import Solver, Stop
from trackweave.trackers._arguments import checked_scan, with_dimensions, with_width
from trackweave.trackers.checkpoint import Saved
from trackweave.trackers.clock_guard import Arrival, ClockGuard
from trackweave.trackers.from_config import from_config
from trackweave.trackers.hypothesis import Assignments, Hypothesis, gathered, unchanged
from trackweave.trackers.scan_preparation import ScanPreparation
from trackweave.trackers.used_numbers import UsedNumbers

__all__ = ["HELD", "LATE", "UNDONE", "Haste", "LiveTracker", "ScanByScan"]

LATE, HELD = "late scan", "held back"
"""Why a step says that it took nothing in."""
UNDONE = "The step was undone: tracker and random generator are as they were before it."
"""What an error out of a step says besides."""


@dataclass(frozen=True, slots=True)
class Haste:
    """With what a step is taken: randomness, deadline [s], what may stop it, and what to tell."""

    rng: np.random.Generator
    deadline: float | None = None
    stop: Stop | None = None
    tracks: bool = True

    def share(self, count: int) -> "Haste":
        """Return the haste of one of so many scans that are taken in at once."""
        if self.deadline is None or count < 2:
            return self
        return replace(self, deadline=self.deadline / count)


class LiveTracker(Saved, ABC):
    """A tracker that takes in scans as they come.

    What a step changes is in the attributes ``CHANGING``; ``copy.copy`` of each of these gives
    one that is independent. The attributes ``SETTINGS`` never change.
    """

    CHANGING: ClassVar[tuple[str, ...]] = ()
    SETTINGS: ClassVar[tuple[str, ...]] = ()
    _guard: ClockGuard

    def __copy__(self) -> Self:
        known = [self.__dict__[name] for name in self.SETTINGS]
        return copy.deepcopy(self, {id(setting): setting for setting in known})

    @property
    def doubts(self) -> dict[int, bool]:
        """Whether live tracks may as well be false alarms that came again, by name.

        Those of which it was never so are left out; what was last said of a track stays so.
        """
        return {}

    @abstractmethod
    def pending(self) -> Assignments:
        """Return the assignments that later scans may amend."""

    @abstractmethod
    def checked(self, scans: Sequence[Scan]) -> Arrival:
        """Return what came in with numbers for its reports, once it is found sound."""

    @abstractmethod
    def is_late(self, arrival: Arrival) -> bool:
        """Tell whether a scan is too old to be of use."""

    @abstractmethod
    def is_before_all(self, arrival: Arrival) -> bool:
        """Tell whether a scan lies before the tracks known beforehand."""

    @abstractmethod
    def take(self, arrival: Arrival, haste: Haste) -> Hypothesis:
        """Take in a checked scan without asking whether its time can be, and say what follows."""

    @abstractmethod
    def unchanged(self, arrival: Arrival, reason: str, *, tracks: bool) -> Hypothesis:
        """Return the last hypothesis again."""

    @abstractmethod
    def begin_anew(self, *, keeps_priors: bool) -> Assignments | None:
        """Forget all but which names and numbers were used; return what is final by that.

        Returns None where it cannot be done.
        """

    def parts(self) -> tuple["LiveTracker", ...]:
        """Return the trackers that a step changes."""
        return (self,)

    def _step(self, scans: Sequence[Scan], haste: Haste) -> Hypothesis:
        """Take in what its time allows, whole or not at all."""
        with _whole_or_not_at_all(self.parts(), haste.rng):
            parts = self._guard.parted(self.checked(scans))
            own = haste.share(len(parts))
            return gathered([self._taken(each, own) for each in parts], None, _reports(parts))

    def _taken(self, arrival: Arrival, haste: Haste) -> Hypothesis:
        if self.is_before_all(arrival):
            late = self.take(arrival, haste)
            return replace(late, held=self._guard.told())
        verdict = self._guard.judge(arrival, is_late=self.is_late(arrival))
        self._guard = verdict.guard
        known_before = None
        if verdict.begins_anew:
            known_before = self.begin_anew(keeps_priors=verdict.keeps_priors)
        if verdict.now:
            own = haste.share(len(verdict.now))
            taken = [self.take(each, own) for each in verdict.now]
            hypothesis = gathered(taken, known_before, _reports(verdict.now))
        else:
            hypothesis = self.unchanged(arrival, HELD, tracks=haste.tracks)
        if not (verdict.guard.held or verdict.aside):
            return hypothesis
        aside = tuple(scan for each in verdict.aside for scan in each.told())
        return replace(hypothesis, held=verdict.guard.told(), set_aside=aside)

    def saved(self) -> dict[str, Any]:
        """Return all that a step may change, as it is now."""
        return {name: _kept(value) if name in self.CHANGING else value
                for name, value in self.__dict__.items()}  # fmt: skip

    def undo(self, saved: dict[str, Any]) -> None:
        """Be again as when that was saved."""
        for part in saved.values():
            if isinstance(part, InactiveClusters):
                part.undone()
        self.__dict__ = saved

    def settle(self, saved: dict[str, Any], tree: AssociationTree | None) -> None:
        """Take it that nobody goes back to what was saved, when the tree was this one."""
        old, is_same = saved.get("_tree"), tree is self.__dict__.get("_tree")
        if tree is not None and is_same and isinstance(old, AssociationTree):
            tree.settled(old)


class ScanByScan(LiveTracker):
    """A tracker of which each step takes one scan."""

    _sensors: Mapping[str, Sensor]
    _priors: TrackTable | None
    _dim: int | None
    _used: UsedNumbers
    _widths: Mapping[str, int]
    _last: Hypothesis | None
    _tree: AssociationTree | None
    _search: Solver
    _limits: GrowthLimits
    _preparation: ScanPreparation

    def pass_over(self, sensor: str, until: float) -> None:
        """Take it that a sensor's beam was elsewhere until a time, where nothing is tracked.

        As an empty scan that does not look where any object may be, but without a step.

        Parameters
        ----------
        sensor
            Its name.
        until
            When its next sweep begins at the earliest [s].
        """
        self._preparation.pass_over(sensor, until)

    @classmethod
    def from_config(cls, config: Any, reports: Any = None) -> Self:
        """Return the tracker that `track` would take with a configuration.

        Parameters
        ----------
        config
            A path of a TOML file, or its content as a mapping.
        reports
            A path or table of reports, as for `track`, from which keys left out are estimated.
            Without any they take their usual values, but that noise (``sigma`` of positions) and
            clutter have to be given, for sensors that the tables ``[sensors.NAME]`` name.

        Returns
        -------
        The tracker, before its first scan. ``search.deadline_ms`` is for whoever calls `step`.

        Raises
        ------
        InvalidInputError
            If a value cannot be used, a key is missing, or ``[tracker] kind`` or ``[plots]`` asks
            for another class.
        """
        return from_config(cls, config, reports)

    @abstractmethod
    def tracks(self) -> TrackTable:
        """Return the live tracks after the last scan."""

    def is_before_all(self, arrival: Arrival) -> bool:
        """Tell whether a scan lies before the tracks known beforehand."""
        return self._priors is not None and arrival.time < float(self._priors.time.max())

    def bound(self, search: Solver, limits: GrowthLimits) -> None:
        """Take another solver and other limits from the next step on.

        Parameters
        ----------
        search
            The solver, with its budget.
        limits
            What bounds the number of sequences considered.
        """
        self._search, self._limits = search, limits
        if self._tree is not None:
            self._tree.limits = limits

    def checked(self, scans: Sequence[Scan]) -> Arrival:
        """Return the scans with dimensions, and with numbers for their reports."""
        sound = []
        for given in scans:
            scan, self._dim = checked_scan(given, self._sensors, self._dim, self._used)
            # What priors tell of height nobody else has to.
            alone = self._priors is None and len(self._sensors) == 1
            self._widths = with_width(self._widths, scan, self._dim, is_alone=alone)
            likely = self._dim or (self._tree.dim if self._tree else 2)
            sound.append(with_dimensions(scan, self._sensors[scan.sensor], likely))
        return Arrival(tuple(sound))

    def left_out(self, arrival: Arrival, haste: Haste) -> Hypothesis:
        """Return the last hypothesis after a scan that came too late."""
        told = self.unchanged(arrival, LATE, tracks=haste.tracks)
        late = [number for scan in arrival.scans for number in scan.report.tolist()]
        return replace(told, late=tuple(late))

    def unchanged(self, arrival: Arrival, reason: str, *, tracks: bool) -> Hypothesis:
        """Return the last hypothesis again."""
        told = unchanged(self._last, arrival.time, self._dim or 2, reason)
        if self._last is None:
            return told
        return replace(told, tracks=self.tracks() if tracks else TrackTable.empty(told.tracks.dim))


@contextmanager
def _whole_or_not_at_all(
    trackers: Sequence[LiveTracker], rng: np.random.Generator
) -> Iterator[None]:
    """Undo what is done to trackers where it does not come to its end, whatever stops it."""
    state = rng.bit_generator.state
    trees = [tracker.__dict__.get("_tree") for tracker in trackers]
    saved = [tracker.saved() for tracker in trackers]
    try:
        yield
    except BaseException as err:
        for tracker, before in zip(trackers, saved, strict=True):
            tracker.undo(before)
        rng.bit_generator.state = state
        err.add_note(UNDONE)
        raise
    for tracker, before, tree in zip(trackers, saved, trees, strict=True):
        tracker.settle(before, tree)


def _kept(part: Any) -> Any:
    """Return what a part is now; nodes are not copied, but left alone from now on."""
    return (
        part.saved() if isinstance(part, AssociationTree | InactiveClusters) else copy.copy(part)
    )


def _reports(arrivals: Sequence[Arrival]) -> frozenset[int]:
    return frozenset(
        number for each in arrivals for scan in each.scans for number in scan.report.tolist()
    ) if len(arrivals) > 1 else frozenset()  # fmt: skip
