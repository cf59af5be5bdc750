"""The sensors of a run: who they are, where they stand and what they see."""

from typing import Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.frames import LocalFrame
from trackweave.io.run_files import RunFiles
from trackweave.plotting.scene import Scene, paths_of_sensors

__all__ = ["sensors_of"]

ARC_POINTS = 72


def sensors_of(run: RunFiles, scene: Scene, frame: LocalFrame | None) -> list[dict[str, Any]]:
    """Return what the page says of each sensor, places in degrees where there is a frame."""
    listed = list(scene.reports.sensors) if scene.reports is not None else []
    heard = run.assignments.sensor.astype(str)
    names = dict.fromkeys([*listed, *np.unique(heard).tolist()])
    paths = {} if scene.reports is None else paths_of_sensors(scene.reports)
    told = run.record.get("configuration", {}).get("sensors", {})
    found = []
    for name in names:
        times = run.assignments.time[heard == name]
        sensor: dict[str, Any] = {"name": name, "reports": int(times.size)}
        if times.size:
            span = float(np.ptp(times))
            sensor["last_heard"] = float(times.max())
            if span > 0:
                sensor["reports_per_s"] = round(times.size / span, 4)
        values = told.get(name, {}) if isinstance(told, dict) else {}
        if isinstance(values, dict):
            sensor["kind"] = str(values.get("measurement", ""))
        stands = scene.sensor_positions.get(name)
        place = paths[name][-1] if name in paths else stands
        if place is not None:
            _put(sensor, _placed(np.array([place[:2]], dtype=float), frame)[0], frame)
            outline = _outline(values.get("field_of_view"), np.array(place[:2], dtype=float))
            if outline is not None and name not in paths:
                sensor["coverage"] = _placed(outline, frame)
        found.append(sensor)
    return found


def _placed(places: FloatArray, frame: LocalFrame | None) -> list[list[float]]:
    if frame is None:
        return [[round(x, 3), round(y, 3)] for x, y in places.tolist()]
    latitude, longitude, _ = frame.to_geodetic(places)
    pairs = zip(longitude.tolist(), latitude.tolist(), strict=True)
    return [[round(east, 6), round(north, 6)] for east, north in pairs]


def _put(sensor: dict[str, Any], place: list[float], frame: LocalFrame | None) -> None:
    names = ("x", "y") if frame is None else ("longitude", "latitude")
    sensor.update(zip(names, place, strict=True))


def _outline(view: Any, place: FloatArray) -> FloatArray | None:
    """Return the border of a field of view [m], None where it has none to draw."""
    if not isinstance(view, dict):
        return None
    if isinstance(view.get("polygon"), list):
        return np.array(view["polygon"], dtype=float)
    reach = view.get("max_range_m")
    if not isinstance(reach, int | float) or not np.isfinite(reach):
        return None
    begin, end = view.get("azimuth_deg") or (0.0, 360.0)
    width = (end - begin) % 360.0 or 360.0
    azimuth = np.radians(begin + np.linspace(0.0, width, ARC_POINTS))
    arc = place + reach * np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
    return arc if width == 360.0 else np.concatenate([[place], arc])
