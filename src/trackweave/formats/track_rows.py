"""Tracks as writers need them: one after the other, on the Earth, in UTC."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.frames import LocalFrame
from trackweave.errors import InvalidInputError
from trackweave.formats.format import Output
from trackweave.formats.json_stream import finite
from trackweave.io.columns import datetime_column

__all__ = [
    "EarthTrack", "boxed_rows", "branches", "chosen_rows", "earth_tracks", "family_of",
    "framed_rows", "joined", "moments", "most_said", "parents",
    "tracks_that_say",
]  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class EarthTrack:
    """A track on the Earth, one number for each of its times."""

    track: int
    name: str
    """What a live service calls it, else the identity that most of its reports tell (MMSI, Mode S
    address), else its number."""
    time: list[str]
    """ISO 8601, UTC."""
    seconds: FloatArray
    """From 1970 UTC."""
    latitude: FloatArray
    longitude: FloatArray
    """-180 to 180."""
    altitude: FloatArray | None
    """Above the ellipsoid [m], None where it is not known everywhere."""
    speed: FloatArray | None
    """Over ground [m/s]."""
    course: FloatArray | None
    """Clockwise from north [degrees]."""
    sigma: FloatArray | None
    """Standard deviation of the position along its worst axis [m], NaN where unknown."""
    sigma_up: FloatArray | None
    """Of the altitude [m]."""
    status: list[str]
    score: float | None


def chosen_rows(output: Output) -> pl.DataFrame:
    """Return what was found in the end: the history where there is one; nothing tentative."""
    rows = output.tracks if output.history is None else output.history
    if "status" in rows.columns:
        rows = rows.filter(pl.col("status") != "tentative")
    return rows.sort("track", "time", maintain_order=True)


def most_said(output: Output, name: str) -> dict[str, str]:
    """Return what most of each track's reports say in a column, by the track as text."""
    reports = _told(output)
    if name not in reports.columns:
        return {}
    said = reports.select(pl.col("track", name).cast(pl.String)).drop_nulls()
    most = (
        said.group_by("track", name)
        .len()
        .sort("len", name, descending=[True, False])
        .unique("track", keep="first")
    )
    return dict(zip(most["track"].to_list(), most[name].to_list(), strict=True))


def tracks_that_say(output: Output, name: str) -> set[str]:
    """Return the tracks, as text, of which at least half of the reports tell a column."""
    reports = _told(output)
    if name not in reports.columns:
        return set()
    share = reports.group_by("track").agg(pl.col(name).is_not_null().mean() >= 0.5)
    return set(share.filter(pl.col(name))["track"].drop_nulls().cast(pl.String).to_list())


def _told(output: Output) -> pl.DataFrame:
    """Return what was reported of tracks: their rows, where these are reports themselves."""
    return output.tracks if output.assignments is None else output.assignments


def moments(time: pl.Series) -> tuple[list[str], FloatArray]:
    """Return times as ISO 8601 in UTC, and in seconds from 1970, where mere seconds begin."""
    if isinstance(time.dtype, pl.Datetime):
        stamps = time.dt.cast_time_unit("us")
        stamps = stamps.dt.convert_time_zone("UTC") if time.dtype.time_zone else stamps
        seconds = stamps.dt.epoch("us").to_numpy() / 1e6
    else:
        seconds = time.cast(pl.Float64).to_numpy()
        low, high = (seconds.min(), seconds.max()) if len(seconds) else (0.0, 0.0)
        if not -6.2e10 < low <= high < 2.5e11:
            raise InvalidInputError(f"time: {low:g} to {high:g} s; expected what a calendar has")
        stamps = datetime_column("time", seconds)
    texts = stamps.dt.strftime("%Y-%m-%dT%H:%M:%S%.3fZ").str.replace(r"\.000Z$", "Z")
    return texts.to_list(), seconds


def earth_tracks(output: Output, name: str) -> Iterator[EarthTrack]:
    """Yield each track, in order of number; ``name`` is the format's, for a refusal."""
    rows = chosen_rows(output)
    if not {"lat", "lon"} <= set(rows.columns):
        raise InvalidInputError(
            f"format {name}: tracks have no latitudes and longitudes; expected reports in lat,lon"
            ", [frame] origin = [latitude, longitude], or place = [latitude, longitude] of a"
            " sensor that measures from where it stands"
        )
    if rows.is_empty():
        return
    # All rows at once: a live picture has thousands of tracks of a row each.
    texts, seconds = moments(rows["time"])
    velocity = _both(rows, "vx", "vy")
    latitude = _column(rows, "lat")
    longitude = (_column(rows, "lon") + 180.0) % 360.0 - 180.0
    known: dict[str, FloatArray | None] = {
        "speed": None if velocity is None else np.hypot(*velocity),
        "course": None if velocity is None else _course(rows, velocity, output.frame),
        "sigma": _worst_axis(rows),
        "sigma_up": np.sqrt(_column(rows, "p_z_z")) if "p_z_z" in rows.columns else None,
    }
    numbers, said = rows["track"].cast(pl.Int64).to_numpy(), most_said(output, "identity")
    first = np.flatnonzero(np.diff(numbers, prepend=numbers[:1] - 1))
    for begin, end in zip(first, [*first[1:], len(numbers)], strict=True):
        part = rows[int(begin) : int(end)]
        number = int(numbers[begin])
        named = part["name"][0] if "name" in part.columns else said.get(str(number))
        yield EarthTrack(
            track=number,
            name=str(number if named is None else named),
            time=texts[begin:end],
            seconds=seconds[begin:end],
            latitude=latitude[begin:end],
            longitude=longitude[begin:end],
            altitude=_whole_column(part, "alt_m"),
            status=part["status"].to_list() if "status" in part.columns else [],
            score=finite(_last(part, "score")),
            **{name: None if each is None else each[begin:end] for name, each in known.items()},
        )


def _course(
    rows: pl.DataFrame, velocity: tuple[FloatArray, FloatArray], frame: LocalFrame | None
) -> FloatArray:
    """Return where tracks go, clockwise from their own north, not that of the plane's origin."""
    east, north = velocity
    place = _both(rows, "x", "y")
    if frame is not None and place is not None:
        # A second on.
        here, there = (
            frame.to_geodetic(np.stack([place[0] + s * east, place[1] + s * north], axis=-1))
            for s in (0.0, 1.0)
        )
        north = there[0] - here[0]
        east = ((there[1] - here[1] + 180.0) % 360.0 - 180.0) * np.cos(np.radians(here[0]))
    return np.asarray(np.degrees(np.arctan2(east, north)) % 360.0)


def _worst_axis(rows: pl.DataFrame) -> FloatArray | None:
    """Return the standard deviation along the longest axis of each position's ellipse [m]."""
    if not {"p_x_x", "p_x_y", "p_y_y"} <= set(rows.columns):
        return None
    xx, xy, yy = (_column(rows, name) for name in ("p_x_x", "p_x_y", "p_y_y"))
    largest = (xx + yy) / 2 + np.hypot((xx - yy) / 2, xy)
    return np.asarray(np.sqrt(np.maximum(largest, 0.0)))


def boxed_rows(output: Output, needed: Collection[str], name: str) -> pl.DataFrame:
    """Return the reports of tracks with the box that passed through, and ``frame``, from 0.

    Parameters
    ----------
    output
        What is written.
    needed
        Columns of the box.
    name
        The format's, for a refusal.

    Returns
    -------
    One row for each report of a track, by frame, then track; ``frame`` is that of the reports, or
    counts the different times from 0 where they have none.

    Raises
    ------
    InvalidInputError
        If reports came without boxes.
    """
    rows = _with_sides(output.tracks if output.assignments is None else output.assignments)
    missing = [column for column in needed if column not in rows.columns]
    if missing:
        raise InvalidInputError(
            f"format {name}: reports have no {', '.join(missing)}; expected the boxes that "
            "objects were found in, as columns of the reports"
        )
    rows = rows.filter(pl.col("track").is_not_null())
    if "frame" not in rows.columns:
        rows = rows.with_columns(frame=pl.col("time").rank("dense").cast(pl.Int64) - 1)
    return rows.sort("frame", "track", maintain_order=True)


def _with_sides(rows: pl.DataFrame) -> pl.DataFrame:
    """Return boxes with both their size and their far sides where either is there."""
    for near, size, far in (("left", "width", "right"), ("top", "height", "bottom")):
        there = set(rows.columns)
        if {near, far} <= there and size not in there:
            rows = rows.with_columns((pl.col(far) - pl.col(near)).alias(size))
        elif {near, size} <= there and far not in there:
            rows = rows.with_columns((pl.col(near) + pl.col(size)).alias(far))
    return rows


def framed_rows(output: Output, name: str) -> pl.DataFrame:
    """Return positions by track, then time: ``track,frame,seconds,x,y,z,parent``.

    Parameters
    ----------
    output
        What is written.
    name
        The format's, for a refusal.

    Returns
    -------
    One row for each state; frames count the different times from 0, heights are 0 without any,
    and ``parent`` is null where a track came of none. A mother's states end with the division,
    but for those that later reports tell of (column ``last_update``, where there is one).

    Raises
    ------
    InvalidInputError
        If there are no plane coordinates.
    """
    rows = _undivided(chosen_rows(output))
    if not {"x", "y"} <= set(rows.columns):
        raise InvalidInputError(f"format {name}: tracks have no x and y; expected both")
    _, seconds = moments(rows["time"])
    height = pl.col("z") if "z" in rows.columns else pl.lit(0.0)
    rows = rows.with_columns(
        pl.Series("seconds", seconds), height.cast(pl.Float64).fill_null(0.0).alias("z")
    )
    frame = pl.col("seconds").rank("dense").cast(pl.Int64) - 1
    parent = pl.col("parent") if "parent" in rows.columns else pl.lit(None)
    return rows.select(
        "track", frame.alias("frame"), "seconds", "x", "y", "z",
        parent.cast(pl.Int64, strict=False).alias("parent"),
    )  # fmt: skip


def _undivided(rows: pl.DataFrame) -> pl.DataFrame:
    """Return rows without those that foretell a mother who has divided already."""
    if not {"parent", "last_update"} <= set(rows.columns) or rows["parent"].is_null().all():
        return rows
    ends = rows.group_by("parent").agg(divides=pl.col("time").min())
    rows = rows.join(ends, left_on="track", right_on="parent", how="left", maintain_order="left")
    goes_on = (pl.col("time") >= pl.col("divides")) & (pl.col("last_update") < pl.col("divides"))
    return rows.filter(~goes_on.fill_null(value=False)).drop("divides")


def parents(rows: pl.DataFrame) -> dict[int, int]:
    """Return the track that each came of by division, of those that did, both among the rows."""
    known = rows.filter(pl.col("parent").is_in(rows["track"].unique().to_list()))
    return dict(known.select("track", "parent").unique(maintain_order=True).iter_rows())


def branches(rows: pl.DataFrame) -> dict[int, int]:
    """Return the mother's last row before each track that came of one, by the track's number."""
    track, frame = rows["track"].to_numpy(), rows["frame"].to_numpy()
    begins = np.flatnonzero(np.diff(track, prepend=track[:1] - 1))
    spans = {
        int(track[begin]): (int(begin), frame[begin:end])
        for begin, end in zip(begins, np.r_[begins[1:], track.size][: begins.size], strict=True)
    }
    found = {}
    for daughter, mother in parents(rows).items():
        begin, frames = spans[mother]
        count = int(np.searchsorted(frames, spans[daughter][1][0]))
        if count:
            found[daughter] = begin + count - 1
    return found


def joined(rows: pl.DataFrame) -> IntArray:
    """Return which rows follow one another, of a track or from a mother to her daughters.

    Parameters
    ----------
    rows
        States by track, then time, as ``framed_rows`` has them.

    Returns
    -------
    Numbers of rows, the earlier and the later, shape (links, 2), by the later.
    """
    track = rows["track"].to_numpy()
    begins = np.flatnonzero(np.diff(track, prepend=track[:1] - 1))
    before, mother = np.arange(track.size, dtype=np.int64) - 1, branches(rows)
    for row in begins.tolist():
        before[row] = mother.get(int(track[row]), -1)
    later = np.flatnonzero(before >= 0)
    return np.stack([before[later], later], axis=-1)


def family_of(track: int, parent: Mapping[int, int]) -> int:
    """Return the track from which a track and all its relatives came."""
    seen = {track}
    while track in parent and parent[track] not in seen:
        track = parent[track]
        seen.add(track)
    return track


def _column(rows: pl.DataFrame, name: str) -> FloatArray:
    return rows[name].cast(pl.Float64).fill_null(float("nan")).to_numpy()


def _whole_column(rows: pl.DataFrame, name: str) -> FloatArray | None:
    if name not in rows.columns or rows[name].null_count():
        return None
    return _column(rows, name)


def _both(rows: pl.DataFrame, first: str, second: str) -> tuple[FloatArray, FloatArray] | None:
    if not {first, second} <= set(rows.columns):
        return None
    return _column(rows, first), _column(rows, second)


def _last(rows: pl.DataFrame, name: str) -> Any:
    return rows[name][-1] if name in rows.columns else None
