"""What a configuration leaves out, estimated from the reports."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.chains import Chains, ball_volume, chains_of, detection_share
from trackweave.estimation.disagreement import disagreements
from trackweave.estimation.frames import Frames, frames_of
from trackweave.estimation.lone import LoneReports, judged, lone_reports
from trackweave.estimation.motion import reach
from trackweave.estimation.looking import Looking
from trackweave.estimation.noise import noise_of_chains
from trackweave.estimation.trees import tree_of
from trackweave.models.strength import StrengthModel

__all__ = ["Estimates", "SensorEstimate", "bounded", "covered_by", "digits", "estimate"]

# Before the data speak: a usual radar, trusted to ± 0.1.
USUAL_DETECTION, USUAL_SPREAD = 0.9, 0.1
DETECTION_RANGE = (0.5, 0.98)
# Process noise in units of σ²/T³, where tracks are too short to tell, and never less.
USUAL_PROCESS, LEAST_PROCESS = 1e-3, 3e-4
SURE_LENGTH = 8
FEWEST_IN_HULL = 10
# No lone report is worth more to a track [nats]: else one that chance puts into the gate of
# another's track outweighs all doubt.
WORTH = 10.0
# What the first of an object's reports costs more than one of nobody, at most [nats].
DEAR = 1.5
# What stands is told from what moves where, beside it, the silence of a slow one spreads so many
# standard deviations of a report, and each is this share of all; it drifts by this part of one in
# such a silence, and goes on as it does for so long [s].
WANDERED, SOME, DRIFTED, STAY = 3.0, 0.1, 0.25, 1800.0
# Slow pauses between an object's own reports that a window holds, and instants in any case.
PAUSES, DEPTHS = 1.5, (5, 60)
# With so many unrelated reports where a successor may be, false segments line up.
CROWDED = 1.0


@dataclass(frozen=True, slots=True)
class SensorEstimate:
    """What one sensor's reports tell of it.

    Parameters
    ----------
    scan_period
        Time from scan to scan [s]; None where it does not scan.
    sigma
        Standard deviation of a report along an axis [m]; or of each number of a report, as a
        tuple [m, rad, m/s].
    detection_probability
        Chance that a scan reports an object.
    clutter_density
        False alarms per m² (m³) and scan.
    covered
        Area [m²] or volume [m³] from which its reports come.
    n_objects
        Objects present at a time, on average.
    density
        Reports per m² (m³) and scan; 0 for unknown.
    disagreement
        By how much else it puts objects elsewhere than other sensors do, as a standard
        deviation along an axis that is part of ``sigma`` [m].
    strength
        What the strength of its reports tells of their origin; None for nothing.
    scans
        Whether it looks, so that its silence tells something; None where nothing tells. Of one
        that does not, detection and clutter are per second.
    """

    scan_period: float | None
    sigma: float | tuple[float, ...]
    detection_probability: float
    clutter_density: float
    covered: float
    n_objects: float
    density: float = 0.0
    disagreement: float = 0.0
    strength: StrengthModel | None = None
    scans: bool | None = None

    @property
    def plane_sigma(self) -> float:
        """Standard deviation along an axis [m]: sigma, or the first of its numbers."""
        return self.sigma[0] if isinstance(self.sigma, tuple) else self.sigma


@dataclass(frozen=True, slots=True)
class Estimates:
    """What the reports tell.

    Parameters
    ----------
    sensors
        Estimates by name of the sensor.
    process_noise
        Power spectral density of the acceleration along an axis [m²/s³].
    max_speed
        Greatest speed of an object [m/s].
    new_target_density
        Objects newly present per m² (m³) and scan.
    initial_target_density
        Objects present per m² (m³) at a time.
    delete_after_misses
        Misses in succession after which hardly any object comes back; None for unknown.
    max_scans
        Scans of all sensors that a window should hold; None for the usual number.
    depth
        Instants that a window should hold where no sensor looks; None for the usual number.
    period
        Time between rows of a track where no sensor looks [s]; None for every scan.
    together
        Within how long hardly any object reports twice where no sensor looks [s]; None for
        unknown.
    ways
        How objects move beside wandering at the process noise, with keys as in ``[motion.imm]``;
        None for no other way.
    doubts
        Why a sensor's estimates are doubtful, by its name; sensors without doubt are left out.
    remarks
        On what a value rests and how sure it is, by its key in a configuration file.
    notes
        Sentences on what was left out or not believed.
    """

    sensors: Mapping[str, SensorEstimate]
    process_noise: float
    max_speed: float
    new_target_density: float
    initial_target_density: float
    delete_after_misses: int | None = None
    max_scans: int | None = None
    depth: int | None = None
    period: float | None = None
    together: float | None = None
    ways: Mapping[str, Any] | None = None
    doubts: Mapping[str, str] = field(default_factory=dict)
    remarks: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class _Findings:
    """One sensor's estimate, and what its tracks tell of the objects."""

    sensor: SensorEstimate
    process_noise: float | None
    max_speed: float | None
    doubt: str | None
    times: float
    note: str | None
    pause: float | None = None
    quick_pause: float | None = None
    slow_pause: float | None = None
    ways: Mapping[str, Any] | None = None


def estimate(
    reports: ReportTable,
    sigma: Mapping[str, float] | None = None,
    scanning: Mapping[str, bool] | None = None,
) -> Estimates:
    """Return estimates of everything that a tracker needs to know and can learn from reports.

    Sensors are looked at one by one: how far apart successors lie, which reports line up over
    six scans beyond chance, and on these how noisy, how often seen and how fast. It is a start
    for data of which nothing else is known, and no replacement for a data sheet.

    Parameters
    ----------
    reports
        At least one report.
    sigma
        Standard deviations that are known, by name of the sensor [m].
    scanning
        Whether sensors look of which it is known, by name; the others are judged.

    Returns
    -------
    Finite, positive values, however odd the reports are.
    """
    known, scans = dict(sigma or {}), dict(scanning or {})
    findings = {
        name: _found(
            reports, index, known.get(name) or _reported_sigma(reports, index), scans.get(name)
        )
        for index, name in enumerate(reports.sensors)
        if np.any(reports.sensor == index)
    }
    with_speed = [found for found in findings.values() if found.max_speed is not None]
    speeds = [found.max_speed for found in with_speed if found.max_speed is not None]
    noises = [found.process_noise for found in findings.values() if found.process_noise]
    fallback = next(iter(findings.values())).sensor
    period = fallback.scan_period or 1.0
    present = [found.sensor.n_objects / found.sensor.covered for found in findings.values()]
    times = [found.times for found in findings.values()]
    max_speed = max(speeds) if speeds else 10 * fallback.plane_sigma / period
    sensors = {name: found.sensor for name, found in findings.items()}
    pauses = [found.pause for found in findings.values() if found.pause is not None]
    lasting = max(pauses) if len(pauses) == len(findings) else None
    slow = max((found.slow_pause or 0.0 for found in findings.values()), default=0.0)
    depth = None if lasting is None else _depth(reports.time, slow)
    quick = min((found.quick_pause or 0.0 for found in findings.values()), default=0.0)
    ways = next((found.ways for found in findings.values() if found.ways), None)
    return Estimates(
        sensors=_reconciled(sensors, reports, max_speed, known),
        process_noise=bounded(
            np.median(noises) if noises else 1e-2 * fallback.plane_sigma**2 / period**3
        ),
        max_speed=bounded(max_speed),
        new_target_density=bounded(float(np.median(np.divide(present, times))), 1e-30),
        initial_target_density=bounded(max(present), 1e-30),
        max_scans=depth,
        depth=depth,
        period=None if lasting is None else digits(lasting),
        together=None if lasting is None else quick,
        ways=None if lasting is None else ways,
        doubts={name: found.doubt for name, found in findings.items() if found.doubt},
        notes=tuple(f"sensor {name}: {f.note}" for name, f in findings.items() if f.note),
    )


def _depth(time: FloatArray, pause: float) -> int:
    """Return how many instants a window needs for some reports of each object."""
    instants = np.unique(time)
    usual = float(np.ptp(instants)) / max(instants.size - 1, 1)
    return int(np.clip(np.ceil(PAUSES * pause / max(usual, 1e-9)), *DEPTHS))


def _reconciled(
    sensors: dict[str, SensorEstimate],
    reports: ReportTable,
    speed: float,
    known: Mapping[str, float],
) -> dict[str, SensorEstimate]:
    """Return sensors whose noise lets them agree: each may mark another part of an object."""
    if len(sensors) < 2:
        return sensors
    extra: dict[str, list[float]] = {}
    for pair, square in disagreements(reports, speed).items():
        first, second = (reports.sensors[index] for index in pair)
        unexplained = square - sensors[first].plane_sigma ** 2 - sensors[second].plane_sigma ** 2
        for name in (first, second):
            extra.setdefault(name, []).append(max(unexplained, 0.0) / 2)
    for name, variances in extra.items():
        if name not in known:
            more = float(np.sqrt(np.mean(variances)))
            sigma = bounded(float(np.hypot(sensors[name].plane_sigma, more)), 1e-6)
            sensors[name] = replace(sensors[name], sigma=sigma, disagreement=more)
    return sensors


def bounded(value: float, least: float = 1e-9) -> float:
    """Return a value that a configuration takes: the data's scale may be anything.

    Parameters
    ----------
    value
        Any number.
    least
        Least value that makes sense. Must be positive.

    Returns
    -------
    A number between, rounded.
    """
    return digits(float(np.clip(value, least, 1e8)))


def digits(value: float, count: int = 4) -> float:
    """Return a value without digits that no estimate can be sure of.

    Parameters
    ----------
    value
        Any finite number.
    count
        How many significant digits stay.

    Returns
    -------
    The rounded number.
    """
    return float(f"{value:.{count}g}")


def _found(
    reports: ReportTable, index: int, sigma: float | None, scans: bool | None
) -> _Findings:
    """Return what one sensor's reports tell, whether it looks or not."""
    if scans is True:
        return _look_at(reports, index, sigma)
    seen, threads, rows = judged(reports, index)
    scans = seen.scans if scans is None else scans
    if scans is not False:
        found = _look_at(reports, index, sigma)
        return replace(found, sensor=replace(found.sensor, scans=scans))
    position = reports.measurement[rows]
    lone = lone_reports(reports.time[rows], position, threads, sigma)
    return _of_lone(lone, seen, position, sigma)


def _of_lone(
    lone: LoneReports, seen: Looking, position: FloatArray, sigma: float | None
) -> _Findings:
    """Return what the reports of a sensor tell that does not look; its second is its scan."""
    typical = lone.sigma or sigma or _spacing(position) * 0.01
    covered = covered_by(position, typical)
    detection = float(np.clip(1 - np.exp(-lone.rate), 1e-4, 0.98))
    worth = detection / float(ball_volume(2.0 * typical, position.shape[1]))
    clutter = max(lone.false_rate / covered, worth * np.exp(-WORTH))
    sensor = SensorEstimate(
        scan_period=None,
        sigma=bounded(typical, 1e-6),
        detection_probability=digits(detection),
        clutter_density=digits(float(np.clip(clutter, 1e-30, 1e10))),
        covered=covered,
        n_objects=lone.n_objects,
        scans=False,
    )
    doubt = f"; {100 * seen.doubt:.0f} % of what tells says otherwise" if seen.doubt > 0 else ""
    note = (
        f"taken for one that does not scan: {seen.n_objects} objects report by themselves, every "
        f"{lone.pause:.3g} s as a median, so that no silence counts as a miss{doubt}; if it "
        "looks, give scans = true or scan_period"
    )
    # A report that none explains is as likely a new one's as nobody's.
    coming = max(lone.new_rate / covered, worth * np.exp(-WORTH - DEAR))
    times = lone.n_objects / covered / coming
    process = lone.process_noise
    if process is not None:
        process = max(process, LEAST_PROCESS * typical**2 / lone.pause**3)
    ways, pauses = _ways(lone, typical, process), (lone.quick_pause, lone.slow_pause)
    return _Findings(sensor, process, lone.max_speed, None, times, note, lone.pause, *pauses, ways)


def _ways(lone: LoneReports, sigma: float, process: float | None) -> Mapping[str, Any] | None:
    """Return two ways to move where those that stand would be lost between two reports.

    With the noise of those that move, where one that is silent for minutes lies could be anywhere
    in the harbour, and its neighbours at the quay in its place.
    """
    wandered = np.sqrt((process or 0.0) * lone.slow_pause**3 / 3)
    if wandered < WANDERED * sigma or not SOME <= lone.standing <= 1.0 - SOME:
        return None
    drift = digits((DRIFTED * sigma) ** 2 / lone.slow_pause)
    return {
        "models": ["standing", "moving"],
        "sojourn_time": [STAY, STAY],
        "standing": {"model": "random-walk", "process_noise": drift},
        "moving": {"model": "constant-velocity"},
    }


def _look_at(reports: ReportTable, index: int, sigma: float | None) -> _Findings:
    """Return what the reports of a sensor tell that looks."""
    rows = reports.sensor == index
    position = reports.measurement[rows]
    blocks, period = frames_of(reports, index)
    n_scans = sum(len(block) for block in blocks)
    per_scan = sum(p.shape[0] for block in blocks for p in block.position) / max(n_scans, 1)
    typical = sigma or _spacing(position) * 0.01
    covered = covered_by(position, typical)
    share = blocks[0].share if blocks else 1.0
    density = per_scan / (covered * share)
    stands_out = reach(blocks)
    chains, seen = None, None
    if stands_out is not None:
        chains = chains_of(blocks, stands_out[0], density)
        seen = detection_share(blocks, stands_out[0], density)
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
        sigma=bounded(sigma or typical, 1e-6),
        detection_probability=digits(detection),
        clutter_density=digits(float(np.clip(clutter, 1e-30, 1e10))),
        covered=covered,
        n_objects=n_objects / share,
        density=density,
    )
    return _Findings(
        found,
        process,
        _max_speed(chains, stands_out),
        _doubt(blocks, stands_out, chains, density),
        # Of those present, each began at some time of the recording, or of the last fifty scans.
        min(max(n_scans, 10), 50),
        _note_on_area(position, covered),
    )


def _note_on_area(position: FloatArray, covered: float) -> str | None:
    """Return what is taken for the area of many reports that span none."""
    if position.shape[0] <= FEWEST_IN_HULL or _hull(position) is not None:
        return None
    unit = "m²" if position.shape[1] == 2 else "m³"
    return (
        "its reports lie on a line or at one place, so that no area tells how dense they are; "
        f"{covered:.3g} {unit} about them stand in"
    )


def _doubt(
    blocks: list[Frames],
    stands_out: tuple[float, float] | None,
    chains: Chains | None,
    density: float,
) -> str | None:
    """Return why the estimates are doubtful, None where they are not."""
    if stands_out is None:
        return "no report stands out as another's successor; usual values stand in"
    if chains is None:
        return "no reports line up over several scans beyond chance; usual values stand in"
    interval = float(np.median([step for frames in blocks for step in np.diff(frames.time)]))
    dim = blocks[0].position[0].shape[1]
    crowd = density * float(ball_volume(stands_out[0] * interval, dim))
    if crowd > CROWDED:
        return (
            f"a crowd, in which {crowd:.2g} unrelated reports lie where an object's next may be, "
            "so that noise and detection probability come out too low"
        )
    return None


def _noise(
    chains: Chains, density: float, sigmas: tuple[float | None, float], period: float | None
) -> tuple[float, float]:
    """Return sigma and process noise from sure tracks, kept to what such tracks can tell."""
    sigma, typical = sigmas
    # Reports without any noise still get some, or no filter could work with them.
    start = max(float(np.sqrt(np.median(chains.residual))), 0.01 * typical, 1e-6)
    known = sigma is not None
    sigma, process = noise_of_chains(
        chains.time, chains.position, sigma or start, density, fixed=known
    )
    unit = sigma**2 / (period or float(np.nanmedian(np.diff(chains.time, axis=1)))) ** 3
    lengths = np.isfinite(chains.position[:, :, 0]).sum(axis=1)
    if np.median(lengths) < SURE_LENGTH:
        process = USUAL_PROCESS * unit
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
        return float(1.25 * np.quantile(chains.speed, 0.9)) or None
    return None if stands_out is None else stands_out[0]


def _reported_sigma(reports: ReportTable, index: int) -> float | None:
    """Return the usual noise that a sensor's reports carry themselves."""
    carried = reports.sigma[reports.sensor == index]
    carried = carried[np.isfinite(carried)]
    return float(np.median(carried)) if carried.size else None


def _spacing(position: FloatArray) -> float:
    """Return the usual distance from a report to its nearest neighbour elsewhere [m]."""
    places = np.unique(position[:: max(position.shape[0] // 5000, 1)], axis=0)
    if places.shape[0] < 2:
        return 100.0
    distance, _ = tree_of(places).query(places, k=2)
    return max(float(np.median(distance[:, 1])), 1e-4)


def covered_by(position: FloatArray, sigma: float) -> float:
    """Return the area or volume of the reports' hull, never zero.

    Parameters
    ----------
    position
        Where the reports are [m], shape (reports, dim), at least one.
    sigma
        Their usual noise [m].

    Returns
    -------
    The area or volume [m², m³].
    """
    dim = position.shape[1]
    # Reports in one place or on a line still come from a surrounding as wide as their noise.
    sides = np.maximum(np.ptp(position, axis=0), 6 * sigma)
    box = float(np.prod(sides))
    hull = _hull(position) if position.shape[0] > FEWEST_IN_HULL else None
    # The outermost of n reports lie about 1/n of a side within the edges.
    margin = (1 + 2 / position.shape[0]) ** dim
    return float(np.clip(max(box if hull is None else hull, 0.1 * box) * margin, 1e-9, 1e24))


def _hull(position: FloatArray) -> float | None:
    """Return the area or volume of the reports' hull, None where they span none."""
    from scipy.spatial import ConvexHull, QhullError

    places = np.unique(position, axis=0)
    if places.shape[0] <= position.shape[1]:
        return None
    try:
        return float(ConvexHull(places).volume)
    except QhullError:
        return None
