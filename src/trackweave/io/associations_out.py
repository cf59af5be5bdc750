"""Which local track was of which object, as a data frame."""

from collections.abc import Sequence

import numpy as np
import polars as pl

from trackweave.fusion.pairings import Pairing
from trackweave.io.frames_out import time_column

__all__ = ["associations_frame"]


def associations_frame(pairings: Sequence[Pairing], *, iso_time: bool = False) -> pl.DataFrame:
    """Return pairings as a data frame.

    Parameters
    ----------
    pairings
        The rows, whose order is kept.
    iso_time
        Whether times are written as dates.

    Returns
    -------
    ``object,sensor,track,from,to,reason``; an empty reason where it lasted to the end.
    """
    begin = np.array([one.begin for one in pairings], dtype=np.float64)
    end = np.array([one.end for one in pairings], dtype=np.float64)
    return pl.DataFrame(
        [
            pl.Series("object", [one.object for one in pairings], dtype=pl.Int64),
            pl.Series("sensor", [one.sensor for one in pairings], dtype=pl.String),
            pl.Series("track", [one.track for one in pairings], dtype=pl.Int64),
            time_column("from", begin, iso_time=iso_time),
            time_column("to", end, iso_time=iso_time),
            pl.Series("reason", [one.reason or None for one in pairings], dtype=pl.String),
        ]
    )
