"""Particles linked from frame to frame in one line, as those know who come from trackpy."""

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np
import polars as pl

from trackweave.arrays import require_instance
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_count, checked_members, checked_number
from trackweave.io.checks import Range, RowChecks
from trackweave.io.frames_in import from_native
from trackweave.io.tables import with_our_names
from trackweave.trackers.frame_linking import linked

__all__ = ["link"]

Table = TypeVar("Table")

_NAMES = ("x", "y", "z")
_FRAME = Range(-1e15, 1e15, "a whole number, the frame's")
_PLACE = Range(-1e12, 1e12)


def link(
    features: Table,
    search_range: float,
    *,
    memory: int = 0,
    pos_columns: Sequence[str] | None = None,
    t_column: str | None = None,
) -> Table:
    """Link features of frames into particles, by their distances alone.

    Every feature is of a particle; one that nothing else belongs to is alone. As in trackpy, what
    is linked from frame to frame has the least sum of squared distances, where a particle that
    nothing follows costs the square of the range; nothing is assumed of how particles move.
    ``tw.track`` knows more: velocities, noise, false detections, divisions, a sure answer of what
    is one and what is not.

    Parameters
    ----------
    features
        A pandas, polars or Arrow table with a row for each feature; it is not changed.
    search_range
        The farthest that a particle comes from where it was last seen to where it is seen next,
        > 0, in units of positions. No link is longer.
    memory
        For how many frames a particle may be unseen.
    pos_columns
        Names of the columns of positions, two or three; left out, x and y, and z if there is one.
    t_column
        Name of the column of frames, whole numbers; left out, ``frame``, or else what ``tw.track``
        takes for the time, such as ``t``.

    Returns
    -------
    The same table, row for row, with the column ``particle``, numbered from 0.

    Raises
    ------
    InvalidInputError
        If the table or a parameter cannot be used.

    Examples
    --------
    >>> import polars as pl
    >>> import trackweave as tw
    >>> found = pl.DataFrame({"frame": [0, 0, 1, 1], "x": [1.0, 9.0, 8.5, 1.5], "y": [2.0] * 4})
    >>> tw.link(found, search_range=2.0)["particle"].to_list()
    [0, 1, 1, 0]
    """
    reach, unseen = (
        checked_number(search_range, "search_range"),
        checked_count(memory, "memory", 0),
    )
    if not 1e-30 <= reach < 1e9:
        raise InvalidInputError(f"search_range: {search_range!r}; expected a number > 0, to 1e9")
    checks, when, names = _columns(features, pos_columns, t_column)
    frame = checks.whole_numbers(when, _FRAME)
    place = np.stack([checks.numbers(name, _PLACE) for name in names], axis=1)
    if len(checks):
        checks.finish("fail")
    owner = linked(frame.astype(np.int64), place, reach, unseen)
    # Numbered as they first appear in the table.
    particle = pl.Series("particle", owner, dtype=pl.Int64)
    first = pl.col("row").min().over("particle").rank("dense").cast(pl.Int64) - 1
    numbers = particle.to_frame().with_row_index("row").select(particle=first)["particle"]
    with_numbers: Table = _with_particle(features, numbers)
    return with_numbers


def _columns(
    features: Any, pos_columns: Sequence[str] | None, t_column: str | None
) -> tuple[RowChecks, str, list[str]]:
    """Return a table to be read, and the names of the columns of frames and of positions."""
    table = from_native(features)
    there, called = table.columns.columns, with_our_names(table).own_names
    if t_column is None:
        t_column = "frame" if "frame" in there else called.get("time", "time")
        t_column = t_column if t_column in there else "frame"
    require_instance(t_column, str, "t_column")
    names = [] if pos_columns is None else checked_members(pos_columns, str, "pos_columns")
    usual = [called.get(name, name) for name in _NAMES]
    # Without a name told, x and y have to be there: y and z alone are a plane that nobody means.
    names = names or usual[:2] + [name for name in usual[2:] if name in there]
    missing = [name for name in (*names, t_column) if name not in there]
    if missing:
        raise InvalidInputError(
            f"table, column {', '.join(missing)}: missing; expected {t_column} and "
            f"{'x, y[, z]' if pos_columns is None else 'the columns of pos_columns'}, or others "
            f"by pos_columns= and t_column= (the columns are {', '.join(there)[:200]})"
        )
    if len(names) not in (2, 3):
        raise InvalidInputError(f"pos_columns: {', '.join(names)}; expected two or three columns")
    return RowChecks(table), t_column, names


def _with_particle(features: Any, particle: pl.Series) -> Any:
    """Return a table of any library with a column more, in the place of one of that name."""
    if isinstance(features, pl.DataFrame):
        return features.with_columns(particle)
    if hasattr(features, "append_column"):
        if "particle" in features.column_names:
            features = features.drop_columns(["particle"])
        return features.append_column("particle", particle.to_arrow())
    return features.assign(particle=particle.to_numpy())
