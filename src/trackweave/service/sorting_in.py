"""A record's rows become reports on the tracker's plane, and what cannot is counted."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import polars as pl

from trackweave.domain.reports import BadRow, ReportTable
from trackweave.errors import TrackweaveError
from trackweave.io.reports import ONLY_SENSOR, reports_in
from trackweave.io.tables import RawTable, with_our_names
from trackweave.io.time_axes import EARLIEST_S
from trackweave.models.sensors import Sensor
from trackweave.run.biases import told_biases, unbiased
from trackweave.run.cartesian_to_polar import as_measured
from trackweave.run.polar_to_cartesian import laid
from trackweave.service.desk import Rejected, Rows
from trackweave.service.inputs.outbox import completed
from trackweave.service.spec import Spec

__all__ = ["SortedIn", "checked_rows", "sorted_in", "usable_rows"]

_HEIGHTS = ("z", "alt_m")
_FLAT = {"z", "alt_m", "elevation_deg", "sigma_z", "sigma_alt_m", "sigma_elevation_deg"}


@dataclass(frozen=True, slots=True, eq=False)
class SortedIn:
    """What became of rows.

    Parameters
    ----------
    reports
        Those that can be tracked, on the plane; None for none.
    refused
        Rows that cannot be used, whatever the configuration.
    strange
        How many reports are of sensors that the configuration does not know, by sensor.
    unfit
        How many measure otherwise than the configuration says of their sensor, by sensor.
    """

    reports: ReportTable | None
    refused: tuple[BadRow, ...] = ()
    strange: Mapping[str, int] = field(default_factory=dict)
    unfit: Mapping[str, int] = field(default_factory=dict)


def checked_rows(table: pl.DataFrame, spec: Spec | None) -> ReportTable:
    """Return rows as reports; those that cannot be used are in ``skipped``.

    Parameters
    ----------
    table
        Columns of a reports table.
    spec
        The plane to lay them on, and how many dimensions there are; None to choose.

    Returns
    -------
    The reports, perhaps none.

    Raises
    ------
    DataFormatError
        If the table as a whole is none of reports.
    """
    raw = RawTable("reports", _fitted(table, spec), np.arange(1, table.height + 1))
    raw = with_our_names(raw)
    if spec is None:
        return reports_in(raw, on_bad_row="skip")
    frame = spec.frame
    origin = None if frame is None else (frame.latitude_deg, frame.longitude_deg)
    projection = "tangent" if frame is None else frame.projection
    found = reports_in(raw, frame_origin=origin, frame_projection=projection, on_bad_row="skip")
    return _dated(found) if spec.iso_time and not found.iso_time else found


def _dated(reports: ReportTable) -> ReportTable:
    """Return the reports whose seconds count from 1970: those of others have dates."""
    early = reports.time < EARLIEST_S
    if not early.any() or reports.row is None:
        return reports
    expected = "a date, as other reports tell, or seconds from 1970 UTC"
    told = zip(reports.row[early].tolist(), reports.time[early].tolist(), strict=True)
    bad = tuple(BadRow(row, "time", f"{time:.15g}", expected) for row, time in told)
    return replace(reports.part(np.flatnonzero(~early)), skipped=(*reports.skipped, *bad))


def usable_rows(rows: Rows, spec: Spec | None) -> tuple[pl.DataFrame, tuple[Rejected, ...]]:
    """Return the rows that can be used, and why others cannot.

    Parameters
    ----------
    rows
        What was sent.
    spec
        The plane to lay them on, and how many dimensions there are; None to choose.

    Returns
    -------
    The rows with a sensor and a time each, and those that were left out.
    """
    table = completed(rows.table)
    found = checked_rows(table, spec)
    bad = {each.row: each for each in found.skipped}
    rejected = tuple(
        Rejected(int(rows.row[number - 1]), bad[number].message("reports"))
        for number in sorted(bad)
    )
    if not bad:
        return table, rejected
    good = np.setdiff1d(np.arange(table.height), [number - 1 for number in bad])
    return table[good.tolist()], rejected


def sorted_in(table: pl.DataFrame, spec: Spec, sensors: Mapping[str, Sensor]) -> SortedIn:
    """Return the reports that the tracker can take.

    Parameters
    ----------
    table
        Columns of a reports table, as they are in the journal.
    spec
        With what the tracker runs.
    sensors
        Its sensors by name.

    Returns
    -------
    The reports, and what became of the others.
    """
    try:
        reports = checked_rows(table, spec)
    except TrackweaveError:
        every = tuple(BadRow(k, None, "", "a report") for k in range(1, table.height + 1))
        return SortedIn(None, every)
    told = spec.configuration.get("sensors", {})
    reports = as_measured(reports, lambda name: told.get(name, {}))
    wrong_plane = reports.frame is not None and spec.frame is None
    fits, strange, unfit = [], dict[str, int](), dict[str, int]()
    for index, name in enumerate(reports.sensors):
        count = int(np.sum(reports.sensor == index))
        sensor = sensors.get(name)
        if sensor is None:
            strange[name] = count
        elif wrong_plane or not _fits(reports, index, sensor, spec):
            unfit[name] = count
        else:
            fits.append(index)
    if len(fits) < len(reports.sensors):
        reports = _of_sensors(reports, fits)
    if not len(reports):
        return SortedIn(None, reports.skipped, strange, unfit)
    # Biases that were told or learned are taken out before anything else.
    reports = unbiased(reports, told_biases(reports, lambda name: told.get(name, {})))
    stands = {name: sensors[name].position for name in reports.sensors}
    places = {name: place for name, place in stands.items() if place is not None}
    on_plane, _ = laid(reports, places)
    return SortedIn(on_plane, reports.skipped, strange, unfit)


def _fits(reports: ReportTable, index: int, sensor: Sensor, spec: Spec) -> bool:
    """Tell whether a sensor's reports measure what the configuration says of it."""
    is_of_space = sensor.measurement.has_range or reports.dim == spec.dim
    return is_of_space and sensor.measurement is reports.kind_of(index)


def _fitted(table: pl.DataFrame, spec: Spec | None) -> pl.DataFrame:
    """Return rows with as many dimensions as the tracking space has, and with a sensor."""
    if "sensor" in table.columns:
        table = table.with_columns(pl.col("sensor").cast(pl.String).fill_null(ONLY_SENSOR))
    if spec is None:
        return table
    if spec.dim == 2:
        return table.drop(name for name in _FLAT if name in table.columns)
    heights = [name for name in _HEIGHTS if name in table.columns]
    return table.filter(pl.any_horizontal(pl.col(heights).is_not_null())) if heights else table


def _of_sensors(reports: ReportTable, fits: list[int]) -> ReportTable:
    number = np.full(len(reports.sensors), -1, dtype=np.int64)
    number[fits] = np.arange(len(fits))
    part = reports.part(np.flatnonzero(np.isin(reports.sensor, fits)))
    kinds = tuple(reports.kinds[k] for k in fits) if reports.kinds else ()
    return replace(
        part,
        sensor=number[part.sensor],
        sensors=tuple(reports.sensors[k] for k in fits),
        kinds=kinds,
        space=reports.dim,
    )
