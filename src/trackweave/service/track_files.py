"""The tracks files of a service: rows as they became known, in parts of a bounded size."""

import logging
from pathlib import Path
from typing import TypeAlias

import polars as pl

from trackweave.domain.tracks import TrackTable
from trackweave.io.encoding import encode_table
from trackweave.io.frames_out import tracks_frame
from trackweave.service.log import say
from trackweave.service.spec import Spec

__all__ = ["TrackFiles", "WritingPlace"]

WritingPlace: TypeAlias = tuple[int, int, int, tuple[str, ...]]
"""Where writing is: part, rows and bytes in it, and its columns."""

_log = logging.getLogger("trackweave.service")

MOST_ROWS = 200_000
"""A part that has so many rows is the last no more."""


class TrackFiles:
    """Writes rows of tracks, and goes on where a snapshot says that it was.

    What it writes depends on the rows alone, not on when or in how many pieces they came.

    Parameters
    ----------
    folder
        Where ``tracks-00001.csv`` and those that follow are; None to write nothing.
    most_rows
        A part that has so many rows is the last no more.
    """

    def __init__(self, folder: Path | None, *, most_rows: int = MOST_ROWS) -> None:
        self._folder, self._most = folder, most_rows
        self.part, self.n_rows, self.size = 0, 0, 0
        self._columns: tuple[str, ...] = ()
        self._waiting: list[pl.DataFrame] = []
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)

    @property
    def is_behind(self) -> bool:
        """Whether the disk has refused rows, which are written once it takes them."""
        return bool(self._waiting)

    def place(self) -> WritingPlace:
        """Return where it is."""
        return self.part, self.n_rows, self.size, self._columns

    def go_on(self, place: WritingPlace) -> None:
        """Be where it was: what was written since is taken back, to be written anew."""
        part, n_rows, size, columns = place
        self.part, self.n_rows, self.size = int(part), int(n_rows), int(size)
        self._columns = tuple(columns)
        if self._folder is None:
            return
        for path in self._folder.glob("tracks-*.csv"):
            number = path.stem.removeprefix("tracks-")
            if number.isdecimal() and int(number) > self.part:
                path.unlink()
        if self.part and self._path().exists():
            with self._path().open("r+b") as file:
                file.truncate(self.size)

    def begin_after(self, place: WritingPlace) -> None:
        """Write what follows a place into a part of its own, numbered on."""
        self.part = int(place[0])

    def add(self, tables: tuple[TrackTable, ...], spec: Spec) -> None:
        """Write rows that became due, after those that still wait for room on the disk."""
        if self._folder is None or not tables:
            return
        was_behind = self.is_behind
        frames = [tracks_frame(table, spec.frame, iso_time=spec.iso_time) for table in tables]
        self._waiting += [frame for frame in frames if not frame.is_empty()]
        try:
            while self._waiting:
                self._write(self._waiting[0])
                del self._waiting[0]
        except OSError as err:
            if not was_behind:
                why = err.strerror or str(err)
                say(_log, logging.WARNING, "tracks file refused", path=self._path(), message=why)

    def _write(self, frame: pl.DataFrame) -> None:
        missing = [name for name in self._columns if name not in frame.columns]
        is_wider = any(name not in self._columns for name in frame.columns)
        # Somebody may have taken the part away.
        is_gone = self.size > 0 and not self._path().exists()
        begins = self.part == 0 or self.n_rows >= self._most or is_wider or is_gone
        if begins:
            self.part, self.n_rows, self.size = self.part + 1, 0, 0
            self._columns = tuple(frame.columns)
        elif missing:
            nothing = [pl.lit(None, dtype=pl.Float64).alias(name) for name in missing]
            frame = frame.with_columns(nothing)
        data = encode_table(frame.select(self._columns), "tracks.csv")
        if self.size:
            data = data[data.index(b"\n") + 1 :]
        with self._path().open("r+b" if self.size else "wb") as file:
            # What was written of these rows before the disk was full is written over.
            file.seek(self.size)
            file.write(data)
            file.truncate()
        self.n_rows, self.size = self.n_rows + frame.height, self.size + len(data)

    def _path(self) -> Path:
        assert self._folder is not None
        return self._folder / f"tracks-{self.part:05d}.csv"
