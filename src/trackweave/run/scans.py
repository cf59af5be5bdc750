"""Scans of a run: turns of a beam, scans in which nothing was seen, scans of one instant."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice, pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan
from trackweave.models.rotation import FollowedRotation, Rotation
from trackweave.run.batches import batch_rows, naming
from trackweave.summaries import counted

__all__ = [
    "N_SECTORS",
    "Sectors",
    "complete_scans",
    "instants_of",
    "missing_times",
    "missing_turns",
    "notes_on_pauses",
    "scan_ends",
    "swept_together",
    "turn_ends",
    "with_turns",
]

# Into so many sectors a turn is cut; an object crosses few borders, and reports come in time.
N_SECTORS = 8
# A cut is moved by up to this share of a sector, to where there are no reports.
MOST_MOVED = 0.25
# Of so many directions the one with the fewest reports is where turns begin.
N_DIRECTIONS = 36


class Sectors:
    """The sectors of a beam's turns, and in which of them reports are.

    Where a beam that wanders is known to some thousandths of a turn only, an object at the border
    of two sectors would be looked for in one and reported in the other. Each turn is cut anew
    there, in the widest gap between reports.
    """

    def __init__(self, rotation: Rotation, time: FloatArray) -> None:
        self._rotation = rotation
        self._moved: dict[int, float] = {}
        swept = rotation.turned(time) * N_SECTORS
        self.number: IntArray = np.floor(swept).astype(np.int64)
        if isinstance(rotation, FollowedRotation):
            borders, cuts = _cuts(swept)
            self._moved = dict(zip(borders.tolist(), cuts.tolist(), strict=True))
            nearest = np.round(swept)
            place = np.searchsorted(borders, nearest).clip(max=max(borders.size - 1, 0))
            if borders.size:
                moved = borders[place] == nearest
                after = nearest - (swept < cuts[place])
                self.number = np.where(moved, after, self.number).astype(np.int64)

    def end(self, number: int) -> float:
        """Return when a sector ends [s]."""
        return float(self._rotation.when(self._moved.get(number + 1, number + 1) / N_SECTORS))

    def ends(self, number: IntArray) -> FloatArray:
        """Return when sectors end [s]."""
        sectors, place = np.unique(number, return_inverse=True)
        moved = [self._moved.get(each + 1, each + 1) for each in sectors.tolist()]
        ends = self._rotation.when(np.asarray(moved, dtype=np.float64) * (1.0 / N_SECTORS))
        return np.asarray(ends[place.reshape(-1)])


def _cuts(swept: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the borders near which there are reports, and where to cut instead [sectors]."""
    border = np.round(swept)
    near = np.abs(swept - border) < MOST_MOVED
    borders = np.unique(border[near])
    if borders.size == 0:
        return borders, borders
    edges = np.concatenate([borders - MOST_MOVED, borders + MOST_MOVED])
    point = np.sort(np.concatenate([swept[near], edges]))
    owner = np.round(point)
    gap = np.where(owner[1:] == owner[:-1], np.diff(point), -1.0)
    middle = (point[1:] + point[:-1]) / 2
    widest = np.lexsort((gap, owner[:-1]))
    last = np.searchsorted(owner[:-1][widest], borders, side="right") - 1
    return borders, middle[widest[last]]


def turn_ends(time: FloatArray, rotation: Rotation) -> tuple[IntArray, FloatArray]:
    """Return the number of each report's turn, and when it ends [s], none before the report."""
    # A turn begins where the sensor sees least: an object there may be seen twice in a turn or not
    # at all, because it moves and because no clock is exact.
    turned = rotation.turned(time)
    place = np.minimum((N_DIRECTIONS * (turned % 1.0)).astype(np.int64), N_DIRECTIONS - 1)
    crowd = np.bincount(place, minlength=N_DIRECTIONS).astype(float)
    # A direction counts with half of its neighbours, which tells gaps from chance; of equally
    # empty ones the one in the midst of the widest gap is taken.
    near = crowd + (np.roll(crowd, 1) + np.roll(crowd, -1)) / 2
    reach = N_DIRECTIONS // 4
    far = sum(
        (np.roll(crowd, step) + np.roll(crowd, -step)) * (1 - step / reach)
        for step in range(1, reach)
    )
    quietest = np.argmin(near + far / (1e3 * max(time.size, 1)))
    begin = (float(quietest) + 0.5) / N_DIRECTIONS
    number = np.floor(turned - begin).astype(np.int64)
    ends = rotation.when(np.asarray(number + 1 + begin, dtype=np.float64))
    return number, np.maximum(ends, time)


def with_turns(reports: ReportTable, rotations: Mapping[str, Rotation]) -> IntArray | None:
    """Return scan numbers, unique within a sensor, for a table in which turns are scans."""
    # Those of the table are kept where it has any; a sensor that does not turn has a scan at each
    # time.
    if reports.scan is not None or not rotations:
        return reports.scan
    _, scan = np.unique(reports.time, return_inverse=True)
    scan = scan.reshape(-1).astype(np.int64)
    for index, name in enumerate(reports.sensors):
        if name in rotations:
            rows = reports.sensor == index
            scan[rows], _ = turn_ends(reports.time[rows], rotations[name])
    return scan


# No object outlives this many scans without a report, so that more would change nothing.
MOST_MISSING = 50
# After so many scans with so many reports on average, one without any was none: chance would empty
# it once in three thousand times, and that several objects hide at once is rarer than that a
# sensor pauses. The number of one scan alone may be chance itself.
FULL, LAST, PAUSE = 8, 4, 1.75
# So many gaps in succession that differ by less than such a factor are a pace of the sensor's own.
ALIKE, SAME_PACE = 4, 1.1


def complete_scans(
    reports: ReportTable,
    periods: Mapping[str, float | None],
    rotations: Mapping[str, Rotation] | None = None,
    hearing: Collection[str] = (),
) -> list[Scan]:
    """Return the scans of a table in order of time, with the empty ones between them."""
    # A scan in which a sensor reported nothing leaves no row, but it is evidence: whatever it
    # covered was missed; unless the last ones had many: then it did not look. Scans of one time
    # are in the order of the table's sensors. A sensor with a rotation makes sectors, in which
    # each report keeps its own time, and so it does in the batches of those that are ``hearing``
    # objects report themselves; one with the period None does not scan.
    turning = rotations or {}
    hearing = naming(reports, hearing)
    scans = list(_scans_at_a_time(reports, {*turning, *hearing}))
    seen: dict[str, list[Scan]] = {}
    for scan in sorted(scans, key=lambda scan: scan.time):
        seen.setdefault(scan.sensor, []).append(scan)
    for index, sensor in enumerate(reports.sensors):
        period = periods.get(sensor)
        if period is not None and sensor in seen and sensor not in turning:
            scans += _empty_scans(reports, index, list(_missing(seen[sensor], period)))
    scans += [*_sectors(reports, turning), *_batches(reports, hearing)]
    place = {name: number for number, name in enumerate(reports.sensors)}
    return sorted(scans, key=lambda scan: (scan.time, place[scan.sensor]))


def scan_ends(
    reports: ReportTable,
    rotations: Mapping[str, Rotation] | None = None,
    hearing: Collection[str] = (),
) -> FloatArray:
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
    for name in naming(reports, hearing):
        for rows in batch_rows(reports, name):
            ends[rows] = reports.time[rows].max()
    return ends


def _batches(reports: ReportTable, hearing: Collection[str]) -> Iterator[Scan]:
    """Yield the batches of some sensors."""
    for name in hearing:
        for rows in batch_rows(reports, name):
            time = reports.time[rows]
            own_times = bool(np.any(time != time.max()))
            yield reports.scan_of(rows, float(time.max()), own_times=own_times)


def _scans_at_a_time(reports: ReportTable, others: Collection[str]) -> Iterator[Scan]:
    """Yield the scans of all but some other sensors, which come one by one."""
    # Reports that the table puts into one scan keep their own times where these differ: in a turn
    # of a radar an aircraft flies a kilometre.
    for scan in reports.scans(but=others):
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
        order = np.argsort(sectors.number, kind="stable")
        found, begin = np.unique(sectors.number[order], return_index=True)
        of_each = np.split(rows[order], begin[1:])
        is_full = [False, *_is_full(found, np.diff(begin, append=rows.size)).tolist()]
        before = None
        for sector, own, after_many in zip(found.tolist(), of_each, is_full, strict=False):
            for empty in _between(before, sector, after_many=after_many):
                yield _empty_sector(reports, index, sectors.end(empty))
            before = sector
            end = max(sectors.end(sector), float(reports.time[own].max()))
            yield reports.scan_of(own, end, own_times=True)


def _is_full(found: IntArray, count: IntArray) -> NDArray[np.bool_]:
    """Tell whether the last turns up to each of some sectors had many reports."""
    # ``found`` are the sectors with reports, ascending, and ``count`` how many each has.
    total = np.r_[0, np.cumsum(count)]
    begin = np.searchsorted(found, found - LAST * N_SECTORS, side="right")
    return np.asarray(total[1:] - total[begin] >= LAST * FULL)


def _between(before: int | None, after: int, *, after_many: bool) -> list[int]:
    """Return the sectors between two, of a long silence only those near its two ends."""
    # A sensor that saw many objects in its turns and then none in one has stopped.
    if before is None:
        return []
    if after_many:
        return list(range(before + 1, min(before + 1 + N_SECTORS, after)))
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


def notes_on_pauses(scans: Iterable[Scan], periods: Mapping[str, float | None]) -> list[str]:
    """Return a sentence on each sensor that did not look for two periods and more."""
    # Of a long silence without a pause empty scans are put near its two ends alone.
    found: dict[str, list[tuple[float, float]]] = {}
    for scan in scans:
        own = found.setdefault(scan.sensor, [])
        last = scan.time if len(scan) else own[-1][1] if own else -np.inf
        own.append((scan.time, last))
    notes = []
    for name, period in periods.items():
        time, heard = np.array(found.get(name, [(0.0, 0.0)])).T
        gaps, least = np.diff(time), PAUSE * (period or np.inf)
        long = gaps[(gaps > least) & (time[:-1] - heard[:-1] < least)]
        if long.size:
            notes.append(
                f"sensor {name}: {counted(long.size, 'pause')} of up to {long.max():.4g} s, right "
                f"after {LAST} scans of {FULL} reports and more on average or {ALIKE} and more in "
                "succession as long: it did not look, and tracks go on"
            )
    return notes


def _many(count: IntArray) -> NDArray[np.bool_]:
    """Tell whether the last scans up to each had many reports."""
    total = np.cumsum(count)
    return np.asarray(total - np.r_[np.zeros(LAST), total][: total.size] >= LAST * FULL)


def _are_paced(time: FloatArray) -> NDArray[np.bool_]:
    """Tell which gaps between scans are some of several alike: the sensor took another pace."""
    gaps = np.diff(time)
    if gaps.size < ALIKE:
        return np.zeros(gaps.size, dtype=np.bool_)
    together = sliding_window_view(gaps, ALIKE)
    alike = np.flatnonzero(together.max(axis=1) < SAME_PACE * together.min(axis=1))
    paced = np.zeros(gaps.size, dtype=np.bool_)
    paced[(alike[:, np.newaxis] + np.arange(ALIKE)).ravel()] = True
    return paced


def _missing(scans: Sequence[Scan], period: float) -> Iterator[float]:
    """Yield when a sensor scanned and saw nothing [s], between its scans in order of time."""
    count = np.array([len(scan) for scan in scans])
    looks = _many(count)[:-1] | _are_paced(np.array([scan.time for scan in scans]))
    for (before, after), is_pause in zip(pairwise(scans), looks, strict=True):
        if not is_pause:
            yield from missing_times([before.time, after.time], period)


def missing_turns(ends: FloatArray, count: IntArray, period: float) -> Iterator[float]:
    """Yield when turns without a report ended [s], from the ends of those with some."""
    for before, after, many in zip(ends[:-1], ends[1:], _many(count), strict=False):
        missing = missing_times([float(before), float(after)], period)
        yield from islice(missing, 1) if many else missing


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


def instants_of(scans: Iterable[Scan], within: float) -> list[tuple[Scan, ...]]:
    """Return scans, in order of time, by the instants at which they were taken, within [s] ≥ 0."""
    # An instant begins with the first scan that is of none yet, and takes in those that follow
    # within the time, up to the first of a sensor that it has already. Its scans are in order of
    # their sensors' names.
    instants: list[list[Scan]] = []
    for scan in scans:
        last: Sequence[Scan] = instants[-1] if instants else ()
        is_near = bool(last) and scan.time - last[0].time <= within
        if is_near and all(scan.sensor != other.sensor for other in last):
            instants[-1].append(scan)
        else:
            instants.append([scan])
    return [tuple(sorted(instant, key=lambda scan: scan.sensor)) for instant in instants]


def swept_together(
    scans: Iterable[Scan], rotations: Mapping[str, Rotation]
) -> list[tuple[Scan, ...]]:
    """Return scans, in order of time, by steps of which each is searched once."""
    # Where several beams turn, a step is what they sweep while the fastest sweeps a sector: with
    # each beam more the sectors come closer, and hardly anything is decided between two of them.
    longest = 0.0
    if len(rotations) > 1:
        longest = min(turning.period for turning in rotations.values()) / N_SECTORS
    steps: list[list[Scan]] = []
    for scan in scans:
        if steps and steps[-1][-1].time < scan.time < steps[-1][0].time + longest:
            steps[-1].append(scan)
        else:
            steps.append([scan])
    return [tuple(step) for step in steps]
