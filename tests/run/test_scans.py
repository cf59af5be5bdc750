"""Scans without reports are put where a sensor with a period left them out."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackweave.domain.reports import ReportTable
from trackweave.models.rotation import Rotation
from trackweave.run.scans import (
    FULL,
    LAST,
    MOST_MISSING,
    N_SECTORS,
    complete_scans,
    missing_times,
    missing_turns,
    notes_on_pauses,
    swept_together,
)


def table(times: list[float], sensors: list[int]) -> ReportTable:
    n = len(times)
    return ReportTable(
        time=np.array(times, float),
        sensor=np.array(sensors, np.int64),
        sensors=("A", "B"),
        measurement=np.zeros((n, 2)),
        sigma=np.full((n, 2), np.nan),
        report=np.arange(n).astype(str).astype(object),
    )


@pytest.mark.parametrize(
    ("times", "missing"),
    [
        ([0.0, 1.0, 2.0], []),
        ([0.0, 1.0, 3.0], [2.0]),
        ([0.0, 1.2, 2.1], []),
        ([0.0, 4.0], [1.0, 2.0, 3.0]),
        ([7.0], []),
        ([], []),
    ],
)
def test_fills_whole_periods(times: list[float], missing: list[float]) -> None:
    assert list(missing_times(times, 1.0)) == missing


def test_fills_only_the_ends_of_a_gap_of_years() -> None:
    found = list(missing_times([0.0, 3e8], 1.0))
    assert len(found) == 2 * MOST_MISSING
    assert found[:2] == pytest.approx([1.0, 2.0])
    assert found[-1] == pytest.approx(3e8 - 1)


@given(st.lists(st.floats(-1e9, 1e9), max_size=6), st.floats(1e-3, 1e6))
def test_missing_times_lie_between_and_ascend(times: list[float], period: float) -> None:
    times = sorted(times)
    found = list(missing_times(times, period))
    assert found == sorted(found)
    assert all(times[0] <= time <= times[-1] for time in found)
    assert len(found) <= 2 * MOST_MISSING * max(len(times) - 1, 0)


def test_scans_of_all_sensors_come_in_order_of_time() -> None:
    scans = complete_scans(table([0.0, 0.0, 1.5, 3.0], [0, 1, 1, 0]), {"A": 1.0, "B": None})
    assert [(scan.time, scan.sensor, len(scan)) for scan in scans] == [
        (0.0, "A", 1),
        (0.0, "B", 1),
        (1.0, "A", 0),
        (1.5, "B", 1),
        (2.0, "A", 0),
        (3.0, "A", 1),
    ]


@pytest.mark.parametrize(
    ("before", "empty"),
    [
        ([FULL] * LAST, []),
        ([FULL] * (LAST - 1) + [FULL - 1], [4.0, 5.0, 6.0]),
        # What one scan has may be chance.
        ([4, 4, 4, 12], [4.0, 5.0, 6.0]),
        ([12], [1.0, 2.0, 3.0]),
    ],
)
def test_after_many_reports_a_scan_without_any_is_none(
    before: list[int], empty: list[float]
) -> None:
    times = np.repeat(np.arange(len(before), dtype=float), before).tolist()
    reports = table([*times, len(before) + 3.0], [0] * (len(times) + 1))
    scans = complete_scans(reports, {"A": 1.0})
    assert [scan.time for scan in scans if len(scan) == 0] == empty
    notes = notes_on_pauses(scans, {"A": 1.0})
    assert bool(notes) is not bool(empty)
    if notes:
        assert notes[0].startswith("sensor A: 1 pause of up to 4 s, right after 4 scans of 8")


@pytest.mark.parametrize("pace", [10.0, 3.0, 1.0])
def test_a_sensor_that_takes_another_pace_misses_nothing(pace: float) -> None:
    times = [*np.arange(6.0), *(5.0 + pace * np.arange(1.0, 6.0))]
    scans = complete_scans(table(times, [0] * len(times)), {"A": 1.0})
    assert not any(len(scan) == 0 for scan in scans)
    assert bool(notes_on_pauses(scans, {"A": 1.0})) is (pace > 1.0)


def test_gaps_that_differ_are_misses() -> None:
    times = [0.0, 1.0, 2.0, 4.0, 7.0, 9.0, 10.0]
    scans = complete_scans(table(times, [0] * len(times)), {"A": 1.0})
    assert [scan.time for scan in scans if len(scan) == 0] == [3.0, 5.0, 6.0, 8.0]


def test_a_long_silence_of_a_sensor_of_few_reports_is_no_pause() -> None:
    scans = complete_scans(table([0.0, 1.0, 500.0], [0, 0, 0]), {"A": 1.0})
    assert max(np.diff([scan.time for scan in scans])) > 100.0
    assert notes_on_pauses(scans, {"A": 1.0, "B": 1.0}) == []


def test_of_turns_without_reports_one_is_put_and_no_more_after_many() -> None:
    turning = {"A": Rotation(8.0, 0.0, 1)}
    for n_before, most in ((FULL - 1, 3 * N_SECTORS), (FULL, N_SECTORS)):
        turns = [8.0 * turn + np.linspace(0.1, 7.9, n_before) for turn in range(LAST)]
        times = [*np.concatenate(turns), LAST * 8.0 + 3 * 8.0]
        scans = complete_scans(table(times, [0] * len(times)), {"A": 8.0}, turning)
        later = [scan for scan in scans if len(scan) == 0 and scan.time > LAST * 8.0]
        assert most - 2 <= len(later) <= most + 2


def test_turns_between_those_with_reports_are_looked_at_but_in_a_pause() -> None:
    ends = np.array([1.0, 2.0, 3.0, 4.0, 8.0])
    few, many = np.full(5, FULL - 1), np.full(5, FULL)
    assert list(missing_turns(ends, few, 1.0)) == [5.0, 6.0, 7.0]
    assert list(missing_turns(ends, many, 1.0)) == [5.0]


def test_reports_of_a_numbered_scan_keep_their_own_times() -> None:
    """A turn of a radar whose beam nobody knows; scans of one time are left as they are."""
    numbered = replace(table([0.0, 1.5, 3.0, 4.0, 4.0], [0] * 5), scan=np.array([1, 1, 1, 2, 2]))
    first, second = complete_scans(numbered, {"A": None, "B": None})
    assert (first.time, first.moments.tolist()) == (3.0, [0.0, 1.5, 3.0])
    assert (second.time, second.moments) == (4.0, None)


def test_what_several_beams_sweep_meanwhile_is_a_step() -> None:
    rotations = {"A": Rotation(8.0, 0.0, 1), "B": Rotation(5.0, 0.0, 1)}
    reports = table(np.arange(0.1, 8.0, 0.1).tolist(), [0, 1] * 39 + [0])
    scans = complete_scans(reports, {"A": 8.0, "B": 5.0}, rotations)
    steps = swept_together(scans, rotations)
    assert [scan for step in steps for scan in step] == scans
    assert max(map(len, steps)) > 1
    for step in steps:
        assert step[-1].time < step[0].time + 5.0 / N_SECTORS
        assert all(early.time < late.time for early, late in pairwise(step))


def test_a_single_beam_is_searched_sector_by_sector() -> None:
    rotations = {"A": Rotation(8.0, 0.0, 1)}
    scans = complete_scans(table([0.1, 1.3, 2.0], [0, 0, 0]), {"A": 8.0}, rotations)
    assert swept_together(scans, rotations) == [(scan,) for scan in scans]
