"""Reports as columns, and their grouping into scans."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.frames import LocalFrame
from trackweave.domain.scans import Scan

__all__ = ["BadRow", "ReportTable"]


@dataclass(frozen=True, slots=True)
class BadRow:
    """A row of a table that cannot be used, and why.

    Parameters
    ----------
    row
        Number of the data record, 1 for the first after the header.
    column
        The column with the fault, None when the row as a whole is at fault.
    found
        What was there, as text.
    expected
        What should have been there.
    """

    row: int
    column: str | None
    found: str
    expected: str

    def message(self, source: str) -> str:
        """Return the sentence that tells of the row, ``source`` being the file's name."""
        place = f"row {self.row}" + ("" if self.column is None else f", column {self.column}")
        return f"{source}, {place}: {self.found}; expected {self.expected}"


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
        Position of each report [m], shape (reports, dim), dim 2 or 3.
    sigma
        Standard deviation along each axis [m], shape (reports, dim); NaN where the file has none.
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

    def __len__(self) -> int:
        return len(self.time)

    @property
    def dim(self) -> int:
        """Number of spatial dimensions, 2 or 3."""
        return int(self.measurement.shape[1])

    def scans(self) -> Iterator[Scan]:
        """Yield the scans in order of time, then sensor.

        A scan is the reports of one sensor with one scan number where the table has scan
        numbers, otherwise the reports of one sensor at one time. ``Scan.report`` holds row
        numbers of this table.
        """
        if len(self) == 0:
            return
        key = self.time if self.scan is None else self.scan
        order = np.lexsort((self.time, key, self.sensor))
        changes = (np.diff(self.sensor[order]) != 0) | (np.diff(key[order]) != 0)
        groups = np.split(order, np.flatnonzero(changes) + 1)
        groups.sort(key=lambda rows: (self.time[rows].max(), self.sensor[rows[0]]))
        for rows in groups:
            yield Scan(
                time=float(self.time[rows].max()),
                sensor=self.sensors[self.sensor[rows[0]]],
                measurement=self.measurement[rows],
                sigma=self.sigma[rows],
                report=np.asarray(rows, dtype=np.int64),
            )
