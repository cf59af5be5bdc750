"""What reports measure, and where their sensors were, as columns of a file."""

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray
from trackweave.domain.frames import LocalFrame
from trackweave.domain.reports import ReportTable

__all__ = ["geodetic_columns", "measured_columns", "number_columns"]

_AXES = ("x", "y", "z")
_PLATFORM = tuple(f"sensor_{name}" for name in ("x", "y", "z", "vx", "vy", "vz"))
_PLATFORM_ON_EARTH = ("sensor_lat", "sensor_lon", "sensor_alt_m", *_PLATFORM[3:])


def measured_columns(reports: ReportTable) -> list[pl.Series]:
    """Return the columns of a table of reports that its measurements make.

    Parameters
    ----------
    reports
        The reports.

    Returns
    -------
    Numbers, their noise where any report has it, and where sensors were unless such columns are
    carried along.
    """
    values: dict[str, FloatArray] = {}
    noise: dict[str, FloatArray] = {}
    for sensor in range(len(reports.sensors)):
        rows = reports.sensor == sensor
        for place, name in enumerate(reports.kind_of(sensor).columns(reports.dim)):
            unit = np.pi / 180 if name.endswith("_deg") else 1.0
            for columns, column, numbers in (
                (values, name, reports.measurement),
                (noise, f"sigma_{name}", reports.sigma),
            ):
                column_values = columns.setdefault(column, np.full(len(reports), np.nan))
                column_values[rows] = numbers[rows, place] / unit
    written = {name: numbers for name, numbers in noise.items() if not np.isnan(numbers).all()}
    if any(name in written for name in ("sigma_x", "sigma_y")):
        written = {name: n for name, n in noise.items() if name in written or name[-1] in "xy"}
    if reports.frame is not None and "x" in values:
        position = np.stack([values.pop(name) for name in _AXES if name in values], axis=-1)
        values = {c.name: c.to_numpy() for c in geodetic_columns(position, reports.frame)} | values
    columns = {**values, **written}
    if reports.platform is not None and not any(n.startswith("sensor_") for n in reports.carried):
        columns |= _platform(reports.platform, reports.frame)
    return [pl.Series(name, numbers, nan_to_null=True) for name, numbers in columns.items()]


def number_columns(names: tuple[str, ...], values: FloatArray) -> list[pl.Series]:
    """Return the columns of a matrix by name, null where there is no number."""
    return [
        pl.Series(name, np.ascontiguousarray(values[:, place]), nan_to_null=True)
        for place, name in enumerate(names)
    ]


def geodetic_columns(position: FloatArray, frame: LocalFrame | None) -> list[pl.Series]:
    """Return ``lat,lon[,alt_m]`` of positions on a plane; none without a plane."""
    if frame is None:
        return []
    latitude, longitude, altitude = frame.to_geodetic(position)
    columns = [pl.Series("lat", latitude), pl.Series("lon", longitude)]
    return [*columns, pl.Series("alt_m", altitude)] if position.shape[1] == 3 else columns


def _platform(platform: FloatArray, frame: LocalFrame | None) -> dict[str, FloatArray]:
    if frame is None:
        return {name: platform[:, place] for place, name in enumerate(_PLATFORM)}
    place = np.stack([*frame.to_geodetic(platform[:, :3]), *platform[:, 3:].T], axis=-1)
    return {name: place[:, column] for column, name in enumerate(_PLATFORM_ON_EARTH)}
