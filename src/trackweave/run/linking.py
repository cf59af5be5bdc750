"""Particles linked from frame to frame in one line, as those know who come from trackpy."""

from collections.abc import Sequence
from typing import Any, TypeVar

import polars as pl

from trackweave.arrays import require_instance
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_count, checked_members, checked_number
from trackweave.io.frames_in import from_native
from trackweave.run.tracking import track

__all__ = ["link"]

Table = TypeVar("Table")

# What a search range is in standard deviations of a step, and a position's noise beside it.
_STEPS, _NOISE = 3.0, 0.01
_NAMES = ("x", "y", "z")


def link(
    features: Table,
    search_range: float,
    *,
    memory: int = 0,
    pos_columns: Sequence[str] | None = None,
    t_column: str = "frame",
) -> Table:
    """Link features of frames into particles that wander.

    Every feature is of a particle; one that nothing else belongs to is alone. ``tw.track`` knows
    more: velocities, noise, false detections, a sure answer of what is one and what is not.

    Parameters
    ----------
    features
        A pandas, polars or Arrow table with a row for each feature; it is not changed.
    search_range
        The farthest that a particle comes from one frame to the next, > 0, in units of positions.
    memory
        For how many frames a particle may be unseen.
    pos_columns
        Names of the columns of positions, two or three; left out, x and y, and z if there is one.
    t_column
        Name of the column of frames, whole numbers.

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
    if not 0 < reach < 1e9:
        raise InvalidInputError(f"search_range: {search_range!r}; expected a number > 0")
    given = from_native(features).columns
    require_instance(t_column, str, "t_column")
    names = [] if pos_columns is None else checked_members(pos_columns, str, "pos_columns")
    names = names or [name for name in _NAMES if name in given.columns]
    missing = [name for name in (*names, t_column) if name not in given.columns]
    if missing or len(names) not in (2, 3):
        raise InvalidInputError(
            f"table, column {', '.join(missing) or 'x'}: missing; expected {t_column} and two or "
            f"three columns of positions (the columns are {', '.join(given.columns)[:200]})"
        )
    reports = given.select(
        pl.col(t_column).alias("time"),
        *(pl.col(name).alias(ours) for name, ours in zip(names, _NAMES, strict=False)),
    )
    found = track(reports, _configuration(reach, unseen)).reports["track"]
    # Those that stand alone are particles of one frame; all are numbered as they first appear.
    numbers = pl.DataFrame({"key": found}).with_row_index("first", offset=1)
    key = pl.col("key").fill_null(-pl.col("first").cast(pl.Int64))
    first = pl.col("first").min().over("key").rank("dense").cast(pl.Int64) - 1
    linked: Table = _with_particle(
        features, numbers.with_columns(key).select(particle=first)["particle"]
    )
    return linked


def _with_particle(features: Any, particle: pl.Series) -> Any:
    """Return a table of any library with a column more, in the place of one of that name."""
    if isinstance(features, pl.DataFrame):
        return features.with_columns(particle)
    if hasattr(features, "append_column"):
        if "particle" in features.column_names:
            features = features.drop_columns(["particle"])
        return features.append_column("particle", particle.to_arrow())
    return features.assign(particle=particle.to_numpy())


def _configuration(reach: float, unseen: int) -> dict[str, object]:
    return {
        "motion": {
            "model": "random-walk",
            "process_noise": (reach / _STEPS) ** 2,
            "max_speed": reach,
        },
        "sensors": {
            "default": {
                "sigma": _NOISE * reach, "detection_probability": 0.95, "clutter_per_scan": 0.01,
                "scan_period": 1.0,
            }
        },
        "lifecycle": {"confirm": "1/1", "delete_after_misses": unseen + 1},
    }  # fmt: skip
