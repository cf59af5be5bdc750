"""Tracks in further formats."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import polars as pl

from trackweave.domain.reports import ReportTable
from trackweave.errors import InvalidInputError
from trackweave.formats.format import Format, Output
from trackweave.formats.registry import format_named
from trackweave.io.frames_out import assignments_frame
from trackweave.plugin_faults import is_ours, told_as_theirs

__all__ = ["try_on", "writers_named", "written"]


def writers_named(names: str | Sequence[str] | None) -> list[Format]:
    """Return the formats that lists with commas name, each of which can be written."""
    names = [names] if isinstance(names, str) else names
    each = [name.strip() for some in names or () for name in some.split(",")]
    twice = next((name for name in each if each.count(name) > 1), None)
    if twice is not None:
        raise InvalidInputError(f"format {twice!r:.60}: twice; expected each name once")
    return [format_named(name, writes=True) for name in each]


def try_on(further: Iterable[Format], reports: ReportTable) -> None:
    """Refuse formats that cannot say what tracks of these reports will be, before they are made.

    Raises
    ------
    InvalidInputError
        If a format needs places on the Earth, or boxes, and there are none.
    """
    found = assignments_frame(reports, {})
    columns = {"track": pl.Int64, "status": pl.String, "x": pl.Float64, "y": pl.Float64}
    if reports.frame is not None:
        columns |= {"lat": pl.Float64, "lon": pl.Float64}
    tracks = pl.DataFrame(schema={"time": found.schema["time"], **columns})
    written(further, Output(tracks, tracks, found, reports.frame))


def written(further: Iterable[Format], output: Output) -> dict[str, bytes]:
    """Return the files of further formats, by name."""
    files: dict[str, bytes] = {}
    for each in further:
        assert each.writer is not None
        try:
            made = each.writer(output)
        except InvalidInputError:  # the format cannot say what is there
            raise
        except Exception:
            with told_as_theirs(each.writer, "writers", "writer", each.name):
                raise
        if not is_ours(each.writer):
            _require_files(made, each.name)
        files |= made
    return files


def _require_files(made: Any, name: str) -> None:
    if not isinstance(made, Mapping) or not all(
        isinstance(file, str) and isinstance(content, bytes) for file, content in made.items()
    ):
        raise InvalidInputError(
            f"format {name}, a plug-in: its writer returned {made!r:.60}; expected the bytes of "
            "files by their names"
        )
