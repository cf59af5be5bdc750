"""What a configuration leaves out of sensors that measure ranges and bearings."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.config import Configuration
from trackweave.config.sensing import ObservedSensor
from trackweave.domain.reports import ReportTable
from trackweave.estimation.directions import bearing_sensor, with_components
from trackweave.estimation.estimates import Estimates, SensorEstimate, digits
from trackweave.estimation.rates import RateNoise, rate_noise
from trackweave.estimation.refine import Followed, Track, sure_tracks
from trackweave.estimation.standing import with_standing
from trackweave.estimation.tails import with_tails
from trackweave.run.polar_to_cartesian import platforms_of
from trackweave.trackers.scan_preparation import USUAL_MISSES
from trackweave.trackers.window import Window

__all__ = ["Directions", "directed", "directions_of"]

USUAL_RATE_SIGMA = 1.0
SAME_TIME = 1e-6
MOST_MISSES = 1000
TURNS_IN_WINDOW, MOST_SCANS = 2.5, 60
TURNS_OF_SLOWEST, MOST_SCANS_OF_TURNS = 5.0, 50
# What the silence of a bearing sensor may say over a scan of the slowest sensor [nats].
WORTH_OF_SILENCE = 1.5
# One of bearings that sees objects more seldom than that does not for such a share of their time,
# and for so long on average [s]: false bearings hide how long it really is.
SELDOM, UNSEEN = 0.5, (0.5, 30.0)


@dataclass(frozen=True, slots=True, eq=False)
class Directions:
    """What is measured otherwise than as positions."""

    reports: ReportTable  # All reports, as they came
    platform: FloatArray  # Each one's sensor, x, y first [m], shape (reports, ≥ 2)
    places: Mapping[str, Sequence[float]]  # Where sensors stand whose rows do not say, by name [m]
    observed: Mapping[str, ObservedSensor]
    sigmas: Mapping[str, tuple[float, ...]]  # What is told of the noise of ranging ones [m, rad]


def directions_of(
    reports: ReportTable,
    configuration: Configuration,
    observed: Mapping[str, ObservedSensor],
    places: Mapping[str, Sequence[float]],
) -> Directions | None:
    """Return what is measured otherwise than as positions, None for nothing."""
    if all(seen.measurement.is_position for seen in observed.values()):
        return None
    sigmas = _told_sigmas(configuration, observed)
    return Directions(reports, platforms_of(reports, places), places, observed, sigmas)


def _told_sigmas(
    configuration: Configuration, observed: Mapping[str, ObservedSensor]
) -> dict[str, tuple[float, ...]]:
    """Return what is told of the noise of sensors that measure ranges [m, rad]."""
    told: dict[str, tuple[float, ...]] = {}
    for name in observed:
        sigma = configuration.sensor(name).get("sigma")
        if isinstance(sigma, Mapping) and {"range_m", "azimuth_deg"} <= set(sigma):
            told[name] = (sigma["range_m"], float(np.radians(sigma["azimuth_deg"])))
    return told


def directed(
    estimates: Estimates,
    tables: tuple[ReportTable, ReportTable],
    followed: Followed,
    directions: Directions,
    *,
    at_rest: bool,
) -> Estimates:
    """Return estimates with those of sensors that measure directions."""
    # ``tables`` are all reports and the stretch of them that was followed.
    (reports, stretch), observed = tables, directions.observed
    ranging = {
        name: directions.places.get(name, ())
        for name, seen in observed.items()
        if seen.measurement.has_range
    }
    estimates = with_components(estimates, stretch, followed, ranging)
    estimates = with_tails(estimates, stretch, followed, ranging, directions.sigmas)
    sure = sure_tracks(estimates, stretch, followed)
    estimates = with_standing(estimates, reports, ranging, (stretch, sure), at_rest=at_rest)
    sensors, notes = dict(estimates.sensors), list(estimates.notes)
    for name in ranging:
        if name in sensors and isinstance(sensors[name].sigma, tuple):
            rates = _rates(name, directions, (stretch, sure), sensors[name].plane_sigma)
            sensors[name] = _in_own_units(sensors[name], observed[name], rates)
            if rates.doubt:
                notes.append(
                    f"sensor {name}: its range_rate_mps {rates.doubt}; expected metres per second,"
                    " positive for what moves away. They count with a sigma of "
                    f"{rates.sigma:g} m/s, which is next to nothing"
                )
    tracks = [(stretch.time[track.rows], stretch.measurement[track.rows]) for track in sure]
    bearing = [name for name, seen in observed.items() if seen.measurement.is_bearing_only]
    for name in bearing:
        rows = directions.reports.sensor == directions.reports.sensors.index(name)
        found = bearing_sensor(
            directions.reports.time[rows],
            directions.reports.measurement[rows, 0],
            directions.platform[rows],
            tracks,
            observed[name].extent,
        )
        if found is not None:
            sensors[name] = found
    sensors = {
        name: _harmless(sensor, sensors) if name in bearing else sensor
        for name, sensor in sensors.items()
    }
    estimates = replace(estimates, sensors=sensors, notes=tuple(notes))
    return _paced(_in_window(estimates, observed), bearing, directions)


def _rates(
    name: str, directions: Directions, tracks: tuple[ReportTable, list[Track]], sigma: float
) -> RateNoise:
    """Return the noise of range rates, the usual where there are none or no track tells."""
    # ``tracks`` are reports and those of them that are sure; ``sigma`` is the noise of ranges [m].
    (stretch, sure), reports = tracks, directions.reports
    kind = directions.observed[name].measurement
    usual = RateNoise(USUAL_RATE_SIGMA)
    if not kind.has_rate or reports.row is None or stretch.row is None:
        return usual
    column = kind.columns(stretch.dim).index("range_rate_mps")
    by_row = np.argsort(reports.row)
    of_sensor = stretch.sensor == stretch.sensors.index(name)
    told = []
    for track in sure:
        rows = track.rows[of_sensor[track.rows]]
        rows = rows[np.diff(stretch.time[rows], prepend=-np.inf) > SAME_TIME]
        at = by_row[np.searchsorted(reports.row, stretch.row[rows], sorter=by_row)]
        told.append((stretch.time[rows], *reports.measurement[at][:, [0, column]].T))
    return rate_noise(told, sigma) or usual


def _in_window(estimates: Estimates, observed: Mapping[str, ObservedSensor]) -> Estimates:
    """Return estimates whose window holds some turns of the slowest of several radars."""
    # What one of them alone sees becomes a track in the window, or never.
    periods = [seen.rotation.period for seen in observed.values() if seen.rotation is not None]
    needed = math.ceil(TURNS_OF_SLOWEST * sum(max(periods) / period for period in periods))
    if len(periods) < 2 or needed <= Window().max_scans:
        return estimates
    return replace(estimates, max_scans=min(needed, MOST_SCANS_OF_TURNS))


def _paced(estimates: Estimates, bearing: Sequence[str], directions: Directions) -> Estimates:
    """Return estimates in which scans are counted over all sensors, fast cameras included."""
    reports = directions.reports
    looks = {
        name: np.unique(reports.time[reports.sensor == index]).size
        for index, name in enumerate(reports.sensors)
    }
    placing = [count for name, count in looks.items() if name not in bearing and count > 1]
    if not bearing or not placing:
        return estimates
    usual = estimates.delete_after_misses or USUAL_MISSES
    misses = min(round(usual * sum(looks.values()) / sum(placing)), MOST_MISSES)
    # Of the slowest sensor's scans the window must hold more than one.
    needed = math.ceil(sum(looks.values()) / min(placing) * TURNS_IN_WINDOW)
    scans = min(needed, MOST_SCANS) if needed > Window().max_scans else estimates.max_scans
    return replace(estimates, delete_after_misses=misses, max_scans=scans)


def _harmless(sensor: SensorEstimate, sensors: Mapping[str, SensorEstimate]) -> SensorEstimate:
    """Return a bearing sensor whose misses end no track that others see."""
    # A camera that sees an object tens of times a second, or never, says little by each miss. It
    # gets a chance of detection that the silence of a whole scan of the slowest bears.
    periods = [other.scan_period for other in sensors.values() if other.scan_period is not None]
    if sensor.scan_period is None:
        return sensor
    looks = max(max(periods) / sensor.scan_period, 1.0)
    most = 1 - math.exp(-WORTH_OF_SILENCE / looks)
    if sensor.detection_probability < SELDOM:
        sensor = replace(sensor, hidden_share=UNSEEN[0], mean_silence=UNSEEN[1])
    return replace(sensor, detection_probability=min(sensor.detection_probability, digits(most)))


def _in_own_units(
    sensor: SensorEstimate, seen: ObservedSensor, rates: RateNoise
) -> SensorEstimate:
    """Return a ranging sensor with noise for each column, and clutter per unit of all of them."""
    assert isinstance(sensor.sigma, tuple)
    sigma = sensor.sigma
    if seen.measurement.has_rate:
        sigma = (*sigma, rates.sigma)
    density = sensor.clutter_density * sensor.covered / seen.extent
    return replace(sensor, sigma=sigma, clutter_density=density)
