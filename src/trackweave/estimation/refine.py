"""What tracks that were made of a stretch of the reports tell."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.chains import local_density
from trackweave.estimation.clear_air import in_the_clear
from trackweave.estimation.coverage import in_view
from trackweave.estimation.estimate import WIDER
from trackweave.estimation.estimates import Estimates, SensorEstimate, bounded, digits, positive
from trackweave.estimation.looking import is_filled_evenly
from trackweave.estimation.neighbours import is_as_most, noise_beside_curves
from trackweave.estimation.noise import (
    arrays_of,
    calm_noise,
    noise_in_turns,
    noise_of_chains,
    scales_of,
)
from trackweave.estimation.silences import long_pauses, silences
from trackweave.models.coverage import FieldOfView
from trackweave.models.local_noise import local_noise

__all__ = [
    "DETECTION_RANGE",
    "LEAST_CHAINS_REPORTS",
    "Followed",
    "Track",
    "refined",
    "stretch_of",
    "sure_tracks",
]

REFINED = ("motion.process_noise", "motion.max_speed", "lifecycle.new_target_density")
REFINED_OF_SENSOR = ("sigma", "detection_probability", "clutter_density", "strength")
MOST_REPORTS, MOST_REPORTS_PER_SCAN = 4000, 200
# A stretch holds so many looks of a usual sensor, be it of a small part of the plane.
LEAST_LOOKS, LEAST_PART = 30, 0.1
# Tracks of so many reports are beyond doubt, and last.
SURE_HITS, LASTING_HITS = 6, 12
# … that one of its sensors saw at so much of the usual share of chances.
SEEN = 0.6
LEAST_CHAINS_REPORTS = 40  # Fewer reports in tracks tell nothing of noise.
# What is believed beforehand of the chance of detection, as if seen so often.
USUAL_DETECTION, USUAL_CHANCES, DETECTION_RANGE = 0.9, 10.0, (0.3, 0.96)
PIECE = 5
# So much of what objects do from one report to the next is left beside the curve through their
# neighbours: noise that is less is hidden by it.
HIDING, WHOLE_PLANE = 0.04, 0.7
# How much denser than on average false alarms may be where they gather.
MOST_GATHERED = 30.0
# Objects are short-lived where a larger share of them is new at each scan, by so many tracks.
FEWEST_LOOKS, EARLY_LOOKS, SHORT_LIVED, MANY_LIVES = 10, 4, 0.03, 20
# So many long silences tell of what a sensor does not see, and for no more of the time.
FEWEST_SILENCES, MOST_HIDDEN = 3, 0.8


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """What tracking a stretch gave."""

    track: IntArray  # Of each report, -1 for none, shape (reports,)
    # When each sensor scanned [s], ascending, by its name; with or without reports.
    looks: Mapping[str, FloatArray]
    # Where sensors see that do not see everywhere, by name.
    views: Mapping[str, FieldOfView] = field(default_factory=dict)
    # Whether they were followed however wild some are, as several radars share objects' tails.
    is_wild: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """A track that is beyond doubt."""

    rows: IntArray  # Rows of its reports, by time
    begin: float  # Time of the first [s]
    end: float  # Time of the last [s]


def stretch_of(reports: ReportTable) -> ReportTable:
    """Return a part of the reports that is quick to track and tells as much as the whole."""
    # It is a middle part of the plane where it is crowded, and of the time.
    number = reports.look
    moments = np.unique(np.stack([number, reports.sensor]), axis=1)
    if len(reports) <= MOST_REPORTS:
        return reports
    keep = np.ones(len(reports), dtype=bool)
    if not reports.kinds:
        looks = float(np.median(np.bincount(moments[1].astype(np.int64))))
        # Many sensors fill a short stretch with few looks of each, which tell little of any.
        lasting = min(1.0, LEAST_LOOKS / looks)
        share = min(MOST_REPORTS_PER_SCAN * moments.shape[1], MOST_REPORTS / lasting)
        share = max(share / len(reports), LEAST_PART)
        if share < 1:
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
    """Return estimates with what sure tracks, if any, tell in the place of what was guessed."""
    tracks = sure_tracks(estimates, reports, followed)
    if not tracks:
        return estimates
    sensors = dict(estimates.sensors)
    noises: list[float] = []
    sizes = np.array([track.rows.size for track in tracks])
    leave_soon = sizes[sizes < LASTING_HITS].sum() > 0.5 * sizes.sum()
    for index, name in enumerate(reports.sensors):
        look = np.sort(reports.look[reports.sensor == index])
        # What does not look is told by threads, per second.
        if name not in sensors or not look.size or sensors[name].scans is False:
            continue
        sensors[name] = _detection(sensors[name], tracks, reports, followed, name)
        # Where first estimates are in doubt, so is what lasts in a crowd: any sure track counts.
        # Where looks hold equally many, and few stay for long, hardly any is a false alarm.
        is_any = name in estimates.doubts or (leave_soon and is_filled_evenly(look))
        lasting = SURE_HITS if is_any else LASTING_HITS
        sensors[name] = _clutter(sensors[name], tracks, (reports, index), followed, lasting)
        found = _noise(sensors[name], tracks, (reports, index), is_wild=followed.is_wild)
        if found is not None:
            sigma = float(np.hypot(found[0], sensors[name].disagreement))
            sensors[name] = replace(sensors[name], sigma=bounded(sigma, 1e-9))
            noises.append(found[1])
    speed = _speed(tracks, reports)
    if noises:
        # Objects are the same for all sensors; what one sees besides is its own wandering.
        estimates = replace(estimates, process_noise=positive(min(noises)))
    if speed is not None:
        # The few that are faster may all come at other times.
        speed = bounded(max(speed, WIDER * estimates.speed_of_few))
        estimates = replace(estimates, max_speed=speed)
    share, silence = _silences(tracks, reports, _of_scans(followed, estimates))
    new, present = _coming(estimates, tracks, reports, followed)
    # As many go as come. Most stay for long, and what breaks off is no end: few that go are left
    # at the usual rate.
    seen = present != estimates.initial_target_density and len(tracks) >= MANY_LIVES
    survival = digits(1.0 - new / present) if seen and new > SHORT_LIVED * present else None
    keys = [f"sensors.{name}.{key}" for name in sensors for key in REFINED_OF_SENSOR]
    said = f"from {len(tracks)} track{'' if len(tracks) == 1 else 's'}"
    return replace(
        estimates,
        remarks={**estimates.remarks, **dict.fromkeys([*REFINED, *keys], said)},
        sensors=sensors,
        hidden_share=digits(share),
        mean_silence=digits(silence),
        survival=survival or estimates.survival,
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
    """Return the tracks that are long and were seen about as often as objects are."""
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
        sensor = estimates.sensors[reports.sensors[index]]
        model = None if sensor.clutter_persistence > 0.0 else sensor.strength
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
    hits, pauses = 0, [np.empty(0, dtype=np.int64)]
    # Beside others, what it alone does not see for long is hidden from it, not missed.
    is_beside = sum(times.size > 1 for times in followed.looks.values()) > 1
    for track in tracks:
        time, is_own = reports.time[track.rows], reports.sensor[track.rows] == index
        # A turn's scan counts as of its end, its reports as of their own times. The first and
        # the last report of a track are why it is there, and say nothing.
        ends = np.searchsorted(looks, [track.begin, track.end])
        first, last = np.minimum(ends, looks.size - 1)
        inner = looks[first : last + 1]
        seen = np.isin(np.arange(first, last + 1), np.searchsorted(looks, time[is_own]))
        seen[[0, -1]] = True
        hits += max(0, int(np.count_nonzero(seen)) - 2)
        unseen = inner[~seen]
        if name in followed.views:
            unseen = unseen[in_view(followed.views[name], reports, index, track.rows, unseen)]
        own = time[is_own]
        pauses.append(np.bincount(np.searchsorted(own, unseen), minlength=own.size))
    missed = np.concatenate(pauses)
    chances = hits + int(missed.sum())
    # What was hidden for long was not missed.
    is_long = long_pauses(missed, chances, are_most=is_beside)
    hidden, n_long = int(missed[is_long].sum()), int(is_long.sum())
    if is_beside and n_long >= FEWEST_SILENCES and sensor.scan_period is not None:
        sensor = replace(
            sensor,
            hidden_share=digits(min(hidden / chances, MOST_HIDDEN)),
            mean_silence=digits(hidden * sensor.scan_period / n_long),
        )
    missed = missed[~is_long]
    usual = USUAL_DETECTION * USUAL_CHANCES
    share = (hits + usual) / (hits + int(missed.sum()) + USUAL_CHANCES)
    return replace(sensor, detection_probability=digits(float(np.clip(share, *DETECTION_RANGE))))


def _clutter(
    sensor: SensorEstimate,
    tracks: list[Track],
    of: tuple[ReportTable, int],
    followed: Followed,
    lasting: int,
) -> SensorEstimate:
    """Return a sensor with the false alarms that are left beside the sure tracks."""
    reports, index = of
    if sensor.density <= 0:
        return sensor
    total = int(np.count_nonzero(reports.sensor == index))
    # In a crowd false alarms line up for a while.
    n_looks = max(followed.looks[reports.sensors[index]].size, 1)
    lasting = min(max(SURE_HITS, n_looks // 2), lasting)
    taken = sum(
        int(np.count_nonzero(reports.sensor[track.rows] == index))
        for track in tracks
        if track.rows.size >= lasting
    )
    share = (total - taken + 0.5) / (total + 0.5)
    clutter = share * sensor.density
    model = sensor.strength
    if model is not None and model.target_spread == sensor.clutter_persistence == 0.0:
        is_false = reports.sensor == index
        for track in tracks:
            is_false[track.rows] = False
        # Weak ones come again where they came before, and must not add up to a track there, but
        # where objects may be weak.
        local = local_density(reports.measurement[is_false]) / n_looks
        clutter = float(np.clip(local, clutter, MOST_GATHERED * clutter))
    present = (1 - share) * sensor.density * sensor.covered / sensor.detection_probability
    return replace(
        sensor,
        clutter_density=positive(clutter),
        n_objects=max(present, 0.1),
    )


def _silences(
    tracks: list[Track], reports: ReportTable, followed: Followed
) -> tuple[float, float]:
    """Return the share of their time for which objects are hidden, and how long on average."""
    looks = np.unique(np.concatenate([np.empty(0), *followed.looks.values()]))
    gaps = []
    for track in tracks:
        time = reports.time[track.rows]
        look, first = np.unique(np.searchsorted(looks, time), return_index=True)
        gaps.append((np.diff(time[first]), np.diff(look) - 1))
    return silences(gaps)


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
    return positive(rate / area), positive(max(present, 0.1) / area)


def _noise(
    sensor: SensorEstimate, tracks: list[Track], of: tuple[ReportTable, int], *, is_wild: bool
) -> tuple[float, float] | None:
    """Return sigma and process noise along the tracks, None where they are too few."""
    reports, index = of
    chains = [track.rows[reports.sensor[track.rows] == index] for track in tracks]
    chains = [rows for rows in chains if rows.size >= SURE_HITS]
    chains = in_the_clear(chains, of, sensor.plane_sigma)
    if sum(map(len, chains)) < LEAST_CHAINS_REPORTS:
        return None
    time, place = arrays_of((reports.time[rows], reports.measurement[rows]) for rows in chains)
    scale = scales_of((reports.time[rows], _own(sensor, reports, rows)) for rows in chains)
    if is_wild:
        # Noise that is the tail's would seem to be turns.
        kept = is_as_most(time, place)
        time, place, scale = time[kept], place[kept], scale[kept]
    usual, density = sensor.plane_sigma, sensor.clutter_density
    calm = calm_noise(time, place, usual, density, scale)
    sigma, process = calm or noise_of_chains(time, place, usual, density, scale=scale)
    unit = float(np.nanmedian(np.diff(time, axis=1))) ** 3
    if sigma**2 < HIDING * process * unit:
        # A filter that takes turns for noise of its own finds none in the reports.
        sigma = max(sigma, noise_beside_curves(time, place))
        _, process = noise_of_chains(time, place, sigma, density, fixed=True, scale=scale)
    # The tracks are sure, so that what is far off behind a turn is of no other object.
    process = noise_in_turns(time, place, (sigma, max(process, 1e-30)), density, scale)
    return sigma, process


def _own(sensor: SensorEstimate, reports: ReportTable, rows: IntArray) -> FloatArray:
    """Return the noise along each axis of some reports [m]; NaN where none is their own."""
    own = reports.sigma[rows, : reports.dim]
    at = local_noise(sensor.sigma_at, reports.measurement[rows]) if sensor.sigma_at else own
    return np.where(np.isnan(own), at, own)


def _speed(tracks: list[Track], reports: ReportTable) -> float | None:
    """Return a speed that hardly any object exceeds, be it of the many or of the few."""
    speeds, usual = [], [0.0]
    for track in tracks:
        own: list[float] = []
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
                    own.append(float(np.linalg.norm(velocity)))
        speeds += own
        if track.rows.size >= LASTING_HITS and own:
            usual.append(float(np.median(own)))
    if len(speeds) < 10:
        return None
    return 1.3 * max(float(np.quantile(speeds, 0.97)), *usual)
