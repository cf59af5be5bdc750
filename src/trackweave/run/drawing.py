"""The picture of a run."""

from base64 import b64encode
from typing import TYPE_CHECKING, Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association.certificate import Status
from trackweave.io.run_files import AssignedReports
from trackweave.plotting import ScanSeries, Scene, figure_of_run
from trackweave.plotting.run import small_png
from trackweave.run.judging import Truth, truth_on
from trackweave.run.result import RunValues, TrackingResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["assigned_per_scan", "figure_of_result", "inline_picture", "places_told"]

# Times that were written to a file and read back may differ in the last digits.
SAME_TIME_S = 1e-6


def figure_of_result(
    result: TrackingResult[Any], truth: Truth | None, *, history: bool, pixels: bool
) -> "Figure":
    """Return the picture of a run.

    Parameters
    ----------
    result
        What the run found.
    truth
        Where targets really were, None where it is not known.
    history
        Whether to draw the smoothed history instead of what was known then.
    pixels
        Whether positions are those of an image.

    Returns
    -------
    A figure of matplotlib.
    """
    return figure_of_run(_scene(result, truth, history=history, pixels=pixels), _series(result))


def inline_picture(result: TrackingResult[Any]) -> str:
    """Return the plan of a run as an element of HTML that needs no file.

    Parameters
    ----------
    result
        What the run found.

    Returns
    -------
    An image of some tens of kilobytes.
    """
    figure = figure_of_run(_scene(result, None, history=False, pixels=False))
    data = b64encode(small_png(figure)).decode("ascii")
    return f'<img alt="Tracks seen from above" src="data:image/png;base64,{data}">'


def places_told(record: dict[str, Any]) -> dict[str, tuple[float, ...]]:
    """Return where a run's configuration says that sensors stand.

    Parameters
    ----------
    record
        Content of run.json.

    Returns
    -------
    Positions [m] by the sensors' names.
    """
    sensors = record.get("configuration", {}).get("sensors", {})
    if not isinstance(sensors, dict):
        return {}
    return {
        name: tuple(float(number) for number in values["position"])
        for name, values in sensors.items()
        if isinstance(values, dict) and values.get("position") is not None
    }


def assigned_per_scan(
    record: dict[str, Any], time: FloatArray, table: AssignedReports
) -> FloatArray:
    """Return how many reports of each scan have a track, copies left out.

    A report belongs to its sensor's first scan that does not end before it. Scans of several
    sensors that were taken together are named for all of them.

    Parameters
    ----------
    record
        Content of run.json.
    time
        The ends of its scans [s].
    table
        All reports.

    Returns
    -------
    Counts, shape (scans,).
    """
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


def _scene(
    result: TrackingResult[Any], truth: Truth | None, *, history: bool, pixels: bool
) -> Scene:
    values, plane = result.values, result.values.frame
    return Scene(
        reports=values.reports,
        tracks=values.history if history else values.tracks,
        truth=None if truth is None else truth_on(truth, plane, "the run"),
        assignment=values.assignment,
        sensor_positions=places_told(result.run),
        pixels=pixels,
        origin=None if plane is None else (plane.latitude_deg, plane.longitude_deg),
    )


def _series(result: TrackingResult[Any]) -> ScanSeries:
    scans, timing = result.run["scans"], result.run["timing"]["scans"]
    time, reports, gap = (
        np.array([scan[key] for scan in scans], dtype=np.float64)  # null becomes NaN
        for key in ("time", "reports", "gap")
    )
    return ScanSeries(
        time=time,
        reports=reports,
        assigned=assigned_per_scan(result.run, time, _assigned(result.values)),
        gap=gap,
        proven=np.array([scan["status"] == Status.OPTIMAL for scan in scans], dtype=np.bool_),
        cpu_ms=np.array([scan["cpu_ms"] for scan in timing], dtype=np.float64),
        known=result.values.tracks,
        iso_time=result.values.reports.iso_time,
    )


def _assigned(values: RunValues) -> AssignedReports:
    reports = values.reports
    track = np.full(len(reports), -1, dtype=np.int64)
    track[list(values.assignment)] = list(values.assignment.values())
    names = np.array(reports.sensors, dtype=object)
    return AssignedReports(reports.report, reports.time, names[reports.sensor], track)
