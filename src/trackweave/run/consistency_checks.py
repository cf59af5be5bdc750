"""What of a configuration a run's first tracks contradict, and what is used instead."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from trackweave.arrays import IntArray
from trackweave.config import Configuration
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.estimation.lone import middle_of
from trackweave.estimation.single_object import single_object
from trackweave.run.diagnostics import Finding
from trackweave.run.motion_check import MotionDoubts
from trackweave.run.noise_check import CLEAR, NoiseDoubts
from trackweave.run.observing import observe, positions_in
from trackweave.run.told_check import ToldDoubts

__all__ = ["ConsistencyChecks"]

# What is told of a single object's noise is doubted beyond so many standard errors.
ERRORS = 3.0


class ConsistencyChecks:
    """What was told of noise and of motion, against what the first tracks of a run show.

    Noise comes first: where too little is told of it, tracks break off whatever objects do.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._told = configuration
        self._noise, self._motion, self._rest = NoiseDoubts(), MotionDoubts(), ToldDoubts()
        self._are_bearings_judged = self._is_one_judged = self._is_break_judged = False

    @property
    def configuration(self) -> Configuration:
        """What the next attempt takes: as read, but for what is doubted."""
        return self._motion.applied(self._noise.applied(self._rest.applied(self._told)))

    def contradict(
        self, reports: ReportTable, settings: Settings, track: IntArray, *, at_end: bool = False
    ) -> bool:
        """Look at the tracks so far; tell whether ``configuration`` changed, to begin again."""
        # ``track`` is that of each report as far as it is known, -1 for none; ``at_end`` no more
        # come.
        if reports.has_foreign:
            # Nothing here knows how reports of a kind from outside scatter.
            return False
        if self._contradicts_bearings(reports, settings):
            return True
        if self._contradicts_one(reports, settings):
            return True
        if at_end and self._breaks(reports, settings, track):
            return True
        if self._noise.contradict(reports, settings, track, at_end=at_end):
            return True
        if not (self._noise.is_settled or at_end):
            return False
        return self._motion.contradict(reports, settings, track, at_end=at_end)

    def _contradicts_bearings(self, reports: ReportTable, settings: Settings) -> bool:
        """Judge once what was told of bearings' noise: of them none scatters about a place."""
        told = [self._told.sensor(name).get("sigma") for name in reports.sensors]
        motion = settings.values["motion"]
        if (
            self._are_bearings_judged
            or None in told
            or not {"max_speed", "process_noise"} <= set(motion)
            or any(sensor.trusts("sigma") for sensor in settings.sensors)
            or not all(sensor.measurement.is_bearing_only for sensor in settings.sensors)
        ):
            return False
        self._are_bearings_judged = True
        from trackweave.run.bearings_alone import likelier_noise

        factor = likelier_noise(
            reports,
            self._told,
            observe(reports, self._told),
            positions_in(reports, self._told),
            (motion["max_speed"], motion["process_noise"]),
        )
        if factor is not None:
            self._noise.overrule(settings, reports.sensors, factor)
        return factor is not None

    def _contradicts_one(self, reports: ReportTable, settings: Settings) -> bool:
        """Judge once what was told of the noise of a single object: less would make it several."""
        if self._is_one_judged or len(settings.sensors) != 1 or len(reports.sensors) != 1:
            return False
        self._is_one_judged = True
        (sensor,), (name,) = settings.sensors, reports.sensors
        told = self._told.sensor(name).get("sigma")
        if not isinstance(told, float | int) or sensor.trusts("sigma"):
            return False
        if not sensor.measurement.is_position or np.isfinite(reports.sigma).any():
            return False
        rows = middle_of(reports, 0)
        found = single_object(reports.time[rows], reports.measurement[rows])
        if found is None:
            return False
        error = 1.0 / np.sqrt(2.0 * found.own.sum() * reports.dim)
        is_clear = found.sigma > max(CLEAR, 1.0 + ERRORS * error) * told
        if is_clear:
            self._noise.overrule(settings, reports.sensors, found.sigma / told)
        return bool(is_clear)

    def _breaks(self, reports: ReportTable, settings: Settings, track: IntArray) -> bool:
        """Judge once whether tracks are broken by what was told of noise."""
        if self._is_break_judged:
            return False
        self._is_break_judged = True
        if self._noise.applied(self._told) is not self._told:
            # By now it is what reports along tracks tell.
            return False
        from trackweave.run.sigma_trial import broken_by_sigma

        factors = broken_by_sigma(reports, self.configuration, settings, track)
        for name, factor in factors.items():
            self._noise.overrule(settings, [name], factor)
        return bool(factors)

    def take_back(self, findings: Sequence[Finding], settings: Settings) -> bool:
        """Look at what contradicts a whole run; tell whether ``configuration`` changed."""
        is_changed = self._rest.take_back(findings, settings)
        if is_changed:
            # Tracks may have broken off for want of what is given back.
            self._motion = MotionDoubts()
        return is_changed

    def entered(self, settings: Settings) -> Settings:
        """Return the configuration as used, in which what was learned counts as estimated."""
        return self._rest.entered(self._motion.entered(self._noise.entered(settings)))

    def findings(self) -> list[Finding]:
        """Return a sentence on each value that is not used as told."""
        return [*self._noise.findings(), *self._motion.findings(), *self._rest.findings()]

    def as_record(self) -> list[dict[str, Any]]:
        """Return what was told, learned and used of each value that was judged."""
        return [*self._noise.as_record(), *self._motion.as_record(), *self._rest.as_record()]
