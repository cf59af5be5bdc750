"""Reports threaded on their objects by nothing but where and when they are."""

import numpy as np

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
