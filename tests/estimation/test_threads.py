"""Reports threaded on their objects by nothing but where and when they are."""

import numpy as np

from trackweave.estimation.pair_ratios import ratio_of_pairs
from trackweave.estimation.threads import threads_of


def test_threads_hardly_mix_objects_although_noise_and_speeds_are_unknown():
    rng = np.random.default_rng(1)
    rows = []
    for number in range(12):
        place, speed = np.array([0.0, 600.0 * number]), np.array([6.0 * (number % 2), 0.0])
        for time in np.cumsum(rng.uniform(4, 12, 60)):
            rows.append((time, *(place + speed * time + rng.normal(0, 6, 2)), number))
    table = np.array(sorted(rows))
    threads = threads_of(table[:, 0], table[:, 1:3])
    owned = [np.bincount(table[each, 3].astype(int)).max() for each in threads.rows]
    assert sum(owned) > 0.9 * threads.n_reports
    assert len(threads.lasting(30)) >= 10


def test_one_wild_report_makes_no_neighbours_of_objects_side_by_side():
    rng = np.random.default_rng(4)
    rows = [
        (time + 0.15 * tag, *(np.array([0.5 * time, 60.0 * tag]) + rng.normal(0, 0.3, 2)), tag)
        for tag in range(6)
        for time in np.arange(0.0, 300.0)
    ]
    rows.append((50.01, 1000.0, 1000.0, 6))
    table = np.array(sorted(rows))
    threads = threads_of(table[:, 0], table[:, 1:3]).lasting(2)
    assert all(np.unique(table[each, 3]).size == 1 for each in threads)
    assert len(threads) == 6


def test_counts_a_report_heard_twice_once():
    time = np.array([0.0, 1.0, 10.0, 20.0, 20.0])
    place = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 0.0]])
    threads = threads_of(time, place)
    assert threads.n_reports == 3
    assert sorted(np.concatenate(threads.rows).tolist()) == [0, 2, 3]


def test_takes_no_two_reports_of_one_stamp_for_one_object():
    time = np.repeat(np.arange(20.0), 2)
    place = np.column_stack([np.tile([0.0, 30.0], 20), time])
    for rows in threads_of(time, place).rows:
        assert np.all(np.diff(time[rows]) > 0)


def test_threads_reports_of_one_place_and_of_one_time():
    here = np.zeros((4, 2))
    assert threads_of(np.arange(4.0), here).n_reports == 1
    assert len(threads_of(np.zeros(4), np.random.default_rng(1).normal(size=(4, 2))).rows) == 4
    assert threads_of(np.empty(0), np.empty((0, 2))).rows == []


def test_threads_ships_in_line_astern():
    """They fill no area, and each comes by where the one ahead was some minutes ago."""
    rng = np.random.default_rng(4)
    rows = []
    for number in range(6):
        for time in np.cumsum(rng.uniform(9, 11, 110)):
            place = np.array([0.0, 1100.0 * number + 5.5 * time])
            rows.append((np.floor(time), *(place + rng.normal(0, 4, 2)), number))
    table = np.array(sorted(rows))
    threads = threads_of(table[:, 0], table[:, 1:3])
    owned = [np.bincount(table[each, 3].astype(int)).max() for each in threads.rows]
    assert sum(owned) > 0.95 * threads.n_reports
    assert len(threads.lasting(80)) == 6


def walkers(seed, count=8, seconds=120.0):
    """Return reports of people who walk in a hall, two a second each, and whose they are."""
    rng = np.random.default_rng(seed)
    rows = []
    for number in range(count):
        place, heading = rng.uniform(0, [30, 18]), rng.uniform(0, 2 * np.pi)
        begun = rng.uniform(0, 0.5)
        for time in begun + np.cumsum(np.maximum(rng.normal(0.5, 0.02, int(2 * seconds)), 0.3)):
            heading += rng.normal(0, 0.15)
            step = 0.6 * np.array([np.cos(heading), np.sin(heading)])
            inside = (place + step > 0) & (place + step < [30, 18])
            heading = heading if inside.all() else np.arctan2(*([9.0, 15.0] - place[::-1]))
            place = np.clip(place + step, 0, [30, 18])
            rows.append((time, *(place + rng.normal(0, 0.12, 2)), number))
    table = np.array(sorted(rows))
    return table[:, 0], table[:, 1:3], table[:, 3].astype(int)


def test_threads_tell_whose_reports_are_although_those_of_others_come_sooner():
    # Between two reports of one there are seven of others, at random places of the hall.
    time, place, who = walkers(5)
    threads = threads_of(time, place)
    same = [who[rows[1:]] == who[rows[:-1]] for rows in threads.rows if rows.size > 1]
    assert np.mean(np.concatenate(same)) > 0.97
    assert sum(map(len, same)) > 0.95 * time.size


def test_pairs_of_one_object_are_many_times_as_many_as_by_chance():
    time, place, who = walkers(6)
    before, behind = np.triu_indices(time.size, 1)
    some = np.flatnonzero(time[behind] - time[before] < 0.7)[::7]
    pairs = before[some], behind[some]
    density = time.size / (30.0 * 18.0 * np.ptp(time))
    ratio, apart = ratio_of_pairs((time, place, np.zeros_like(place)), pairs, density)
    is_same = who[pairs[0]] == who[pairs[1]]
    assert np.median(ratio[is_same]) > 15.0
    assert np.median(ratio[~is_same]) < 2.0
    assert np.allclose(apart, np.linalg.norm(place[pairs[1]] - place[pairs[0]], axis=1))
    unknown = np.full_like(place, np.nan)
    ratio, apart = ratio_of_pairs((time, place, unknown), pairs, density)
    assert np.all(ratio == 0)
    assert np.isnan(apart).all()


def test_no_thread_is_of_every_fourth_report() -> None:
    # Where chance makes no pairs at all, each multiple of a pause seems as likely.
    pauses = []
    for seed in range(12):
        rng, rows = np.random.default_rng(seed), []
        for _ in range(8):
            place = np.array([*rng.uniform(-8e4, 8e4, 2), 9000.0 + rng.uniform(0.0, 3000.0)])
            time, burst = rng.uniform(0.0, 600.0), rng.uniform(15e3, 21e3)
            while time < 2600.0:
                up = 5.0 if place[2] < burst else 0.0
                place = place + 10.0 * np.array([14.0, 3.0, up]) + rng.normal(0.0, 4.0, 3)
                time += 10.0
                if rng.random() < 0.9:
                    rows.append((time, *(place + rng.normal(0.0, 8.0, 3))))
        table = np.array(sorted(rows))
        threads = threads_of(table[:, 0], table[:, 1:]).rows[:8]
        pauses.append(np.median([np.median(np.diff(table[each, 0])) for each in threads]))
    np.testing.assert_allclose(pauses, 10.0)
