"""What a configuration leaves out, from the reports and from tracks made of them."""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from trackweave.config import Configuration
from trackweave.config.fill import Settings, fill, known_sigma, needs_estimates
from trackweave.domain.reports import ReportTable
from trackweave.estimation.axes import with_axes
from trackweave.estimation.clutter_places import with_clutter_places
from trackweave.estimation.echoes import without_echoes
from trackweave.estimation.estimate import estimate
from trackweave.estimation.estimates import Estimates
from trackweave.estimation.levels import with_levels
from trackweave.estimation.noise_places import with_noise_places
from trackweave.estimation.persistence import notes_on_persistence, with_persistence
from trackweave.estimation.plausibility import believable, without_stale
from trackweave.estimation.refine import Followed, refined, stretch_of, sure_tracks
from trackweave.estimation.standing import with_seldom
from trackweave.estimation.strengths import with_strengths
from trackweave.estimation.tails import with_tails
from trackweave.estimation.unexplained import unexplained, with_faster
from trackweave.models.rotation import Rotation
from trackweave.models.sensors import Sensor
from trackweave.run.batches import hearing_in
from trackweave.run.directed import MOST_MISSES, Directions, directed
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

__all__ = ["Looking", "estimates_for"]

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


@dataclass(frozen=True, slots=True, eq=False)
class Looking:
    """What is known of how sensors look, by name."""

    scanning: Mapping[str, bool] = field(default_factory=dict)  # Whether they do at all
    rotations: Mapping[str, Rotation] = field(default_factory=dict)  # Of beams that turn


def estimates_for(
    reports: ReportTable,
    configuration: Configuration,
    directions: Directions | None = None,
    looking: Looking | None = None,
    kept: Kept | None = None,
) -> Estimates | None:
    """Return estimates of what a configuration leaves out, None where there is nothing."""
    # First estimates come from reports that line up beyond chance. With them a stretch of the
    # recording is tracked, patiently; the tracks tell more, and better in a crowd. ``directions``
    # are the ranges and bearings that the positions came from or stand beside. Turns of beams are
    # scans. ``kept`` is what attempts of one run share.
    names = reports.sensors
    if directions is None and not needs_estimates(configuration, names):
        return None
    # The solver here is the usual one: whose options ``[search]`` holds, a preset may still say.
    configuration = configuration.changed(search={})
    looking, kept = looking or Looking(), kept or Kept()
    turning = {name: each for name, each in looking.rotations.items() if name in names}
    reports = replace(reports, scan=with_turns(reports, turning))
    reports, notes = without_echoes(reports)
    estimates = _first(reports, known_sigma(configuration, names), looking, kept)
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
    asked = configuration, beams, looking.scanning
    arrays = reports.time, reports.sensor, reports.measurement
    if directions is not None and (known := kept.known(asked, arrays)) is not None:
        return directed(known[0], known[1], known[2], directions, at_rest=at_rest)
    stretch, first = stretch_of(reports), estimates
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
    more = notes_on_persistence(
        estimates,
        {name: configuration.sensor(name).get("clutter_persistence") for name in names},
    )
    estimates = without_stale(first, replace(estimates, notes=(*estimates.notes, *more)))
    if directions is None:
        estimates = with_tails(estimates, stretch, followed)
        left = stretch if at_rest else unexplained(estimates, stretch, followed)
        return with_seldom(estimates, left, followed.looks, stretch, at_rest=at_rest)
    told = estimates, (reports, stretch), followed
    kept.keep(asked, arrays, told)
    return directed(*told, directions, at_rest=at_rest)


def _first(
    reports: ReportTable, sigma: Mapping[str, float], looking: Looking, kept: Kept
) -> Estimates:
    """Return what reports tell before any is tracked, which no doubt of motion changes."""
    asked = "first", sigma, looking.scanning
    arrays = reports.time, reports.sensor, reports.measurement, reports.look
    known: Estimates | None = kept.known(asked, arrays)
    if known is None:
        known = estimate(reports, sigma, looking.scanning)
        kept.keep(asked, arrays, known)
    return known


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
