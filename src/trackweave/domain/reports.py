"""Reports as columns, and their grouping into scans."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.facts import Facts, Skips
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.frames import LocalFrame
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.scans import Scan
from trackweave.keys import ANGLE_NOISE, NOISE
from trackweave.summaries import summary

__all__ = ["ANGLE_NOISE_DEG", "NOISE_M", "BadRow", "ReportTable"]

NOISE_M = (NOISE.least, NOISE.most)
"""Least and greatest standard deviation of a length [m], or of a rate [m/s]: a nanometre is what
the sharpest microscope tells, a million kilometres more than any sensor is off."""
ANGLE_NOISE_DEG = (ANGLE_NOISE.least, ANGLE_NOISE.most)
"""The same of an angle [degrees]: from what radio telescopes an Earth apart tell to nothing."""


@dataclass(frozen=True, slots=True)
class BadRow:
    """A row of a table that cannot be used, and why.

    Records count from 1, after the header; without a column the row as a whole is at fault. Of
    several files together ``file`` is the one in which the row has its number.
    """

    row: int
    column: str | None
    found: str
    expected: str
    file: str = ""

    def message(self, source: str) -> str:
        """Return the sentence that tells of the row, ``source`` being the file's name."""
        place = f"row {self.row}" + ("" if self.column is None else f", column {self.column}")
        return f"{self.file or source}, {place}: {self.found}; expected {self.expected}"


_PER_REPORT = (
    "time", "sensor", "measurement", "sigma", "report", "scan", "platform", "identity",
    "strength", "height", "row", "context", "stamp",
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class ReportTable:
    """Reports of one or many sensors, one array per column, sorted by time, then sensor.

    Built by the readers in ``trackweave.io``, which check every value; row k of each column
    belongs to the same report.

    Parameters
    ----------
    time
        Time of each report [s], shape (reports,), ascending.
    sensor
        Index into ``sensors``, shape (reports,).
    sensors
        Names of the sensors.
    measurement
        What each report measures, shape (reports, width), in the order of its sensor's kind,
        angles in radians from 0 to 2π; NaN to the right of what a kind has.
    sigma
        Standard deviation of each number, of the same shape; NaN where the file has none.
    report
        Identifier of each report as text, shape (reports,).
    scan
        Scan number of each report, shape (reports,), or None when the table has no such column.
    carried
        Columns that pass through to the assignments, in the order of the rows here.
    frame
        The plane on which latitudes and longitudes were laid, None for plane coordinates.
    iso_time
        Whether times came as ISO 8601 (seconds are then counted from 1970 UTC).
    skipped
        Rows that were left out because they could not be used, in the file's order.
    kind
        The kind of table that came in and in which results go back: "polars" (also for files),
        "pandas" or "pyarrow".
    kinds
        What each sensor measures; empty where all report positions.
    space
        Number of dimensions of the tracking space, 2 or 3; 0 for as many as a measurement has
        numbers, where all sensors report positions.
    platform
        Where each report's sensor was, and how it moved: x, y, z [m] and their rates [m/s], shape
        (reports, 6); NaN where the row does not say. None where no row does.
    identity
        Whom each report says it is of, an index into ``identities`` or -1, shape (reports,).
    identities
        Their names.
    strength
        How strong each report is, shape (reports,), NaN where the row does not say.
    height
        Height of each report's object [m], shape (reports,), NaN where the row does not say.
    notes
        Sentences on what a user should know of how the table was read.
    row
        Number of each report's data record in what was read, from 1, shape (reports,); None where
        the reports came in the order that they have here.
    unavailable
        Reports whose position is a code for "not available": their measurements are NaN, and
        they are of no scan; None where there are none.
    context
        Further numbers of each report that a kind from outside the package asks for, shape
        (reports, numbers), NaN where a cell is empty; None where no kind does.
    report_type
        The polars type of the whole numbers that all identifiers are, None where they are text.
    facts
        What the recording tells beside its reports.
    undecoded
        Records of a binary file or a stream that could not be decoded.
    stamp
        Time of each report as it came [s], shape (reports,), where ``time`` is another by now.

    Examples
    --------
    >>> import polars as pl
    >>> import trackweave as tw
    >>> frame = pl.DataFrame({"time": [0.0, 0.0, 1.0], "x": [1.0, 9.0, 2.0], "y": [0.0] * 3})
    >>> reports = tw.read_reports(frame)
    >>> len(reports), reports.sensors, reports.dim
    (3, ('default',), 2)
    >>> [(scan.time, len(scan)) for scan in reports.scans()]
    [(0.0, 2), (1.0, 1)]
    """

    time: FloatArray
    sensor: IntArray
    sensors: tuple[str, ...]
    measurement: FloatArray
    sigma: FloatArray
    report: np.ndarray[Any, Any]
    scan: IntArray | None = None
    carried: Mapping[str, Any] = field(default_factory=dict)
    frame: LocalFrame | None = None
    iso_time: bool = False
    skipped: tuple[BadRow, ...] = ()
    kind: str = "polars"
    kinds: tuple[MeasurementKind | ForeignKind, ...] = ()
    space: int = 0
    platform: FloatArray | None = None
    identity: IntArray | None = None
    identities: tuple[str, ...] = ()
    strength: FloatArray | None = None
    height: FloatArray | None = None
    notes: tuple[str, ...] = ()
    row: IntArray | None = None
    report_type: Any = None
    context: FloatArray | None = None
    unavailable: "ReportTable | None" = None
    facts: Facts = field(default_factory=Facts)
    undecoded: Skips = field(default_factory=Skips)
    stamp: FloatArray | None = None

    __repr__ = summary

    def __len__(self) -> int:
        return len(self.time)

    @property
    def dim(self) -> int:
        """Number of dimensions of the tracking space, 2 or 3."""
        return self.space or int(self.measurement.shape[1])

    @property
    def look(self) -> FloatArray | IntArray:
        """Number of each report's scan, or its time [s] where the table has none."""
        return self.time if self.scan is None else self.scan

    def kind_of(self, sensor: int) -> MeasurementKind | ForeignKind:
        """Return what a sensor measures, by its index."""
        return self.kinds[sensor] if self.kinds else MeasurementKind.POSITION

    def rows_told(self) -> IntArray | None:
        """Return the number of each row with a report, those not available too; None as ``row``.

        Returns
        -------
        Numbers of data records, unavailable ones behind the others.
        """
        if self.row is None or self.unavailable is None or self.unavailable.row is None:
            return self.row
        return np.concatenate([self.row, self.unavailable.row])

    def part(self, rows: IntArray) -> "ReportTable":
        """Return some rows, in the order asked for, without the columns that pass through.

        Parameters
        ----------
        rows
            Row numbers.

        Returns
        -------
        A table of the same sensors.
        """
        columns: dict[str, Any] = {
            name: np.ascontiguousarray(getattr(self, name)[rows])
            for name in _PER_REPORT
            if getattr(self, name) is not None
        }
        return replace(self, carried={}, **columns)

    def retimed(self, time: FloatArray) -> "ReportTable":
        """Return the same reports at other times, in the order of these.

        Parameters
        ----------
        time
            Time of each report [s], shape (reports,).

        Returns
        -------
        A table of the same reports; what passes through goes with its row.
        """
        order = np.lexsort((self.sensor, time))
        row = np.arange(1, len(self) + 1) if self.row is None else self.row
        carried = {key: each[order] for key, each in self.carried.items()}
        came = self.time if self.stamp is None else self.stamp
        moved = replace(self, time=time, row=row, stamp=came)
        return replace(moved.part(order), carried=carried)

    def scans(self, but: Collection[str] = ()) -> Iterator[Scan]:
        """Yield the scans in order of time, then sensor, but those of some sensors.

        A scan is the reports of one sensor with one scan number where the table has scan
        numbers, otherwise the reports of one sensor at one time. ``Scan.report`` holds row
        numbers of this table.
        """
        wanted = np.array([name not in but for name in self.sensors], dtype=np.bool_)
        rows = np.flatnonzero(wanted[self.sensor])
        if rows.size == 0:
            return
        key = self.look
        order = rows[np.lexsort((self.time[rows], key[rows], self.sensor[rows]))]
        changes = (np.diff(self.sensor[order]) != 0) | (np.diff(key[order]) != 0)
        groups = np.split(order, np.flatnonzero(changes) + 1)
        groups.sort(key=lambda rows: (self.time[rows].max(), self.sensor[rows[0]]))
        for rows in groups:
            yield self.scan_of(rows, float(self.time[rows].max()))

    def scan_of(self, rows: IntArray, time: float, *, own_times: bool = False) -> Scan:
        """Return a scan of some rows of one sensor.

        Parameters
        ----------
        rows
            At least one row number.
        time
            End of the scan [s].
        own_times
            Whether each report keeps its own time, or all count as of the end.

        Returns
        -------
        The scan; ``Scan.report`` holds the row numbers.
        """
        sensor = int(self.sensor[rows[0]])
        kind = self.kind_of(sensor)
        size = kind.n_components(self.dim)
        # Positions without a height stand in a space of three dimensions with two numbers.
        size = min(size, self.measurement.shape[1])
        has_platform = self.platform is not None and not np.isnan(self.platform[rows, 0]).any()
        return Scan(
            time=time,
            sensor=self.sensors[sensor],
            measurement=self.measurement[rows, :size],
            sigma=self.sigma[rows, :size],
            report=np.asarray(rows, dtype=np.int64),
            moments=self.time[rows] if own_times else None,
            platform=np.nan_to_num(self.platform[rows])
            if self.platform is not None and has_platform
            else None,
            identity=None if self.identity is None else self.identity[rows],
            strength=None if self.strength is None else self.strength[rows],
            height=None if self.height is None or self.dim > 2 else self.height[rows],
            context=self.context_of(kind, rows),
        )

    def context_of(self, kind: MeasurementKind | ForeignKind, rows: IntArray) -> FloatArray | None:
        """Return further numbers of some reports of a kind; None for a kind of ours.

        Parameters
        ----------
        kind
            What their sensor measures.
        rows
            Row numbers.

        Returns
        -------
        Shape (rows, numbers).
        """
        if not isinstance(kind, ForeignKind) or self.context is None:
            return None
        return np.ascontiguousarray(self.context[rows, : len(kind.context)])

    @property
    def has_foreign(self) -> bool:
        """Whether any sensor's kind is from outside the package."""
        return any(isinstance(kind, ForeignKind) for kind in self.kinds)
