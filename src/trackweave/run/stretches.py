"""Some reports of a recording, tracked under one set of values after another."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.growth_limits import GrowthLimits
from trackweave.config import Configuration
from trackweave.config.fill import fill
from trackweave.config.sensing import UNKNOWN_SENSOR, ObservedSensor
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import Estimates
from trackweave.randomness import generator_of
from trackweave.run.course import course_of
from trackweave.run.record import Assigned
from trackweave.solvers import Auto

__all__ = ["SURE_HITS", "Stretch", "Tracked", "middle_part"]

SURE_HITS = 12
"""A track of so many reports is beyond doubt."""
# Tracks are looked at after so many steps each.
TOLD = 5
# Where nearly nothing is known, proofs take time and tell nothing more.
QUICK, SEED = Auto(evaluations=10_000, branches=0), 1


@dataclass(frozen=True, slots=True, eq=False)
class Tracked:
    """What came of a stretch under some values."""

    cost: float  # Of all tracks [nats]
    track: IntArray  # Of each report, -1 for none
    speed: float  # The usual speed of tracks beyond doubt [m/s]; NaN where there are none


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """Some reports, and what is told of them."""

    reports: ReportTable
    configuration: Configuration
    observed: Mapping[str, ObservedSensor]

    @classmethod
    def of_positions(cls, reports: ReportTable, configuration: Configuration) -> "Stretch":
        """Return reports of sensors of which nothing else is to be observed."""
        # A beam that is told to turn would have to be observed: each instant is a scan here.
        sensors = {
            name: {key: value for key, value in told.items() if key != "rotation"}
            for name, told in configuration.table("sensors").items()
        }
        plain = configuration.changed(sensors=sensors)
        return cls(reports, plain, dict.fromkeys(reports.sensors, UNKNOWN_SENSOR))

    def tracked(self, estimates: Estimates) -> Tracked:
        """Track the stretch as some estimates say."""
        names = self.reports.sensors
        settings = fill(self.configuration, estimates, names, observed=self.observed)
        # Narrow growth takes a seventh of the time, and tells the same.
        settings = replace(settings, search=QUICK, growth=GrowthLimits(), estimate="best")
        settings = replace(settings, deadline=None, plots=None)
        course = course_of(self.reports, settings, {}, None)
        rng, assigned = generator_of(SEED), Assigned.nothing(len(self.reports))
        cost: dict[int, float] = {}
        speeds: list[FloatArray] = []
        for number, scans in enumerate(course.steps):
            is_told = number % TOLD == 0 or number == len(course.steps) - 1
            told = course.take(scans, rng, None, tracks=is_told)
            assigned.enter(told.final)
            rows, dim = told.tracks, self.reports.dim
            cost |= dict(zip(rows.track.tolist(), rows.score.tolist(), strict=True))
            velocity = rows.mean[rows.hits >= SURE_HITS, dim : 2 * dim]
            speeds.append(np.linalg.norm(velocity, axis=1))
        assigned.enter(course.tracker.pending())
        every = np.concatenate([np.empty(0), *speeds])
        usual = float(np.median(every)) if every.size else math.nan
        return Tracked(sum(cost.values()), assigned.track, usual)


def middle_part(reports: ReportTable, most: int) -> ReportTable:
    """Return so many reports at most, in the middle of the time."""
    skip = max(0, (len(reports) - most) // 2)
    return reports.part(np.arange(skip, min(len(reports), skip + most)))
