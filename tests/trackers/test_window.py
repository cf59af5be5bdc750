import numpy as np
import pytest

from oracles.scenes import run, scan, sensor, tracker
from trackweave.errors import InvalidInputError
from trackweave.trackers.window import Window


def times(target):
    return [known.data.time for known in target._open.scans]


@pytest.mark.parametrize("changed", [{"depth": 0}, {"max_scans": 0}])
def test_refuses_a_window_of_nothing(changed):
    with pytest.raises(InvalidInputError, match="a whole number from 1 to"):
        Window(**changed)


def test_holds_as_many_scans_as_it_is_deep():
    target = tracker(window=3)
    run(target, [scan(float(time), []) for time in range(10)])
    assert times(target) == [7.0, 8.0, 9.0]


def test_a_depth_of_one_holds_the_newest_instant():
    target = tracker(sensor("a"), sensor("b"), window=1)
    run(target, [scan(float(time), [], name) for time in range(4) for name in "ab"])
    assert times(target) == [3.0, 3.0]


def test_depth_counts_the_slowest_sensors_scans():
    target = tracker(sensor("slow", scan_period=4.0), sensor("fast"), window=2)
    scans = []
    for time in range(13):
        scans += [scan(float(time), [], "slow")] if time % 4 == 0 else []
        scans.append(scan(float(time), [], "fast"))
    run(target, scans)
    assert times(target) == [5.0, 6.0, 7.0, 8.0, 8.0, 9.0, 10.0, 11.0, 12.0, 12.0]


def test_never_holds_more_scans_than_allowed():
    target = tracker(
        sensor("slow", scan_period=10.0), sensor("fast"), window=Window(depth=5, max_scans=4)
    )
    for time in range(30):
        run(target, [scan(float(time), [], "fast")])
        assert len(times(target)) <= 4


def test_an_instant_stays_together_when_there_is_no_room():
    names = "abc"
    target = tracker(*(sensor(name) for name in names), window=Window(depth=3, max_scans=4))
    for time in range(5):
        for name in names:
            run(target, [scan(float(time), [], name)])
            held = times(target)
            assert held[0] not in held or target._open.fixed_until < held[0]


def test_without_a_periodic_sensor_depth_counts_instants():
    target = tracker(sensor(scan_period=None), window=2)
    run(target, [scan(time, []) for time in (0.0, 0.3, 7.0, 7.1)])
    assert times(target) == [7.0, 7.1]


def test_slots_are_numbered_in_order_of_time_whatever_came_late():
    target = tracker(sensor("a"), sensor("b"), window=5)
    run(target, [scan(0.0, [(0, 0), (9, 9)], "a"), scan(2.0, [(1, 0)], "a")])
    run(target, [scan(1.0, [(5, 5), (4, 4), (3, 3)], "b")])
    slots = np.concatenate([known.data.slot for known in target._open.scans])
    assert slots.tolist() == [0, 1, 2, 3, 4, 5]
    assert target._report_index.instants(slots).tolist() == [0, 0, 1, 1, 1, 2]
    assert target._report_index.report[slots - target._report_index.origin].tolist() == [
        0,
        1,
        5,
        4,
        3,
        2,
    ]
