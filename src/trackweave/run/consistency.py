"""Whether the tracks of several sensors speak of one world: its clock, its plane, its units."""

from collections.abc import Mapping

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.frames import LocalFrame
from trackweave.domain.tracks import TrackTable
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.io.positions import choose_frame
from trackweave.io.tracks_in import LocalTracks

__all__ = ["on_one_plane", "require_agreement"]

Tables = Mapping[str, LocalTracks]

THOUSAND = (250.0, 4000.0)
"""Ratios that a unit a thousand times larger explains, and hardly anything else."""
DEGREES = (25_000.0, 120_000.0)
"""How many metres a degree may be: of latitude, or of longitude as far north as ships go."""
SAME_SCALE = 0.02
"""How far distances on one plane may be from those on another, as a share."""


def require_agreement(tables: Tables) -> None:
    """Refuse tracks of one sensor alone, and tracks that cannot be of one world."""
    # Dimensions differ, some times are dates and others seconds, a sensor's times overlap with no
    # other's, or units disagree by a thousand.
    if len(tables) < 2:
        raise InvalidInputError(
            f"tracks: {'those of one sensor' if tables else 'none'}; expected the tracks of two "
            "sensors at least"
        )
    filled = {name: table for name, table in tables.items() if len(table)}
    if not filled:
        listed = ", ".join(table.name for table in tables.values())
        raise DataFormatError(f"{listed}: no tracks; expected some, of one sensor at least")
    _require_one_kind(filled)
    _require_overlap(filled)
    for table in filled.values():
        _require_speeds(table)
    _require_one_scale(filled)


def _require_one_kind(tables: Tables) -> None:
    first = next(iter(tables.values()))
    for table in tables.values():
        if table.tracks.dim != first.tracks.dim:
            raise DataFormatError(
                f"{table.name}, column z: tracks in {table.tracks.dim} dimensions; expected "
                f"{first.tracks.dim} as in {first.name}"
            )
        if table.iso_time != first.iso_time:
            kinds = {True: "dates", False: "seconds"}
            raise DataFormatError(
                f"{table.name}, column time: {kinds[table.iso_time]}; expected "
                f"{kinds[first.iso_time]} as in {first.name}"
            )


def _require_overlap(tables: Tables) -> None:
    """Refuse a sensor whose tracks are all before or after those of all others."""
    spans = {name: (t.tracks.time[0], t.tracks.time[-1]) for name, t in tables.items()}
    for name, (first, last) in spans.items():
        others = [span for other, span in spans.items() if other != name]
        if not others or any(begin <= last and first <= end for begin, end in others):
            continue
        begin, end = min(span[0] for span in others), max(span[1] for span in others)
        raise DataFormatError(
            f"{tables[name].name}, column time: from {first:.15g} to {last:.15g} s, the others' "
            f"from {begin:.15g} to {end:.15g} s; expected times that overlap"
        )


def _require_speeds(table: LocalTracks) -> None:
    """Refuse tracks that move a thousand times as far as their velocities say, or as little."""
    # Or as much less as a degree has metres, where positions can be degrees.
    moved, said = _ways(table.tracks)
    if said == 0.0 or moved == 0.0:
        return
    ratio = moved / said
    if DEGREES[0] <= 1.0 / ratio <= DEGREES[1] and _may_be_degrees(table.tracks):
        raise DataFormatError(
            f"{table.name}, columns x and vx: tracks move {ratio:.3g} times as far as their "
            "velocities say, as degrees do; expected metres and metres per second, and degrees "
            "in lat and lon"
        )
    if THOUSAND[0] <= max(ratio, 1.0 / ratio) <= THOUSAND[1]:
        raise DataFormatError(
            f"{table.name}, columns x and vx: tracks move {ratio:.3g} times as far as their "
            "velocities say; expected metres and metres per second"
        )


def _may_be_degrees(tracks: TrackTable) -> bool:
    place = np.abs(tracks.mean[:, :2])
    return bool(place.max() <= 360.0 and place.min(axis=1).max() <= 90.0)


def _ways(tracks: TrackTable) -> tuple[float, float]:
    """Return how far all tracks went from their first row to their last, and said they did."""
    dim = tracks.dim
    order = np.lexsort((tracks.time, tracks.track))
    number, time, mean = tracks.track[order], tracks.time[order], tracks.mean[order]
    inside = np.diff(number) == 0
    step = np.diff(mean[:, :dim], axis=0)[inside]
    said = ((mean[1:, dim:] + mean[:-1, dim:]) / 2.0 * np.diff(time)[:, None])[inside]
    start = np.flatnonzero(np.diff(number[1:][inside], prepend=-1))
    if not start.size:
        return 0.0, 0.0
    ways = [
        float(np.linalg.norm(np.add.reduceat(each, start, axis=0), axis=1).sum())
        for each in (step, said)
    ]
    return ways[0], ways[1]


def _require_one_scale(tables: Tables) -> None:
    """Refuse tracks whose extent and speed both are a thousand times another sensor's."""
    sizes = {name: _sizes(table.tracks) for name, table in tables.items()}
    names = list(tables)
    for place, name in enumerate(names):
        for other in names[:place]:
            ratios = sizes[name] / sizes[other]
            if np.all((ratios >= THOUSAND[0]) & (ratios <= THOUSAND[1])) or np.all(
                (1.0 / ratios >= THOUSAND[0]) & (1.0 / ratios <= THOUSAND[1])
            ):
                raise DataFormatError(
                    f"{tables[name].name}, columns x, y, vx and vy: extent and speeds are "
                    f"{ratios[0]:.3g} and {ratios[1]:.3g} times those of {tables[other].name}; "
                    "expected metres and metres per second in both"
                )


def _sizes(tracks: TrackTable) -> FloatArray:
    """Return the typical distance of tracks from their middle and their typical speed."""
    dim = tracks.dim
    place = tracks.mean[:, :dim]
    apart = np.median(np.linalg.norm(place - np.median(place, axis=0), axis=1))
    speed = np.median(np.linalg.norm(tracks.mean[:, dim:], axis=1))
    # One object that stands still has no extent of its own: then its uncertainty stands for it.
    if apart == 0.0:
        apart = np.median(np.sqrt(tracks.covariance[:, 0, 0]))
    if speed == 0.0:
        speed = np.median(np.sqrt(tracks.covariance[:, dim, dim]))
    return np.array([apart, speed], dtype=np.float64)


def on_one_plane(tables: Tables) -> tuple[dict[str, LocalTracks], LocalFrame | None, list[str]]:
    """Return tracks on one plane where all tell lat and lon, the plane, and what to know of it."""
    # The plane is None where positions are taken as they are.
    told = {name: table for name, table in tables.items() if table.latitude is not None}
    filled = [name for name, table in tables.items() if len(table)]
    if not told or not set(filled) <= set(told):
        notes = []
        if told:
            silent = ", ".join(tables[name].name for name in filled if name not in told)
            notes.append(
                f"lat,lon: not in {silent}, so x,y of all tables are taken to be of one plane"
            )
        return dict(tables), None, notes
    latitude = np.concatenate(
        [table.latitude for table in told.values() if table.latitude is not None]
    )
    longitude = np.concatenate(
        [table.longitude for table in told.values() if table.longitude is not None]
    )
    frame = choose_frame(latitude, longitude)
    moved = dict(tables) | {name: _laid(table, frame) for name, table in told.items()}
    note = f"positions are on the plane that touches {frame.latitude_deg}, {frame.longitude_deg}"
    return moved, frame, [note]


def _laid(table: LocalTracks, frame: LocalFrame) -> LocalTracks:
    """Return tracks on a plane; velocities and covariances turn with it."""
    assert table.latitude is not None
    assert table.longitude is not None
    dim, mean = table.tracks.dim, table.tracks.mean.copy()
    if not len(table):
        return table
    there = frame.to_plane(table.latitude, table.longitude, np.zeros(len(table)))[:, :2]
    old, new = mean[:, :2] - mean[:, :2].mean(axis=0), there - there.mean(axis=0)
    turn = complex(np.vdot(old[:, 0] + 1j * old[:, 1], new[:, 0] + 1j * new[:, 1]))
    # On less than ten metres rounding alone would turn the plane.
    angle = 0.0
    if np.sum(new**2) > 100.0 * len(table):
        scale = float(np.sqrt(np.sum(old**2) / np.sum(new**2)))
        if abs(scale - 1.0) > SAME_SCALE:
            raise DataFormatError(
                f"{table.name}, columns x and y: distances are {scale:.3g} times those of "
                "lat and lon; expected metres"
            )
        angle = float(np.angle(turn))
    rotation = np.eye(2 * dim)
    c, s = np.cos(angle), np.sin(angle)
    for corner in (0, dim):
        rotation[corner : corner + 2, corner : corner + 2] = [[c, -s], [s, c]]
    mean = mean @ rotation.T
    mean[:, :2] = there
    covariance = rotation @ table.tracks.covariance @ rotation.T
    return table.with_states(mean, (covariance + covariance.swapaxes(1, 2)) / 2.0)
