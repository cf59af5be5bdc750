"""What a configuration leaves out, from the reports and from tracks made of them."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from trackweave.config.fill import Settings, fill, known_sigma, needs_estimates
from trackweave.config.observed import ObservedSensor
from trackweave.config.sections import Configuration
from trackweave.domain.reports import ReportTable
from trackweave.estimation import Estimates, Followed, estimate, refined, stretch_of
from trackweave.run.collect import Assigned
from trackweave.run.scans import complete_scans
from trackweave.trackers.multiscan import MultiScanTracker

__all__ = ["estimates_for"]

N_ROUNDS = 2
# Tracks are followed patiently, or pauses would never be seen to end.
PATIENT_DETECTION, PATIENT_AMONG_OTHERS, PATIENT_MISSES = 0.85, 0.5, 15
# The estimates must follow from the reports alone, whatever the seed of a run.
SEED = 1


def estimates_for(
    reports: ReportTable,
    configuration: Configuration,
    observed: Mapping[str, ObservedSensor] | None = None,
) -> Estimates | None:
    """Return estimates of what a configuration leaves out.

    First estimates come from reports that line up beyond chance. With them a stretch of the
    recording is tracked, patiently; the tracks tell more, and better in a crowd.

    Parameters
    ----------
    reports
        At least one report.
    configuration
        As read.
    observed
        What the sensors' reports show, by name; a sensor left out reports positions.

    Returns
    -------
    The estimates; None where nothing that can be estimated is left out.
    """
    names = tuple(
        name for index, name in enumerate(reports.sensors) if np.any(reports.sensor == index)
    )
    if not needs_estimates(configuration, names):
        return None
    estimates = estimate(reports, known_sigma(configuration, names))
    stretch = stretch_of(reports)
    for _ in range(N_ROUNDS):
        followed = _follow(stretch, fill(configuration, estimates, names, observed=observed))
        estimates = refined(estimates, stretch, followed)
    return estimates


def _follow(reports: ReportTable, settings: Settings) -> Followed:
    """Track reports patiently; return the track of each, and when each sensor looked."""
    # Of several sensors, some may see what others never see.
    patient = PATIENT_DETECTION if len(settings.sensors) == 1 else PATIENT_AMONG_OTHERS
    sensors = [
        replace(sensor, detection_probability=min(sensor.detection_probability, patient))
        for sensor in settings.sensors
    ]
    scans = complete_scans(reports, {sensor.name: sensor.scan_period for sensor in sensors})
    counts = Counter(scan.sensor for scan in scans)
    misses = round(PATIENT_MISSES * len(scans) / min(counts.values()))
    tracker = MultiScanTracker(
        motion=settings.motion,
        sensors=sensors,
        window=settings.window,
        lifecycle=replace(settings.lifecycle, delete_after_misses=misses),
        limits=settings.growth,
        estimate="best",
    )
    rng, assigned = np.random.default_rng(SEED), Assigned.nothing(len(reports))
    for scan in scans:
        assigned.enter(tracker.step(scan, rng=rng).final)
    assigned.enter(tracker.pending())
    looks: dict[str, list[float]] = {name: [] for name in reports.sensors}
    for scan in scans:
        looks[scan.sensor].append(scan.time)
    return Followed(assigned.track, {name: np.array(times) for name, times in looks.items()})
