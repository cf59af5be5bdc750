"""Noise of positions that is not the same along each axis, as along a camera's line of sight."""

from dataclasses import replace

import numpy as np

from trackweave.arrays import IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import Estimates, bounded, positive
from trackweave.estimation.neighbours import beside_neighbours
from trackweave.estimation.noise import arrays_of, noise_of_chains
from trackweave.estimation.refine import Followed, sure_tracks

__all__ = ["with_axes"]

# So many reports of so many tracks tell, and noise that is so many times as large along one axis.
FEWEST_REPORTS, FEWEST_TRACKS, APART = 200, 8, 2.0
# Reports before and after one that say where it is.
BESIDE = 5
# So many reports lie off by no more than so many standard deviations: of noise that grows with the
# distance, that of the far ones counts.
MOST, MOST_OF_NORMAL = 0.9, 1.6449


def with_axes(estimates: Estimates, reports: ReportTable, followed: Followed) -> Estimates:
    """Return estimates with the noise along each axis of sensors in which it is not alike."""
    sensors = dict(estimates.sensors)
    tracks, process = sure_tracks(estimates, reports, followed), list[float]()
    for index, name in enumerate(reports.sensors):
        if name not in sensors or sensors[name].scans is False or sensors[name].sigma_at:
            continue
        chains = [track.rows[reports.sensor[track.rows] == index] for track in tracks]
        chains = [rows for rows in chains if rows.size >= BESIDE]
        off = [
            beside_neighbours(reports.time[rows], reports.measurement[rows])[1] for rows in chains
        ]
        if len(off) < FEWEST_TRACKS or sum(map(len, off)) < FEWEST_REPORTS:
            continue
        noise = np.quantile(np.abs(np.concatenate(off)), MOST, axis=0) / MOST_OF_NORMAL
        if noise.max() > APART * noise.min() > 0.0:
            axes = tuple(bounded(float(each), 1e-9) for each in noise)
            sensors[name] = replace(sensors[name], axes=axes)
            process.append(_process(reports, chains, axes))
    if process:
        # Along the others what objects do is hidden in the noise.
        estimates = replace(estimates, process_noise=positive(min(process)))
    return replace(estimates, sensors=sensors)


def _process(reports: ReportTable, chains: list[IntArray], axes: tuple[float, ...]) -> float:
    """Return the process noise along the axis with the least noise [m²/s³]."""
    quiet = int(np.argmin(axes))
    time, place = arrays_of(
        (reports.time[rows], reports.measurement[rows, quiet : quiet + 1]) for rows in chains
    )
    density = 1e-3 / max(float(np.ptp(reports.measurement[:, quiet])), 1e-9)
    return noise_of_chains(time, place, axes[quiet], density)[1]
