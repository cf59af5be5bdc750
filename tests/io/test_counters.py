"""Scan numbers that begin anew are other scans."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.io.counters import unwrapped


@pytest.mark.parametrize("modulus", [10, 100, 256])
def test_a_counter_that_wraps_goes_on(modulus):
    true = np.repeat(np.arange(1000), 3)
    number, count = unwrapped(true % modulus)
    assert count == 999 // modulus
    assert np.array_equal(np.diff(number) > 0, np.diff(true) > 0)


def test_late_reports_of_the_scan_before_stay_there():
    number, count = unwrapped(np.array([253, 254, 255, 0, 255, 1, 0, 2, 3, 4, 5, 254]))
    assert count == 1
    assert number[4] == number[2]
    assert number[6] == number[3]
    assert np.unique(number).size == 9


def test_numbers_that_do_not_begin_anew_stay_as_they_are():
    for scan in ([5, 5, 6, 4, 6, 7, 9, 8], [3], []):
        number, count = unwrapped(np.array(scan, dtype=np.int64))
        assert number.tolist() == scan
        assert count == 0


def test_a_note_tells_of_counters_that_begin_anew():
    time = np.arange(600) // 2
    table = pl.DataFrame({"time": time, "x": time * 1.0, "y": 0.0, "scan": time % 128})
    reports = tw.read_reports(table)
    assert np.unique(reports.scan).size == 300
    assert reports.notes[-1] == (
        "column scan: numbers of sensor default begin anew 2 times; those before and after are "
        "other scans"
    )
