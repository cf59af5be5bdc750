"""What a listener is told of tracks: rows of a tracks table as objects of JSON."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import polars as pl

from trackweave.domain.frames import LocalFrame
from trackweave.service.desk import Json, Picture

__all__ = ["as_text", "full_message", "track_messages", "tracks_message"]

# What an object calls a column, and to how many decimals it is told: what is finer than a
# millimetre would double the size of what is sent and help nobody.
_NUMBERS = {
    "x": ("x", 3), "y": ("y", 3), "z": ("z", 3), "vx": ("vx", 4), "vy": ("vy", 4),
    "vz": ("vz", 4), "lat": ("latitude", 8), "lon": ("longitude", 8), "alt_m": ("height_m", 2),
    "existence": ("existence", 6), "visible": ("visible", 6), "score": ("score", 3),
}  # fmt: skip
_AS_THEY_ARE = ("status", "identity", "hits", "sensors")
_COVARIANCE = ("p_x_x", "p_x_y", "p_y_y")


def track_messages(tracks: pl.DataFrame, frame: LocalFrame | None = None) -> list[Json]:
    """Return rows of a tracks table as what a page and other listeners are sent.

    Parameters
    ----------
    tracks
        Columns of a tracks file, a row for each track; ``identity``, ``sensors``, ``existence``
        and ``visible`` are told where they are there.
    frame
        The plane of ``x`` and ``y``: courses are then clockwise from a track's own north.

    Returns
    -------
    An object for each row. What is not known is left out; every number is finite.
    """
    if tracks.is_empty():
        return []
    columns: dict[str, Sequence[Any]] = {
        "track": tracks["track"].cast(pl.String).to_list(),
        "time": _seconds(tracks["time"]),
    }
    columns |= {name: tracks[name].to_list() for name in _AS_THEY_ARE if name in tracks.columns}
    for name, (told, digits) in _NUMBERS.items():
        if name in tracks.columns:
            columns[told] = _rounded(tracks[name], digits)
    if set(_COVARIANCE) <= set(tracks.columns):
        parts = zip(*(_rounded(tracks[name], 4) for name in _COVARIANCE), strict=True)
        columns["covariance"] = [None if None in part else list(part) for part in parts]
    if {"vx", "vy"} <= set(tracks.columns):
        columns["speed"] = _rounded((tracks["vx"] ** 2 + tracks["vy"] ** 2).sqrt(), 4)
        columns["course_deg"] = _rounded(_course(tracks, frame), 2)
    return [
        {name: value for name, value in zip(columns, row, strict=True) if value is not None}
        for row in zip(*columns.values(), strict=True)
    ]


def tracks_message(time: float | None, changed: list[Json], ended: Sequence[str]) -> Json:
    """Return what tells of tracks that changed up to a time [s], and of those that ended."""
    return {"type": "tracks", "time": time, "changed": changed, "ended": list(ended)}


def full_message(picture: Picture) -> Json:
    """Return what tells of all tracks: who hears it forgets what was heard before."""
    found = tracks_message(picture.time, track_messages(picture.tracks, picture.frame), ())
    return {**found, "full": True, "geographic": picture.frame is not None}


def as_text(message: Mapping[str, Any]) -> str:
    """Return an object as JSON; numbers that are not finite, which it has not, as null."""
    try:
        return _encode(message)
    except ValueError:
        return _encode(_finite(message))


def _encode(message: Any) -> str:
    return json.dumps(message, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: _finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return value


def _seconds(time: pl.Series) -> list[float]:
    """Return times in seconds, from 1970 UTC where they are dates."""
    if isinstance(time.dtype, pl.Datetime):
        time = time.dt.cast_time_unit("us").to_physical() / 1e6
    return _rounded(time, 6)


def _rounded(column: pl.Series, digits: int) -> list[Any]:
    numbers = column.cast(pl.Float64)
    told = numbers.is_finite().fill_null(value=False)
    return numbers.round(digits).set(~told, None).to_list()


def _course(tracks: pl.DataFrame, frame: LocalFrame | None) -> pl.Series:
    """Return where tracks go, clockwise from north [degrees]."""
    east, north = (tracks[name].cast(pl.Float64).to_numpy() for name in ("vx", "vy"))
    if frame is not None and {"lat", "lon"} <= set(tracks.columns):
        # A second on.
        ahead = tracks.select(pl.col("x") + pl.col("vx"), pl.col("y") + pl.col("vy")).to_numpy()
        latitude, longitude, _ = frame.to_geodetic(ahead)
        here = tracks["lat"].to_numpy()
        turned = (longitude - tracks["lon"].to_numpy() + 180.0) % 360.0 - 180.0
        north, east = latitude - here, turned * np.cos(np.radians(here))
    return pl.Series(np.degrees(np.arctan2(east, north)) % 360.0)
