"""Sensors that copy others, and reports that come all at once."""

from collections.abc import Iterator
from itertools import permutations

import numpy as np

from trackweave.run.diagnostics.case import Case, Finding

__all__ = ["copied_sensors", "single_times"]

FEWEST_AT_ONCE = 10
# A sensor is another's copy when so many of its reports are; rounded numbers meet by chance.
FEWEST_COPIES, COPIED_SHARE, LEAST_DIFFERENT = 10, 0.5, 0.9
MOST_COMPARED = 2000


def single_times(case: Case) -> Iterator[Finding]:
    """Yield which sensors report at one time only, although more than a scan holds."""
    for name, own in zip(case.reports.sensors, case.rows, strict=True):
        time = case.reports.time[own]
        if time.size >= FEWEST_AT_ONCE and np.ptp(time) == 0.0 and case.reports.scan is None:
            yield Finding(
                "one time",
                name,
                f"sensor {name}: all {time.size} reports have the time {time[0]:.15g} s, so that "
                "they are one scan",
                weight=50.0,
            )


def copied_sensors(case: Case) -> Iterator[Finding]:
    """Yield which sensors' reports are those of another, number for number."""
    reports, said = case.reports, set[str]()
    keys = {index: _numbers(case, index) for index in case.examined}
    for one, other in permutations(keys, 2):
        copy, original = reports.sensors[one], reports.sensors[other]
        if copy in said or original in said or reports.kind_of(one) != reports.kind_of(other):
            continue
        if min(keys[one].size, keys[other].size) < FEWEST_COPIES:
            continue
        equal = int(np.isin(keys[one], keys[other]).sum())
        if equal < COPIED_SHARE * keys[one].size or _is_coarse(keys[one]):
            continue
        said.add(copy)
        yield Finding(
            "copies",
            copy,
            f"sensor {copy}: {equal} of {keys[one].size} of its reports are number for number "
            f"those of sensor {original}; copies count as evidence of their own: leave one out",
            weight=150.0,
            seen=equal / keys[one].size,
        )


def _numbers(case: Case, index: int) -> np.ndarray:
    """Return one number for what each of a sensor's reports measures."""
    measured = np.nan_to_num(case.reports.measurement[case.rows[index]][:MOST_COMPARED])
    # Any mixture will do that different measurements hardly share.
    return np.asarray(measured @ np.sqrt(2.0 + np.arange(measured.shape[1])))


def _is_coarse(numbers: np.ndarray) -> bool:
    return np.unique(numbers).size < LEAST_DIFFERENT * numbers.size
