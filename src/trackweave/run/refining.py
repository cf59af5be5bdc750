"""What a configuration leaves out, from the reports and from tracks made of them."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.config import Configuration
from trackweave.config.fill import Settings, fill, known_sigma, needs_estimates
from trackweave.config.sensing import ObservedSensor
from trackweave.domain.reports import ReportTable
from trackweave.estimation.axes import with_axes
from trackweave.estimation.clutter_places import with_clutter_places
from trackweave.estimation.directions import bearing_sensor, with_components
from trackweave.estimation.echoes import without_echoes
from trackweave.estimation.estimate import estimate
from trackweave.estimation.estimates import Estimates, SensorEstimate, digits
from trackweave.estimation.levels import with_levels
from trackweave.estimation.noise_places import with_noise_places
from trackweave.estimation.persistence import notes_on_persistence, with_persistence
from trackweave.estimation.plausibility import believable
from trackweave.estimation.rates import RateNoise, rate_noise
from trackweave.estimation.refine import Followed, Track, refined, stretch_of, sure_tracks
from trackweave.estimation.standing import with_seldom, with_standing
from trackweave.estimation.strengths import with_strengths
from trackweave.estimation.tails import with_tails
from trackweave.estimation.unexplained import unexplained, with_faster
from trackweave.models.rotation import Rotation
from trackweave.models.sensors import Sensor
from trackweave.run.batches import hearing_in
from trackweave.run.kept import Kept
from trackweave.run.record import Assigned
from trackweave.run.scans import (
    complete_scans,
    missing_turns,
    swept_together,
    turn_ends,
    with_turns,
)
from trackweave.run.wider_search import widely_searched
from trackweave.solvers import Auto
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.scan_preparation import USUAL_MISSES
from trackweave.trackers.window import Window

__all__ = ["Directions", "estimates_for"]

# Of so many rounds the later are run only while what an object can do changes by such a factor.
N_ROUNDS, MOST_ROUNDS, OTHER = 2, 4, 3.0
# Tracks are followed patiently, or pauses would never be seen to end, and turns be two tracks.
PATIENT_DETECTION, PATIENT_AMONG_OTHERS, PATIENT_MISSES = 0.85, 0.5, 15
# So much more do objects turn then, as long as reports tell what they do from look to look: less
# than this share of what would hide in their noise.
PATIENT_NOISE, HIDDEN_PART = 10.0, 0.03
# Some of what radars see is off by far, mostly the same objects', and beside others each sees
# nothing at times: or the tracks would leave out the very reports that tell.
PATIENT_TAILS, PATIENT_SCALE, PATIENT_PERSISTENCE, PATIENT_SHARE = 0.05, 10.0, 0.9, 0.1
# Where less than this share of reports is on sure tracks, objects may go farther.
SPARSE = 0.4
# Where nearly nothing is known, proofs of what is best take minutes and tell nothing more.
QUICK = Auto(evaluations=10_000, branches=0)
# Nor need decisions stay open for long in a sky, as they do in a crowd of people: it tells the
# same, and takes less time.
TURNING_DEPTH = 3
# The estimates must follow from the reports alone, whatever the seed of a run.
SEED = 1
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
    kept: Kept = field(default_factory=Kept)  # What attempts of one run share


def estimates_for(
    reports: ReportTable,
    configuration: Configuration,
    directions: Directions | None = None,
    scanning: Mapping[str, bool] | None = None,
    rotations: Mapping[str, Rotation] | None = None,
) -> Estimates | None:
    """Return estimates of what a configuration leaves out, None where there is nothing."""
    # First estimates come from reports that line up beyond chance. With them a stretch of the
    # recording is tracked, patiently; the tracks tell more, and better in a crowd. ``directions``
    # are the ranges and bearings that the positions came from or stand beside. Turns of the
    # ``rotations`` are scans.
    names = reports.sensors
    if directions is None and not needs_estimates(configuration, names):
        return None
    # The solver here is the usual one: whose options ``[search]`` holds, a preset may still say.
    configuration = configuration.changed(search={})
    turning = {name: each for name, each in (rotations or {}).items() if name in names}
    reports = replace(reports, scan=with_turns(reports, turning))
    reports, notes = without_echoes(reports)
    estimates = estimate(reports, known_sigma(configuration, names), scanning)
    sure = {
        "in_metres": reports.frame is not None or directions is not None,
        "is_speed_told": configuration.said("motion", "max_speed") is not None,
    }
    estimates = believable(replace(estimates, notes=(*notes, *estimates.notes)), reports, **sure)
    estimates = with_levels(estimates, reports)
    lone = all(each.scans is False for each in estimates.sensors.values())
    if directions is None and (lone or estimates.of_one_object):
        # Threads have told it all; whether tracks know better, ``run.likelier`` asks.
        return estimates
    at_rest = configuration.said("lifecycle", "at_rest") == "echoes"
    beams = {name: (each.period, each.phase, each.direction) for name, each in turning.items()}
    asked = configuration, beams, scanning
    arrays = reports.time, reports.sensor, reports.measurement
    known = None if directions is None else directions.kept.known(asked, arrays)
    if directions is not None and known is not None:
        return _directed(known[0], known[1], known[2], directions, at_rest=at_rest)
    stretch = stretch_of(reports)
    for number in range(1, MOST_ROUNDS + 1):
        before = estimates
        estimates, followed = _followed(estimates, stretch, configuration, turning, number)
        estimates = with_persistence(estimates, stretch, followed)
        estimates = refined(with_strengths(estimates, stretch, followed), stretch, followed)
        estimates = with_clutter_places(estimates, stretch, followed)
        if number == 1:
            estimates = with_faster(estimates, unexplained(estimates, stretch, followed))
        estimates = believable(estimates, reports, **sure)
        if directions is None:
            estimates = with_noise_places(estimates, stretch, followed)
            estimates = with_axes(estimates, stretch, followed)
        if number >= N_ROUNDS and not _is_other(before, estimates):
            break
    persistence = {name: configuration.sensor(name).get("clutter_persistence") for name in names}
    estimates = replace(
        estimates, notes=(*estimates.notes, *notes_on_persistence(estimates, persistence))
    )
    if directions is None:
        estimates = with_tails(estimates, stretch, followed)
        left = stretch if at_rest else unexplained(estimates, stretch, followed)
        return with_seldom(estimates, left, followed.looks, stretch, at_rest=at_rest)
    told = estimates, (reports, stretch), followed
    directions.kept.keep(asked, arrays, told)
    return _directed(*told, directions, at_rest=at_rest)


def _followed(
    estimates: Estimates,
    stretch: ReportTable,
    configuration: Configuration,
    rotations: Mapping[str, Rotation],
    number: int,
) -> tuple[Estimates, Followed]:
    """Return by what a stretch is tracked in a round, and what that gave."""
    settings = fill(configuration, _patient(estimates), stretch.sensors)
    followed = _follow(stretch, settings, rotations)
    sure = sum(track.rows.size for track in sure_tracks(estimates, stretch, followed))
    if number > 1 or rotations or sure > SPARSE * len(stretch):
        return estimates, followed
    found = widely_searched(estimates, stretch, configuration, is_tracked=sure > 0)
    if found is None:
        return estimates, followed
    return found, _follow(stretch, fill(configuration, found, stretch.sensors), rotations)


def _is_other(before: Estimates, after: Estimates) -> bool:
    """Tell whether objects, or false alarms, do something else than they were followed by."""
    if any(
        (each.clutter_persistence > 0) != (before.sensors[name].clutter_persistence > 0)
        for name, each in after.sensors.items()
    ):
        return True
    ratios = [after.max_speed / before.max_speed, after.process_noise / before.process_noise]
    return bool(np.abs(np.log(ratios)).max() > math.log(OTHER))


def _directed(
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


def _patient(estimates: Estimates) -> Estimates:
    """Return estimates by which objects are followed through turns that none has told of yet."""
    sensors = estimates.sensors.values()
    looks = sum(1.0 / each.scan_period for each in sensors if each.scan_period is not None)
    most = HIDDEN_PART * min(each.plane_sigma for each in sensors) ** 2 * looks**3
    known = estimates.process_noise
    return replace(estimates, process_noise=max(known, min(PATIENT_NOISE * known, most)))


def _turned(sensor: Sensor, rotation: Rotation | None) -> Sensor:
    """Return a sensor as what it sees is followed, where its beam turns."""
    if rotation is None:
        return sensor
    return replace(
        sensor,
        rotation=rotation,
        tail_share=PATIENT_TAILS,
        tail_scale=PATIENT_SCALE,
        tail_persistence=PATIENT_PERSISTENCE,
        hidden_share=PATIENT_SHARE,
    )


def _follow(
    reports: ReportTable, settings: Settings, rotations: Mapping[str, Rotation]
) -> Followed:
    """Track reports patiently; return the track of each, and when each sensor looked."""
    # Of several sensors, some may see what others never see.
    patient = PATIENT_DETECTION if len(settings.sensors) == 1 else PATIENT_AMONG_OTHERS
    sensors = [
        replace(
            sensor,
            detection_probability=min(sensor.detection_probability, patient),
        )
        for sensor in settings.sensors
    ]
    sensors = [_turned(each, rotations.get(each.name)) for each in sensors]
    periods = {sensor.name: sensor.scan_period for sensor in sensors}
    silent = hearing_in(sensors)
    scans = complete_scans(reports, periods, rotations, silent)
    counts = Counter(scan.sensor for scan in scans if scan.sensor not in silent) or {"": 1}
    misses = min(round(PATIENT_MISSES * sum(counts.values()) / min(counts.values())), MOST_MISSES)
    window = settings.window
    if rotations:
        window = replace(window, depth=min(window.depth, TURNING_DEPTH))
    tracker = MultiHypothesisTracker(
        motion=settings.motion,
        sensors=sensors,
        window=window,
        lifecycle=replace(settings.lifecycle, delete_after_misses=misses),
        limits=settings.growth,
        search=QUICK,
        estimate="best",
        max_ahead=None,
    )
    rng, assigned = np.random.default_rng(SEED), Assigned.nothing(len(reports))
    doubts: dict[int, bool] = {}
    for step in swept_together(scans, rotations):
        assigned.enter(tracker.step(step, rng=rng, tracks=False).final)
        doubts |= tracker.doubts
    assigned.enter(tracker.pending())
    assigned.drop_doubted(doubts)
    looks: dict[str, list[float]] = {name: [] for name in reports.sensors}
    for scan in scans:
        if scan.sensor not in rotations:
            looks[scan.sensor].append(scan.time)
    for index, name in enumerate(reports.sensors):
        rows = reports.sensor == index
        if name in rotations and np.any(rows):
            # A turn's scan counts as of its end, its reports as of their own times.
            turns = turn_ends(reports.time[rows], rotations[name])[1]
            ends, count = np.unique(turns, return_counts=True)
            looks[name] = sorted([*ends, *missing_turns(ends, count, rotations[name].period)])
    views = {each.name: each.field_of_view for each in sensors if each.field_of_view is not None}
    return Followed(
        assigned.track,
        {name: np.array(times) for name, times in looks.items()},
        views,
        is_wild=len(rotations) > 1,
    )
