"""What is shown of the tracks: the picture now, what of it changed, and where each has been."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.tracks import TrackTable
from trackweave.io.frames_out import tracks_frame
from trackweave.service.desk import Json, Picture
from trackweave.service.engine import Engine
from trackweave.service.messages import track_messages

__all__ = ["Board", "Drawn"]

MOST_POINTS = 300
"""So many points of a trail are kept."""
REPEATED = 5.0
"""A track that nothing was reported of is told again after so many seconds of its time."""


_NOBODY = tracks_frame(TrackTable.empty(2))


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """A new picture, and what of it differs from the one before."""

    picture: Picture
    changed: pl.DataFrame
    ended: tuple[str, ...]


@dataclass(slots=True)
class Board:
    """The newest picture; drawn on the engine's thread, read by everybody."""

    picture: Picture = field(default_factory=lambda: Picture(None, _NOBODY))
    _track: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    _update: FloatArray = field(default_factory=lambda: np.empty(0))
    _status: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    _told: FloatArray = field(default_factory=lambda: np.empty(0))
    _trails: dict[int, deque[tuple[float, float, float]]] = field(default_factory=dict)

    def draw(self, engine: Engine) -> Drawn | None:
        """Draw the tracks as they are; None before the first scan."""
        spec, time = engine.spec, engine.time
        if spec is None or time is None:
            return None
        tracks = engine.tracks()
        tracks = tracks.at(np.argsort(tracks.track, kind="stable"))
        place = np.searchsorted(self._track, tracks.track)
        place = np.minimum(place, max(len(self._track) - 1, 0))
        is_new = np.ones(len(tracks), dtype=np.bool_)
        told = np.full(len(tracks), -np.inf)
        if len(self._track):
            known = self._track[place] == tracks.track
            told[known] = self._told[place[known]]
            same = known & (self._update[place] == tracks.last_update)
            same &= self._status[place] == tracks.status
            is_new = ~same | (tracks.time - told >= REPEATED)
        ended = np.setdiff1d(self._track, tracks.track)
        told[is_new] = tracks.time[is_new]
        self._track, self._update = tracks.track, tracks.last_update
        self._status, self._told = tracks.status, told
        self._trace(tracks, np.flatnonzero(is_new), ended)
        frame = tracks_frame(tracks, spec.frame, iso_time=spec.iso_time)
        names = engine.identities_of(tracks.track)
        if names is not None:
            frame = frame.with_columns(identity=pl.Series(names, dtype=pl.String))
        heights = engine.heights_of(tracks.track)
        if heights is not None:
            frame = frame.with_columns(height_m=pl.Series(heights, dtype=pl.Float64))
        self.picture = Picture(time, frame, spec.frame)
        changed = frame.filter(pl.Series(is_new))
        return Drawn(self.picture, changed, tuple(map(str, ended.tolist())))

    def track(self, identifier: str) -> Json | None:
        """Return a live track with its trail; None for none."""
        if not identifier.isdecimal() or len(identifier) > 18:
            return None
        picture, number = self.picture, int(identifier)
        row = picture.tracks.filter(pl.col("track") == number)
        if row.is_empty():
            return None
        told = track_messages(row, picture.frame)[0]
        return {**told, "trail": [list(point) for point in self._trails.get(number, ())]}

    def _trace(self, tracks: TrackTable, rows: IntArray, ended: IntArray) -> None:
        for number in ended.tolist():
            self._trails.pop(number, None)
        for row in rows.tolist():
            point = (
                float(tracks.time[row]),
                round(float(tracks.mean[row, 0]), 3),
                round(float(tracks.mean[row, 1]), 3),
            )
            trail = self._trails.get(int(tracks.track[row]))
            if trail is None:
                trail = self._trails[int(tracks.track[row])] = deque(maxlen=MOST_POINTS)
            trail.append(point)
