"""Scans of different sensors that belong to one instant."""

import pytest

from oracles.scenes import scan
from trackweave.run.scans import instants_of


def grouped(times, within):
    """Return the instants of scans given as name and time, in order of time."""
    scans = [scan(time, [], name) for name, time in times]
    return ["".join(each.sensor for each in instant) for instant in instants_of(scans, within)]


@pytest.mark.parametrize(
    ("times", "within", "expected"),
    [
        ([("A", 0.0), ("B", 0.0), ("A", 1.0), ("B", 1.0)], 0.0, ["AB", "AB"]),
        ([("A", 0.0), ("B", 0.4), ("A", 1.0), ("B", 1.4)], 0.5, ["AB", "AB"]),
        ([("A", 0.0), ("B", 0.4), ("A", 1.0), ("B", 1.4)], 0.1, ["A", "B", "A", "B"]),
        # Never two scans of one sensor, however wide an instant may be.
        ([("A", 0.0), ("A", 0.1), ("B", 0.2)], 9.0, ["A", "AB"]),
        # Counted from the first scan, not from scan to scan.
        ([("A", 0.0), ("B", 0.6), ("C", 1.2)], 0.6, ["AB", "C"]),
        # Periods of 1.0 s and 1.3 s.
        ([("A", 0.0), ("B", 0.0), ("A", 1.0), ("B", 1.3), ("A", 2.0)], 0.1, ["AB", "A", "B", "A"]),
        ([], 1.0, []),
    ],
)
def test_scans_near_to_the_first_of_an_instant_are_of_it(times, within, expected):
    assert grouped(times, within) == expected
