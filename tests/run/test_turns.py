"""Reports of a turning beam become turns, each report with its own time."""

import numpy as np
import pytest

from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.reports import ReportTable
from trackweave.models.rotation import FollowedRotation, Rotation
from trackweave.run.scans import (
    N_SECTORS,
    Sectors,
    complete_scans,
    scan_ends,
    turn_ends,
    with_turns,
)

TURN = Rotation(4.0)


def radar(time: list[float], sensors: list[int] | None = None, **columns) -> ReportTable:
    n = len(time)
    return ReportTable(
        time=np.array(time, float),
        sensor=np.zeros(n, np.int64) if sensors is None else np.array(sensors, np.int64),
        sensors=("A", "B"),
        measurement=np.ones((n, 2)),
        sigma=np.full((n, 2), np.nan),
        report=np.arange(n).astype(str).astype(object),
        kinds=(Kind.RANGE_AZIMUTH, Kind.POSITION),
        space=2,
        **columns,
    )


def test_turns_begin_where_little_is_seen():
    # Seen a quarter before and after time 0, 4, 8, …, which a turn from 0 to 4 would split.
    time = np.sort(np.concatenate([np.arange(8) * 4.0 + 0.5, np.arange(1, 9) * 4.0 - 0.5]))
    number, ends = turn_ends(time, TURN)
    assert np.unique(number, return_counts=True)[1].tolist() == [1, *[2] * 7, 1]
    assert np.all(ends >= time)
    assert np.diff(np.unique(ends)) == pytest.approx(4.0)


def test_times_counted_from_1970_are_turned_alike():
    time = np.sort(np.random.default_rng(1).uniform(0, 100, 50))
    near, _ = turn_ends(time, TURN)
    far, ends = turn_ends(time + 1.6e9, TURN)
    np.testing.assert_array_equal(np.diff(near), np.diff(far))
    assert np.all((ends >= time + 1.6e9) & (ends <= time + 1.6e9 + 4.0))


def test_a_turn_is_scanned_in_sectors_whose_reports_keep_their_times():
    reports = radar([0.4, 0.45, 2.0, 4.5, 5.0])
    scans = complete_scans(reports, {"A": 4.0}, {"A": TURN})
    assert [len(scan) for scan in scans] == [2, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1]
    assert np.diff([scan.time for scan in scans]) == pytest.approx(0.5)
    assert scans[0].moments.tolist() == [0.4, 0.45]
    assert scans[0].report.tolist() == [0, 1]
    ends = scan_ends(reports, {"A": TURN})
    assert [ends[row] for scan in scans for row in scan.report] == [
        scan.time for scan in scans for _ in scan.report
    ]


def test_scan_numbers_of_the_table_are_turns_already():
    reports = radar([0.5, 1.0, 2.0], scan=np.array([7, 7, 8]))
    assert with_turns(reports, {"A": TURN}).tolist() == [7, 7, 8]


def test_sensors_that_do_not_turn_keep_their_scans():
    reports = radar([0.6, 1.0, 1.0, 2.2], [0, 1, 1, 0])
    scans = complete_scans(reports, {"A": 4.0, "B": 1.0}, {"A": TURN})
    full = [(scan.sensor, scan.moments is None) for scan in scans if len(scan)]
    assert full == [("A", False), ("B", True), ("A", False)]
    number = with_turns(reports, {"A": TURN})
    assert number[1] == number[2]
    assert number[0] == number[3]
    assert with_turns(reports, {}) is None


def test_identical_times_are_told_apart_by_nothing():
    number, ends = turn_ends(np.full(5, 3.0), TURN)
    assert np.unique(number).size == 1
    assert np.all(ends >= 3.0)


def test_a_moving_sensor_is_somewhere_between_in_a_turn_without_reports():
    platform = np.array([[0.0, 0, 0, 1, 0, 0], [12.0, 0, 0, 1, 0, 0]])
    reports = radar([0.0, 12.0], platform=platform)
    scans = complete_scans(reports, {"A": 4.0}, {})
    assert [scan.time for scan in scans] == [0.0, 4.0, 8.0, 12.0]
    assert scans[1].platform == pytest.approx([4.0, 0, 0, 1, 0, 0])


def test_a_radar_that_is_silent_for_an_hour_misses_at_most_a_hundred_turns():
    reports = radar([0.5, 1.0, 4.5, 3605.0, 3605.5])
    scans = complete_scans(reports, {"A": 4.0}, {"A": TURN})
    silent = [scan.time for scan in scans if len(scan) == 0 and 4.9 < scan.time <= 3605.0]
    assert len(silent) == 100 * 8
    assert sum(time < 1000.0 for time in silent) == 50 * 8


def test_sectors_of_a_steady_beam_are_eighths():
    time = np.sort(np.random.default_rng(1).uniform(0, 100, 300))
    sectors = Sectors(TURN, time)
    np.testing.assert_array_equal(sectors.number, np.floor(time / 0.5))
    np.testing.assert_array_equal(sectors.ends(sectors.number), (sectors.number + 1) * 0.5)


def test_sectors_of_a_followed_beam_are_cut_between_reports():
    rng = np.random.default_rng(1)
    turns = np.arange(101.0)
    knots = np.concatenate([[0.0], np.cumsum(rng.uniform(3.9, 4.1, 100))])
    beam = FollowedRotation(4.0, 0.0, 1, knots, turns)
    time = np.sort(rng.uniform(0, knots[-1], 2500))
    sectors = Sectors(beam, time)
    ends, begins = sectors.ends(sectors.number), sectors.ends(sectors.number - 1)
    assert np.all((begins <= time) & (time < ends))
    assert [sectors.end(number) for number in sectors.number[:9]] == ends[:9].tolist()
    swept = beam.turned(ends) - beam.turned(begins)
    assert np.all((swept >= 0.5 / N_SECTORS) & (swept <= 1.5 / N_SECTORS))
    # In sixteenths of a turn with some two reports each there is a gap to cut in.
    room = beam.turned(time) - beam.turned(begins), beam.turned(ends) - beam.turned(time)
    assert np.mean(np.minimum(*room) < 0.005) < 0.01
