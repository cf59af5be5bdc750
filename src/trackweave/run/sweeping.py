"""Reports of a beam that sweeps a sector, each with its own time: sweeps are their scans."""

from dataclasses import replace

import numpy as np

from trackweave.arrays import IntArray
from trackweave.config import Configuration
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.estimation.rotation import rotation_of
from trackweave.estimation.sweeps import sweeps_of

__all__ = ["with_sweeps"]


def with_sweeps(
    reports: ReportTable, configuration: Configuration
) -> tuple[ReportTable, Configuration]:
    """Return reports with sweeps of sectors for scans, where there are any, and what is told."""
    # Where several sensors report, and a beam of another turns, nobody's scans are numbered: turns
    # would be lost. A ``rotation`` that is told of a beam that sweeps is left out, unless trusted.
    if reports.scan is not None:
        return reports, configuration
    _, scan = np.unique(reports.time, return_inverse=True)
    scan, notes = scan.reshape(-1).astype(np.int64), list[str]()
    sensors = {name: dict(table) for name, table in configuration.table("sensors").items()}
    for index, name in enumerate(reports.sensors):
        rows = np.flatnonzero(reports.sensor == index)
        if not _comes_one_by_one(reports, rows):
            continue
        found = _sweeps(reports, index, rows, configuration)
        if found is None:
            return reports, configuration
        scan[rows], lasts = found
        told = sensors.get(name, {}).pop("rotation", None)
        doubt = f", although rotation = {told!r} is told, which is not used" if told else ""
        notes.append(
            f"sensor {name}: its beam sweeps a sector, {lasts:.3g} s a sweep{doubt}; each sweep "
            "is a scan"
        )
    if not notes:
        return reports, configuration
    reports = replace(reports, scan=scan, notes=(*reports.notes, *notes))
    return reports, configuration.changed(sensors=sensors)


def _comes_one_by_one(reports: ReportTable, rows: IntArray) -> bool:
    """Tell whether hardly any two reports of a sensor are of one time."""
    return bool(rows.size and np.unique(reports.time[rows]).size > 0.5 * rows.size)


def _sweeps(
    reports: ReportTable, index: int, rows: IntArray, configuration: Configuration
) -> tuple[IntArray, float] | None:
    """Return the sweep of each report and how long one takes, None for no such beam."""
    kind, said = reports.kind_of(index), configuration.sensor(reports.sensors[index])
    if not isinstance(kind, MeasurementKind) or kind.azimuth is None:
        return None
    if said.get("rotation") == "none" or said.get("scans") is False:
        return None
    trust = said.get("trust", False)
    if "rotation" in said and (trust is True or (trust and "rotation" in trust)):
        return None
    time, azimuth = reports.time[rows], reports.measurement[rows, kind.azimuth]
    period = said.get("scan_period")
    found = sweeps_of(time, azimuth, period)
    if found is None and period is not None:
        found = sweeps_of(time, azimuth)
    if found is None or rotation_of(time, azimuth, period=period) is not None:
        return None
    return found
