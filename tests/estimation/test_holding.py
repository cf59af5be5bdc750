"""A holding stack under a slow radar: turns of 36 degrees a scan are neither noise nor clutter."""

from dataclasses import replace

import numpy as np
import pytest

from estimation.test_estimate import table
from trackweave.estimation.clutter_places import with_clutter_places
from trackweave.estimation.directions import with_components
from trackweave.estimation.estimate import estimate
from trackweave.estimation.estimates import Estimates, SensorEstimate
from trackweave.estimation.refine import Followed, refined, sure_tracks
from trackweave.estimation.standing import with_standing

PERIOD, N_SCANS, SPEED = 12.0, 100, 110.0
SIGMA = 70.0, np.radians(0.08)
FIX = np.array([30e3, 40e3])
HERE = {"A": (0.0, 0.0)}
NOBODY = -1


def racetrack(phase: np.ndarray) -> np.ndarray:
    """Return places on legs of a minute and half circles of a minute, at times of a round."""
    into, radius, leg = phase % 60.0, SPEED / np.radians(3.0), 60.0 * SPEED
    angle, part = np.radians(3.0) * into, phase % 240.0 // 60.0
    east = [0.0 * into, radius * (1.0 - np.cos(angle)), 2.0 * radius + 0.0 * into]
    east.append(radius * (1.0 + np.cos(angle)))
    north = [SPEED * into - leg, radius * np.sin(angle), -SPEED * into]
    north.append(-leg - radius * np.sin(angle))
    return np.stack([np.choose(part.astype(int), each) for each in (east, north)], axis=1)


def stack(begun=(0.0, 50.0, 90.0, 150.0, 200.0)):
    """Return times, places and whose: aircraft in one stack, and false alarms everywhere."""
    rng, moments = np.random.default_rng(2), PERIOD * np.arange(N_SCANS)
    seen = [moments[rng.random(N_SCANS) < 0.92] for _ in begun]
    place = [FIX + racetrack(own + first) for own, first in zip(seen, begun, strict=True)]
    whose = np.repeat(np.arange(len(begun)), [own.size for own in seen])
    true = np.concatenate(place)
    distance = np.linalg.norm(true, axis=1) + rng.normal(0.0, SIGMA[0], len(true))
    azimuth = np.arctan2(*true.T) + rng.normal(0.0, SIGMA[1], len(true))
    told = distance[:, None] * np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
    false = rng.uniform(-90e3, 90e3, (200, 2))
    when = np.concatenate([*seen, rng.choice(moments, 200)])
    return when, np.concatenate([told, false]), np.r_[whose, np.full(200, NOBODY)]


def followed_of(told):
    """Return reports, and them followed rightly."""
    time, place, whose = told
    order = np.lexsort((np.zeros(time.size), time))
    looks = {"A": PERIOD * np.arange(N_SCANS)}
    return table(time, place), Followed(whose[order], looks)


def known(sigma=70.0):
    sensor = SensorEstimate(PERIOD, sigma, 0.92, 1e-10, 3e10, 5.0, density=2.1e-10)
    return Estimates({"A": sensor}, 100.0, 300.0, 1e-12, 1e-10)


def test_the_first_estimate_keeps_the_turns_it_has_found():
    """Else nearly straight ways stand beside the noise that was found with turns."""
    time, place, _ = stack()
    assert estimate(table(time, place)).process_noise > 30.0


def test_noise_is_told_beside_turns_that_hide_it():
    reports, followed = followed_of(stack())
    found = refined(known(43.0), reports, followed)
    assert 50.0 < found.sensors["A"].sigma < 110.0  # 70 along and 75 across the line of sight
    assert found.process_noise > 30.0


def test_ranges_and_azimuths_of_one_radar_are_as_exact_as_they_are():
    reports, followed = followed_of(stack())
    sigma = with_components(known(), reports, followed, HERE).sensors["A"].sigma
    assert sigma == pytest.approx(SIGMA, rel=0.4)


def standing(told):
    reports, followed = followed_of(told)
    guess = known(SIGMA)
    tracks = sure_tracks(guess, reports, followed)
    assert len(tracks) == 5
    return with_standing(guess, reports, HERE, (reports, tracks)).sensors["A"].echoes


def test_where_many_pass_no_false_alarms_stand():
    assert standing(stack()) == ()


def test_false_alarms_that_stand_on_their_way_are_found():
    time, place, whose = stack()
    rng, there = np.random.default_rng(5), FIX - [0.0, 60.0 * SPEED]
    moments = PERIOD * np.flatnonzero(rng.random(N_SCANS) < 0.4)
    more = there + rng.normal(0.0, 200.0, (moments.size, 2))
    told = np.r_[time, moments], np.r_[place, more], np.r_[whose, np.full(moments.size, NOBODY)]
    ((x, y, _, number),) = standing(told)
    assert np.hypot(x - there[0], y - there[1]) < 300.0
    assert number == pytest.approx(0.4, rel=0.3)


def test_aircraft_side_by_side_are_no_dense_false_alarms():
    """Each would seem to be made of the other's reports."""
    reports, followed = followed_of(stack((0.0, 0.5, 90.0, 90.5)))
    guess = replace(known().sensors["A"], clutter_density=6e-11)
    found = with_clutter_places(replace(known(), sensors={"A": guess}), reports, followed)
    assert found.sensors["A"].echoes == ()
