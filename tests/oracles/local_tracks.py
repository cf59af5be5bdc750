"""Tables of tracks as a sensor's tracker writes them, made by filters that know the truth."""

from collections.abc import Iterable, Mapping

import numpy as np
import polars as pl

from trackweave.domain.frames import LocalFrame
from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.filters.kalman import predicted, updated
from trackweave.io.frames_out import tracks_frame

__all__ = ["NOISE", "sensor_table", "sensor_tracks"]

NOISE = 0.1


def sensor_tracks(
    rng: np.random.Generator,
    objects: Mapping[int, tuple[float, float]],
    times: Iterable[float],
    *,
    sigma: float = 5.0,
    shift: tuple[float, float] = (0.0, 0.0),
) -> TrackTable:
    """Return the tracks of objects, by number their places at time 0; all go east at 10 m/s."""
    rows: list[TrackTable] = []
    number = np.array(list(objects))
    place = np.array(list(objects.values())).reshape(-1, 2)
    n = len(number)
    state = np.concatenate([place, np.zeros((n, 2))], axis=1)
    spread = np.tile(np.diag([1e4, 1e4, 400.0, 400.0]), (n, 1, 1))
    before = None
    for time in times:
        if before is not None:
            gap = np.full(n, time - before)
            state, spread = predicted(state, spread, gap, NOISE)
        before = time
        where = place + np.array([10.0 * time, 0.0]) + rng.normal(0.0, sigma, (n, 2)) + shift
        state, spread = updated(state, spread, where, np.full((n, 2), sigma))
        rows.append(
            TrackTable(
                np.full(n, time), number, np.full(n, CONFIRMED), state, spread, np.zeros(n),
                np.ones(n, dtype=np.int64), np.full(n, time),
            )
        )  # fmt: skip
    return TrackTable.concatenate(rows, 2)


def sensor_table(
    rng: np.random.Generator,
    objects: Mapping[int, tuple[float, float]],
    times: Iterable[float],
    *,
    frame: LocalFrame | None = None,
    iso_time: bool = False,
    **options: float | tuple[float, float],
) -> pl.DataFrame:
    """Return the same as a table with the columns of a tracks file."""
    tracks = sensor_tracks(rng, objects, times, **options)  # type: ignore[arg-type]
    return tracks_frame(tracks, frame, iso_time=iso_time)
