"""Tracks after the fact: final assignments, smoothed over all their reports."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import COASTING, CONFIRMED, TENTATIVE, TrackTable
from trackweave.filters.smoother import smooth
from trackweave.run.scans import scan_ends

__all__ = ["smoothed_history"]

# Cells of a batch of tracks, so that memory stays bounded.
MOST_CELLS = 100_000


@dataclass(frozen=True, slots=True, eq=False)
class _Path:
    """One track's moments: scans between its first and last report, and the reports in them."""

    track: int
    time: FloatArray
    report: IntArray
    start_mean: FloatArray | None
    start_covariance: FloatArray | None


def smoothed_history(
    reports: ReportTable,
    assignment: Mapping[int, int],
    tracks: TrackTable,
    settings: Settings,
    priors: TrackTable | None = None,
) -> TrackTable:
    """Return every track at every scan between its first and last report.

    Each state is conditioned on all of the track's reports, later ones included
    (Rauch, Tung & Striebel, "Maximum likelihood estimates of linear dynamic systems", 1965).

    Parameters
    ----------
    reports
        All reports.
    assignment
        From row number to track, after all amendments.
    tracks
        The tracks as they were known scan by scan; their status and score are taken from it.
    settings
        Motion and sensors.
    priors
        States from which tracks set out, if any.

    Returns
    -------
    Rows by time, then track.
    """
    paths = _paths(reports, assignment, tracks, priors)
    sigma = _sigma(reports, settings)
    parts = []
    for batch in _batches(paths):
        parts.append(_smooth(batch, reports, sigma, settings))
    table = TrackTable.concatenate(parts, reports.dim)
    table = _with_status(table, tracks)
    return _rows(table, np.lexsort((table.track, table.time)))


def _paths(
    reports: ReportTable,
    assignment: Mapping[int, int],
    tracks: TrackTable,
    priors: TrackTable | None,
) -> list[_Path]:
    # As in the tracks, a report counts at the end of its scan.
    ends = scan_ends(reports)
    moments = np.unique(np.concatenate([tracks.time, ends]))
    rows_of: dict[int, list[int]] = {}
    for row, track in assignment.items():
        rows_of.setdefault(track, []).append(row)
    begun = {} if priors is None else {int(track): k for k, track in enumerate(priors.track)}
    paths = []
    for track in sorted(rows_of):
        rows = np.array(sorted(rows_of[track]), dtype=np.int64)
        rows = rows[np.argsort(ends[rows], kind="stable")]
        first, last = ends[rows[0]], ends[rows[-1]]
        between = moments[(moments > first) & (moments < last)]
        empty = np.setdiff1d(between, ends[rows])
        time = np.concatenate([ends[rows], empty])
        report = np.concatenate([rows, np.full(empty.size, -1, dtype=np.int64)])
        prior = begun.get(track)
        if prior is not None and priors is not None and priors.time[prior] <= first:
            time = np.r_[priors.time[prior], time]
            report = np.r_[-1, report]
            start = priors.mean[prior], priors.covariance[prior]
        else:
            start = None, None
        order = np.argsort(time, kind="stable")
        paths.append(_Path(track, time[order], report[order], *start))
    return paths


def _batches(paths: list[_Path]) -> list[list[_Path]]:
    """Put tracks of like length together."""
    batches: list[list[_Path]] = []
    for path in sorted(paths, key=lambda path: (-path.time.size, path.track)):
        if not batches or (len(batches[-1]) + 1) * batches[-1][0].time.size > MOST_CELLS:
            batches.append([])
        batches[-1].append(path)
    return batches


def _sigma(reports: ReportTable, settings: Settings) -> FloatArray:
    """Return each report's own noise, or its sensor's."""
    by_name = {sensor.name: sensor.sigmas(reports.dim) for sensor in settings.sensors}
    usual = np.stack([by_name[name] for name in reports.sensors])[reports.sensor]
    return np.where(np.isnan(reports.sigma), usual, reports.sigma)


def _smooth(
    batch: list[_Path], reports: ReportTable, sigma: FloatArray, settings: Settings
) -> TrackTable:
    """Smooth the tracks of a batch, all at once."""
    dim = reports.dim
    shape = len(batch), max(path.time.size for path in batch)
    time, report = np.zeros(shape), np.full(shape, -1, dtype=np.int64)
    for row, path in enumerate(batch):
        size = path.time.size
        time[row, :size], time[row, size:] = path.time, path.time[-1]
        report[row, :size] = path.report
    position, noise = np.full((*shape, dim), np.nan), np.ones((*shape, dim))
    position[report >= 0] = reports.measurement[report[report >= 0]]
    noise[report >= 0] = sigma[report[report >= 0]]
    for row, path in enumerate(batch):
        if path.start_mean is None:
            # The first report makes the first state; it is not taken twice.
            position[row, 0] = np.nan
    start = _start(batch, reports, sigma, settings)
    mean, covariance = smooth(time, position, noise, start, settings.motion.process_noise)
    return _table(batch, time, report, mean, covariance)


def _start(
    batch: list[_Path], reports: ReportTable, sigma: FloatArray, settings: Settings
) -> tuple[FloatArray, FloatArray]:
    """Return each track's first state: its prior, or its first report with unknown velocity."""
    dim = reports.dim
    mean, cov = np.zeros((len(batch), 2 * dim)), np.zeros((len(batch), 2 * dim, 2 * dim))
    spread = settings.motion.velocity_variance(dim)
    for row, path in enumerate(batch):
        if path.start_mean is not None and path.start_covariance is not None:
            mean[row], cov[row] = path.start_mean, path.start_covariance
        else:
            first = path.report[0]
            mean[row, :dim] = reports.measurement[first]
            cov[row] = np.diag(np.r_[sigma[first] ** 2, np.full(dim, spread)])
    return mean, cov


def _table(
    batch: list[_Path], time: FloatArray, report: IntArray, mean: FloatArray, cov: FloatArray
) -> TrackTable:
    """Return one row per track and time, the last of those with the same time."""
    parts = []
    for row, path in enumerate(batch):
        size = path.time.size
        own, taken = time[row, :size], report[row, :size] >= 0
        last = np.r_[np.diff(own) > 0, True]
        # A prior lies before the track's first report and is nobody's finding.
        last &= own >= own[taken][0]
        hits = np.cumsum(taken)
        update = np.maximum.accumulate(np.where(taken, own, -np.inf))
        kept = np.flatnonzero(last)
        parts.append(
            TrackTable(
                time=own[kept],
                track=np.full(kept.size, path.track, dtype=np.int64),
                status=np.where(update[kept] == own[kept], CONFIRMED, COASTING).astype(np.int64),
                mean=mean[row, kept],
                covariance=cov[row, kept],
                score=np.full(kept.size, np.nan),
                hits=hits[kept].astype(np.int64),
                last_update=update[kept],
            )
        )
    return TrackTable.concatenate(parts, mean.shape[2] // 2)


def _with_status(table: TrackTable, tracks: TrackTable) -> TrackTable:
    """Enter what is known of each track in the end: whether it was believed, and its score."""
    confirmed = np.unique(tracks.track[tracks.status >= CONFIRMED])
    order = np.lexsort((tracks.time, tracks.track))
    names, first = np.unique(tracks.track[order], return_index=True)
    last = order[np.r_[first[1:], order.size] - 1] if order.size else order
    place = np.clip(np.searchsorted(names, table.track), 0, max(names.size - 1, 0))
    score = table.score.copy()
    if names.size:
        known = names[place] == table.track
        score[known] = tracks.score[last[place[known]]]
    status = np.where(np.isin(table.track, confirmed), table.status, TENTATIVE)
    return TrackTable(
        table.time, table.track, status.astype(np.int64), table.mean, table.covariance,
        score, table.hits, table.last_update,
    )  # fmt: skip


def _rows(table: TrackTable, rows: IntArray) -> TrackTable:
    return TrackTable(*(getattr(table, name)[rows] for name in TrackTable.__dataclass_fields__))
