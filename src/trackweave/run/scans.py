"""All scans of a run in order, those in which a sensor saw nothing included."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan
from trackweave.models.rotation import Rotation
from trackweave.run.turns import N_SECTORS, Sectors

__all__ = ["complete_scans", "missing_times", "scan_ends"]

# No object outlives this many scans without a report, so that more would change nothing.
MOST_MISSING = 50


def complete_scans(
    reports: ReportTable,
    periods: Mapping[str, float | None],
    rotations: Mapping[str, Rotation] | None = None,
) -> list[Scan]:
    """Return the scans of a table in order of time, with the empty ones between them."""
    # A scan in which a sensor reported nothing leaves no row, but it is evidence: whatever it
    # covered was missed. Scans of one time are in the order of the table's sensors. A sensor with
    # a rotation makes sectors, in which each report keeps its own time; one with the period None
    # does not scan.
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
    """Return when each report's scan ends, the time that a tracker takes it for [s]."""
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
            sectors = Sectors(rotations[sensor], reports.time[rows])
            ends[rows] = np.maximum(sectors.ends(sectors.number), reports.time[rows])
    return ends


def _scans_at_a_time(reports: ReportTable, turning: Mapping[str, Rotation]) -> Iterator[Scan]:
    """Yield the scans of sensors of whose turns nothing is known."""
    # Reports that the table puts into one scan keep their own times where these differ: in a turn
    # of a radar an aircraft flies a kilometre.
    for scan in reports.scans():
        if scan.sensor not in turning:
            moments = reports.time[scan.report]
            yield scan if np.all(moments == scan.time) else replace(scan, moments=moments)


def _sectors(reports: ReportTable, turning: Mapping[str, Rotation]) -> Iterator[Scan]:
    """Yield the sectors of turns, as a radar sends them: what one holds is known at its end."""
    # Whole turns of several radars overlap, so that they could not be taken in order of time.
    for index, sensor in enumerate(reports.sensors):
        rows = np.flatnonzero(reports.sensor == index)
        if sensor not in turning or rows.size == 0:
            continue
        sectors = Sectors(turning[sensor], reports.time[rows])
        seen: dict[int, list[int]] = {}
        for row, sector in zip(rows.tolist(), sectors.number.tolist(), strict=True):
            seen.setdefault(sector, []).append(row)
        found = sorted(seen)
        for before, sector in zip([None, *found[:-1]], found, strict=True):
            for empty in _between(before, sector):
                yield _empty_sector(reports, index, sectors.end(empty))
            own = np.array(seen[sector], dtype=np.int64)
            end = max(sectors.end(sector), float(reports.time[own].max()))
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


def missing_times(times: Iterable[float], period: float) -> Iterator[float]:
    """Yield when a sensor scanned without a report [s], from ascending times with one."""
    # Of a long gap only the times near its two ends are told.
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
