"""Rows of tracks become pictures: what a sensor said of all its tracks at one time."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.tracks import TrackTable
from trackweave.filters.kalman import predicted
from trackweave.fusion.pictures import LocalPicture

__all__ = ["local_pictures"]

PATIENCE = 3.0
"""How many usual times between rows of a track it may have none and still be the same."""


def local_pictures(name: str, tracks: TrackTable, process_noise: float) -> list[LocalPicture]:
    """Return what a sensor said at each of its times, from its rows sorted by time."""
    # A track that has no row at a time, but one before and one after not long apart, was there all
    # the same: it is predicted from the row before. The process noise is the power spectral
    # density of the acceleration along each axis [m²/s³].
    times, moment = np.unique(tracks.time, return_inverse=True)
    source, place = _gaps(tracks, moment.reshape(-1))
    mean, covariance = predicted(
        tracks.mean[source], tracks.covariance[source], times[place] - tracks.time[source],
        process_noise,
    )  # fmt: skip
    covariance = (covariance + covariance.swapaxes(1, 2)) / 2.0
    every = np.concatenate([moment.reshape(-1), place])
    order = np.argsort(every, kind="stable")
    number = np.concatenate([tracks.track, tracks.track[source]])[order]
    means = np.concatenate([tracks.mean, mean])[order]
    spreads = np.concatenate([tracks.covariance, covariance])[order]
    start = np.searchsorted(every[order], np.arange(times.size + 1))
    return [
        LocalPicture(name, float(time), number[begin:end], means[begin:end], spreads[begin:end])
        for time, begin, end in zip(times, start[:-1], start[1:], strict=True)
    ]


def _gaps(tracks: TrackTable, moment: IntArray) -> tuple[IntArray, IntArray]:
    """Return times at which tracks have no row: the row before each, and which time it is."""
    order = np.lexsort((tracks.time, tracks.track))
    same = np.diff(tracks.track[order]) == 0
    wait: FloatArray = np.diff(tracks.time[order])
    usual = float(np.median(wait[same])) if np.any(same) else 0.0
    missed = np.where(same & (wait <= PATIENCE * usual), np.diff(moment[order]) - 1, 0)
    row = np.repeat(np.arange(missed.size), missed)
    turn = np.arange(row.size) - np.repeat(np.cumsum(missed) - missed, missed)
    source = order[row]
    return source.astype(np.int64), (moment[source] + 1 + turn).astype(np.int64)
