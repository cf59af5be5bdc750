"""Reports that do not count as they came: far from all others in time or place, or heard twice."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import polars as pl
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.config.fill import Settings
from trackweave.config.sensing import ObservedSensor
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import Estimates
from trackweave.estimation.trees import tree_of
from trackweave.models.rotation import Rotation
from trackweave.models.sensors import Sensor
from trackweave.run.held import held_in
from trackweave.run.scans import scan_ends

__all__ = [
    "Doubles",
    "doubles_of",
    "heard_once",
    "is_astray",
    "is_lone",
    "note_on_astray",
    "note_on_lone",
    "repeats_within",
    "with_doubles",
]

# Farther than so many of the recording's own longer gaps; scans between may be lost.
GAPS, LONGER = 10.0, 0.9
# Where more stamps than this stand alone, that is how the recording is.
MOST_LONE = 0.1
# Positions of so many reports tell where the recording is; what is so many times as far off as
# nearly all of them is elsewhere, if it is no more than this part of all.
FEWEST_PLACES, ASTRAY, MOST_ASTRAY = 40, 30.0, 0.01
# Of what is as far from all the rest of it as the recording is wide, no object's, it may be more.
MOST_SCATTERED = 0.05


def is_lone(reports: ReportTable, max_ahead: float) -> NDArray[np.bool_]:
    """Tell which reports are of a scan that stands alone, far from both its neighbours."""
    # Gaps of hours are no fault of a recording; a single scan between two of them, or before or
    # behind all others, is. It is judged by the order in time, because rows may come in any.
    # ``max_ahead`` is how far apart scans may be in any case [s].
    time = reports.time
    gaps = np.diff(np.unique(scan_ends(reports)))
    nobody = np.zeros(len(reports), dtype=np.bool_)
    if gaps.size == 0:
        return nobody
    far = max(max_ahead, GAPS * float(np.quantile(gaps, LONGER)))
    if not np.any(gaps > far):
        return nobody
    starts = np.concatenate([[0], np.flatnonzero(np.diff(time) > far) + 1])
    number = time if reports.scan is None else reports.scan
    lone = nobody.copy()
    n_lone = 0
    for first, end in zip(starts, [*starts[1:], len(reports)], strict=True):
        own = slice(first, end)
        if np.ptp(reports.sensor[own]) == 0 and np.ptp(number[own]) == 0:
            lone[own] = True
            n_lone += 1
    return lone if n_lone <= MOST_LONE * (gaps.size + 1) else nobody


def note_on_lone(reports: ReportTable, lone: NDArray[np.bool_]) -> list[str]:
    """Return a sentence on the reports that are set aside, none where none is."""
    times = np.unique(reports.time[lone])
    if times.size == 0:
        return []
    listed = ", ".join(f"{time:.15g}" for time in times[:3].tolist())
    more = ", …" if times.size > 3 else ""
    return [
        f"time: {int(lone.sum())} reports at {listed}{more} s stand alone, far from all others; "
        "their scans are set aside, and their reports are of no track (live.max_ahead)"
    ]


def is_astray(reports: ReportTable) -> NDArray[np.bool_]:
    """Tell which positions lie so far from all others that they are no place of the recording."""
    # One at 1e9 m, or at the origin of coordinates in the millions, would make false alarms seem
    # to be spread over all that lies between.
    nobody = np.zeros(len(reports), dtype=np.bool_)
    if reports.kinds or len(reports) < FEWEST_PLACES:
        return nobody
    place = reports.measurement
    for most, outside, scattered in ((MOST_ASTRAY, 0.02, False), (MOST_SCATTERED, 0.05, True)):
        low, middle, high = np.quantile(place, [outside, 0.5, 1.0 - outside], axis=0)
        usual = float(np.max(np.maximum(high - middle, middle - low)))
        astray: NDArray[np.bool_] = np.any(np.abs(place - middle) > ASTRAY * usual, axis=1)
        if usual == 0.0 or not 0 < astray.sum() <= most * len(reports):
            continue
        if not scattered or _is_scattered(place[astray], usual):
            return astray
    return nobody


def _is_scattered(place: FloatArray, usual: float) -> bool:
    """Tell whether most of some places are farther from one another than what is usual."""
    near = tree_of(place).query(place, k=min(2, len(place)))[0].reshape(len(place), -1)[:, -1]
    return bool(np.median(near) > usual)


def note_on_astray(reports: ReportTable, astray: NDArray[np.bool_]) -> list[str]:
    """Return a sentence on the reports that are set aside for their places, none without any."""
    rows = np.flatnonzero(astray)
    if rows.size == 0:
        return []
    place = ", ".join(f"{axis:.6g}" for axis in reports.measurement[rows[0]].tolist())
    return [
        f"position: {rows.size} of {len(reports)} reports set aside, of no track, more than "
        f"{ASTRAY:.0f} times as far off as nearly all others (report {reports.report[rows[0]]} at "
        f"({place}) m on the plane); they tell nothing of noise and false alarms"
    ]


# What is told beside a measurement: copies may tell less than the first.
BESIDE = ("sigma", "strength", "height")
# Where nothing scans, receivers stamp what they hear within so many seconds, but for rounding. A
# beam that turns is elsewhere for such a part of its turn: what is said again comes by a network.
WITHIN_S, PART_OF_TURN = 2.0 + 1e-6, 0.5

Settled: TypeAlias = tuple[Settings, Estimates | None]
Settling: TypeAlias = Callable[[ReportTable], Settled]


@dataclass(frozen=True, eq=False)
class Doubles:
    """Which reports are copies of others."""

    reports: ReportTable
    # Row of the report of which each is a copy, its own where it is none, shape (reports,).
    first: IntArray
    # Whether each is a place that is said again of what has moved on; None for none.
    held: NDArray[np.bool_] | None = None
    lone: frozenset[str] = frozenset()  # Sensors that do not scan, by name

    @cached_property
    def copies(self) -> IntArray:
        """Rows of the copies."""
        return np.flatnonzero(self.first != np.arange(self.first.size))

    @cached_property
    def once(self) -> ReportTable:
        """The reports without the copies; the same table where there is none."""
        if self.copies.size == 0:
            return self.reports
        heard, named = self.first == np.arange(self.first.size), self.reports
        if named.identity is not None:
            identity, told = named.identity.copy(), self.copies[named.identity[self.copies] >= 0]
            identity[self.first[told]] = named.identity[told]
            named = replace(named, identity=identity)
        filled: dict[str, Any] = {
            name: self._filled(getattr(named, name))
            for name in BESIDE
            if getattr(named, name) is not None
        }
        named = replace(named, **filled)
        return named.part(np.flatnonzero(heard))

    def _filled(self, values: FloatArray) -> FloatArray:
        """Return values of all reports, those that one heard first lacks from its copies."""
        filled = values.copy()
        for copy in self.copies.tolist():
            own = filled[self.first[copy]]
            filled[self.first[copy]] = np.where(np.isnan(own), values[copy], own)
        return filled

    @property
    def place(self) -> IntArray:
        """Row in ``once`` of each report or of the one of which it is a copy."""
        heard = self.first == np.arange(self.first.size)
        return (np.cumsum(heard) - 1)[self.first]

    def shared(self, second: Mapping[int, int]) -> dict[int, int]:
        """Return the second track of every copy, by row, from that of each report heard once."""
        found = {row: second.get(once, -1) for row, once in enumerate(self.place.tolist())}
        return {row: track for row, track in found.items() if track >= 0}

    def restored(self, once: ReportTable) -> ReportTable:
        """Return all reports, with the measurements that those heard once have by now."""
        return replace(self.reports, measurement=once.measurement[self.place])

    def notes(self) -> list[str]:
        """Return a sentence on the copies, none where there is none."""
        is_held = np.zeros(len(self.reports), dtype=np.bool_) if self.held is None else self.held
        said, copies = [], self.copies[~is_held[self.copies]]
        if is_held.any():
            said.append(
                f"{int(is_held.sum()):,} of {len(self.reports):,} reports say a place again, to "
                "the last digit, where something was a look before that was too fast to stop: old "
                "news, as receivers tell of what they no longer hear; they have its track, and "
                "count no more"
            )
        if copies.size == 0:
            return said
        sentence = (
            f"{copies.size:,} of {len(self.reports):,} reports are heard twice: the same "
            "numbers of one sensor at one time or in one scan, or within 2 s where it has no "
            "scans or its beam turns; each counts once, and copies have the track of the first"
        )
        lone = np.array([name in self.lone for name in self.reports.sensors])
        later = self.reports.time[copies] > self.reports.time[self.first[copies]]
        if self.reports.scan is None and np.any(later & lone[self.reports.sensor[copies]]):
            sentence += (
                ". What rests and is reported anew without noise within 2 s counts as heard twice "
                "too; if the sensor looks, give scans = true"
            )
        return [*said, sentence]


def doubles_of(reports: ReportTable, settle: Settling) -> tuple[Doubles, Settled]:
    """Return which reports are copies: equal numbers of one sensor, at one time or soon after."""
    # Of a sensor that scans, copies are of one time, or of one scan where scans are numbered: what
    # stands still repeats itself from scan to scan. Of one that does not scan, or whose beam
    # turns, a report is a copy of the first of the same numbers within two seconds. The first is
    # the earliest, or the earlier row. Places that are held count as copies, too. ``settle`` fills
    # a configuration's gaps from reports without copies.
    at_once = np.zeros(len(reports.sensors))
    same = Doubles(reports, _first_heard(reports, at_once))
    settled = settle(same.once)
    sensors = {sensor.name: sensor for sensor in settled[0].sensors}
    first = same.first
    if reports.scan is None:
        within = np.array([repeats_within(sensors[name]) for name in reports.sensors])
        first = _first_heard(reports, within)
    every = held_in(reports, sensors, first)
    lone = frozenset(name for name, each in sensors.items() if each.scans is False)
    near = Doubles(reports, every, every != first, lone)
    if near.copies.size == same.copies.size:
        return same, settled
    return near, settle(near.once)


def heard_once(reports: ReportTable, observed: Mapping[str, ObservedSensor]) -> IntArray:
    """Return the rows of reports but for copies, where no more than beams is known."""
    turns = [observed[name].rotation for name in reports.sensors]
    within = np.array([0.0 if turn is None else _within_turn(turn) for turn in turns])
    return np.unique(_first_heard(reports, within))


def _within_turn(rotation: Rotation) -> float:
    return min(WITHIN_S, PART_OF_TURN * rotation.period)


def repeats_within(sensor: Sensor) -> float:
    """Return for how long the same numbers of a sensor are one report heard twice [s]."""
    if sensor.rotation is not None:
        return _within_turn(sensor.rotation)
    # From scan to scan what stands still repeats itself.
    return 0.0 if sensor.scans is not False else WITHIN_S


def _first_heard(reports: ReportTable, within_s: FloatArray) -> IntArray:
    """Return the row of the first of equal reports for each, its own where it is the first."""
    # By sensor, those within so many seconds of the first.
    what = _same_numbers(reports)
    moment = reports.look
    order = np.lexsort((moment, what))
    within = within_s[reports.sensor[order]]
    moment = moment[order]
    near = (np.diff(what[order]) == 0) & (np.diff(moment) <= within[1:])
    head = np.arange(len(reports))
    for place in (np.flatnonzero(near) + 1).tolist():
        if moment[place] - moment[head[place - 1]] <= within[place]:
            head[place] = head[place - 1]
    first = np.empty_like(head)
    first[order] = order[head]
    return first


def _same_numbers(reports: ReportTable) -> IntArray:
    """Return one number for all reports of a sensor that are equal but for their times."""
    columns: list[FloatArray | IntArray] = [reports.sensor]
    for matrix in (reports.measurement, reports.platform, reports.context):
        columns += [] if matrix is None else list(matrix.T)
    frame = pl.DataFrame({str(place): column for place, column in enumerate(columns)})
    where = frame.columns
    for beside in BESIDE:
        values = getattr(reports, beside)
        for place, column in enumerate([] if values is None else np.atleast_2d(values.T)):
            # What one copy does not tell is as the others have it, if these agree.
            own = pl.Series(f"{beside} {place}", column, nan_to_null=True)
            told = pl.col(own.name)
            is_one = told.drop_nulls().n_unique().over(where) <= 1
            frame = frame.with_columns(own).with_columns(
                pl.when(is_one).then(0.0).otherwise(told).alias(own.name)
            )
    if reports.identity is not None:
        # An identity that one copy lacks is that of the others, if those have one.
        name = pl.when(pl.col("name") >= 0).then(pl.col("name"))
        is_one = name.drop_nulls().n_unique().over(frame.columns) <= 1
        named = frame.with_columns(name=pl.Series(reports.identity))
        frame = named.with_columns(name=pl.when(is_one).then(0).otherwise(pl.col("name")))
    row = frame.with_row_index("row").select(pl.col("row").first().over(frame.columns))
    return row.to_series().cast(pl.Int64).to_numpy()


def with_doubles(record: dict[str, Any], doubles: Doubles) -> dict[str, Any]:
    """Return a run's record, a new one, that tells which reports were heard twice."""
    every = doubles.reports
    unavailable = 0 if every.unavailable is None else len(every.unavailable)
    totals = {
        **record["totals"],
        "doubles": int(doubles.copies.size),
        "unavailable_reports": unavailable,
    }
    listed = [
        {"report": str(every.report[copy]), "of": str(every.report[doubles.first[copy]])}
        for copy in doubles.copies.tolist()
    ]
    return {**record, "totals": totals, "doubles": listed}
