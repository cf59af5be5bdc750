"""All scans of a run in order, those in which a sensor saw nothing included."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan

__all__ = ["complete_scans", "missing_times", "scan_ends"]

# No object outlives this many scans without a report, so that more would change nothing.
MOST_MISSING = 50


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
