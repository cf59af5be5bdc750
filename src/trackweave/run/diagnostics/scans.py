"""How often sensors scan, copies of other sensors, and reports that come all at once."""

from collections.abc import Iterator
from itertools import permutations

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.config.sensing import sense_of
from trackweave.estimation.lone import judged
from trackweave.estimation.rotation import follows, loose_rotation_of, rotation_of
from trackweave.models.sensors import Sensor
from trackweave.run.diagnostics.case import Case, Finding

__all__ = [
    "copied_sensors",
    "lone_reports",
    "reporting_objects",
    "single_times",
    "sparse_scans",
    "unseen_turns",
]

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


# From so many moments on it can be told how a sensor's reports come.
FEWEST_MOMENTS = 10
# Moments this many times nearer than the scan period are within a turn, and this many times
# farther apart more than a miss.
WITHIN_TURN = 1.5
# It explains whatever tracks show.
A_CAUSE = 95.0


def lone_reports(case: Case) -> Iterator[Finding]:
    """Yield sensors whose reports come one by one although nobody says that they turn."""
    if case.reports.scan is not None:
        return
    for sensor, sizes, gaps in _paces(case):
        if np.median(sizes) > 1 or sensor.scans is False:
            continue
        why = _is_told_otherwise(sensor, gaps, is_given=sensor.name not in case.guessed)
        if why:
            yield Finding(
                "lone reports",
                sensor.name,
                f"sensor {sensor.name}: {np.sum(sizes == 1)} of {sizes.size} scans hold one "
                f"report {why}; for a rotating sensor give its rotation and scan_period, or a "
                "`scan` column, and scans = false where objects report by themselves",
                weight=40.0,
            )


def unseen_turns(case: Case) -> Iterator[Finding]:
    """Yield sensors whose lone reports are those of a turn that is told away."""
    if case.reports.scan is not None:
        return
    for index in case.examined:
        sensor, own = case.sensors[index], case.rows[index]
        time = case.reports.time[own]
        moments, sizes = np.unique(time, return_counts=True)
        is_lone = moments.size >= FEWEST_MOMENTS and np.median(sizes) <= 1
        is_silent = sensor.scans is False and case.is_told(f"sensors.{sensor.name}.scans")
        if not is_lone or is_silent or not case.tells_place(index):
            continue
        place = case.position[own]
        azimuth = np.arctan2(*(place - case.platform[own]).T)
        if sensor.rotation is not None and follows(time, azimuth, sensor.rotation):
            continue
        is_denied = case.is_told(f"sensors.{sensor.name}.rotation") and sensor.rotation is None
        found = None
        if is_denied:
            found = rotation_of(time, azimuth) or loose_rotation_of(time, azimuth)
        if found is not None:
            yield Finding(
                "turn",
                sensor.name,
                f"sensor {sensor.name}: its reports come as from a beam that turns "
                f'{sense_of(found)} in {found.period:.4g} s; leave rotation = "none" out in '
                f"[sensors.{sensor.name}]",
                weight=A_CAUSE,
                seen=found.period,
            )


def reporting_objects(case: Case) -> Iterator[Finding]:
    """Yield sensors that are told to scan, and whose objects report by themselves."""
    for index in case.examined:
        sensor = case.sensors[index]
        is_told = case.is_told(f"sensors.{sensor.name}.scans") and sensor.scans is True
        is_position = case.reports.kind_of(index).is_position
        if not is_told or not is_position or sensor.rotation is not None:
            continue
        seen = judged(case.reports, index)[0]
        if seen.scans is False:
            yield Finding(
                "scans",
                sensor.name,
                f"sensor {sensor.name}: scans is told as true, but {seen.n_objects} objects keep "
                "pauses of their own between reports, as in AIS: give scans = false, or leave it "
                "out, so that no silence counts as a miss",
                weight=A_CAUSE,
            )


def sparse_scans(case: Case) -> Iterator[Finding]:
    """Yield sensors of which fewer scans hold a report than with a single object."""
    for sensor, _, gaps in _paces(case):
        period, usual = sensor.scan_period, float(np.median(gaps))
        if sensor.name in case.guessed or period is None:
            continue
        if usual > WITHIN_TURN * period / sensor.detection_probability:
            yield Finding(
                "scan period",
                sensor.name,
                f"sensor {sensor.name}: its reports come every {usual:g} s, although its scan "
                f"period is {period:g} s; the scans between count as misses of every track",
                weight=45.0,
                told=period,
                seen=usual,
            )


def _paces(case: Case) -> Iterator[tuple[Sensor, IntArray, FloatArray]]:
    """Yield sensors that do not turn, the sizes of their scans and the gaps between them."""
    for sensor, own in zip(case.sensors, case.rows, strict=True):
        moments, sizes = np.unique(case.reports.time[own], return_counts=True)
        if sensor.rotation is None and moments.size >= FEWEST_MOMENTS:
            yield sensor, sizes, np.diff(moments)


def _is_told_otherwise(sensor: Sensor, gaps: FloatArray, *, is_given: bool) -> str:
    """Return what speaks against scans of one report being scans, nothing where they may be."""
    period = sensor.scan_period
    if is_given:
        if period is None or WITHIN_TURN * float(np.median(gaps)) >= period:
            return ""
        return f"although its scan period is {period:g} s"
    if period is not None and _is_steady(gaps, period):
        return ""
    return "and no scan_period is given, so that each is taken for a scan of its own"


def _is_steady(gaps: FloatArray, period: float) -> bool:
    """Tell whether a sensor's clock is better than the azimuths of plots would let it seem."""
    turns = gaps / period
    return float(np.mean(np.abs(turns - np.round(turns)) < 0.05)) > 0.95
