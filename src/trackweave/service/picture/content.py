"""What a run's page holds: its tracks, reports, sensors and words, as columns of whole numbers."""

import base64
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.frames import LocalFrame
from trackweave.domain.tracks import TrackTable
from trackweave.io.run_files import RunFiles
from trackweave.plotting.scene import ScanSeries, Scene, places_of_reports
from trackweave.service.picture.land import land_around
from trackweave.service.picture.sensors import sensors_of
from trackweave.service.picture.tracked import heights_of, identities_of
from trackweave.service.picture.words import curves_of, facts_of, notes_of

__all__ = ["MOST_REPORTS", "MOST_ROWS", "Grid", "content_of_run"]

UNIT_S = 1e-3
DEGREE_UNIT = 1e-6
PARTS_OF_PLANE = 1e6
"""A plane's unit of length is about such a part of its extent."""
MOST_ROWS, MOST_REPORTS = 600_000, 300_000
"""What a browser holds with ease. Of more only each so many is in the page."""
GAP = 3.5
"""A track without rows for so many of its usual steps was lost meanwhile."""
LAND_MARGIN = 1.5
UNKNOWN_HEIGHT = -1e6


class Grid(NamedTuple):
    """How places and times become whole numbers."""

    frame: LocalFrame | None
    """Where the plane lies on the Earth, None where nobody knows."""
    unit: float
    """A step of a coordinate [degrees, or m]."""
    begin: float
    """The time that counts as 0 [s]."""

    def places(self, position: FloatArray) -> tuple[IntArray, IntArray]:
        """Return places [m], shape (n, 2 or 3), in steps east (longitude) and north (latitude)."""
        x, y = position[:, 0], position[:, 1]
        if self.frame is not None:
            y, x, _ = self.frame.to_geodetic(position)
        return _whole(x / self.unit), _whole(y / self.unit)

    def times(self, time: FloatArray) -> IntArray:
        """Return times [s] in steps since the beginning."""
        return _whole((time - self.begin) / UNIT_S)


def content_of_run(run: RunFiles, scene: Scene, scans: ScanSeries) -> dict[str, Any]:
    """Return what the page of a run holds, as ``page/run.js`` reads it."""
    tracks = scene.tracks
    reports = _placed_reports(scene)
    times = np.concatenate([tracks.time, scans.time, reports[0]])
    begin, end = (float(times.min()), float(times.max())) if times.size else (0.0, 0.0)
    frame = None if scene.pixels else run.frame
    everywhere = np.concatenate([tracks.mean[:, :2], reports[1]])
    grid = Grid(frame, DEGREE_UNIT if frame is not None else _unit_of(everywhere), begin)
    stride = -(-len(tracks) // MOST_ROWS) or 1
    listed, kept = _tracks(tracks, grid, end, stride)
    number_of = {int(each["id"]): k for k, each in enumerate(listed)}
    identities = identities_of(scene)
    numbers, taken = np.unique(run.assignments.track, return_counts=True)
    hits = dict(zip(numbers.tolist(), taken.tolist(), strict=True))
    for track in listed:
        track["identity"] = identities.get(int(track["id"]))
        track["hits"] = hits.get(int(track["id"]), 0)
    content = {
        "geographic": frame is not None, "down": scene.pixels, "calendar": scans.iso_time,
        "from": begin, "to": end, "unit": grid.unit, "unit_s": UNIT_S,
        "tracks": listed, "rows": _columns(tracks, heights_of(scene), grid, kept),
        "reports": _reports(scene, reports, grid, number_of),
        "sensors": sensors_of(run, scene, grid.frame), "truth": _truth(scene, grid),
        "facts": facts_of(run, scans, stride), "notes": notes_of(run), "curves": curves_of(scans),
        "middle": 0.0 if frame is None else frame.longitude_deg,
    }  # fmt: skip
    if frame is not None:
        content["coast"] = _coast(frame, everywhere)
    return content


def _whole(values: FloatArray) -> IntArray:
    return np.round(np.nan_to_num(values, posinf=0.0, neginf=0.0)).astype(np.int64)


def _steps(values: IntArray) -> list[int]:
    """Return the first number and how each differs from the one before it."""
    found: list[int] = np.diff(values, prepend=0).tolist()
    return found


def _unit_of(places: FloatArray) -> float:
    known = places[np.isfinite(places).all(axis=1)]
    extent = float(np.abs(known).max()) if known.size else 1.0
    return float(10.0 ** np.floor(np.log10(max(extent, 1e-6) / PARTS_OF_PLANE)))


def _tracks(
    table: TrackTable, grid: Grid, end: float, stride: int
) -> tuple[list[dict[str, Any]], list[IntArray]]:
    """Return each track's facts and those of its rows that are kept, in order of appearance."""
    order = np.lexsort((table.time, table.track))
    track = table.track[order]
    begins = np.flatnonzero(np.diff(track, prepend=track[:1] - 1))
    ends = np.append(begins[1:], track.size)[: begins.size]
    listed: list[dict[str, Any]] = []
    kept: list[IntArray] = []
    for begin, stop in zip(begins.tolist(), ends.tolist(), strict=True):
        rows = order[begin:stop]
        few = np.unique(np.append(rows[::stride], rows[-1:]))
        few = few[np.argsort(table.time[few], kind="stable")]
        kept.append(few)
        listed.append({
            "id": str(int(table.track[rows[0]])), "n": int(few.size),
            **_life(grid.times(table.time[rows]), grid, end),
        })  # fmt: skip
    # In order of appearance, so that neighbours in time differ in colour.
    appeared = sorted(range(len(listed)), key=lambda k: (table.time[kept[k][0]], k))
    return [listed[k] for k in appeared], [kept[k] for k in appeared]


def _life(times: IntArray, grid: Grid, end: float) -> dict[str, Any]:
    """Return when a track ended, None where it lasted, and when it was lost meanwhile."""
    apart = np.diff(times)
    usual = int(np.median(apart)) if apart.size else 0
    lost: list[int] = np.flatnonzero(apart > GAP * usual).tolist() if apart.size > 2 else []
    last = int(times[-1])
    lasts = last + usual >= grid.times(np.array([end]))[0]
    return {
        "ended": None if lasts else last + max(usual, 1),
        "gaps": [[int(times[k]) + usual, int(times[k + 1])] for k in lost],
    }


def _columns(
    table: TrackTable, heights: FloatArray | None, grid: Grid, kept: list[IntArray]
) -> dict[str, list[int]]:
    """Return the columns of all rows; each track's begin anew."""
    rows = np.concatenate([np.empty(0, dtype=np.int64), *kept])
    dim = table.dim
    bounds = np.cumsum([0, *map(len, kept)])
    parts = [slice(*ends) for ends in pairwise(bounds.tolist())]

    def column(values: IntArray) -> list[int]:
        return [step for part in parts for step in _steps(values[part])]

    x, y = grid.places(table.mean[rows, :dim])
    spread = table.covariance[rows]
    sigma = np.sqrt(np.maximum(np.diagonal(spread, axis1=1, axis2=2)[:, :2], 1e-12))
    along = spread[:, 0, 1] / (sigma[:, 0] * sigma[:, 1])
    columns = {
        "time": grid.times(table.time[rows]), "x": x, "y": y,
        "vx": _whole(table.mean[rows, dim] * 100), "vy": _whole(table.mean[rows, dim + 1] * 100),
        "sx": _whole(50 * np.log(sigma[:, 0])), "sy": _whole(50 * np.log(sigma[:, 1])),
        "rho": _whole(100 * np.clip(along, -0.99, 0.99)),
    }  # fmt: skip
    if heights is not None:
        # A height that nobody told is below every other.
        columns["height"] = _whole(np.nan_to_num(heights[rows], nan=UNKNOWN_HEIGHT))
    existence = table.existence[rows] if table.existence.size == len(table) else np.empty(0)
    if existence.size and np.isfinite(existence).all():
        columns["existence"] = _whole(1000 * existence)
    status: list[int] = table.status[rows].tolist()
    return {name: column(values) for name, values in columns.items()} | {"status": status}


def _placed_reports(scene: Scene) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return time and place of each report that has one, and its row."""
    if scene.reports is None:
        return np.empty(0), np.empty((0, 2)), np.empty(0, dtype=np.int64)
    places = places_of_reports(scene.reports, scene.sensor_positions)
    rows = np.flatnonzero(np.isfinite(places).all(axis=1))
    return scene.reports.time[rows], places[rows], rows


def _reports(
    scene: Scene,
    placed: tuple[FloatArray, FloatArray, IntArray],
    grid: Grid,
    number_of: dict[int, int],
) -> dict[str, list[int]] | None:
    if scene.reports is None:
        return None
    stride = -(-placed[0].size // MOST_REPORTS) or 1
    time, rows = placed[0][::stride], placed[2][::stride]
    x, y = grid.places(placed[1][::stride])
    track_of = scene.assignment or {}
    track = [number_of.get(track_of.get(row, -1), -1) for row in rows.tolist()]
    sensor: list[int] = scene.reports.sensor[rows].tolist()
    return {
        "time": _steps(grid.times(time)), "x": _steps(x), "y": _steps(y),
        "sensor": sensor, "track": track,
    }  # fmt: skip


def _truth(scene: Scene, grid: Grid) -> list[dict[str, list[int]]]:
    truth = scene.truth
    if truth is None:
        return []
    names = np.asarray(truth.target)
    found = []
    for name in dict.fromkeys(names.tolist()):
        rows = np.flatnonzero(names == name)
        rows = rows[np.argsort(truth.time[rows], kind="stable")]
        x, y = grid.places(truth.position[rows])
        columns = (grid.times(truth.time[rows]), x, y)
        found.append(dict(zip(("time", "x", "y"), map(_steps, columns), strict=True)))
    return found


def _coast(frame: LocalFrame, places: FloatArray) -> str:
    known = places[np.isfinite(places).all(axis=1)]
    if not len(known):
        known = np.zeros((1, 2))
    latitude, longitude, _ = frame.to_geodetic(known)
    # Within half a turn of the plane's middle, as the page takes them.
    longitude = frame.longitude_deg + (longitude - frame.longitude_deg + 180.0) % 360.0 - 180.0
    west, east = float(longitude.min()), float(longitude.max())
    south, north = float(latitude.min()), float(latitude.max())
    margin = LAND_MARGIN * max(east - west, north - south, 0.2)
    box = land_around(west - margin, south - margin, east + margin, north + margin)
    return base64.b64encode(box).decode("ascii")
