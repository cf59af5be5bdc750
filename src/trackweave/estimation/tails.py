"""Whether a sensor's noise has heavy tails, from single reports far beside their own tracks.

A report is compared with what its neighbours in the track say of it, two before and two after. Its
noise is N(0, R) or, with a share ε, N(0, k²R): the contaminated normal distribution [1]_, fitted
by expectation and maximisation. What turns, neighbours that are off themselves, a sigma that is
too small or strangers in a crowd would explain is not taken for tails.

.. [1] J. W. Tukey, A survey of sampling from contaminated distributions, 1960.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.chi_squared import poisson_reaches
from trackweave.domain.reports import ReportTable
from trackweave.estimation.along_sight import platform_of
from trackweave.estimation.estimates import Estimates, SensorEstimate, digits
from trackweave.estimation.neighbours import LONGEST_SPAN, expected_of
from trackweave.estimation.refine import Followed, Track, sure_tracks
from trackweave.models.local_noise import local_noise

__all__ = ["fitted_persistence", "fitted_tails", "with_tails"]

# Standard deviations from which on a report is far off, and how many such of how many tracks tell
# of tails: one odd object is no sensor.
FAR, FEWEST_FAR, FEWEST_TRACKS, FEWEST_REPORTS = 5.0, 5, 3, 100
# Noise of all tracks that is so many times that of most, but not more, is of a few that are worse.
MIXED = (2.0, 5.0)
# What is believed of tails beforehand, as if so many reports had told: the tracks that tell never
# held what was farther off than their gates.
USUAL_SHARE, USUAL_REPORTS, MOST_SHARE = 0.01, 500.0, 0.5
USUAL_SCALE, USUAL_WIDE, MOST_SCALE = 12.0, 10.0, 50.0
# Sure tracks hold few of those whose every report is wild: of radars that share objects so much
# is wide at least.
LEAST_SHARED = 0.05
# How far wide noise persists from report to report of an object, what is usual of transponders
# that are bad, and by how much likelier another must be to be believed [nats].
PERSISTENCE = (0.0, 0.5, 0.8, 0.9, 0.95, 0.98)
USUAL_PERSISTENCE, LIKELIER = 0.95, 3.0
# Where so many strangers lie as near as a report that is far off, it may be one of them; and so
# many would come where an object's own report is missing in no more than one of so many sensors.
CROWDED, BY_CHANCE = 0.1, 1e-4
# Noise so many times as large in the middle of all reports is another sigma.
OTHER_SIGMA = 2.0
MEDIAN_SQUARE = 1.386
"""Median of the squared distance in a plane."""
N_ROUNDS = 50


class _Beside(NamedTuple):
    """How far reports are beside what their neighbours say, in two components, and whose."""

    square: FloatArray  # In units of the noise
    distance: FloatArray  # [m]
    track: IntArray


def with_tails(
    estimates: Estimates,
    reports: ReportTable,
    followed: Followed,
    places: Mapping[str, Sequence[float]] | None = None,
    told: Mapping[str, tuple[float, ...]] | None = None,
) -> Estimates:
    """Return estimates with the share and scale of wide noise of sensors whose reports have it."""
    # ``places`` are those of the sensors that measure range and azimuth [m], and ``told`` what
    # noise a user tells of them [m, rad].
    tracks = sure_tracks(estimates, reports, followed)
    sensors = dict(estimates.sensors)
    narrow: dict[str, SensorEstimate] = {}
    squares: dict[str, FloatArray] = {}
    whose: dict[str, IntArray] = {}
    speaking: set[str] = set()
    # Of several radars sigma is that of most tracks, and what a few add is the tail; with a single
    # one, whose misses no other makes good, fewer names are lost to the noise of all.
    is_several = len(places or ()) > 1
    for index, name in enumerate(reports.sensors):
        if name not in sensors or name in estimates.doubts:
            continue
        place = None if places is None else places.get(name)
        usual = _of_most(sensors[name]) if is_several else sensors[name]
        is_told = name in (told or {})
        known = replace(usual, sigma=(told or {}).get(name, usual.sigma))
        is_mixed = not is_several and not is_told and _is_mixed(known)
        beside = _beside((known, index, place), reports, tracks)
        if beside.track.size >= FEWEST_REPORTS:
            narrow[name], squares[name], whose[name] = usual, beside.square, beside.track
            if is_mixed or _speaks(beside, known):
                speaking.add(name)
    ranging = set(places or ()) & set(narrow)
    # A transponder that is bad is so for every radar. Where several turn, some are bad although
    # the sure tracks of a stretch may be of none of them.
    is_shared = len(ranging) > 1 and (followed.is_wild or bool(ranging & speaking))
    for name in sorted(speaking | ranging if is_shared else speaking):
        share, scale = fitted_tails(squares[name])
        if is_shared and name in ranging:
            share = max(share, LEAST_SHARED)
        tail, likely = (share, scale), USUAL_PERSISTENCE if is_shared and name in ranging else 0.0
        sensors[name] = replace(
            sensors[name],
            sigma=narrow[name].sigma,
            tail_share=digits(share, 3),
            tail_scale=digits(scale, 3),
            tail_persistence=fitted_persistence(squares[name], whose[name], tail, likely),
        )
    return replace(estimates, sensors=sensors)


def _of_most(sensor: SensorEstimate) -> SensorEstimate:
    """Return a sensor with the noise of most tracks: that of few that are worse is its tail."""
    return sensor if sensor.sigma_of_most is None else replace(sensor, sigma=sensor.sigma_of_most)


def _is_mixed(sensor: SensorEstimate) -> bool:
    """Tell whether the noise of some tracks is many times that of most."""
    whole, most = sensor.sigma, sensor.sigma_of_most
    if not isinstance(whole, tuple) or most is None:
        return False
    times = max(one / other for one, other in zip(whole, most, strict=True))
    return MIXED[0] < times < MIXED[1]


def _speaks(beside: _Beside, sensor: SensorEstimate) -> bool:
    """Tell whether more reports are far off than turns, strangers or another sigma explain."""
    whole = beside.square.sum(axis=1)
    strangers = sensor.density * np.pi * beside.distance**2
    far = (whole > FAR**2) & (strangers < CROWDED)
    n_far, count = int(far.sum()), whole.size
    if n_far < FEWEST_FAR:
        return False
    if np.unique(beside.track[far]).size < FEWEST_TRACKS:
        return False
    if float(np.median(whole)) > OTHER_SIGMA * MEDIAN_SQUARE:
        return False
    missed = (1.0 - sensor.detection_probability) * count
    return poisson_reaches(n_far, missed * strangers[far].mean()) < BY_CHANCE


def fitted_tails(square: FloatArray) -> tuple[float, float]:
    """Return the likeliest share and scale of wide noise, given squares in units of the narrow."""
    # The narrow part has the noise that the sensor is known by: what a tracker will take it for.
    width = square.shape[1]
    whole = square.sum(axis=1)
    share, scale = USUAL_SHARE, USUAL_SCALE
    for _ in range(N_ROUNDS):
        ratio = np.log(share / (1.0 - share)) - width * np.log(scale)
        ratio += 0.5 * whole * (1.0 - 1.0 / scale**2)
        wide = 1.0 / (1.0 + np.exp(-np.clip(ratio, -50.0, 50.0)))
        n_wide = float(wide.sum()) + USUAL_SHARE * USUAL_REPORTS
        share = min(n_wide / (wide.size + USUAL_REPORTS), MOST_SHARE)
        total = float(np.sum(wide * whole)) + USUAL_WIDE * width * USUAL_SCALE**2
        variance = total / (width * (float(wide.sum()) + USUAL_WIDE))
        scale = float(np.clip(np.sqrt(variance), 1.0, MOST_SCALE))
    return share, scale


def fitted_persistence(
    square: FloatArray, track: IntArray, tail: tuple[float, float], usual: float
) -> float:
    """Return how far wide noise persists, given squares by time in each track, of like ones."""
    # Narrow and wide follow each other as a Markov chain whose states are not seen: the likelihood
    # of a persistence is that of the forward pass, over all tracks at once.
    share, scale = tail
    width = square.shape[1]
    ratio = 0.5 * square.sum(axis=1) * (1.0 - 1.0 / scale**2) - width * np.log(scale)
    _, number, count = np.unique(track, return_inverse=True, return_counts=True)
    place = np.arange(track.size) - np.repeat(np.cumsum(count) - count, count)
    table = np.full((count.size, int(count.max())), np.nan)
    table[number, place] = np.exp(np.minimum(ratio, 500.0))
    tried = np.array(PERSISTENCE)
    wild, found = np.full((count.size, tried.size), share), np.zeros(tried.size)
    for odds in table.T[:, :, None]:
        before = share + tried * (wild - share)
        total = 1.0 - before + before * odds
        found += np.nansum(np.log(total), axis=0)
        wild = before * odds / total
    best = int(np.argmax(found))
    is_told = found[best] - found[PERSISTENCE.index(usual)] > LIKELIER
    return PERSISTENCE[best] if is_told else usual


def _beside(
    sensor: tuple[SensorEstimate, int, Sequence[float] | None],
    reports: ReportTable,
    tracks: list[Track],
) -> _Beside:
    """Return how far each report of a sensor is beside what its neighbours say."""
    found, index, place = sensor
    parts = [_Beside(np.empty((0, 2)), np.empty(0), np.empty(0, dtype=np.int64))]
    for number, track in enumerate(tracks):
        rows = track.rows[reports.sensor[track.rows] == index]
        rows = rows[np.diff(reports.time[rows], prepend=-np.inf) > 1e-6]
        if rows.size < 5:
            continue
        time, position = reports.time[rows], reports.measurement[rows]
        middle = position[2:-2, :2]
        variance = np.full((middle.shape[0], 2), found.plane_sigma**2)
        if found.sigma_at:
            variance = local_noise(found.sigma_at, position[2:-2])[:, :2] ** 2
        turned = np.broadcast_to(np.eye(2), (middle.shape[0], 2, 2))
        if isinstance(found.sigma, tuple) and place is not None:
            relative = middle - platform_of(reports, rows, place)[2:-2, :2]
            reach = np.maximum(np.linalg.norm(relative, axis=1), 1e-9)
            east, north = (relative / reach[:, None]).T
            turned = np.array([[east, north], [north, -east]]).transpose(2, 0, 1)
            # Beside the sensor places are off by more than by what an angle tells.
            variance[:, 1] = np.maximum(found.sigma[1] * reach, found.sigma[0]) ** 2
        least = np.full(middle.shape[0], np.inf)
        square, distance = np.full(middle.shape, np.inf), np.full(middle.shape[0], np.inf)
        for expected, known in expected_of(time, position[:, :2]):
            off = middle - expected
            along = np.einsum("kij,kj->ki", turned, off)
            mine = along**2 / (variance * (1.0 + known)[:, None])
            nearer = mine.sum(axis=1) < least
            square[nearer], distance[nearer] = mine[nearer], np.linalg.norm(off, axis=1)[nearer]
            least = np.minimum(least, mine.sum(axis=1))
        span = time[4:] - time[:-4]
        told = span < LONGEST_SPAN * float(np.median(np.diff(time)))
        whose = np.full(int(told.sum()), number)
        parts.append(_Beside(square[told], distance[told], whose))
    return _Beside(*map(np.concatenate, zip(*parts, strict=True)))
