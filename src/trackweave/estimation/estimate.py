"""What a configuration leaves out, estimated from the reports."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.chains import (
    Chains,
    chains_of,
    detection_share,
    doubt_about,
    speed_of_few,
)
from trackweave.estimation.covering import along_line, covered_by, note_on_area, spacing_of
from trackweave.estimation.disagreement import reconciled
from trackweave.estimation.estimates import Estimates, SensorEstimate, bounded, digits, positive
from trackweave.estimation.frames import frames_of, scan_period, usual_gap
from trackweave.estimation.identities import identity_error, note_on_identities
from trackweave.estimation.lone import LoneReports, judged, lone_reports, middle_of
from trackweave.estimation.lone_values import LoneValues, note_on_lone, rhythm_of
from trackweave.estimation.motion import reach
from trackweave.estimation.noise import noise_of_chains
from trackweave.estimation.receivers import (
    as_one,
    note_on_receivers,
    receivers_in,
    shared,
)
from trackweave.estimation.renaming import renaming_share
from trackweave.estimation.single_object import single_object
from trackweave.estimation.threads import Threads

__all__ = ["WIDER", "estimate"]

# Before the data speak: a usual radar, trusted to ± 0.1.
USUAL_DETECTION, USUAL_SPREAD = 0.9, 0.1
DETECTION_RANGE = (0.5, 0.98)
# Process noise is never less, in units of σ²/T³.
LEAST_PROCESS = 3e-4
# Threads of anonymous lone reports leave out what lies far off, so that none tells how much does:
# measured on tags behind racks, and on ships with a wild position in three hundred.
WILD_SHARE, WILD_SCALE = 0.05, 8.0
# Above the greatest speed that is seen.
WIDER = 1.25
# Without a period misses and lives are counted in it [s].
SECOND = 1.0
# Of what comes alone in so many of its looks nobody knows when it looks.
ALONE = 0.9
UNTOLD = (
    "nothing tells whose its reports are, nor when it looks, so that no silence of it counts as a "
    "miss, and its noise is taken to be that of the others, {:.3g} m; better give its sigma, and "
    "scans and scan_period if it looks"
)
# Between two reports of an object that rests there is at least so much time [s]; it seems to move
# by so many standard deviations in it, and no other came in so many times as long.
SHORTEST, RUSHING, NEVER = 1e-6, 3.0, 10.0
# So many times as exact as it lies about its way nothing is.
COLLAPSED = 5.0


@dataclass(frozen=True, slots=True)
class _Findings:
    """One sensor's estimate, and what its tracks tell of the objects."""

    sensor: SensorEstimate
    process_noise: float | None
    max_speed: float | None
    speed_of_few: float
    doubt: str | None
    times: float
    note: str | None
    lone: LoneReports | None = None
    ways: Mapping[str, Any] | None = None
    of_one_object: bool = False  # Whether all reports are of one object


def estimate(
    reports: ReportTable,
    sigma: Mapping[str, float] | None = None,
    scanning: Mapping[str, bool] | None = None,
    threads: Mapping[str, Threads] | None = None,
) -> Estimates:
    """Return estimates of everything that a tracker needs to know and can learn from reports."""
    # Sensors are looked at one by one: how far apart successors lie, which reports line up over
    # six scans beyond chance, and on these how noisy, how often seen and how fast. It is a start
    # for data of which nothing else is known, and no replacement for a data sheet. Values are
    # finite and positive, however odd the reports are. ``sigma`` is what is known by name of the
    # sensor [m], ``scanning`` whether sensors look, where it is known, and ``threads`` which
    # reports of those that do not are of one object.
    known, scans, threaded = dict(sigma or {}), dict(scanning or {}), dict(threads or {})
    receivers = receivers_in(reports, {*known, *scans, *threaded})
    apart, reports = reports, as_one(reports, receivers)
    scans |= dict.fromkeys(receivers, False)
    findings = {
        name: _found(
            reports,
            (index, threaded.get(name)),
            known.get(name) or _reported_sigma(reports, index),
            scans.get(name),
        )
        for index, name in enumerate(reports.sensors)
        if np.any(reports.sensor == index)
    }
    for name in _untold(findings, reports, scans):
        usual = known.get(name) or _usual_sigma(findings)
        found = _found(reports, (reports.sensors.index(name), None), usual, False)
        findings[name] = replace(found, note=UNTOLD.format(usual))
    with_speed = [found for found in findings.values() if found.max_speed is not None]
    speeds = [found.max_speed for found in with_speed if found.max_speed is not None]
    noises = [found.process_noise for found in findings.values() if found.process_noise]
    fallback = next(iter(findings.values())).sensor
    period = fallback.scan_period or 1.0
    present = [found.sensor.n_objects / found.sensor.covered for found in findings.values()]
    times = [found.times for found in findings.values()]
    few = max(found.speed_of_few for found in findings.values())
    max_speed = max(speeds) if speeds else 10 * fallback.plane_sigma / period
    max_speed = max(max_speed, WIDER * few)
    sensors = {name: found.sensor for name, found in findings.items()}
    sensors = reconciled(sensors, reports, max_speed, known)
    if receivers:
        sensors |= shared(sensors[receivers[0]], apart, receivers)
    lone = [(found.lone, found.ways) for found in findings.values() if found.lone is not None]
    only_lone = rhythm_of(lone, reports.time) if len(lone) == len(findings) else {}
    return Estimates(
        sensors=sensors,
        process_noise=positive(
            np.median(noises) if noises else 1e-2 * fallback.plane_sigma**2 / period**3
        ),
        max_speed=bounded(max_speed),
        new_target_density=positive(float(np.median(np.divide(present, times)))),
        initial_target_density=positive(max(present)),
        doubts={name: found.doubt for name, found in findings.items() if found.doubt},
        speed_of_few=few,
        of_one_object=all(found.of_one_object for found in findings.values()),
        notes=(
            *note_on_receivers(receivers),
            *(
                f"sensor {name}: {note}"
                for name, found in findings.items()
                if name not in receivers
                for note in (found.note, note_on_identities(found.sensor.identity_error))
                if note
            ),
        ),
        **only_lone,
    )


def _untold(
    findings: Mapping[str, _Findings], reports: ReportTable, scans: Mapping[str, bool]
) -> list[str]:
    """Return the sensors of which nothing is told, beside others, and each report comes alone."""
    found = []
    for name, each in findings.items():
        looks = reports.look[reports.sensor == reports.sensors.index(name)]
        is_alone = np.unique(looks).size >= ALONE * looks.size
        if each.max_speed is None and is_alone and name not in scans:
            found.append(name)
    return found if len(found) < len(findings) else []


def _usual_sigma(findings: Mapping[str, _Findings]) -> float:
    """Return the median noise of the sensors of which something is told [m]."""
    told = [each.sensor.plane_sigma for each in findings.values() if each.max_speed is not None]
    return float(np.median(told))


def _found(
    reports: ReportTable,
    sensor: tuple[int, Threads | None],
    sigma: float | None,
    scans: bool | None,
) -> _Findings:
    """Return what one sensor's reports tell, whether it looks or not."""
    found = _kinematic(reports, sensor, sigma, scans)
    error = identity_error(reports, sensor[0])
    if error is None:
        return found
    error += renaming_share(reports, sensor[0])
    return replace(found, sensor=replace(found.sensor, identity_error=digits(error)))


def _kinematic(
    reports: ReportTable,
    sensor: tuple[int, Threads | None],
    sigma: float | None,
    scans: bool | None,
) -> _Findings:
    """Return what a sensor's reports tell by when and where they are."""
    # ``sensor`` is its number, and its threads where they are known.
    index, known = sensor
    found = None if known is not None else _of_single_object(reports, index, sigma, scans)
    if found is not None:
        return found
    if scans is True:
        return _in_scans(_look_at(reports, index, sigma), reports, index)
    seen, threads, rows = judged(reports, index, known)
    is_told = scans is not None
    if scans is None:
        scans = seen.scans if known is None else False
    if scans is not False:
        found = _look_at(reports, index, sigma)
        found = replace(found, sensor=replace(found.sensor, scans=scans))
        return _in_scans(found, reports, index) if scans else found
    position = reports.measurement[rows]
    own = reports.sigma[rows, : reports.dim]
    lone = lone_reports(reports.time[rows], position, threads, sigma, own)
    note = note_on_lone(lone, seen, is_told=is_told)
    found = _of_lone(lone, note, position, sigma)
    share, scale = (WILD_SHARE, WILD_SCALE) if not threads.is_whole else (lone.tail or (0.0, 1.0))
    wild = replace(found.sensor, tail_share=digits(share, 3), tail_scale=digits(scale, 3))
    return replace(found, sensor=wild)


def _in_scans(found: _Findings, reports: ReportTable, index: int) -> _Findings:
    """Return what a sensor tells that looks, now and then where it has no period."""
    # Passes of a satellite are hours apart, never the same number of them: misses and lives are
    # counted by its scans all the same. Seconds serve those that look more often.
    gap = usual_gap(reports, index)
    if found.sensor.scan_period is not None or gap <= SECOND:
        return found
    return replace(found, sensor=replace(found.sensor, scan_period=digits(gap)))


def _of_lone(lone: LoneReports, note: str, position: FloatArray, sigma: float | None) -> _Findings:
    """Return what a sensor's reports tell that does not look; its second is its scan."""
    typical = lone.sigma or sigma or spacing_of(position) * 0.01
    covered = covered_by(position, typical)
    values = LoneValues.of(lone, typical, covered, position.shape[1])
    sensor = SensorEstimate(
        scan_period=None,
        sigma=bounded(typical, 1e-9),
        detection_probability=digits(values.detection),
        clutter_density=positive(values.clutter),
        covered=covered,
        n_objects=lone.n_objects,
        scans=False,
    )
    times = lone.n_objects / covered / values.coming
    return _Findings(
        sensor, values.process, lone.max_speed, 0.0, None, times, note, lone, values.ways
    )


def _of_single_object(
    reports: ReportTable, index: int, sigma: float | None, scans: bool | None
) -> _Findings | None:
    """Return what a sensor's reports tell of a single object, None where they are of others."""
    rows = middle_of(reports, index)
    time, position = reports.time[rows], reports.measurement[rows]
    single = single_object(time, position)
    if single is None:
        return None
    if scans is False:
        # It reports itself whenever it likes.
        thread = Threads([np.flatnonzero(single.own)], rows.size)
        heard = _kinematic(reports, (index, thread), sigma, False)
        if sigma is None and COLLAPSED * heard.sensor.plane_sigma < single.sigma:
            # A dozen reports may be explained as well by no noise and a motion that is all noise.
            heard = _kinematic(reports, (index, thread), single.sigma, False)
        return replace(heard, of_one_object=True)
    period = scan_period(np.unique(time))
    looks = time.size if period is None else max(round(float(np.ptp(time)) / period) + 1, 1)
    known = sigma or single.sigma
    covered = covered_by(position, known)
    own = int(np.count_nonzero(single.own))
    share = min(own / looks, 1.0)
    detection = _detection((share, float(np.sqrt(share * (1.0 - share) / looks))))
    found = SensorEstimate(
        scan_period=None if period is None else digits(period, 7),
        sigma=bounded(known, 1e-9),
        detection_probability=digits(detection),
        clutter_density=positive(max(rows.size - own, 0.5) / looks / covered),
        covered=covered,
        n_objects=1.0,
        density=rows.size / looks / covered,
        # Or a lone report would tell nothing of a second object that is not there.
        scans=True,
    )
    wait = max(float(np.median(np.diff(time))), SHORTEST)
    process = LEAST_PROCESS * known**2 / wait**3
    speed = max(RUSHING * known / wait, WIDER * single.speed)
    told = _Findings(found, process, speed, 0.0, None, NEVER * looks, None, of_one_object=True)
    return _in_scans(told, reports, index)


def _look_at(reports: ReportTable, index: int, sigma: float | None) -> _Findings:
    """Return what the reports of a sensor tell that looks."""
    rows = reports.sensor == index
    position = reports.measurement[rows]
    line = along_line(position)
    if line is not None:
        along = replace(reports, measurement=(reports.measurement @ line)[:, np.newaxis])
        return _on_line(along, index, sigma, position)
    blocks, period = frames_of(reports, index)
    n_scans = sum(len(block) for block in blocks)
    per_scan = sum(p.shape[0] for block in blocks for p in block.position) / max(n_scans, 1)
    typical = sigma or spacing_of(position) * 0.01
    covered = covered_by(position, typical)
    share = blocks[0].share if blocks else 1.0
    density = per_scan / (covered * share)
    stands_out = reach(blocks)
    chains, seen, few = None, None, 0.0
    if stands_out is not None:
        chains = chains_of(blocks, stands_out[0], density)
        seen = detection_share(blocks, stands_out[0], density)
        few = speed_of_few(blocks, stands_out[0], density) or 0.0
    process = None
    if chains is not None:
        sigma, process = _noise(chains, density, (sigma, typical), period)
    detection = _detection(seen)
    n_objects = min(stands_out[1] / detection**2 if stands_out else 1.0, per_scan / detection)
    n_objects = max(n_objects, 0.1)
    floor = max(0.005 * per_scan, 0.5 / max(n_scans, 1))
    clutter = max(per_scan - n_objects * detection, floor) / (covered * share)
    found = SensorEstimate(
        scan_period=None if period is None else digits(period, 7),
        sigma=bounded(sigma or typical, 1e-9),
        detection_probability=digits(detection),
        clutter_density=positive(clutter),
        covered=covered,
        n_objects=n_objects / share,
        density=density,
    )
    return _Findings(
        found,
        process,
        _max_speed(chains, stands_out),
        few,
        # An object's own report is none of a stranger's.
        doubt_about(blocks, stands_out, chains, max(per_scan - 1.0, 0.0) / (covered * share)),
        # Of those present, each began at some time of the recording, or of the last fifty scans.
        min(max(n_scans, 10), 50),
        note_on_area(position, covered),
    )


def _on_line(
    reports: ReportTable, index: int, sigma: float | None, position: FloatArray
) -> _Findings:
    """Return what the reports of a sensor tell that lie on a line, from places along it."""
    found = _look_at(reports, index, sigma)
    sensor = found.sensor
    # The surrounding of a line is as wide as the noise.
    wide = covered_by(position, sensor.plane_sigma) / sensor.covered
    return replace(
        found,
        sensor=replace(
            sensor,
            covered=sensor.covered * wide,
            clutter_density=positive(sensor.clutter_density / wide),
            density=sensor.density / wide,
        ),
        note=note_on_area(position, sensor.covered * wide),
    )


def _noise(
    chains: Chains, density: float, sigmas: tuple[float | None, float], period: float | None
) -> tuple[float, float]:
    """Return sigma and process noise from sure tracks, kept to what such tracks can tell."""
    sigma, typical = sigmas
    # Reports without any noise still get some, or no filter could work with them.
    start = max(float(np.sqrt(np.median(chains.residual))), 0.01 * typical, 1e-9)
    known = sigma is not None
    sigma, process = noise_of_chains(
        chains.time, chains.position, sigma or start, density, fixed=known
    )
    unit = sigma**2 / (period or float(np.nanmedian(np.diff(chains.time, axis=1)))) ** 3
    return sigma, max(process, LEAST_PROCESS * unit)


def _detection(seen: tuple[float, float] | None) -> float:
    """Return the probability of detection, drawn to the usual one as far as the data are few."""
    if seen is None:
        return USUAL_DETECTION
    share, error = seen
    weight = USUAL_SPREAD**2 / (USUAL_SPREAD**2 + error**2 + 0.03**2)
    return float(np.clip(weight * share + (1 - weight) * USUAL_DETECTION, *DETECTION_RANGE))


def _max_speed(chains: Chains | None, stands_out: tuple[float, float] | None) -> float | None:
    """Return a speed that hardly any object exceeds."""
    if chains is not None:
        # The fastest tenth holds most of the segments that are none.
        return float(WIDER * np.quantile(chains.speed, 0.9)) or None
    return None if stands_out is None else stands_out[0]


def _reported_sigma(reports: ReportTable, index: int) -> float | None:
    """Return the usual noise that a sensor's reports carry themselves."""
    carried = reports.sigma[reports.sensor == index]
    carried = carried[np.isfinite(carried)]
    return float(np.median(carried)) if carried.size else None
