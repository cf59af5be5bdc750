"""Sweeps over a sector are found by when and from where reports came."""

import numpy as np
import pytest

from trackweave.estimation.sweeps import sweeps_of

PERIOD = 5.0


def reports(seed, moments_of, span=600.0, period=PERIOD, count=12):
    """Return times and azimuths of what stands here and there, and the number of each period."""
    rng = np.random.default_rng(seed)
    rows = []
    for azimuth in rng.uniform(-1, 1, count):
        for number in range(int(span / period)):
            rows += [
                (period * (number + moment), azimuth + rng.normal(0, 0.01), number)
                for moment in moments_of(azimuth)
                if rng.random() < 0.7
            ]
    return np.array(sorted(rows)).T


def saw(azimuth):
    return [0.45 * (azimuth + 1)]


def to_and_fro(azimuth):
    return [(azimuth + 1) / 4, 1 - (azimuth + 1) / 4]


@pytest.mark.parametrize("told", [None, PERIOD, 1.05 * PERIOD])
def test_a_beam_that_flies_back_has_a_scan_for_each_period(told):
    time, azimuth, period = reports(1, saw)
    number, lasts = sweeps_of(time, azimuth, told)
    assert lasts == pytest.approx(PERIOD, rel=1e-3)
    assert np.array_equal(number, (period - period[0]).astype(int))


@pytest.mark.parametrize("count", [5, 12, 40])
def test_a_beam_that_sweeps_back_has_two_scans_for_each_period(count):
    time, azimuth, _ = reports(2, to_and_fro, count=count)
    number, lasts = sweeps_of(time, azimuth)
    assert lasts == pytest.approx(PERIOD / 2, rel=1e-3)
    # In a sweep nothing is seen twice.
    for one in np.unique(number):
        seen = np.sort(azimuth[number == one])
        assert np.all(np.diff(seen) > 0)
    assert number[-1] == pytest.approx(2 * 600.0 / PERIOD, abs=2)


@pytest.mark.parametrize("count", [20_000, 200_000])
def test_dense_reports_are_of_the_shortest_sweep(count):
    # The first few hundred are of a few sweeps, and every second fits twice the period.
    time = np.sort(np.random.default_rng(0).uniform(0, 36_000, count))
    number, lasts = sweeps_of(time, 2.0 * (time / 4.0 % 1.0) - 1.0)
    assert lasts == pytest.approx(4.0, rel=1e-4)
    # Cut in the gap between sweeps; these have none.
    assert np.mean(number - number[0] == np.floor(time / 4.0) - np.floor(time[0] / 4.0)) > 0.9
    _, lasts = sweeps_of(time, np.abs(2.0 * (time / 8.0 % 1.0) - 1.0))
    assert lasts == pytest.approx(4.0, rel=1e-4)


def test_a_beam_that_turns_round_does_not_sweep():
    time, azimuth, _ = reports(3, lambda a: [(a + 1) / 2])
    assert sweeps_of(time, np.pi * azimuth) is None


@pytest.mark.parametrize("seed", range(5))
def test_reports_at_any_time_are_of_no_sweep(seed):
    rng = np.random.default_rng(seed)
    time = np.sort(rng.uniform(0, 600, 900))
    assert sweeps_of(time, rng.uniform(-1, 1, 900)) is None
    assert sweeps_of(time, 0.5 * np.sin(time / 100)) is None
    assert sweeps_of(time, np.zeros(900)) is None
    assert sweeps_of(np.zeros(900), rng.uniform(-1, 1, 900)) is None
    assert sweeps_of(time[:20], rng.uniform(-1, 1, 20)) is None


def test_a_wide_sector_flown_back_over_what_is_not_seen_is_no_turn():
    # Of 210 degrees, stamps off by up to a tenth of the period: the way on is the shorter one.
    rng = np.random.default_rng(1)
    azimuth = np.repeat(rng.uniform(-1.83, 1.83, 10), 200)
    number = np.tile(np.arange(200), 10)
    moment = 0.9 * (azimuth + 1.83) / 3.66 + rng.uniform(0, 0.1, azimuth.size)
    time = PERIOD * (number + moment)
    order = np.argsort(time)[rng.random(time.size) < 0.7]
    found, lasts = sweeps_of(time[order], azimuth[order])
    assert lasts == pytest.approx(PERIOD, rel=1e-3)
    assert np.mean(found - found[0] == number[order] - number[order][0]) > 0.98
