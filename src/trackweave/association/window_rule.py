"""What it costs to extend a sequence by a report, in nats against "all false alarms".

The standard track score [1]_. A first report costs −ln(P_D β |∂x/∂z| / λ), where β is the density
of objects not yet seen and λ that of false alarms; a report that joins costs
½νᵀS⁻¹ν + ½ln|2πS| + ln λ − ln P_D; a scan that covered the predicted place without a report
costs −ln(1 − P_D), with P_D averaged over the predicted position; to live on costs −ln p per scan
period, and to end −ln(1 − p), once. With N identities known, a report of the track's own is worth
ln((1 − e)N + e), one of another costs −ln e, where e is the chance of a wrong or new one.

.. [1] S. S. Blackman, *Multiple-Target Tracking with Radar Applications*, 1986, ch. 9.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._nodes import ScanInput, WindowRule
from trackweave.association.foreign_begin import Said, blur_of_foreign, said_by_foreign
from trackweave.chi_squared import quantile_of
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.scans import Scan
from trackweave.models.coverage import Coverage, everywhere
from trackweave.models.foreign_motion import AnyMotion, ForeignMotion
from trackweave.models.measurements import to_position
from trackweave.models.sensors import Sensor

__all__ = [
    "FARTHEST",
    "Context",
    "coverage_of",
    "scan_input",
    "swept",
    "window_rule",
    "without_reports",
]

GATE_PROBABILITY = 0.9997
"""How many of an object's own reports the gate lets through."""
FARTHEST = 1e5
"""How far a sensor sees of which nothing says how far [m]."""
APART, BESIDE = 0.5, 0.05
"""Reports of a turning sensor are of one object only if so many turns apart; of scans that a
column tells so many periods, for a beam that sweeps to and fro is soon back where it turns."""


class Context(NamedTuple):
    """What a scan is seen against.

    ``motion`` tells the dimensions, ``sensor`` is the number of the scan's sensor in its tracker
    and ``column`` that among those that do not see some objects for a while, -1 for none;
    ``n_identities`` how many identities are known, ``start`` when the sweep of a turning sensor
    began [s], ``period`` the scan period in which misses are counted [s].
    """

    motion: AnyMotion
    dim: int
    sensor: int = 0
    column: int = -1
    n_identities: int = 1
    start: float | None = None
    period: float | None = None


def window_rule(
    motion: AnyMotion,
    lifecycle: tuple[float, float, float, float, float],
    dim: int,
    *,
    unscented: bool = False,
    crossing_time: float = 0.0,
) -> WindowRule:
    """Return the rule as kernels read it, for the extended filter or the unscented one."""
    # ``lifecycle`` is the probability of survival per scan period; and when an object is not
    # looked for any more: by how much more probable it is that it is gone [nats], after how many
    # misses in a row, and after how many seconds without a report; and for how many its track is
    # shown then. ``crossing_time`` is how far apart in time two bearings may cross [s].
    survival, gone, max_misses, max_unseen, max_shown = lifecycle
    end_cost = -math.log(1.0 - survival)
    return WindowRule(
        motion=motion.rule(dim, unscented=unscented),
        crossing_time=float(crossing_time),
        end_cost=end_cost,
        most_tail=end_cost + gone,
        max_misses=float(max_misses),
        max_unseen=float(max_unseen),
        max_shown=float(max_shown),
        way=motion if isinstance(motion, ForeignMotion) else None,
    )


def scan_input(
    scan: Scan, sensor: Sensor, survival_cost: float, context: Context
) -> tuple[ScanInput, IntArray]:
    """Return a scan as kernels read it, slots from 0, and the order in which its reports stand."""
    # Living on since the last scan costs ``survival_cost`` [nats].
    kind, dim, count = sensor.measurement, context.dim, len(scan)
    size = scan.measurement.shape[1] if count else kind.n_components(dim)
    measurement = scan.measurement.reshape(count, size)
    sigma = sensor.noise(scan.sigma.reshape(count, size), measurement, dim)
    platform = sensor.platform
    if scan.platform is not None and scan.platform.size:
        platform = scan.platform
    platforms = np.broadcast_to(platform, (max(count, 1), 6))
    told = (measurement, sigma, platforms[:count])
    if isinstance(kind, ForeignKind):
        said = said_by_foreign(kind, scan, told, (context.motion, dim))
    else:
        said = _said_by_ours(kind, scan, sensor, told, context)
    is_located, place, spread, covariance, log_begin, foreign = said
    order = np.argsort(place[:, 0] if is_located else measurement[:, -1], kind="stable")
    moment = np.full(count, scan.time) if scan.moments is None else scan.moments
    setting, noise, used = _settings(covariance[order], platforms[:count][order])
    start = _start(scan, context.start)
    coverage = coverage_of(sensor, scan, start)
    if not coverage.everywhere:
        coverage = coverage._replace(blur=_blur(sensor, covariance, dim))
    own = np.full(count, -1, dtype=np.int64) if scan.identity is None else scan.identity
    evidence = np.zeros(count)
    if sensor.strength is not None and scan.strength is not None:
        evidence = sensor.strength.evidence(scan.strength)
    if sensor.echoes and is_located:
        volume = measurement[:, 0] if kind.has_range else np.ones(count)
        evidence -= np.log(sensor.false_alarms(place[:, :2], volume))
    fading, clearing = sensor.hiding() if context.column >= 0 else (0.0, 0.0)
    error = sensor.identity_error
    apart = APART if sensor.rotation is not None else BESIDE if scan.moments is not None else 0.0
    return ScanInput(
        kind=int(kind),
        sensor=context.sensor,
        time=float(scan.time),
        reference=float(scan.time if start is None else (start + scan.time) / 2),
        new_instant=True,
        is_silence_telling=(
            sensor.tells_silence(count) if scan.tells_silence is None else scan.tells_silence
        ),
        is_heard=sensor.scans is False,
        has_moments=scan.moments is not None,
        is_located=is_located,
        separation=apart * (sensor.scan_period or 0.0),
        pace=_pace(sensor, context.period),
        gate=_gate(size),
        reach=_reach(sensor),
        measurement=np.ascontiguousarray(measurement[order]),
        moment=np.ascontiguousarray(moment[order]),
        setting=setting,
        noise=noise,
        platform=used,
        position=np.ascontiguousarray(place[order]),
        position_covariance=np.ascontiguousarray(spread[order]),
        log_begin=log_begin[order],
        slot=np.arange(count),
        identity=np.ascontiguousarray(own[order]),
        evidence=np.ascontiguousarray(evidence[order]),
        level=(
            np.full(count, np.nan)
            if scan.height is None
            else scan.height[order] - sensor.height_offset
        ),
        sigma_level=float(sensor.sigma_height),
        identity_gain=math.log((1.0 - error) * max(context.n_identities, 1) + error),
        identity_loss=-math.log(error),
        detection_probability=float(sensor.detection_probability),
        log_clutter=math.log(sensor.clutter_density),
        survival_cost=float(survival_cost),
        hiding=0.0,
        showing=0.0,
        coverage=coverage,
        tail_share=float(sensor.tail_share),
        tail_scale=float(sensor.tail_scale) if sensor.tail_share > 0.0 else 1.0,
        tail_persistence=float(sensor.tail_persistence) if sensor.tail_share > 0.0 else 0.0,
        column=context.column,
        fading=fading,
        clearing=clearing,
        foreign=None if foreign is None else foreign.part(order),
    ), order


def _said_by_ours(
    kind: MeasurementKind,
    scan: Scan,
    sensor: Sensor,
    told: tuple[FloatArray, FloatArray, FloatArray],
    context: Context,
) -> Said:
    """Return what reports of a kind of ours say; ``told`` are numbers, noise and platforms."""
    measurement, sigma, platform = told
    (count, size), dim = measurement.shape, context.dim
    is_located = kind.gives_position(dim) and (kind.has_range or size == dim)
    place, spread = np.zeros((count, dim)), np.zeros((count, dim, dim))
    if is_located:
        place, spread = to_position(kind, measurement, sigma, platform, dim)
    elif count:
        place = platform[:, :dim].copy()
    covariance = sigma[:, :, None] ** 2 * np.eye(size)
    if scan.covariance is not None:
        covariance = scan.covariance
        if is_located and kind.is_position:
            spread = covariance
    log_begin = _log_begin(sensor, measurement, sigma, platform, context)
    return Said(is_located, place, spread, covariance, log_begin)


def _pace(sensor: Sensor, period: float | None) -> float:
    """Return what a miss of a sensor counts for, in scans of the given period."""
    if period is None or sensor.scan_period is None:
        return 1.0
    return min(1.0, sensor.scan_period / period)


@cache
def _gate(size: int) -> float:
    """Return the squared distance that hardly any own report of so many numbers exceeds."""
    return quantile_of(size, GATE_PROBABILITY)


def without_reports(scan: ScanInput) -> ScanInput:
    """Return a scan as if it had seen nothing."""
    per_report = (
        "measurement", "moment", "setting", "position", "position_covariance", "log_begin",
        "slot", "identity", "evidence", "level",
    )  # fmt: skip
    foreign = None if scan.foreign is None else scan.foreign.part(slice(0))
    return scan._replace(foreign=foreign, **{name: getattr(scan, name)[:0] for name in per_report})


def _settings(
    covariance: FloatArray, platform: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return which noise and platform each report has, and these, each only once."""
    count, size = covariance.shape[:2]
    both = np.concatenate([covariance.reshape(count, size * size), platform], axis=1)
    if count == 0 or np.all(both == both[0]):
        unique, setting = both[:1], np.zeros(count, dtype=np.int64)
    else:
        unique, setting = np.unique(both, axis=0, return_inverse=True)
    noise = unique[:, : size * size].reshape(-1, size, size)
    place = np.ascontiguousarray(unique[:, size * size :])
    return setting.reshape(-1).astype(np.int64), np.ascontiguousarray(noise), place


def _start(scan: Scan, given: float | None) -> float | None:
    """Return when a sweep began, None for a scan of one time."""
    if scan.moments is None:
        return None
    if given is not None:
        return given
    return float(scan.moments.min(initial=scan.time))


def _blur(sensor: Sensor, covariance: FloatArray, dim: int) -> FloatArray:
    """Return how far reports lie beside their objects, as `Coverage` has it."""
    kind = sensor.measurement
    noise = covariance.mean(axis=0) if len(covariance) else np.diag(sensor.sigmas(dim) ** 2)
    if isinstance(kind, ForeignKind):
        return blur_of_foreign(kind, noise, sensor.platform, dim)
    sigma = np.sqrt(np.diagonal(noise))
    if kind.is_position:
        return np.array([0.0, np.max(sigma[:2]), np.max(sigma[:2])])
    return np.array([sigma[1], sigma[0], 0.0] if kind.has_range else [sigma[0], 0.0, 0.0])


def coverage_of(sensor: Sensor, scan: Scan, start: float | None) -> Coverage:
    """Return where a scan looked: the sensor's field of view, as far as its beam went."""
    # The scan may say where the sensor was. The beam of a turning sensor began with the scan at
    # ``start`` [s], None for a whole turn ago.
    view = sensor.field_of_view
    coverage = everywhere() if view is None else view.coverage()
    platform, end = sensor.platform, scan.time
    if scan.platform is not None and scan.platform.size:
        platform = np.atleast_2d(scan.platform)[0]
        coverage = coverage._replace(position=platform[:2].copy())
    if sensor.rotation is None or start is None:
        return coverage
    if sensor.rotation.turned(end) - sensor.rotation.turned(start) >= 1.0 - 1e-9:
        return coverage
    return swept(coverage, platform[:2], sensor.rotation.sector(start, end))


def swept(coverage: Coverage, position: FloatArray, sector: tuple[float, float]) -> Coverage:
    """Return what a coverage shares with a sector about the sensor: first edge and width [rad]."""
    # Where a sector and the coverage's own overlap in two pieces, the larger counts. The edge is
    # the clockwise first.
    first, width = sector
    if coverage.everywhere:
        bounds = np.array([0.0, np.inf, first, width])
        centre = np.asarray(position, dtype=float).copy()
        return Coverage(False, centre, bounds, np.empty((0, 2)), np.zeros(3))
    own_first, own_width = coverage.bounds[2], coverage.bounds[3]
    ahead = (first - own_first) % (2 * np.pi)
    behind = (own_first - first) % (2 * np.pi)
    from_first = max(0.0, min(width, own_width - ahead))
    from_own = max(0.0, min(own_width, width - behind))
    bounds = coverage.bounds.copy()
    if own_width >= 2 * np.pi:
        # A whole turn begins nowhere: it must not cut the sector that passes its first edge.
        bounds[2:] = first, width
    elif from_first >= from_own:
        bounds[2:] = first, from_first
    else:
        bounds[2:] = own_first, from_own
    return coverage._replace(bounds=bounds)


def _reach(sensor: Sensor) -> float:
    """Return how far a sensor sees [m]."""
    view = sensor.field_of_view
    farthest = np.inf if view is None else view.max_range
    return float(farthest) if np.isfinite(farthest) else FARTHEST


def _log_begin(
    sensor: Sensor,
    measurement: FloatArray,
    sigma: FloatArray,
    platform: FloatArray,
    context: Context,
) -> FloatArray:
    """Return what each report adds to a new object's log evidence beyond the density [nats]."""
    kind, dim = sensor.measurement, context.dim
    if kind.is_bearing_only:
        return np.full(measurement.shape[0], math.log(0.5 * _reach(sensor) ** 2))
    if not kind.has_range or not kind.gives_position(dim):
        return np.zeros(measurement.shape[0])
    distance = np.maximum(measurement[:, 0], 1e-9)
    volume = np.log(distance)
    if dim == 3:
        volume = 2.0 * volume + np.log(np.maximum(np.cos(measurement[:, 2]), 1e-9))
    if kind.has_rate:
        # Against the velocities of which nothing is known.
        variance = context.motion.velocity_variance(dim) + sigma[:, -1] ** 2
        closing = measurement[:, -1] + _own_rate(measurement, platform, dim)
        volume -= 0.5 * (closing**2 / variance + np.log(2.0 * np.pi * variance))
    return np.asarray(volume)


def _own_rate(measurement: FloatArray, platform: FloatArray, dim: int) -> FloatArray:
    """Return how fast the sensor itself moves towards where each report points [m/s]."""
    upward = measurement[:, 2] if dim == 3 else np.zeros(measurement.shape[0])
    level = np.cos(upward)
    rate: FloatArray = (
        level * np.sin(measurement[:, 1]) * platform[:, 3]
        + level * np.cos(measurement[:, 1]) * platform[:, 4]
        + np.sin(upward) * platform[:, 5]
    )
    return rate
