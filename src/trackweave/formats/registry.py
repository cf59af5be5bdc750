"""Which formats there are: ours, and those that other packages bring."""

import warnings
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points

from trackweave.errors import InvalidInputError
from trackweave.formats.format import Format
from trackweave.plugin_faults import told_as_theirs

__all__ = ["format_named", "formats", "recognised"]

# Modules here, in the order in which they are asked whether a file is theirs; each has a FORMAT.
_OURS: tuple[str, ...] = (
    "parquet", "asterix", "ais", "sbs", "opensky", "coco", "readsb", "trackmate", "ctc", "geff",
    "kitti", "mot", "geojson", "kml", "czml", "cot", "asterix_062", "jsonl",
)  # fmt: skip
# Whatever has a header of columns; somebody else's format of text may be more particular.
_LAST: tuple[str, ...] = ("csv",)


@cache
def formats() -> dict[str, Format]:
    """Return all formats by name, ours first, then what entry points bring.

    An entry point of the group ``trackweave.readers`` or ``trackweave.writers`` is a ``Format``.
    One that fails to load, is none, or has the name of another is warned of and left out.

    Returns
    -------
    Formats in the order in which they are asked whether a file is theirs.
    """
    found = _imported(_OURS)
    last = _imported(_LAST)
    for group in ("trackweave.readers", "trackweave.writers"):
        for entry in entry_points(group=group):
            foreign = _loaded(entry)
            if foreign is None or found.get(foreign.name) is foreign:
                continue
            if foreign.name in {**found, **last}:
                warnings.warn(
                    f"format {foreign.name} of {entry.value}: not used, there is one of that name",
                    UserWarning,
                    stacklevel=2,
                )
                continue
            found[foreign.name] = foreign
    return {**found, **last}


def format_named(name: str, *, writes: bool = False) -> Format:
    """Return the format of a name that can be read, or written.

    Parameters
    ----------
    name
        Its name.
    writes
        Whether it is to be written.

    Returns
    -------
    The format.

    Raises
    ------
    InvalidInputError
        If there is none of that name, or it cannot do that.
    """
    able = {
        each.name: each
        for each in formats().values()
        if (each.writer if writes else each.can_read)
    }
    if name not in able:
        what = "written" if writes else "read"
        raise InvalidInputError(
            f"format {name!r:.60}: expected one that can be {what}: {', '.join(sorted(able))}"
        )
    return able[name]


def recognised(head: bytes, name: str) -> Format | None:
    """Return the first format that takes a file for its own, by its beginning and its name."""
    for each in formats().values():
        if each.recognise is None:
            continue
        with told_as_theirs(each.recognise, "readers", "recognise", each.name):
            if each.recognise(head, name):
                return each
    return None


def _imported(modules: tuple[str, ...]) -> dict[str, Format]:
    ours: list[Format] = [import_module(f"trackweave.formats.{name}").FORMAT for name in modules]
    return {each.name: each for each in ours}


def _loaded(entry: EntryPoint) -> Format | None:
    try:
        found = entry.load()
    except Exception as err:  # somebody else's package may fail in any way
        found = err
    if isinstance(found, Format):
        return found
    told = found if isinstance(found, Exception) else type(found).__name__
    warnings.warn(f"format {entry.value}: not used ({told})", UserWarning, stacklevel=3)
    return None
