"""Reports in tracks of one sensor each, as registration takes them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.config import Configuration
from trackweave.config.sensing import ObservedSensor
from trackweave.domain.reports import ReportTable
from trackweave.estimation.covering import covered_by
from trackweave.estimation.frames import frames_of
from trackweave.estimation.lone import judged
from trackweave.estimation.motion import reach
from trackweave.estimation.sightings import N_BIASES, Sightings, tracks_apart
from trackweave.estimation.tracklets import FEWEST_REPORTS, SensorReports, tracklets_of
from trackweave.run.observing import positions_in
from trackweave.run.polar_to_cartesian import laid, platforms_of
from trackweave.run.scans import with_turns

__all__ = ["heard_tracks", "hearing", "is_looking", "sightings_of", "tracks_of"]

# So many reports tell enough, but no less than so many turns of the slowest: where these hold
# more, those of a part of the plane.
MOST_REPORTS, LEAST_TURNS = 40_000, 40.0
# Where less than this share of a range is on the ground, a report says little of it.
STEEPEST = 0.7
# A range without a height is one on the ground, as far as objects are no faster [m/s].
FASTEST_ON_GROUND = 60.0
# Some go faster than the speed at which successors stand out.
WIDER = 1.5
# How exact places are before tracks tell it: a share of the way from scan to scan.
ROUGH = 0.15
# With so many unrelated reports where an object's next may be, tracks are torn and mixed, unless
# they leave so little noise that there are hardly any within so many deviations of it.
CROWDED, DEVIATIONS, HARDLY = 0.3, 3.0, 0.1
CROWD = "no tracks of one sensor stand out, as in a crowd"
NO_HEIGHT = (
    "objects are faster than on the ground, and no report tells how high they are (height_m), so "
    "that ranges along the line of sight are not those on the plane"
)


def sightings_of(
    reports: ReportTable,
    configuration: Configuration,
    observed: Mapping[str, ObservedSensor],
    chosen: Sequence[int],
    *,
    flat: bool = False,
) -> tuple[Sightings, float] | str:
    """Return what some sensors saw, and the greatest speed [m/s]; or why that is not clear."""
    # ``chosen`` are numbers of sensors whose reports say where objects are, and that look. Ranges
    # without heights are on the ground, however fast an object is, where it is all ``flat``.
    followed = tracks_of(reports, configuration, observed, chosen)
    if isinstance(followed, str):
        return followed
    seen, fastest = followed
    keep = (seen.track >= 0) & (seen.steepness < 1.0 / STEEPEST)
    if not flat:
        keep &= ~_flies_without_height(reports, seen)
    if not keep.any():
        return CROWD if np.all(seen.track < 0) else NO_HEIGHT
    return seen.part(keep), fastest


def tracks_of(
    reports: ReportTable,
    configuration: Configuration,
    observed: Mapping[str, ObservedSensor],
    chosen: Sequence[int],
    *,
    every: bool = False,
) -> tuple[Sightings, float] | str:
    """Return all reports, those in tracks of one sensor with their numbers, others with -1."""
    # Besides the greatest speed [m/s]; or why nothing is clear. Of many reports a part is looked
    # at unless ``every`` one is, which in a crowd none is.
    geometry = _geometry(reports, configuration, chosen)
    outward = np.stack([np.sin(geometry.azimuth), np.cos(geometry.azimuth)], axis=1)
    place = geometry.centre + np.where(
        geometry.is_polar[reports.sensor, None], geometry.distance[:, None] * outward, 0.0
    )
    turning = {name: seen.rotation for name, seen in observed.items() if seen.rotation is not None}
    scan = with_turns(reports, turning)
    if scan is None:
        scan = np.unique(reports.time, return_inverse=True)[1].reshape(-1)
    periods = _periods(reports, observed)
    alone = hearing(reports, configuration, observed, chosen)
    heard = {index: heard_tracks(reports, index) for index in alone}
    looking = [index for index in chosen if index not in heard]
    positions = replace(reports, measurement=place, scan=scan, kinds=(), space=0)
    fastest = configuration.said("motion", "max_speed") or _fastest(positions, looking, heard)
    if fastest is None:
        return CROWD
    strangers = {
        i: _crowd(place[reports.sensor == i], scan[reports.sensor == i], fastest * periods[i])
        for i in looking
    }
    crowded = [index for index, number in strangers.items() if number > CROWDED]
    if crowded and every:
        return CROWD
    for index, number in heard.items():
        periods[index] = _pace(reports.time, number)
    periods[np.isnan(periods)] = np.nanmin(periods)
    track = np.full(len(reports), -1, dtype=np.int64)
    slowest = float(periods[list(chosen)].max())
    looked_at = np.ones(len(reports), np.bool_) if every else _enough(reports.time, place, slowest)
    rows = [np.flatnonzero((reports.sensor == index) & looked_at) for index in chosen]
    found = [
        heard[index][own]
        if index in heard
        else tracklets_of(
            SensorReports(
                reports.time[own], place[own], np.full(own.size, ROUGH * fastest * periods[index]),
                geometry.height[own], scan[own], periods[index],
            ),
            fastest,
        )
        for index, own in zip(chosen, rows, strict=True)
    ]  # fmt: skip
    track[np.concatenate(rows)] = tracks_apart(found)
    seen = replace(geometry, track=track, period=periods)
    if crowded and not _stand_out(
        seen, {i: strangers[i] / (fastest * periods[i]) ** 2 for i in crowded}
    ):
        return CROWD
    return seen, fastest


def hearing(
    reports: ReportTable,
    configuration: Configuration,
    observed: Mapping[str, ObservedSensor],
    chosen: Sequence[int],
) -> list[int]:
    """Return which sensors hear objects report themselves, and do not look."""
    names = {index: reports.sensors[index] for index in chosen}
    looking = [index for index in chosen if is_looking(observed[names[index]])]
    hear = [index for index in chosen if index not in looking]
    # Where none looks otherwise one whose clock ticks in whole seconds seems to, each second.
    is_told = [
        observed[name].rotation is not None
        or configuration.sensor(name).get("scan_period") is not None
        or configuration.sensor(name).get("scans") is True
        for name in (names[index] for index in looking)
    ]
    if any(is_told) or not all(reports.kind_of(index).is_position for index in looking):
        return hear
    if any(judged(reports, index)[0].scans is not False for index in looking):
        return hear
    return list(chosen)


def is_looking(seen: ObservedSensor) -> bool:
    """Tell whether a sensor's reports show when it looks."""
    return seen.rotation is not None or seen.scan_period is not None


def heard_tracks(reports: ReportTable, index: int) -> IntArray:
    """Return the track of each report of a sensor that hears objects report, -1 for none."""
    # All are -1 where it tells no positions, or nothing tells whose its reports are.
    number = np.full(len(reports), -1, dtype=np.int64)
    if reports.kind_of(index).is_position:
        looking, threads, rows = judged(reports, index)
        if threads.is_whole or looking.scans is False:
            for count, own in enumerate(threads.lasting(FEWEST_REPORTS)):
                number[rows[own]] = count
    return number


def _geometry(
    reports: ReportTable, configuration: Configuration, chosen: Sequence[int]
) -> Sightings:
    """Return all reports without tracks; those of other sensors hold nothing of use."""
    places = positions_in(reports, configuration)
    on_plane, platform = laid(reports, places)[0].measurement, platforms_of(reports, places)
    n_reports = len(reports)
    centre, slant = platform[:, :2].copy(), np.zeros(n_reports)
    distance, azimuth, steepness = np.ones(n_reports), np.zeros(n_reports), np.ones(n_reports)
    height = np.full(n_reports, np.nan) if reports.height is None else reports.height.copy()
    is_polar = np.zeros(len(reports.sensors), dtype=np.bool_)
    for index in chosen:
        own, kind = reports.sensor == index, reports.kind_of(index)
        if kind.is_position:
            centre[own] = reports.measurement[own, :2]
            if reports.dim == 3:
                height[own] = reports.measurement[own, 2]
            continue
        is_polar[index] = True
        slant[own], azimuth[own] = reports.measurement[own, 0], on_plane[own, 1]
        distance[own] = on_plane[own, 0]
        if kind.has_elevation and reports.dim == 3:
            elevation = on_plane[own, 2]
            distance[own] *= np.cos(elevation)
            height[own] = platform[own, 2] + on_plane[own, 0] * np.sin(elevation)
            steepness[own] = np.cos(elevation)
        else:
            steepness[own] = slant[own] / np.maximum(distance[own], 1e-9)
    return Sightings(
        reports.time, reports.sensor, np.full(n_reports, -1, dtype=np.int64), centre, distance,
        slant, azimuth, steepness, height, is_polar, np.ones(is_polar.size),
    )  # fmt: skip


def _enough(time: FloatArray, place: FloatArray, slowest: float) -> NDArray[np.bool_]:
    """Tell which reports are looked at: those in the middle of the time, and of the plane."""
    if time.size <= MOST_REPORTS:
        return np.ones(time.size, dtype=np.bool_)
    skip = (time.size - MOST_REPORTS) // 2
    begin, end = time[skip], time[skip + MOST_REPORTS - 1]
    more = max(0.0, LEAST_TURNS * slowest - (end - begin)) / 2.0
    chosen: NDArray[np.bool_] = (time >= begin - more) & (time <= end + more)
    share = MOST_REPORTS / int(np.count_nonzero(chosen))
    if share >= 1.0:
        return chosen
    centre = np.median(place[chosen], axis=0)
    away = np.abs((place - centre) / (np.ptp(place[chosen], axis=0) + 1e-9)).max(axis=1)
    near: NDArray[np.bool_] = away <= np.quantile(away[chosen], share)
    return np.logical_and(chosen, near)


def _periods(reports: ReportTable, observed: Mapping[str, ObservedSensor]) -> FloatArray:
    """Return from scan to scan of each sensor [s]; NaN where it has none."""
    found = []
    for name in reports.sensors:
        turn = observed[name].rotation
        found.append(observed[name].scan_period if turn is None else turn.period)
    return np.array([np.nan if period is None else period for period in found])


def _pace(time: FloatArray, number: IntArray) -> float:
    """Return from report to report of a track as a median [s]."""
    order = np.lexsort((time, number))
    order = order[number[order] >= 0]
    same = np.diff(number[order]) == 0
    return float(np.median(np.diff(time[order])[same]))


def _fastest(
    positions: ReportTable, looking: Sequence[int], heard: Mapping[int, IntArray]
) -> float | None:
    """Return a speed that few objects exceed [m/s], None where no reports follow each other."""
    # Of sensors that look, or of tracks of those that hear where none does.
    if not looking:
        return max(_speed_of_most(positions, number) for number in heard.values()) or None
    speeds = []
    for index in looking:
        if np.count_nonzero(positions.sensor == index) > 1:
            found = reach(frames_of(positions, index)[0])
            if found is not None:
                speeds.append(found[0])
    return WIDER * float(np.median(speeds)) if speeds else None


def _speed_of_most(positions: ReportTable, number: IntArray) -> float:
    """Return a speed that nine steps in ten of numbered reports are slower than [m/s]."""
    order = np.lexsort((positions.time, number))
    order = order[number[order] >= 0]
    same = np.diff(number[order]) == 0
    way = np.linalg.norm(np.diff(positions.measurement[order], axis=0), axis=1)
    wait = np.diff(positions.time[order])
    told = same & (wait > 0.0)
    return WIDER * float(np.quantile(way[told] / wait[told], 0.9)) if told.any() else 0.0


def _crowd(place: FloatArray, scan: IntArray, reach_of_one: float) -> float:
    """Return how many unrelated reports of a scan lie where an object's next may be."""
    if len(place) < 3:
        return 0.0
    per_scan = len(place) / np.unique(scan).size
    return per_scan * np.pi * reach_of_one**2 / covered_by(place, reach_of_one)


def _stand_out(seen: Sightings, strangers: Mapping[int, float]) -> bool:
    """Tell whether tracks lie beside the way of their own far less than others do."""
    # ``strangers`` are how many unrelated reports of a scan lie in a disc of 1 m about an object,
    # by sensor. Tracks that go from one object to the next leave about as much as these are apart.
    known = seen.part(seen.track >= 0)
    for index, number in strangers.items():
        own = known.track_sensor == index
        if not own.any():
            return False
        if np.isnan(known.track_sigma[own]).all():
            return False
        along, across = np.nanmedian(known.track_sigma[own], axis=0)
        across *= np.median(known.distance[known.sensor == index])
        if not number * DEVIATIONS**2 * along * across <= HARDLY:
            return False
    return True


def _flies_without_height(reports: ReportTable, seen: Sightings) -> NDArray[np.bool_]:
    """Tell which reports tell a slant range alone of what is no place on the ground."""
    track, place = seen.track, seen.corrected(np.zeros((seen.n_sensors, N_BIASES)))[1]
    kinds = [reports.kind_of(index) for index in range(len(reports.sensors))]
    is_flat = np.array([kind.has_range and not kind.has_elevation for kind in kinds])
    doubtful = is_flat[reports.sensor] & np.isnan(seen.height) & (track >= 0)
    if not doubtful.any():
        return doubtful
    order = np.flatnonzero(track >= 0)
    order = order[np.lexsort((reports.time[order], track[order]))]
    first = np.flatnonzero(np.diff(track[order], prepend=-1))
    last = np.append(first[1:], order.size) - 1
    way = np.linalg.norm(place[order[last]] - place[order[first]], axis=1)
    speed = way / np.maximum(reports.time[order[last]] - reports.time[order[first]], 1e-9)
    doubtful[order] &= (speed > FASTEST_ON_GROUND)[track[order]]
    return doubtful
