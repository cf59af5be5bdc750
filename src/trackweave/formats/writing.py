"""Tracks in further formats."""

from collections.abc import Iterable

from trackweave.errors import InvalidInputError
from trackweave.formats.format import Format, Output
from trackweave.formats.registry import format_named

__all__ = ["writers_named", "written"]


def writers_named(names: str | None) -> list[Format]:
    """Return the formats that a list with commas names, each of which can be written."""
    if names is None:
        return []
    each = [name.strip() for name in names.split(",")]
    twice = next((name for name in each if each.count(name) > 1), None)
    if twice is not None:
        raise InvalidInputError(f"format {twice!r:.60}: twice; expected each name once")
    return [format_named(name, writes=True) for name in each]


def written(further: Iterable[Format], output: Output) -> dict[str, bytes]:
    """Return the files of further formats, by name."""
    files: dict[str, bytes] = {}
    for each in further:
        assert each.writer is not None
        files |= each.writer(output)
    return files
