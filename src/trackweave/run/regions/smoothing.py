"""Histories on workers: each smooths some tracks, since no track's history asks for another's."""

import time as clock
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import TrackTable
from trackweave.engine import Pool
from trackweave.run.history import shown_times, smoothed_at

__all__ = ["smoothed_on"]


Share: TypeAlias = tuple[
    tuple[ReportTable, dict[int, int], TrackTable], tuple[FloatArray, FloatArray], Settings
]
"""Some tracks of a run, when they are shown, and the run's settings, as `smoothed_at` has them."""


def smoothed_on(
    pool: Pool,
    count: int,
    found: tuple[ReportTable, Mapping[int, int], TrackTable],
    settings: Settings,
) -> tuple[TrackTable, list[float]]:
    """Return every track's history as `smoothed_history` does, in shares of about equal size.

    Parameters
    ----------
    pool
        The workers.
    count
        How many shares; what comes out does not depend on it.
    found
        The reports, the track of each row that has one, and the tracks as they were known.
    settings
        The run's.

    Returns
    -------
    The history, and the CPU of each share [s].
    """
    reports, assignment, tracks = found
    ends, moments = shown_times(reports, tracks, settings)
    rows = np.array(sorted(assignment), dtype=np.int64)
    name = np.array([assignment[row] for row in rows.tolist()], dtype=np.int64)
    shares: list[Share] = []
    for own in _shares(name, count):
        mine = np.isin(name, own)
        assigned = dict(enumerate(name[mine].tolist()))
        some = reports.part(rows[mine]), assigned, tracks.at(np.isin(tracks.track, own))
        shares.append((some, (ends[rows[mine]], moments), settings))
        pool.submit(_smoothed, *shares[-1])
    # A share whose workers were lost is done here.
    done = [
        _smoothed(*share) if outcome.error else outcome.value
        for share, outcome in zip(shares, pool.gather(), strict=True)
    ]
    table = TrackTable.concatenate([part for part, _ in done], reports.dim)
    return table.at(np.lexsort((table.track, table.time))), [cpu for _, cpu in done]


def _shares(name: IntArray, count: int) -> list[IntArray]:
    """Return the names of tracks in shares with about as many reports each."""
    names, n_reports = np.unique(name, return_counts=True)
    cuts = np.searchsorted(np.cumsum(n_reports), np.arange(1, count) * name.size / count)
    return [own for own in np.split(names, cuts) if own.size]


def _smoothed(*share: Any) -> tuple[TrackTable, float]:
    """Return a share's history and the CPU that it took [s]."""
    begin = clock.process_time()
    return smoothed_at(*share), clock.process_time() - begin
