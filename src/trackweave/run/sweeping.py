"""Reports that each have their own time: a beam's sweeps, or a camera's bursts, are scans."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.config import Configuration
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.estimation.bursts import bursts_of, slices_of
from trackweave.estimation.lone import judged
from trackweave.estimation.looking import shun_successive
from trackweave.estimation.rotation import loose_rotation_of, rotation_of
from trackweave.estimation.sweeps import sweeps_of
from trackweave.run.observing import azimuth_of, positions_in
from trackweave.run.polar_to_cartesian import platforms_of

__all__ = ["with_sweeps"]


def with_sweeps(
    reports: ReportTable, configuration: Configuration
) -> tuple[ReportTable, Configuration]:
    """Return reports with sweeps and bursts for scans, where there are any, and what is told."""
    # Where several sensors report, and a beam of another turns, nobody's scans are numbered: turns
    # would be lost. A ``rotation`` that is told of a beam that sweeps is left out, unless trusted.
    if reports.scan is not None:
        return reports, configuration
    platform = platforms_of(reports, positions_in(reports, configuration))
    _, scan = np.unique(reports.time, return_inverse=True)
    scan, notes = scan.reshape(-1).astype(np.int64), list[str]()
    sensors = {name: dict(table) for name, table in configuration.table("sensors").items()}
    for index, name in enumerate(reports.sensors):
        rows = np.flatnonzero(reports.sensor == index)
        said = configuration.sensor(name)
        found = _slices(reports, index, rows, said)
        if found is None and not _comes_one_by_one(reports, rows):
            continue
        found = found or _bursts(reports, index, rows, said, platform)
        found = found or _sweeps(reports, index, rows, said)
        if found is None:
            return reports, configuration
        scan[rows], sentence = found
        own, doubt = sensors.get(name, {}), ""
        if own.get("rotation", "none") != "none":
            told = own.pop("rotation")
            doubt = f", although rotation = {told!r} is told, which is not used"
        notes.append(f"sensor {name}: {sentence}{doubt}; each is a scan")
    if not notes:
        return reports, configuration
    reports = replace(reports, scan=scan, notes=(*reports.notes, *notes))
    return reports, configuration.changed(sensors=sensors)


def _comes_one_by_one(reports: ReportTable, rows: IntArray) -> bool:
    """Tell whether hardly any two reports of a sensor are of one time."""
    return bool(rows.size and np.unique(reports.time[rows]).size > 0.5 * rows.size)


def _bursts(
    reports: ReportTable,
    index: int,
    rows: IntArray,
    said: Mapping[str, Any],
    platform: FloatArray,
) -> tuple[IntArray, str] | None:
    """Return the burst of each report and a sentence, None for none or where a beam turns."""
    if said.get("rotation", "none") != "none" or said.get("scans") is False:
        return None
    found = bursts_of(reports.time[rows])
    if found is None:
        return None
    kind = reports.kind_of(index)
    if isinstance(kind, MeasurementKind) and kind.is_position:
        number = np.zeros(len(reports), dtype=np.int64)
        number[rows] = found[0]
        _, threads, own = judged(reports, index)
        if shun_successive(number[own], threads.rows):
            return None
    if isinstance(kind, MeasurementKind):
        azimuth = azimuth_of(kind, reports.measurement[rows], platform[rows])
        time = reports.time[rows]
        if rotation_of(time, azimuth) or loose_rotation_of(time, azimuth):
            return None
    return found[0], f"its reports come in bursts of {found[1]:.3g} s at most"


def _slices(
    reports: ReportTable, index: int, rows: IntArray, said: Mapping[str, Any]
) -> tuple[IntArray, str] | None:
    """Return the look of each report whose slices have their own times, and a sentence."""
    kind = reports.kind_of(index)
    if said.get("scans") is False or not (isinstance(kind, MeasurementKind) and kind.is_position):
        return None
    found = slices_of(reports.time[rows], reports.measurement[rows])
    if found is None:
        return None
    return found[0], f"its reports come in looks of {found[1]:.3g} s at most, slice by slice"


def _sweeps(
    reports: ReportTable, index: int, rows: IntArray, said: Mapping[str, Any]
) -> tuple[IntArray, str] | None:
    """Return the sweep of each report and a sentence, None for no such beam."""
    kind = reports.kind_of(index)
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
    return found[0], f"its beam sweeps a sector, {found[1]:.3g} s a sweep"
