"""GeoJSON (RFC 7946): each track a line with the times of its points in ``coordTimes``.

Of assignments each report is a point, without a place where it says none.
"""

import json
from typing import Any

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray
from trackweave.formats.format import Format, Output
from trackweave.formats.json_stream import finite
from trackweave.formats.track_rows import EarthTrack, earth_tracks, moments

__all__ = ["FORMAT"]

_PLACES = 8  # a millimetre


def _write(output: Output) -> dict[str, bytes]:
    if {"report", "probability", "lat", "lon"} <= set(output.tracks.columns):
        features = _points(output.tracks)
    else:
        features = [_feature(each) for each in earth_tracks(output, "geojson")]
    collection = {"type": "FeatureCollection", "features": features}
    text = json.dumps(collection, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return {"tracks.geojson": text.encode("utf-8")}


def _points(reports: pl.DataFrame) -> list[dict[str, Any]]:
    """Return a point for each report, with what is told of it."""
    moment, _ = moments(reports["time"])
    rows = reports.with_columns(time=pl.Series(moment)).iter_rows(named=True)
    return [_point(row) for row in rows]


def _point(row: dict[str, Any]) -> dict[str, Any]:
    north, east = (
        finite(row.pop(name), -most, most) for name, most in (("lat", 90), ("lon", 360))
    )
    geometry = None
    if north is not None and east is not None:
        place = [round((east + 180.0) % 360.0 - 180.0, _PLACES), round(north, _PLACES)]
        geometry = {"type": "Point", "coordinates": place}
    told = {
        name: value if isinstance(value, str | int) else finite(value)
        for name, value in row.items()
    }
    return {"type": "Feature", "id": row["report"], "geometry": geometry, "properties": told}


def _feature(track: EarthTrack) -> dict[str, Any]:
    columns = [track.longitude, track.latitude]
    if track.altitude is not None:
        columns.append(track.altitude)
    points: FloatArray = np.asarray(np.round(np.stack(columns, axis=-1), _PLACES), np.float64)
    lines, numbers = _cut(points)
    times: list[Any] = [[track.time[k] for k in part] for part in numbers]
    if len(points) == 1:
        geometry, times = {"type": "Point", "coordinates": points[0].tolist()}, times[0]
    elif len(lines) == 1:
        geometry, times = {"type": "LineString", "coordinates": lines[0].tolist()}, times[0]
    else:
        geometry = {"type": "MultiLineString", "coordinates": [line.tolist() for line in lines]}
    return {
        "type": "Feature",
        "id": track.track,
        "geometry": geometry,
        "properties": {
            "track": track.track,
            "name": track.name,
            "begin": track.time[0],
            "end": track.time[-1],
            "status": track.status[-1] if track.status else None,
            "score": track.score,
            "speed_mps": _rounded(track.speed),
            "course_deg": _rounded(track.course),
            "sigma_m": _rounded(track.sigma),
            "coordTimes": times,
        },
    }


def _cut(points: FloatArray) -> tuple[list[FloatArray], list[list[int]]]:
    """Return a line in parts that do not cross the antimeridian, and whose times points have."""
    # Where it crosses, both parts have a point on it, with the time of the point before or after.
    crossings = np.flatnonzero(np.abs(np.diff(points[:, 0])) > 180.0)
    lines, numbers, first, start = [], [], 0, points[:0]
    for place in crossings:
        before, after = points[place].copy(), points[place + 1].copy()
        side = np.copysign(180.0, before[0])
        after[0] += 2 * side
        share = (side - before[0]) / (after[0] - before[0])
        edge = np.round(before + share * (after - before), _PLACES)
        lines.append(np.concatenate([start, points[first : place + 1], edge[np.newaxis]]))
        numbers.append([*[first] * len(start), *range(first, place + 1), int(place)])
        start, first = edge[np.newaxis] * [-1, *[1] * (len(edge) - 1)], int(place) + 1
    lines.append(np.concatenate([start, points[first:]]))
    numbers.append([*[first] * len(start), *range(first, len(points))])
    return lines, numbers


def _rounded(values: FloatArray | None) -> list[float | None] | None:
    if values is None:
        return None
    return [round(float(v), 3) if np.isfinite(v) else None for v in values]


FORMAT = Format(
    name="geojson",
    title="GeoJSON (RFC 7946)",
    endings=(".geojson",),
    carries="positions in WGS-84, times, speed, course, uncertainty along the worst axis",
    loses="full covariances, tentative rows",
    writer=_write,
)
