"""All scans of a run in order, those in which a sensor saw nothing included."""

from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan
from trackweave.models.rotation import Rotation
from trackweave.models.sensors import Sensor

__all__ = [
    "complete_scans",
    "missing_times",
    "notes_on_lone_reports",
    "notes_on_sparse_scans",
    "scan_ends",
]

# No object outlives this many scans without a report, so that more would change nothing.
MOST_MISSING = 50
# From so many moments on it can be told whether a sensor's reports come one by one.
FEWEST_MOMENTS = 10
# Into so many sectors a turn is cut; an object crosses few borders, and reports come in time.
N_SECTORS = 8
# Moments this many times nearer than the scan period are within a turn.
WITHIN_TURN = 1.5


def complete_scans(
    reports: ReportTable,
    periods: Mapping[str, float | None],
    rotations: Mapping[str, Rotation] | None = None,
) -> list[Scan]:
    """Return the scans of a table in order of time, with the empty ones between them.

    A scan in which a sensor reported nothing leaves no row, but it is evidence: whatever it
    covered was missed.

    Parameters
    ----------
    reports
        The reports.
    periods
        Scan period of each sensor [s], None for one that does not scan.
    rotations
        How beams turn, by sensor: such a sensor's scans are sectors of its turns, in which each
        report keeps its own time. A sensor left out does not turn.

    Returns
    -------
    Scans by time, then in the order of the table's sensors.
    """
    turning = rotations or {}
    scans = list(_scans_at_a_time(reports, turning))
    times: dict[str, list[float]] = {}
    for scan in sorted(scans, key=lambda scan: scan.time):
        times.setdefault(scan.sensor, []).append(scan.time)
    for index, sensor in enumerate(reports.sensors):
        period = periods.get(sensor)
        if period is not None and sensor in times and sensor not in turning:
            scans += _empty_scans(reports, index, list(missing_times(times[sensor], period)))
    scans += _sectors(reports, turning)
    place = {name: number for number, name in enumerate(reports.sensors)}
    return sorted(scans, key=lambda scan: (scan.time, place[scan.sensor]))


def scan_ends(reports: ReportTable, rotations: Mapping[str, Rotation] | None = None) -> FloatArray:
    """Return when each report's scan ends, which is the time that a tracker takes it for.

    Parameters
    ----------
    reports
        The reports.
    rotations
        How beams turn, by sensor, as for ``complete_scans``.

    Returns
    -------
    Times [s], shape (reports,).
    """
    if len(reports) == 0:
        return reports.time
    ends = reports.time.copy()
    if reports.scan is not None:
        pairs = np.stack([reports.sensor, reports.scan], axis=1)
        scans, number = np.unique(pairs, axis=0, return_inverse=True)
        last = np.full(len(scans), -np.inf)
        np.maximum.at(last, number.reshape(-1), reports.time)
        ends = last[number.reshape(-1)]
    for index, sensor in enumerate(reports.sensors):
        if rotations and sensor in rotations:
            rows = reports.sensor == index
            step = rotations[sensor].period / N_SECTORS
            sector = np.floor(reports.time[rows] / step)
            ends[rows] = np.maximum((sector + 1) * step, reports.time[rows])
    return ends


def _scans_at_a_time(reports: ReportTable, turning: Mapping[str, Rotation]) -> Iterator[Scan]:
    """Yield the scans of sensors of whose turns nothing is known.

    Reports that the table puts into one scan keep their own times where these differ: in a turn
    of a radar an aircraft flies a kilometre.
    """
    for scan in reports.scans():
        if scan.sensor not in turning:
            moments = reports.time[scan.report]
            yield scan if np.all(moments == scan.time) else replace(scan, moments=moments)


def _sectors(reports: ReportTable, turning: Mapping[str, Rotation]) -> Iterator[Scan]:
    """Yield the sectors of turns, as a radar sends them: what is seen in one is known at its end.

    Whole turns of several radars overlap, so that they could not be taken in order of time.
    """
    for index, sensor in enumerate(reports.sensors):
        rows = np.flatnonzero(reports.sensor == index)
        if sensor not in turning or rows.size == 0:
            continue
        step = turning[sensor].period / N_SECTORS
        number = np.floor(reports.time[rows] / step).astype(np.int64)
        seen: dict[int, list[int]] = {}
        for row, sector in zip(rows.tolist(), number.tolist(), strict=True):
            seen.setdefault(sector, []).append(row)
        found = sorted(seen)
        for before, sector in zip([None, *found[:-1]], found, strict=True):
            for empty in _between(before, sector):
                yield _empty_sector(reports, index, (empty + 1) * step)
            own = np.array(seen[sector], dtype=np.int64)
            end = max((sector + 1) * step, float(reports.time[own].max()))
            yield reports.scan_of(own, end, own_times=True)


def _between(before: int | None, after: int) -> list[int]:
    """Return the sectors between two, of a long silence only those near its two ends."""
    if before is None:
        return []
    near = MOST_MISSING * N_SECTORS
    early = range(before + 1, min(before + 1 + near, after))
    return [*early, *range(max(early.stop, after - near), after)]


def _empty_sector(reports: ReportTable, sensor: int, time: float) -> Scan:
    """Return a sector in which a sensor saw nothing."""
    (scan,) = _empty_scans(reports, sensor, [time])
    return replace(scan, moments=np.empty(0))


def _empty_scans(reports: ReportTable, sensor: int, times: list[float]) -> list[Scan]:
    """Return scans of a sensor without reports, which say where it was all the same."""
    nothing = np.empty((0, reports.kind_of(sensor).n_components(reports.dim)))
    places: list[FloatArray | None] = [None] * len(times)
    rows = reports.sensor == sensor
    if reports.platform is not None and times and not np.isnan(reports.platform[rows, 0]).any():
        known = reports.platform[rows]
        between = [np.interp(times, reports.time[rows], known[:, axis]) for axis in range(6)]
        places = list(np.stack(between, axis=-1))
    name = reports.sensors[sensor]
    return [
        Scan(time, name, nothing, platform=place)
        for time, place in zip(times, places, strict=True)
    ]


def notes_on_lone_reports(
    reports: ReportTable,
    periods: Mapping[str, float | None],
    guessed: Container[str],
    turning: Container[str] = (),
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
    turning
        Names of the sensors whose reports are grouped into turns.

    Returns
    -------
    Nothing for a table with scan numbers, in which no turn has to be guessed.
    """
    if reports.scan is not None:
        return []
    notes = []
    for number, name in enumerate(reports.sensors):
        if name in turning:
            continue
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
            "for a rotating sensor give its rotation and scan_period, or a `scan` column"
        )
    return notes


def notes_on_sparse_scans(
    reports: ReportTable,
    sensors: Iterable[Sensor],
    guessed: Container[str],
    turning: Container[str] = (),
) -> list[str]:
    """Return a sentence for each sensor that has far fewer scans than its scan period says.

    Parameters
    ----------
    reports
        The reports.
    sensors
        The sensors as they are configured.
    guessed
        Names of the sensors whose period nobody gave.
    turning
        Names of the sensors whose reports are grouped into turns.

    Returns
    -------
    Nothing where as many scans hold a report as would with a single object.
    """
    notes = []
    for sensor in sensors:
        name, period = sensor.name, sensor.scan_period
        if name in guessed or name in turning or period is None or name not in reports.sensors:
            continue
        number = reports.sensors.index(name)
        gaps = np.diff(np.unique(reports.time[reports.sensor == number]))
        usual = float(np.median(gaps)) if gaps.size + 1 >= FEWEST_MOMENTS else 0.0
        if usual > WITHIN_TURN * period / sensor.detection_probability:
            notes.append(
                f"sensor {name}: its reports come every {usual:g} s, although its scan period is "
                f"{period:g} s; the scans between count as misses of every track"
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
