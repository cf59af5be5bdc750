"""What tracks that were made of a stretch of the reports tell."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.chains import local_density
from trackweave.estimation.estimate import Estimates, SensorEstimate, bounded, digits
from trackweave.estimation.noise import calm_noise, noise_of_chains

__all__ = [
    "DETECTION_RANGE",
    "Followed",
    "Track",
    "refined",
    "stretch_of",
    "sure_tracks",
]

REFINED = ("motion.process_noise", "motion.max_speed", "lifecycle.new_target_density")
REFINED_OF_SENSOR = ("sigma", "detection_probability", "clutter_density", "strength")
MOST_REPORTS = 4000
MOST_REPORTS_PER_SCAN = 200
# A track of so many reports is beyond doubt.
SURE_HITS = 6
LASTING_HITS = 12
# … that one of its sensors saw at so much of the usual share of chances.
SEEN = 0.6
LEAST_CHAINS_REPORTS = 40
MOST_CHAINS = 80
LONGEST_CHAIN = 60
# What is believed beforehand of the chance of detection, as if seen so often.
USUAL_DETECTION, USUAL_CHANCES = 0.9, 10.0
DETECTION_RANGE = (0.3, 0.96)
PIECE = 5
# Misses after which tracks end: never fewer than the first, never more scans than the second.
LEAST_PATIENCE, MOST_PATIENCE = 5, 15
FEWEST_PAUSES = 5
# Pauses longer than this on average are more than chance.
BURSTS = 1.5
LEAST_BEARABLE = 0.75
RETURNED = 0.95
WHOLE_PLANE = 0.7
# How much denser than on average false alarms may be where they gather.
MOST_GATHERED = 30.0
FEWEST_LOOKS, EARLY_LOOKS = 10, 4


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """What tracking a stretch gave.

    Parameters
    ----------
    track
        Track of each report, -1 for none, shape (reports,).
    looks
        When each sensor scanned [s], ascending, by its name; with or without reports.
    """

    track: IntArray
    looks: Mapping[str, FloatArray]


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """A track that is beyond doubt.

    Parameters
    ----------
    rows
        Rows of its reports, by time.
    begin, end
        Times of the first and the last [s].
    """

    rows: IntArray
    begin: float
    end: float


def stretch_of(reports: ReportTable) -> ReportTable:
    """Return a part of the reports that is quick to track and tells as much as the whole.

    Parameters
    ----------
    reports
        At least one report.

    Returns
    -------
    Reports of a middle part of the plane where it is crowded, and of a middle part of the time.
    """
    keep = np.ones(len(reports), dtype=bool)
    n_moments = np.unique(np.stack([reports.time, reports.sensor]), axis=1).shape[1]
    if len(reports) <= MOST_REPORTS:
        return reports
    share = MOST_REPORTS_PER_SCAN * n_moments / len(reports)
    if share < 1 and not reports.kinds:
        centre = np.median(reports.measurement, axis=0)
        scale = np.ptp(reports.measurement, axis=0) + 1e-9
        distance = np.abs((reports.measurement - centre) / scale).max(axis=1)
        keep = distance <= np.quantile(distance, share)
    rows = np.flatnonzero(keep)
    skip = max(0, (rows.size - MOST_REPORTS) // 2)
    rows = rows[skip : skip + MOST_REPORTS]
    inside = (reports.time >= reports.time[rows[0]]) & (reports.time <= reports.time[rows[-1]])
    return reports.part(np.flatnonzero(keep & inside))


def refined(estimates: Estimates, reports: ReportTable, followed: Followed) -> Estimates:
    """Return estimates with what tracks tell in the place of what was guessed.

    Parameters
    ----------
    estimates
        What is known so far.
    reports
        The stretch that was tracked.
    followed
        Its tracks.

    Returns
    -------
    Estimates; where there is no sure track, as they were.
    """
    tracks = sure_tracks(estimates, reports, followed)
    if not tracks:
        return estimates
    sensors = dict(estimates.sensors)
    noises: list[float] = []
    for index, name in enumerate(reports.sensors):
        if name not in sensors or not np.any(reports.sensor == index):
            continue
        if sensors[name].scans is False:
            continue  # Told by threads, per second.
        sensors[name] = _detection(sensors[name], tracks, reports, followed, name)
        if name not in estimates.doubts:
            sensors[name] = _clutter(sensors[name], tracks, reports, index)
        found = _noise(sensors[name], tracks, reports, index)
        if found is not None:
            sigma = float(np.hypot(found[0], sensors[name].disagreement))
            sensors[name] = replace(sensors[name], sigma=bounded(sigma, 1e-6))
            noises.append(found[1])
    speed = _speed(tracks, reports)
    if noises:
        # Objects are the same for all sensors; what one sees besides is its own wandering.
        estimates = replace(estimates, process_noise=bounded(min(noises)))
    if speed is not None:
        estimates = replace(estimates, max_speed=bounded(speed))
    new, present = _coming(estimates, tracks, reports, followed)
    keys = [f"sensors.{name}.{key}" for name in sensors for key in REFINED_OF_SENSOR]
    said = f"from {len(tracks)} track{'' if len(tracks) == 1 else 's'}"
    return replace(
        estimates,
        remarks={**estimates.remarks, **dict.fromkeys([*REFINED, *keys], said)},
        sensors=sensors,
        delete_after_misses=_patience(tracks, reports, _of_scans(followed, estimates)),
        new_target_density=new,
        initial_target_density=present,
    )


def _of_scans(followed: Followed, estimates: Estimates) -> Followed:
    """Return the same with the looks alone of sensors that look."""
    known = estimates.sensors
    looks = {
        name: times
        for name, times in followed.looks.items()
        if name not in known or known[name].scans is not False
    }
    return replace(followed, looks=looks)


def sure_tracks(estimates: Estimates, reports: ReportTable, followed: Followed) -> list[Track]:
    """Return the tracks that are long and were seen about as often as objects are.

    Parameters
    ----------
    estimates
        What is known so far.
    reports
        The stretch that was tracked.
    followed
        Its tracks.

    Returns
    -------
    The tracks.
    """
    rows = np.flatnonzero(followed.track >= 0)
    number = followed.track[rows]
    rows = rows[np.lexsort((reports.time[rows], number))]
    groups = np.split(rows, np.flatnonzero(np.diff(followed.track[rows])) + 1)
    tracks = [
        Track(group, float(reports.time[group[0]]), float(reports.time[group[-1]]))
        for group in groups
        if group.size >= SURE_HITS
    ]
    return [
        track
        for track in tracks
        if _is_seen(track, estimates, reports, followed) and _is_strong(track, estimates, reports)
    ]


def _is_strong(track: Track, estimates: Estimates, reports: ReportTable) -> bool:
    """Tell whether a track's reports are more like those of objects than like false alarms."""
    if reports.strength is None:
        return True
    evidence = []
    for index in np.unique(reports.sensor[track.rows]):
        model = estimates.sensors[reports.sensors[index]].strength
        if model is not None:
            rows = track.rows[reports.sensor[track.rows] == index]
            evidence.append(model.evidence(reports.strength[rows]))
    return not evidence or float(np.concatenate(evidence).mean()) >= 0


def _is_seen(track: Track, estimates: Estimates, reports: ReportTable, followed: Followed) -> bool:
    """Tell whether one of a track's sensors saw it about as often as it sees objects."""
    for index in np.unique(reports.sensor[track.rows]):
        name = reports.sensors[index]
        time = reports.time[track.rows[reports.sensor[track.rows] == index]]
        if estimates.sensors[name].scans is False and time.size >= SURE_HITS:
            return True
        looks = np.searchsorted(followed.looks[name], [time[0], time[-1]])
        share = time.size / (looks[1] - looks[0] + 1)
        if time.size >= SURE_HITS - 2 and share >= SEEN * USUAL_DETECTION:
            return True
    return False


def _detection(
    sensor: SensorEstimate,
    tracks: list[Track],
    reports: ReportTable,
    followed: Followed,
    name: str,
) -> SensorEstimate:
    """Return a sensor with its chance of detection and its clutter as the tracks tell."""
    index = reports.sensors.index(name)
    looks = followed.looks[name]
    hits = chances = 0
    pauses: list[int] = []
    for track in tracks:
        # The first and the last report are why the track is there, and say nothing.
        first, last = np.searchsorted(looks, [track.begin, track.end])
        own = reports.time[track.rows[reports.sensor[track.rows] == index]]
        # A turn's scan counts as of its end, its reports as of their own times.
        seen = np.isin(np.arange(first + 1, last), np.searchsorted(looks, own))
        hits += int(np.count_nonzero(seen))
        chances += seen.size
        runs = np.diff(np.flatnonzero(np.r_[True, seen, True])) - 1
        pauses += runs[runs > 0].tolist()
    usual = USUAL_DETECTION * USUAL_CHANCES
    share = (hits + usual) / (chances + USUAL_CHANCES)
    share = min(share, _bearable(np.array(pauses), chances))
    return replace(sensor, detection_probability=digits(float(np.clip(share, *DETECTION_RANGE))))


def _bearable(pauses: IntArray, chances: int) -> float:
    """Return the chance of detection under which long pauses cost what they are worth.

    Misses that come one by one are rightly priced one by one. Where they come in rows, behind
    another object or over a horizon, the price of each must be lower, or tracks end in the row.

    Returns
    -------
    A probability; 1 where pauses are few or short.
    """
    if pauses.size < FEWEST_PAUSES or pauses.mean() < BURSTS:
        return 1.0
    long = float(np.quantile(pauses, 0.9))
    begin, stay = pauses.size / max(chances, 1), 1 - 1 / float(pauses.mean())
    cost = (-math.log(begin) - (long - 1) * math.log(stay)) / long
    return max(1 - math.exp(-cost), LEAST_BEARABLE)


def _clutter(
    sensor: SensorEstimate, tracks: list[Track], reports: ReportTable, index: int
) -> SensorEstimate:
    """Return a sensor with the false alarms that are left beside the sure tracks."""
    if sensor.density <= 0:
        return sensor
    total = int(np.count_nonzero(reports.sensor == index))
    # In a crowd false alarms line up for a while.
    n_looks = np.unique(reports.time[reports.sensor == index]).size
    lasting = min(max(SURE_HITS, n_looks // 2), LASTING_HITS)
    taken = sum(
        int(np.count_nonzero(reports.sensor[track.rows] == index))
        for track in tracks
        if track.rows.size >= lasting
    )
    share = (total - taken + 0.5) / (total + 0.5)
    clutter = share * sensor.density
    if sensor.strength is not None:
        is_false = reports.sensor == index
        for track in tracks:
            is_false[track.rows] = False
        # Weak ones come again where they came before, and must not add up to a track there.
        local = local_density(reports.measurement[is_false]) / n_looks
        clutter = float(np.clip(local, clutter, MOST_GATHERED * clutter))
    present = (1 - share) * sensor.density * sensor.covered / sensor.detection_probability
    return replace(
        sensor,
        clutter_density=digits(float(np.clip(clutter, 1e-30, 1e10))),
        n_objects=max(present, 0.1),
    )


def _patience(tracks: list[Track], reports: ReportTable, followed: Followed) -> int | None:
    """Return after how many misses hardly any object came back, None where none was lost."""
    looks = np.unique(np.concatenate(list(followed.looks.values())))
    pauses = []
    for track in tracks:
        passed = np.searchsorted(looks, np.unique(reports.time[track.rows]))
        pauses += [pause for pause in np.diff(passed) - 1 if pause > 0]
    if len(pauses) < FEWEST_PAUSES:
        return None
    usual = math.ceil(float(np.quantile(pauses, RETURNED))) + 2
    return int(np.clip(usual, LEAST_PATIENCE, MOST_PATIENCE * _looks_per_turn(followed)))


def _looks_per_turn(followed: Followed) -> float:
    """Return how many scans of all sensors there are to one of the slowest."""
    counts = [times.size for times in followed.looks.values() if times.size > 1]
    return sum(counts) / min(counts) if counts else 1.0


def _coming(
    estimates: Estimates,
    tracks: list[Track],
    reports: ReportTable,
    followed: Followed,
) -> tuple[float, float]:
    """Return how many objects come with each scan and how many there are, per m² (m³)."""
    sensors = estimates.sensors
    known = estimates.new_target_density, estimates.initial_target_density
    name = max(sensors, key=lambda name: sensors[name].covered)
    density, looks = sensors[name].density, followed.looks.get(name, np.empty(0))
    if density <= 0 or looks.size < FEWEST_LOOKS:
        return known
    count = int(np.count_nonzero(reports.sensor == reports.sensors.index(name)))
    area = count / looks.size / density
    if area < WHOLE_PLANE * sensors[name].covered:
        # Into a part of the plane objects come over its edges.
        return known
    # Those of the first scans were there before.
    begun = looks[EARLY_LOOKS]
    came = sum(track.begin > begun for track in tracks)
    present = sum(track.end - track.begin for track in tracks) / float(looks[-1] - looks[0])
    rate = (came + 0.5) / (looks.size - EARLY_LOOKS)
    return bounded(rate / area, 1e-30), bounded(max(present, 0.1) / area, 1e-30)


def _noise(
    sensor: SensorEstimate, tracks: list[Track], reports: ReportTable, index: int
) -> tuple[float, float] | None:
    """Return sigma and process noise along the tracks, None where they are too few."""
    chains = [track.rows[reports.sensor[track.rows] == index] for track in tracks]
    chains = sorted((rows for rows in chains if rows.size >= SURE_HITS), key=len, reverse=True)
    chains = [rows[:LONGEST_CHAIN] for rows in chains[:MOST_CHAINS]]
    if sum(map(len, chains)) < LEAST_CHAINS_REPORTS:
        return None
    length = max(map(len, chains))
    time = np.full((len(chains), length), np.nan)
    place = np.full((len(chains), length, reports.dim), np.nan)
    for row, rows in enumerate(chains):
        # Two reports of one moment would tell of endless speed.
        rows = rows[np.r_[True, np.diff(reports.time[rows]) > 1e-6]]
        time[row, : rows.size] = reports.time[rows]
        place[row, : rows.size] = reports.measurement[rows]
    calm = calm_noise(time, place, sensor.plane_sigma, sensor.clutter_density)
    sigma, process = calm or noise_of_chains(
        time, place, sensor.plane_sigma, sensor.clutter_density
    )
    return sigma, max(process, 1e-9)


def _speed(tracks: list[Track], reports: ReportTable) -> float | None:
    """Return a speed that hardly any object exceeds."""
    speeds = []
    for track in tracks:
        # Each piece is of one sensor: between two that disagree, objects seem to jump.
        order = np.argsort(reports.sensor[track.rows], kind="stable")
        of = reports.sensor[track.rows[order]]
        for rows in np.split(track.rows[order], np.flatnonzero(np.diff(of)) + 1):
            time, place = reports.time[rows], reports.measurement[rows]
            for start in range(0, rows.size - PIECE + 1, 2):
                piece = slice(start, start + PIECE)
                centred = time[piece] - time[piece].mean()
                if np.ptp(centred) > 1e-6:
                    velocity = centred @ place[piece] / np.dot(centred, centred)
                    speeds.append(float(np.linalg.norm(velocity)))
    return 1.3 * float(np.quantile(speeds, 0.97)) if len(speeds) >= 10 else None
