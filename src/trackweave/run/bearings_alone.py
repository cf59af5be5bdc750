"""What bearings alone tell of their sensors and objects.

No report says where its object is, so that nothing can be read off the reports themselves. A
stretch of them is tracked under one value after another instead: those are taken under which the
tracks are the most probable, and then what the tracks themselves tell.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.config import Configuration
from trackweave.config.sensing import ObservedSensor
from trackweave.domain.reports import ReportTable
from trackweave.estimation.coverage import reach_of_bearings
from trackweave.estimation.estimates import Estimates, SensorEstimate, bounded, digits, positive
from trackweave.estimation.refine import DETECTION_RANGE
from trackweave.run.noise_check import with_scaled
from trackweave.run.polar_to_cartesian import platforms_of
from trackweave.run.stretches import SURE_HITS, Stretch, Tracked, middle_part

__all__ = ["estimates_of_bearings", "likelier_noise"]

MOST_REPORTS, MOST_JUDGED, FEWEST_REPORTS = 1500, 600, 60
"""So many reports are tracked at most, to judge what is told, and fewer tell nothing."""
# Which sequences are found is chance by so much of the cost of all; so much is worth a process
# noise by which no turn is lost, for a stretch has few.
NEARLY, WORTH_OF_TURNS = 0.03, 0.01
PROCESS_NOISES = (0.001, 0.01, 0.1, 1.0, 10.0)
SIGMAS_DEG = (0.03, 0.06, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0)
SPEEDS, FASTER = (50.0, 350.0, 2500.0), 4.0
SAID = (
    "bearings alone: what is left out is estimated by tracking a stretch under one value after "
    f"another, a noise of {SIGMAS_DEG[0]:g}° to {SIGMAS_DEG[-1]:g}° where rows tell none, a "
    f"process noise of {PROCESS_NOISES[0]:g} to {PROCESS_NOISES[-1]:g} m²/s³, and speeds up to "
    f"{', '.join(f'{speed:g}' for speed in SPEEDS[:-1])} or {SPEEDS[-1]:g} m/s; give sigma, "
    "process_noise and max_speed where they are beyond that"
)
# A noise that is told is not believed where tracks are likelier under another by so much of their
# cost; ``TRIAL`` and then ``FACTORS`` are how many times as large others are.
CLEAR, TRIAL, FACTORS = 0.1, (0.25, 4.0), (0.06, 0.12, 0.5, 2.0, 8.0, 16.0)
# Before anything is known half of what is there comes while it is watched.
COMING = 0.5
# What is believed of the chance of detection beforehand, as if seen so often.
USUAL_DETECTION, USUAL_CHANCES = 0.9, 10.0
# Tracks that begin in so much of the time were there before.
EARLY = 0.15


@dataclass(frozen=True, slots=True, eq=False)
class _Stretch(Stretch):
    """Some bearings, and what is told of them."""

    area: float = 1.0  # From which they tell places [m²]

    def counted(self, estimates: Estimates, tracked: Tracked) -> Estimates:
        """Return estimates with what tracks tell of how many there are, and how they are seen."""
        time, index = self.reports.time, self.reports.sensor
        span = max(float(np.ptp(time)), 1e-9)
        groups = [np.flatnonzero(tracked.track == each) for each in np.unique(tracked.track)]
        sure = [rows for rows in groups if rows.size >= SURE_HITS and tracked.track[rows[0]] >= 0]
        came = sum(time[rows[0]] > time[0] + EARLY * span for rows in sure)
        present = sum(float(time[rows[-1]] - time[rows[0]]) for rows in sure) / span
        sensors = {}
        for number, name in enumerate(self.reports.sensors):
            own = index == number
            seen = [time[rows[own[rows]]] for rows in sure]
            left = int(np.count_nonzero(own & (tracked.track < 0)))
            sensors[name] = _seen(estimates.sensors[name], np.unique(time[own]), seen, left)
        fastest = estimates.max_speed
        speed = FASTER * tracked.speed if tracked.speed > 0.0 else fastest
        n_scans = max(span / _period(self.observed), 1.0)
        return replace(
            estimates,
            sensors=sensors,
            max_speed=bounded(min(speed, fastest)),
            new_target_density=positive((came + 0.5) / (self.area * n_scans)),
            initial_target_density=positive(max(present, 0.5) / self.area),
        )


def estimates_of_bearings(
    reports: ReportTable,
    configuration: Configuration,
    observed: Mapping[str, ObservedSensor],
    places: Mapping[str, Sequence[float]],
) -> Estimates | None:
    """Return estimates of sensors that measure bearings alone; None where they are too few."""
    # ``places`` are where sensors are said to stand [m]; rows that say it come first.
    stretch = _stretch_of(reports, configuration, observed, places)
    if stretch is None:
        return None
    estimates, tracked = _at_speeds(stretch)
    estimates = stretch.counted(estimates, tracked)
    if configuration.said("motion", "process_noise") is None:
        tried = [replace(estimates, process_noise=value) for value in PROCESS_NOISES]
        estimates, tracked = _likeliest(stretch, tried, WORTH_OF_TURNS)
    else:
        tracked = stretch.tracked(estimates)
    if math.isnan(tracked.speed):
        # Without tracks nothing is known.
        return None
    return replace(stretch.counted(estimates, tracked), notes=(SAID,))


def likelier_noise(
    reports: ReportTable,
    configuration: Configuration,
    observed: Mapping[str, ObservedSensor],
    places: Mapping[str, Sequence[float]],
    motion: tuple[float, float],
) -> float | None:
    """Return how many times the sigma told of bearings is clearly likelier; None for as told."""
    # ``motion`` is the greatest speed [m/s] and the process noise [m²/s³] that tracks were begun
    # with. A stretch is tracked under a much larger and a smaller noise before any other.
    stretch = _stretch_of(reports, configuration, observed, places, MOST_JUDGED)
    if stretch is None:
        return None
    first = replace(_first(stretch), max_speed=motion[0], process_noise=motion[1])

    def cost(factor: float) -> float:
        other = with_scaled(configuration, dict.fromkeys(stretch.reports.sensors, factor))
        return replace(stretch, configuration=other).tracked(first).cost

    as_told = cost(1.0)
    clear = as_told - CLEAR * abs(as_told)
    costs = {factor: cost(factor) for factor in TRIAL}
    if min(costs.values()) >= clear:
        return None
    costs |= {factor: cost(factor) for factor in FACTORS}
    return min(costs, key=lambda factor: costs[factor])


def _stretch_of(
    reports: ReportTable,
    configuration: Configuration,
    observed: Mapping[str, ObservedSensor],
    places: Mapping[str, Sequence[float]],
    most: int = MOST_REPORTS,
) -> _Stretch | None:
    """Return a stretch of so many reports at most; None where they are too few."""
    reach = reach_of_bearings(platforms_of(reports, places))
    is_enough = len(reports) >= FEWEST_REPORTS and len(reports.sensors) > 1
    if not is_enough or reports.dim != 2 or reach <= 0.0:
        return None
    return _Stretch(middle_part(reports, most), configuration, observed, math.pi * reach**2)


def _at_speeds(stretch: _Stretch) -> tuple[Estimates, Tracked]:
    """Return what fits best of all noises, at the least speed that makes tracks as probable."""
    tried = [_first(stretch)]
    if _tells_no_sigma(stretch.reports, stretch.configuration):
        tried = [_with_sigma(tried[0], sigma) for sigma in SIGMAS_DEG]
    best = _likeliest(stretch, tried)
    if stretch.configuration.said("motion", "max_speed") is not None:
        return best
    for speed in SPEEDS[1:]:
        # One trial tells whether all noises are worth another.
        quicker = stretch.tracked(replace(best[0], max_speed=speed))
        if quicker.cost >= best[1].cost - NEARLY * abs(best[1].cost):
            break
        best = _likeliest(stretch, [replace(each, max_speed=speed) for each in tried])
    return best


def _likeliest(
    stretch: _Stretch, tried: Sequence[Estimates], nearly: float = NEARLY
) -> tuple[Estimates, Tracked]:
    """Return of some estimates the last under which the tracks are nearly the most probable."""
    found = [(estimates, stretch.tracked(estimates)) for estimates in tried]
    least = min(tracked.cost for _, tracked in found)
    return [each for each in found if each[1].cost <= least + nearly * abs(least)][-1]


def _first(stretch: _Stretch) -> Estimates:
    """Return what is believed before anything is known."""
    reports, observed = stretch.reports, stretch.observed
    looks = np.unique(np.stack([reports.time, reports.sensor]), axis=1).shape[1]
    present = len(reports) / looks / stretch.area
    n_scans = max(float(np.ptp(reports.time)) / _period(observed), 1.0)
    sensors = {
        name: SensorEstimate(
            scan_period=observed[name].scan_period,
            # Of rows that tell their own, no other is wanted.
            sigma=1.0,
            detection_probability=USUAL_DETECTION,
            clutter_density=0.1 * observed[name].reports_per_scan / observed[name].extent,
            covered=observed[name].extent,
            n_objects=1.0,
        )
        for name in reports.sensors
    }
    return Estimates(sensors, 1.0, SPEEDS[0], COMING * present / n_scans, present)


def _with_sigma(estimates: Estimates, sigma_deg: float) -> Estimates:
    """Return estimates with the noise of all bearings [degrees]."""
    sigma = (digits(math.radians(sigma_deg)),)
    sensors = {name: replace(each, sigma=sigma) for name, each in estimates.sensors.items()}
    return replace(estimates, sensors=sensors)


def _tells_no_sigma(reports: ReportTable, configuration: Configuration) -> bool:
    """Tell whether neither rows nor file say how noisy bearings are."""
    told = ["sigma" in configuration.sensor(name) for name in reports.sensors]
    return bool(np.isnan(reports.sigma[:, 0]).all()) and not any(told)


def _period(observed: Mapping[str, ObservedSensor]) -> float:
    """Return the time from scan to scan by which objects come [s], as a tracker takes it."""
    known = [seen.scan_period for seen in observed.values() if seen.scan_period is not None]
    return max(known, default=1.0)


def _seen(
    sensor: SensorEstimate, looks: FloatArray, seen: Sequence[FloatArray], left: int
) -> SensorEstimate:
    """Return a sensor as tracks tell of it: ``seen`` are the times of each, ``left`` is left."""
    clutter = digits((left + 0.5) / looks.size / sensor.covered)
    if sensor.scan_period is None:
        # A lone report tells nothing of whom it is not of.
        return replace(sensor, clutter_density=clutter)
    hits, chances = USUAL_DETECTION * USUAL_CHANCES, USUAL_CHANCES
    for times in seen:
        if times.size > 1:
            ends = np.searchsorted(looks, times[[0, -1]])
            chances += int(ends[1] - ends[0])
            hits += np.unique(times).size - 1
    share = digits(float(np.clip(hits / chances, *DETECTION_RANGE)))
    return replace(sensor, clutter_density=clutter, detection_probability=share)
