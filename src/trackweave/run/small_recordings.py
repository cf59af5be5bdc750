"""Small recordings of every kind of measurement, to compile kernels by tracking them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray
from trackweave.randomness import generator_of

__all__ = ["Recording", "recording_of", "recording_of_radars"]

SIDE, SPEED, SCANS, OBJECTS, FALSE_ALARMS = 3000.0, 15.0, 12, 6, 2
RADARS = {"north": (0.0, 30e3, 10.0), "south": (0.0, -25e3, 12.0)}
"""Where radars stand, east and north [m], and how long a turn of each takes [s]."""
AIRCRAFT, TURNS, SKY = 30, 6, 40e3
PLACES = ((0.0, 0.0, 30.0), (SIDE, -200.0, 20.0), (-300.0, SIDE, 40.0))


@dataclass(frozen=True)
class Recording:
    """Reports, and what there is to tell of them.

    Parameters
    ----------
    reports
        A table, as in a reports file.
    config
        What a configuration has to say of it.
    """

    reports: pl.DataFrame
    config: Mapping[str, Any]


def recording_of(kind: str, *, n_sensors: int = 1, dim: int = 2) -> Recording:
    """Return objects on straight lines and some turns, as sensors of a kind report them.

    Parameters
    ----------
    kind
        A kind of measurement, as a configuration names it.
    n_sensors
        How many sensors, from 1 to 3.
    dim
        Coordinates of positions, 2 or 3.

    Returns
    -------
    The recording, the same at each call.
    """
    rng = generator_of(1)
    rows: list[dict[str, Any]] = []
    paths = _paths(rng, dim)
    for scan in range(SCANS):
        for sensor in range(n_sensors):
            time = 2.0 * scan + 0.5 * sensor
            false = rng.uniform(0.0, SIDE, (FALSE_ALARMS, paths.shape[2]))
            seen = [path for path in paths[:, scan] if rng.random() < 0.9]
            for place in [*seen, *false]:
                row = _measured(kind, place - np.array(PLACES[sensor]), rng)
                if kind == "position":
                    row |= dict(zip("xyz"[:dim], place + rng.normal(0.0, 8.0, 3), strict=False))
                rows.append({"time": time, "sensor": f"s{sensor}", **row})
    sensors = {f"s{k}": _told(kind, k) for k in range(n_sensors)}
    return Recording(pl.DataFrame(rows), {"motion": {"max_speed": 40.0}, "sensors": sensors})


def recording_of_radars() -> Recording:
    """Return what two turning radars report of so many aircraft that none of them sees all.

    Returns
    -------
    The recording, the same at each call.
    """
    rng = generator_of(3)
    begin = rng.uniform(-SKY, SKY, (AIRCRAFT, 2))
    velocity = rng.normal(0.0, 10.0 * SPEED, (AIRCRAFT, 2))
    rows: list[tuple[float, str, float, float]] = []
    for name, (east, north, turn) in RADARS.items():
        for k in range(TURNS):
            away = begin + turn * k * velocity - (east, north)
            time = turn * (k + np.arctan2(*away.T) % (2.0 * np.pi) / (2.0 * np.pi))
            away = begin + time[:, None] * velocity - (east, north)
            found = np.hypot(*away.T) + rng.normal(0.0, 50.0, AIRCRAFT)
            azimuth = np.degrees(np.arctan2(*away.T)) + rng.normal(0.0, 0.1, AIRCRAFT)
            rows += zip(time, [name] * AIRCRAFT, found, azimuth % 360.0, strict=True)
    columns = ["time", "sensor", "range_m", "azimuth_deg"]
    sensors = {
        name: {
            "measurement": "range-azimuth",
            "position": list(place),
            "sigma": {"range_m": 50.0, "azimuth_deg": 0.1},
        }
        for name, (*place, _) in RADARS.items()
    }
    reports = pl.DataFrame(rows, columns, orient="row").sort("time")
    return Recording(reports, {"motion": {"max_speed": 600.0}, "sensors": sensors})


def _paths(rng: np.random.Generator, dim: int) -> FloatArray:
    """Return the positions of all objects at all scans, of three coordinates."""
    course = rng.uniform(0.0, 2.0 * np.pi, OBJECTS)[:, None]
    course = course + np.arange(SCANS) * rng.choice([0.0, 0.15], OBJECTS)[:, None]
    step = 2.0 * SPEED * np.stack([np.sin(course), np.cos(course), np.zeros_like(course)], axis=2)
    start = rng.uniform(0.2 * SIDE, 0.8 * SIDE, (OBJECTS, 1, 3))
    start[1:, :, 2] = 500.0
    # Two come so close that windows have something to decide.
    start[1] = start[0] + 12.0
    step[1] = step[0]
    return np.asarray(start + np.cumsum(step, axis=1))


def _measured(kind: str, away: FloatArray, rng: np.random.Generator) -> dict[str, float]:
    """Return what a sensor measures of an object so far away, with noise."""
    ground = float(np.hypot(*away[:2]))
    azimuth = float(np.degrees(np.arctan2(*away[:2])) + rng.normal(0.0, 0.2)) % 360.0
    if kind == "position":
        return {}
    if kind == "bearing":
        return {"bearing_deg": azimuth}
    found = {"range_m": float(np.hypot(ground, away[2]) + rng.normal(0.0, 8.0))}
    found["azimuth_deg"] = azimuth
    if "elevation" in kind:
        found["elevation_deg"] = float(np.degrees(np.arctan2(away[2], ground)))
    if "rate" in kind:
        found["range_rate_mps"] = float(rng.normal(0.0, SPEED))
    return found


def _told(kind: str, sensor: int) -> dict[str, Any]:
    """Return what is told of a sensor."""
    sigma: Any = 8.0
    if kind != "position":
        sigma = {"range_m": 8.0, "azimuth_deg": 0.2}
        if "elevation" in kind:
            sigma["elevation_deg"] = 0.2
        if "rate" in kind:
            sigma["range_rate_mps"] = 5.0
        if kind == "bearing":
            sigma = {"bearing_deg": 0.2}
    place = {} if kind == "position" else {"position": list(PLACES[sensor])}
    return {"measurement": kind, "sigma": sigma, "scan_period": 2.0, **place}
