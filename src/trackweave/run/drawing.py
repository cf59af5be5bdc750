"""The picture of a run."""

import json
from base64 import b64encode
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association.certificate import Status
from trackweave.domain.reports import ReportTable
from trackweave.io.encoding import encode_json
from trackweave.io.run_files import AssignedReports, RunFiles
from trackweave.plotting import ScanSeries, Scene, figure_of_run
from trackweave.plotting.run import small_png
from trackweave.run.judging import Truth, truth_on
from trackweave.run.polar_to_cartesian import laid
from trackweave.run.result import TrackingResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "assigned_per_scan",
    "figure_of_result",
    "inline_picture",
    "scene_of",
    "series_of",
    "with_reports",
]

# Times that were written to a file and read back may differ in the last digits.
SAME_TIME_S = 1e-6


def figure_of_result(
    result: TrackingResult[Any], truth: Truth | None, *, history: bool, pixels: bool
) -> "Figure":
    """Return the picture of a run as a figure of matplotlib."""
    run = _as_files(result)
    return figure_of_run(
        _with_own(scene_of(run, truth, "the run", history=history, pixels=pixels), result),
        series_of(run),
    )


def inline_picture(result: TrackingResult[Any]) -> str:
    """Return the plan of a run as an element of HTML that needs no file."""
    scene = scene_of(_as_files(result), None, "the run", history=False, pixels=False)
    data = b64encode(small_png(figure_of_run(_with_own(scene, result)))).decode("ascii")
    return f'<img alt="Tracks seen from above" src="data:image/png;base64,{data}">'


def scene_of(
    run: RunFiles, truth: Truth | None, place: str, *, history: bool, pixels: bool
) -> Scene:
    """Return what is to be seen of a run but for its reports; messages call it by its place."""
    plane = run.frame
    return Scene(
        reports=None,
        tracks=run.history if history else run.tracks,
        truth=None if truth is None else truth_on(truth, plane, place),
        sensor_positions=run.sensor_positions(),
        pixels=pixels,
        origin=None if plane is None else (plane.latitude_deg, plane.longitude_deg),
    )


def series_of(run: RunFiles) -> ScanSeries:
    """Return what each scan of a run left behind."""
    time, reports, gap = run.scans("time", "reports", "gap")
    proven = [
        scan["status"] == Status.OPTIMAL if "status" in scan else scan["gap"] == 0.0
        for scan in run.record["scans"]
    ]
    return ScanSeries(
        time=time,
        reports=reports,
        assigned=assigned_per_scan(run.record, time, run.assignments),
        gap=gap,
        proven=np.array(proven, dtype=np.bool_),
        cpu_ms=run.cpu_ms(),
        known=run.tracks,
        iso_time=run.iso_time,
    )


def assigned_per_scan(
    record: dict[str, Any], time: FloatArray, table: AssignedReports
) -> FloatArray:
    """Return how many reports of each scan, told by its end [s], have a track, but for copies."""
    # A report belongs to its sensor's first scan that does not end before it. Scans of several
    # sensors that were taken together are named for all of them.
    counts = np.zeros(time.size)
    named = [str(scan.get("sensor")) for scan in record["scans"]]
    copies = {str(each["report"]) for each in record.get("doubles", ())}
    of_track = (table.track >= 0) & ~np.isin(table.report.astype(str), sorted(copies))
    known = np.unique(table.sensor.astype(str)).tolist()
    looks = {text: {text, *text.split("+")} for text in dict.fromkeys(named)}
    for name in known:
        own = np.array([row for row, text in enumerate(named) if name in looks[text]], dtype=int)
        own = own[np.argsort(time[own], kind="stable")]
        when = table.time[of_track & (table.sensor == name)]
        place = np.searchsorted(time[own], when - SAME_TIME_S)
        np.add.at(counts, own[place[place < own.size]], 1)
    return counts


def with_reports(
    scene: Scene, reports: ReportTable, assignment: Mapping[int, int] | None
) -> Scene:
    """Return a scene with reports where the tracker took them to be, and their tracks."""
    on_plane, _ = laid(reports, scene.sensor_positions)
    return replace(scene, reports=on_plane, assignment=assignment)


def _with_own(scene: Scene, result: TrackingResult[Any]) -> Scene:
    # The result's reports lie on the plane already.
    return replace(scene, reports=result.values.reports, assignment=result.values.assignment)


def _as_files(result: TrackingResult[Any]) -> RunFiles:
    """Return a run as its files would tell it."""
    values, reports = result.values, result.values.reports
    track = np.full(len(reports), -1, dtype=np.int64)
    track[list(values.assignment)] = list(values.assignment.values())
    sensor = np.array(reports.sensors, dtype=object)[reports.sensor]
    assigned = AssignedReports(reports.report, reports.time, sensor, track)
    record = json.loads(encode_json(result.run))
    return RunFiles(
        Path(), record, values.tracks, values.history, assigned, values.frame, reports.iso_time
    )
