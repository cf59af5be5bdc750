"""Objects at rest that report themselves, told apart by where and when."""

import itertools
import math

import numpy as np
import pytest

from trackweave.estimation._resting import (
    SIZE,
    absence,
    fit_rhythm,
    part_two,
    wait_density,
    weigh,
)
from trackweave.estimation.resting import (
    KNOWN,
    NEW,
    OF_USUAL,
    Berth,
    chain_of,
    parted,
    sureness,
)

GRAIN = 0.5


def paced(interval: float, jitter: float = 0.01, lost: float = 0.2) -> np.ndarray:
    return np.array([interval, jitter, lost, 0.0])


def free(rate: float) -> np.ndarray:
    return np.array([0.0, 0.02, 0.5, rate])


def density(wait: float, rhythm: np.ndarray) -> float:
    """Return the same as the kernel, by the sum over all numbers of lost reports."""
    interval, jitter, lost, rate = rhythm
    wait = max(wait, GRAIN)
    if interval == 0.0:
        return math.log(rate) - rate * wait
    total = 0.03 / (5.0 * wait)
    for count in range(1, 7):
        sigma = math.sqrt(count * (jitter * interval) ** 2 + GRAIN**2)
        off = (wait - count * interval) / sigma
        normal = math.exp(-0.5 * off**2) / (sigma * math.sqrt(2.0 * math.pi))
        total += 0.97 * (1.0 - lost) * lost ** (count - 1) * normal
    return math.log(total)


@pytest.mark.parametrize("rhythm", [paced(30.0), paced(180.0, 0.1, 0.4), free(0.02)])
@pytest.mark.parametrize("wait", [0.0, 7.0, 29.0, 61.0, 175.0, 364.0, 2000.0])
def test_waits_are_as_probable_as_all_numbers_of_lost_reports_make_them(rhythm, wait):
    assert wait_density(wait, rhythm, GRAIN) == pytest.approx(density(wait, rhythm), abs=1e-6)


def test_a_density_of_waits_sums_to_one():
    wait = np.linspace(1e-3, 60.0 * math.exp(2.5), 400_001)
    rhythm = paced(60.0, 0.05)
    total = np.trapezoid([math.exp(wait_density(each, rhythm, 1e-3)) for each in wait], wait)
    # Six intervals are the most, and other waits are counted over a range without an end.
    assert total == pytest.approx(1.0, abs=0.06)


def chain_value(time, place, mean, variance, rhythm, begin, end) -> float:
    if not time.size:
        return 0.0
    value = absence(time[0] - begin, rhythm) + absence(end - time[-1], rhythm)
    value += sum(wait_density(wait, rhythm, GRAIN) for wait in np.diff(time))
    off = ((place - mean) ** 2).sum(axis=1)
    dim = place.shape[1]
    return value - 0.5 * float((off / variance + dim * math.log(2 * math.pi * variance)).sum())


def scene(rng: np.random.Generator, n: int, dim: int):
    time = np.sort(rng.uniform(0.0, 300.0, n))
    place = rng.normal(0.0, 6.0, (n, dim))
    objects = (
        rng.normal(0.0, 4.0, (2, dim)),
        rng.uniform(10.0, 40.0, 2),
        np.stack([paced(rng.uniform(20.0, 60.0), 0.1), free(0.02)])[rng.permutation(2)],
    )
    return time, place, objects


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("seed", range(12))
def test_two_objects_have_the_likeliest_of_all_ways(seed, dim):
    rng = np.random.default_rng([seed, dim])
    time, place, objects = scene(rng, 8, dim)
    begin, end = -20.0, 330.0

    def value(owner: np.ndarray) -> float:
        return sum(
            chain_value(time[owner == k], place[owner == k], objects[0][k], objects[1][k],
                        objects[2][k], begin, end)
            for k in range(2)
        )  # fmt: skip

    every = [np.array(each) for each in itertools.product((0, 1), repeat=time.size)]
    owner = np.empty(time.size, dtype=np.int64)
    part_two((time, place), objects, (begin, end, GRAIN), owner)
    assert value(owner) == pytest.approx(max(map(value, every)), abs=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_a_report_is_as_probable_as_its_other_owners_make_it(seed):
    rng = np.random.default_rng(seed)
    time, place, objects = scene(rng, 12, 2)
    begin, end = -20.0, 330.0
    owner = rng.integers(0, 2, time.size)
    owner[:2] = 0, 1
    told = np.empty(time.size)
    weigh((time, place), owner, objects, (begin, end, GRAIN), told)
    for row in range(time.size):
        values = []
        for k in (owner[row], 1 - owner[row]):
            other = owner.copy()
            other[row] = k
            values.append(sum(
                chain_value(time[other == each], place[other == each], objects[0][each],
                            objects[1][each], objects[2][each], begin, end)
                for each in range(2)
            ))  # fmt: skip
        assert told[row] == pytest.approx(1.0 / (1.0 + math.exp(values[1] - values[0])), abs=1e-9)


@pytest.mark.parametrize(("interval", "lost"), [(181.0, 0.0), (31.0, 0.3), (600.0, 0.5)])
def test_a_rhythm_is_found_though_reports_are_lost(interval, lost):
    rng = np.random.default_rng(3)
    due = np.cumsum(interval * (1.0 + 0.004 * rng.standard_normal(120)))
    time = np.round(due[rng.random(120) >= lost])
    rhythm = np.empty(SIZE)
    fit_rhythm(np.diff(time), GRAIN, rhythm)
    assert rhythm[0] == pytest.approx(interval, rel=0.01)
    assert abs(rhythm[2] - lost) <= 0.15


def test_who_reports_whenever_it_likes_keeps_no_interval():
    time = np.cumsum(np.random.default_rng(5).exponential(60.0, 80))
    rhythm = np.empty(SIZE)
    fit_rhythm(np.diff(time), 0.005, rhythm)
    assert rhythm[0] == 0.0
    assert rhythm[3] == pytest.approx(1.0 / 60.0, rel=0.3)


def moored(rng: np.random.Generator, where, interval: float, *, hours: float = 1.0, sigma=6.0):
    due = np.cumsum(interval + rng.uniform(0.0, 0.01 * interval, int(hours * 3600 / interval)))
    time = np.round(due[rng.random(due.size) < 0.85] + rng.uniform(0.0, interval))
    return np.column_stack([time, rng.normal(where, sigma, (time.size, 2))])


def together(*ships: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, Berth]:
    rows = np.vstack(ships)
    truth = np.repeat(np.arange(len(ships)), [len(each) for each in ships])
    order = np.argsort(rows[:, 0], kind="stable")
    time, place = rows[order, 0], rows[order, 1:]
    extent = float(np.prod(np.ptp(place, axis=0) + 12.0))
    return time, place, truth[order], Berth(36.0, extent, time[0], time[-1], GRAIN)


def share_right(truth: np.ndarray, owner: np.ndarray) -> float:
    return sum(np.bincount(owner[truth == each]).max() for each in np.unique(truth)) / truth.size


@pytest.mark.parametrize("apart", [0.0, 12.0, 30.0])
@pytest.mark.parametrize("seed", range(3))
def test_ships_side_by_side_are_told_apart(seed, apart):
    rng = np.random.default_rng(seed)
    ships = [moored(rng, (k * apart, 0.0), interval) for k, interval in enumerate((181, 181, 31))]
    time, place, truth, berth = together(*ships)
    owner, gain = parted(time, place, np.zeros(time.size, dtype=np.int64), berth)
    assert np.unique(owner).size == 3
    assert gain > 100.0
    assert share_right(truth, owner) > (0.9 if apart < 20.0 else 0.97)


@pytest.mark.parametrize("seed", range(3))
def test_one_alone_that_was_taken_for_several_is_one(seed):
    rng = np.random.default_rng(seed)
    time, place, _, berth = together(moored(rng, (0.0, 0.0), 31.0))
    owner, gain = parted(time, place, rng.integers(0, 3, time.size), berth)
    assert np.unique(owner).tolist() == [0]
    assert gain > 0.0


def test_names_last_through_stretches():
    rng = np.random.default_rng(8)
    ships = [moored(rng, (k * 25.0, 0.0), 31.0, hours=6.0) for k in range(2)]
    time, place, truth, berth = together(*ships)
    assert time.size > 600
    owner, _ = parted(time, place, np.zeros(time.size, dtype=np.int64), berth)
    assert np.unique(owner).size == 2
    assert share_right(truth, owner) > 0.97


def test_who_is_silent_for_a_stretch_keeps_its_name():
    rng = np.random.default_rng(8)
    ships = [moored(rng, (k * 25.0, 0.0), 31.0, hours=8.0) for k in range(2)]
    silent = (ships[1][:, 0] > 4000.0) & (ships[1][:, 0] < 20000.0)
    time, place, truth, berth = together(ships[0], ships[1][~silent])
    owner, _ = parted(time, place, np.zeros(time.size, dtype=np.int64), berth)
    assert np.unique(owner).size == 2
    assert share_right(truth, owner) > 0.97


def test_sure_is_what_lies_apart_or_comes_in_time():
    rng = np.random.default_rng(4)

    def told(apart: float, rhythm: str) -> np.ndarray:
        ships = [moored(rng, (k * apart, 0.0), 61.0) for k in range(2)]
        if rhythm == "none":
            for ship in ships:
                ship[:, 0] = np.sort(rng.uniform(0.0, 3600.0, len(ship)))
        time, place, truth, berth = together(*ships)
        return sureness(time, place, truth.astype(np.int64), berth)

    assert np.median(told(60.0, "none")) > 0.999
    assert np.median(told(0.0, "kept")) > 0.999
    assert 0.3 < np.median(told(0.0, "none")) < 0.8


def test_a_chain_is_as_probable_as_all_places_and_noises_make_it():
    time, place = np.array([100.0, 400.0, 900.0]), np.array([[1.0], [9.0], [4.0]])
    berth = Berth(36.0, 50.0, 0.0, 1000.0, GRAIN)
    chain = chain_of(time, place, berth)
    mean, variance = np.meshgrid(np.linspace(-200, 200, 2001), np.geomspace(0.5, 2e4, 4001))
    scale = KNOWN * OF_USUAL * berth.variance
    prior = KNOWN * math.log(scale) - math.lgamma(KNOWN)
    prior = prior - (KNOWN + 1) * np.log(variance) - scale / variance - math.log(berth.extent)
    off = sum((each - mean) ** 2 for each in place[:, 0])
    density = np.exp(prior - 1.5 * np.log(2 * math.pi * variance) - off / variance / 2)
    over_mean = np.trapezoid(density, mean[0], axis=1)
    where = math.log(np.trapezoid(over_mean, variance[:, 0]))
    when = -math.log(1000.0) + absence(100.0, chain.rhythm) + absence(100.0, chain.rhythm)
    when += sum(wait_density(wait, chain.rhythm, GRAIN) for wait in np.diff(time))
    assert chain.likelihood == pytest.approx(where + when - NEW, abs=1e-3)


def test_the_same_reports_give_the_same_bytes():
    rng = np.random.default_rng(9)
    time, place, _, berth = together(*(moored(rng, (k * 10.0, 0.0), 91.0) for k in range(4)))
    begin = np.zeros(time.size, dtype=np.int64)
    first, again = (parted(time, place, begin, berth) for _ in range(2))
    assert first[0].tobytes() == again[0].tobytes()
    assert first[1] == again[1]


@pytest.mark.slow
def test_hundreds_of_one_stamp_are_parted_too():
    rng = np.random.default_rng(2)
    time = np.repeat([0.0, 60.0], 350)
    place = rng.normal(0.0, 6.0, (700, 2))
    berth = Berth(36.0, 1e4, 0.0, 60.0, GRAIN)
    owner, gain = parted(time, place, np.tile(np.arange(350), 2) // 2, berth)
    assert owner.shape == time.shape
    assert np.isfinite(gain)
