"""All scans of a run in order, those in which a sensor saw nothing included."""

from collections.abc import Container, Iterable, Iterator, Mapping
from itertools import pairwise

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan

__all__ = ["complete_scans", "missing_times", "notes_on_lone_reports", "scan_ends"]

# No object outlives this many scans without a report, so that more would change nothing.
MOST_MISSING = 50
# From so many moments on it can be told whether a sensor's reports come one by one.
FEWEST_MOMENTS = 10
# Moments this many times nearer than the scan period are within a turn.
WITHIN_TURN = 1.5


def complete_scans(reports: ReportTable, periods: Mapping[str, float | None]) -> list[Scan]:
    """Return the scans of a table in order of time, with the empty ones between them.

    A scan in which a sensor reported nothing leaves no row, but it is evidence: whatever it
    covered was missed.

    Parameters
    ----------
    reports
        The reports.
    periods
        Scan period of each sensor [s], None for one that does not scan.

    Returns
    -------
    Scans by time, then in the order of the table's sensors.
    """
    scans = list(reports.scans())
    times: dict[str, list[float]] = {}
    for scan in scans:
        times.setdefault(scan.sensor, []).append(scan.time)
    nothing = np.empty((0, reports.dim))
    for sensor, found in times.items():
        period = periods.get(sensor)
        if period is not None:
            scans += [Scan(time, sensor, nothing) for time in missing_times(found, period)]
    place = {name: number for number, name in enumerate(reports.sensors)}
    return sorted(scans, key=lambda scan: (scan.time, place[scan.sensor]))


def scan_ends(reports: ReportTable) -> FloatArray:
    """Return when each report's scan ends, which is the time that a tracker takes it for.

    Parameters
    ----------
    reports
        The reports.

    Returns
    -------
    Times [s], shape (reports,).
    """
    if reports.scan is None or len(reports) == 0:
        return reports.time
    pairs = np.stack([reports.sensor, reports.scan], axis=1)
    scans, number = np.unique(pairs, axis=0, return_inverse=True)
    ends = np.full(len(scans), -np.inf)
    np.maximum.at(ends, number.reshape(-1), reports.time)
    return np.asarray(ends[number.reshape(-1)])


def notes_on_lone_reports(
    reports: ReportTable, periods: Mapping[str, float | None], guessed: Container[str]
) -> list[str]:
    """Return a sentence for each sensor whose reports come one by one, as a rotating one's do.

    Parameters
    ----------
    reports
        The reports.
    periods
        Scan period of each sensor [s], None for one that does not scan.
    guessed
        Names of the sensors whose period nobody gave.

    Returns
    -------
    Nothing for a table with scan numbers, in which no turn has to be guessed.
    """
    if reports.scan is not None:
        return []
    notes = []
    for number, name in enumerate(reports.sensors):
        moments, sizes = np.unique(reports.time[reports.sensor == number], return_counts=True)
        if moments.size < FEWEST_MOMENTS or np.median(sizes) > 1:
            continue
        gaps, period = np.diff(moments), periods.get(name)
        if name in guessed:
            if period is not None and _is_steady(gaps, period):
                continue
            but = "and no scan_period is given, so that each is taken for a scan of its own"
        elif period is not None and WITHIN_TURN * float(np.median(gaps)) < period:
            but = f"although its scan period is {period:g} s"
        else:
            continue
        notes.append(
            f"sensor {name}: {np.sum(sizes == 1)} of {sizes.size} scans hold one report {but}; "
            "plots of a rotating sensor are not grouped into turns yet: give a `scan` column"
        )
    return notes


def _is_steady(gaps: FloatArray, period: float) -> bool:
    """Tell whether a sensor's clock is better than the azimuths of plots would let it seem."""
    turns = gaps / period
    return float(np.mean(np.abs(turns - np.round(turns)) < 0.05)) > 0.95


def missing_times(times: Iterable[float], period: float) -> Iterator[float]:
    """Yield when a sensor scanned without a report.

    Parameters
    ----------
    times
        When it scanned with one [s], ascending.
    period
        Its scan period [s]. Must be positive.

    Yields
    ------
    Times [s] between the first and the last; of a long gap only those near its two ends.
    """
    found: FloatArray = np.fromiter(times, dtype=np.float64)
    for before, after in pairwise(found):
        n_missing = round(min((after - before) / period, 1e15)) - 1
        if n_missing <= 0:
            continue
        # Spread evenly, because periods are never exact, over as many as fit.
        step = (after - before) / (n_missing + 1)
        near = min(n_missing, 2 * MOST_MISSING)
        first = near if near == n_missing else MOST_MISSING
        yield from (float(before + step * k) for k in range(1, first + 1))
        yield from (float(after - step * k) for k in range(near - first, 0, -1))
