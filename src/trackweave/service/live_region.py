"""One region of the plane, live, and whoever has all of them.

What regions say follows from what they are given, wherever they are and however often they were
begun anew from what they packed. So it is no part of an answer who houses them.
"""

import time as clock
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from trackweave.arrays import IntArray
from trackweave.association.growth_limits import GrowthLimits
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.errors import InvalidInputError, NumericalError
from trackweave.service.shared_tracks import Given
from trackweave.service.spec import Spec
from trackweave.solvers.protocol import Solver
from trackweave.trackers.checkpoint import pack, unpack
from trackweave.trackers.hypothesis import Assignments, Hypothesis
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker

__all__ = ["NOBODY", "Here", "House", "LiveRegion", "Told"]

NOBODY: IntArray = np.empty(0, dtype=np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Told:
    """What a region says after a step."""

    hypothesis: Hypothesis | None
    """None where the step raised, and was undone."""
    tracks: TrackTable
    open: Given
    """Reports of the window at which other regions look as well."""
    born: dict[int, int]
    """The step at which each of their tracks was first told of."""
    cpu: float
    """What it took [s]."""


@dataclass(slots=True)
class LiveRegion:
    """One region's tracker; under its own names, as it knows no other region."""

    tracker: MultiHypothesisTracker
    rng: np.random.Generator
    shared: IntArray = field(default_factory=NOBODY.copy)
    """Reports that are not final, at which other regions look as well."""
    born: dict[int, int] = field(default_factory=dict)
    steps: int = 0

    @classmethod
    def unpacked(cls, content: bytes) -> "LiveRegion":
        """Return the region that `packed` was asked of."""
        found: LiveRegion = unpack(content, (cls,))
        return found

    def packed(self) -> bytes:
        """Return all that it knows."""
        return pack(self, (LiveRegion,))

    def bound(self, search: Solver, limits: GrowthLimits) -> None:
        """Take another solver and other limits from the next step on."""
        self.tracker.bound(search, limits)

    def tracks(self) -> TrackTable:
        """Return the live tracks."""
        return self.tracker.tracks()

    def pending(self) -> Assignments:
        """Return the assignments that later scans may amend."""
        return self.tracker.pending()

    def step(self, scans: Sequence[Scan], shared: IntArray, tracks: bool) -> Told:
        """Take in its part of a step; ``shared`` are its reports at which others look too."""
        begun, hypothesis = clock.process_time(), None
        try:
            found = self.tracker.step(scans, rng=self.rng, tracks=tracks)
        except (InvalidInputError, NumericalError):
            known = self.tracker.tracks() if tracks else TrackTable.empty(2)
        else:
            # Nobody asks for these over borders, and they are long.
            hypothesis, known = replace(found, amendments=()), found.tracks
            aside = [number for scan in found.set_aside for number in scan.report]
            gone = np.array([*found.final.report.tolist(), *found.late, *aside], np.int64)
            self.shared = np.setdiff1d(np.concatenate([self.shared, shared]), gone)
        pending = self.tracker.pending()
        own = np.isin(pending.report, self.shared)
        self._note_born(pending, known if tracks else None)
        given = Given(pending.report[own], pending.track[own])
        born = {each: self.born[each] for each in np.unique(given.track).tolist() if each >= 0}
        return Told(hypothesis, known, given, born, clock.process_time() - begun)

    def _note_born(self, pending: Assignments, known: TrackTable | None) -> None:
        self.steps += 1
        there = np.unique(pending.track[pending.track >= 0]).tolist()
        for each in there:
            self.born.setdefault(each, self.steps)
        if known is not None:
            alive = {*there, *known.track.tolist()}
            self.born = {each: step for each, step in self.born.items() if each in alive}


class House(Protocol):
    """Whoever has regions, and asks them."""

    cpu: float
    """What they have taken so far, of each step the slowest one's [s]."""

    def prepare(self, spec: Spec) -> None:
        """Be ready for the regions of a configuration."""

    def begin(self, states: Sequence[bytes]) -> None:
        """Have the regions that were packed, and no others."""

    def workers(self) -> list[list[int]] | None:
        """Return the processes that have each region; None where they are in this one."""

    def ask(self, method: str, args: Sequence[tuple[Any, ...]]) -> list[Any]:
        """Return what a method of each region gives, with arguments for each."""

    def packed(self) -> list[bytes]:
        """Return all that each region knows."""

    def look(self) -> None:
        """See whether all is well."""

    def close(self) -> None:
        """Leave the regions."""


class Here:
    """Regions in this process, one after the other."""

    def __init__(self) -> None:
        self.cpu = 0.0
        self._regions: list[LiveRegion] = []

    def prepare(self, spec: Spec) -> None:
        """There is nothing to be done."""

    def workers(self) -> None:
        """Return that there are none."""

    def begin(self, states: Sequence[bytes]) -> None:
        """Have the regions that were packed, and no others."""
        self._regions = [LiveRegion.unpacked(state) for state in states]

    def ask(self, method: str, args: Sequence[tuple[Any, ...]]) -> list[Any]:
        """Return what a method of each region gives, with arguments for each."""
        each = zip(self._regions, args, strict=True)
        return [getattr(region, method)(*own) for region, own in each]

    def packed(self) -> list[bytes]:
        """Return all that each region knows."""
        return [region.packed() for region in self._regions]

    def look(self) -> None:
        """All is well."""

    def close(self) -> None:
        """Nothing is to be left."""
