"""What of a configuration a run's first tracks contradict, and what is used instead."""

from typing import Any

from trackweave.arrays import IntArray
from trackweave.config import Configuration
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.run.bearing_check import BearingDoubts
from trackweave.run.diagnostics import Finding
from trackweave.run.motion_check import MotionDoubts
from trackweave.run.noise_check import NoiseDoubts

__all__ = ["ConsistencyChecks"]


class ConsistencyChecks:
    """What was told of noise and of motion, against what the first tracks of a run show.

    Noise comes first: where too little is told of it, tracks break off whatever objects do.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._told = configuration
        self._noise, self._motion = NoiseDoubts(), MotionDoubts()
        self._bearings = BearingDoubts()

    @property
    def configuration(self) -> Configuration:
        """What the next attempt takes: as read, but for what is doubted."""
        return self._motion.applied(self._noise.applied(self._bearings.applied(self._told)))

    def contradict(
        self, reports: ReportTable, settings: Settings, track: IntArray, *, at_end: bool = False
    ) -> bool:
        """Look at the tracks so far; tell whether ``configuration`` changed, to begin again."""
        # ``track`` is that of each report as far as it is known, -1 for none; ``at_end`` no more
        # come.
        if reports.has_foreign:
            # Nothing here knows how reports of a kind from outside scatter.
            return False
        if self._bearings.contradict(reports, settings, self._told):
            return True
        if self._noise.contradict(reports, settings, track, at_end=at_end):
            return True
        if not (self._noise.is_settled or at_end):
            return False
        return self._motion.contradict(reports, settings, track, at_end=at_end)

    def entered(self, settings: Settings) -> Settings:
        """Return the configuration as used, in which what was learned counts as estimated."""
        return self._motion.entered(self._noise.entered(self._bearings.entered(settings)))

    def findings(self) -> list[Finding]:
        """Return a sentence on each value that is not used as told."""
        doubts = self._bearings, self._noise, self._motion
        return [finding for each in doubts for finding in each.findings()]

    def as_record(self) -> list[dict[str, Any]]:
        """Return what was told, learned and used of each value that was judged."""
        doubts = self._bearings, self._noise, self._motion
        return [record for each in doubts for record in each.as_record()]
