"""Places of false alarms that come again are told from objects that stand and from traffic."""

from dataclasses import replace

import numpy as np
import pytest

from estimation.test_estimate import table
from trackweave.estimation.estimates import Estimates, SensorEstimate
from trackweave.estimation.standing import with_seldom, with_standing

SIGMA = (50.0, 0.001)
SENSOR = SensorEstimate(4.0, SIGMA, 0.9, 1e-6, 1e10, 8.0)
GUESS = Estimates({"A": SENSOR}, 0.1, 300.0, 1e-12, 1e-10)
PLACE = (1000.0, 2000.0)
NOBODY = table(np.array([0.0]), np.array([PLACE])), ()


def found(spread=3.0, share=0.4, n_scans=120, last=1.0, drift=0.0, stays=0, *, at_rest=False):
    """Return the places found beside aircraft, of one at 20 km, due east, and when it is there."""
    rng = np.random.default_rng(4)
    moments = 4.0 * np.arange(n_scans)
    start, heading = rng.uniform(-1e5, 1e5, (20, 2)), rng.uniform(0, 2 * np.pi, 20)
    step = 200.0 * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    air = (start + step * moments[:, None, None]).reshape(-1, 2)
    there = (rng.random(n_scans) < share) & (moments <= last * moments[-1])
    if stays:
        # Of every so many scans the first are full, but for one in twenty.
        there = (np.arange(n_scans) % stays < share * stays) & (rng.random(n_scans) < 0.95)
    distance = 20e3 + drift * moments + SIGMA[0] * spread * rng.normal(size=n_scans)
    azimuth = np.pi / 2 + SIGMA[1] * spread * rng.normal(size=n_scans)
    echo = distance[:, None] * np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
    time = np.concatenate([np.repeat(moments, 20), moments[there]])
    where = np.concatenate([air, echo[there]]) + PLACE
    order = np.argsort(time, kind="stable")
    reports = table(time[order], where[order])
    told = with_standing(GUESS, reports, {"A": PLACE}, NOBODY, at_rest=at_rest)
    return told.sensors["A"].echoes


def test_a_place_of_false_alarms_is_found_with_its_spread_and_number():
    ((x, y, spread, count),) = found()
    assert (x, y) == (pytest.approx(21e3, abs=60.0), pytest.approx(2e3, abs=30.0))
    assert spread == pytest.approx(150.0, rel=0.4)
    assert count == pytest.approx(0.4, rel=0.3)


def test_a_place_in_three_dimensions_is_a_column_of_all_elevations():
    rng, n_scans = np.random.default_rng(4), 120
    moments = 4.0 * np.arange(n_scans)
    start, heading = rng.uniform(-3e4, 3e4, (20, 2)), rng.uniform(0, 2 * np.pi, 20)
    step = 100.0 * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    air = (start + step * moments[:, None, None]).reshape(-1, 2)
    there = rng.random(n_scans) < 0.4
    trees = np.array([20e3, 0.0]) + rng.normal(0.0, (150.0, 60.0), (n_scans, 2))
    time = np.concatenate([np.repeat(moments, 20), moments[there]])
    where = np.concatenate([air, trees[there]]) + PLACE
    height = np.concatenate(
        [np.tile(rng.uniform(500, 5e3, 20), n_scans), np.full(there.sum(), 10)]
    )
    order = np.argsort(time, kind="stable")
    reports = table(time[order], np.column_stack([where, height])[order])
    guess = replace(GUESS, sensors={"A": replace(SENSOR, sigma=(*SIGMA, 0.001))})
    nobody = table(np.array([0.0]), np.array([(*PLACE, 0.0)])), ()
    told = with_standing(guess, reports, {"A": PLACE}, nobody)
    ((x, y, _, count),) = told.sensors["A"].echoes
    assert (x, y) == (pytest.approx(21e3, abs=60.0), pytest.approx(2e3, abs=30.0))
    elevation = np.ptp(np.arctan2(height, np.linalg.norm(where - PLACE, axis=1)))
    assert count * elevation == pytest.approx(0.4, rel=0.3)


def test_what_is_seen_seldom_is_false_however_exact():
    assert len(found(spread=1.0, share=0.3)) == 1


def test_an_object_that_stands_is_none():
    assert found(spread=1.0, share=0.9) == ()


def test_where_what_stands_is_told_to_be_an_echo_it_is_one_and_what_moves_is_not():
    ((x, *_, count),) = found(spread=1.0, share=0.9, at_rest=True)
    assert x == pytest.approx(21e3, abs=60.0)
    assert count == pytest.approx(0.9, rel=0.1)
    assert found(spread=1.0, share=0.9, drift=0.8, at_rest=True) == ()
    assert len(on_plane(0.9, at_rest=True)) == 1


def moored(offsets, scatter, sensor=SENSOR, at=(1000.0, 0.0)):
    """Return the places found of objects that stand at offsets from a place, east and north."""
    # How far each report scatters is a function of a generator and a number of reports.
    rng, moments = np.random.default_rng(7), 4.0 * np.arange(120)
    where = [np.array(at) + offset + scatter(rng, moments.size) for offset in offsets]
    seen = rng.random((len(offsets), moments.size)) < 0.9
    time = np.concatenate([moments[each] for each in seen])
    place = np.concatenate([every[each] for every, each in zip(where, seen, strict=True)]) + PLACE
    order = np.argsort(time, kind="stable")
    guess = replace(GUESS, sensors={"A": sensor})
    told = with_standing(guess, table(time[order], place[order]), {"A": PLACE}, NOBODY)
    return told.sensors["A"].echoes


def as_measured(rng, count):
    """Return how far reports of a sensor at 20 km scatter, due east of it."""
    return rng.normal(0.0, SIGMA, (count, 2)) * (1.0, 20e3)


def test_objects_that_stand_side_by_side_are_none():
    assert moored([(0, 0), (0, 90), (0, -110)], as_measured, at=(20e3, 0.0)) == ()


def test_an_object_that_is_wider_than_azimuths_are_exact_is_none_near_the_sensor():
    def as_wide(rng, count):
        return rng.normal(0.0, 40.0, (count, 2))

    # Beside it a few reports come from far away.
    about = [(0, 0), (50e3, 0), (0, 50e3)]
    assert moored(about, as_wide) != ()
    assert moored(about, as_wide, replace(SENSOR, across=40.0)) == ()


@pytest.mark.parametrize("odd", [{"last": 0.6}, {"drift": 8.0}, {"n_scans": 20}, {"share": 0.03}])
def test_neither_is_what_leaves_or_moves_or_is_seen_too_little(odd):
    assert found(**odd) == ()


def on_plane(
    share: float, n_scans: int = 120, stays: int = 0, *, at_rest: bool = False
) -> tuple[tuple[float, ...], ...]:
    """Return the places found where positions of 5 m come from one place, sure tracks left out."""
    rng = np.random.default_rng(5)
    moments = np.arange(float(n_scans))
    is_there = rng.random(n_scans) < share
    if stays:
        is_there = (np.arange(n_scans) % stays < share * stays) & (rng.random(n_scans) < 0.95)
    there = moments[is_there]
    place = np.array([300.0, -200.0]) + rng.normal(0.0, 20.0, (there.size, 2))
    sensor = SensorEstimate(1.0, 5.0, 0.9, 1e-7, 1e8, 4.0)
    guess = Estimates({"A": sensor}, 0.1, 20.0, 1e-9, 1e-8)
    reports = table(there, place)
    found = with_seldom(guess, reports, {"A": moments}, reports, at_rest=at_rest)
    return found.sensors["A"].echoes


def test_a_place_on_the_plane_is_found_with_its_spread_and_number():
    ((x, y, spread, count),) = on_plane(0.3)
    assert (x, y) == (pytest.approx(300.0, abs=10.0), pytest.approx(-200.0, abs=10.0))
    assert spread == pytest.approx(20.0, rel=0.5)
    assert count == pytest.approx(0.3, rel=0.4)


@pytest.mark.parametrize("places", [found, on_plane])
def test_objects_that_stand_in_turn_are_none(places):
    # Trains in a station, aircraft at a stand: seen seldom in all, but in scan after scan.
    assert places(share=0.4, stays=30) == ()
    assert len(places(share=0.4, stays=30, at_rest=True)) == 1


def test_what_wags_there_in_every_scan_is_an_object():
    assert on_plane(0.9) == ()


def test_false_alarms_that_come_everywhere_stand_nowhere():
    rng = np.random.default_rng(6)
    time = np.sort(rng.integers(0, 100, 5000).astype(float))
    place = rng.uniform(0.0, 1000.0, (time.size, 2))
    sensor = SensorEstimate(1.0, 5.0, 0.9, 5e-5, 1e6, 4.0)
    guess = Estimates({"A": sensor}, 0.1, 20.0, 1e-9, 1e-8)
    reports = table(time, place)
    found = with_seldom(guess, reports, {"A": np.arange(100.0)}, reports)
    assert found.sensors["A"].echoes == ()


def test_where_noise_is_coarse_what_comes_from_anywhere_is_no_place():
    # Thirty false alarms a scan all over a sector that is 100 by 40 standard deviations wide.
    rng = np.random.default_rng(5)
    coarse = replace(SENSOR, sigma=(500.0, 0.02), scan_period=30.0)
    distance, azimuth = rng.uniform(10e3, 60e3, 6000), rng.uniform(-0.4, 0.4, 6000)
    where = distance[:, None] * np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
    reports = table(np.repeat(30.0 * np.arange(200), 30), where)
    guess = replace(GUESS, sensors={"A": coarse})
    assert with_standing(guess, reports, {"A": (0.0, 0.0)}, NOBODY).sensors["A"].echoes == ()


@pytest.mark.parametrize("drift", [0.6, 0.8, 1.2])
def test_an_object_that_moves_slowly_is_none(drift):
    assert found(spread=1.0, share=0.9, drift=drift) == ()
