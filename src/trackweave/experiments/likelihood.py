"""How well a run foresaw each scan's reports from the scans before: a measure without truth."""

from typing import Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.tracks import TENTATIVE, TrackTable
from trackweave.models.sensors import Sensor
from trackweave.run import RunValues

__all__ = ["log_likelihood"]


def log_likelihood(values: RunValues) -> float | None:
    """Return the mean log-likelihood of reports as predicted from the scans before them.

    Each scan's reports are a Poisson process [1]_ of false alarms, at the density of the run's
    configuration, and of what the confirmed tracks as known after the scan before would show. A
    report counts before any track has taken it, so that it is held out of what it judges.

    Parameters
    ----------
    values
        A run, whose tracks are what was known then.

    Returns
    -------
    Nats per report, the more the better; None where sensors report other than positions, or not
    scan by scan.

    References
    ----------
    .. [1] D. J. Daley, D. Vere-Jones, *An introduction to the theory of point processes*, 2003.
    """
    reports, tracks, sensors = values.reports, values.tracks, values.settings.sensors
    numbers = range(len(reports.sensors))
    are_positions = all(reports.kind_of(number).is_position for number in numbers)
    is_scanned = all(each.rotation is None and each.scans is not False for each in sensors)
    if not are_positions or not is_scanned:
        return None
    known = _confirmed(tracks)
    place = reports.measurement[:, : reports.dim]
    volume = float(np.prod(np.maximum(np.ptp(place, axis=0), 1.0)))
    noise = float(values.settings.values["motion"].get("process_noise") or 0.0)
    moments = np.unique(known.time)
    total = 0.0
    scans, first = np.unique(
        np.column_stack([reports.time, reports.sensor]), axis=0, return_index=True
    )
    for number, (time, _) in enumerate(scans):
        last = first[number + 1] if number + 1 < len(first) else len(reports)
        rows = slice(first[number], last)
        before = np.searchsorted(moments, time) - 1
        now = known.time == moments[before] if before >= 0 else np.zeros(len(known), dtype=bool)
        sensor = sensors[int(reports.sensor[first[number]])]
        own = reports.sigma[rows, : reports.dim]
        sigma = sensor.noise(own, place[rows], reports.dim)
        seen = _foreseen(known, now, float(time), noise)
        total += _scan(place[rows], sigma, seen, sensor, volume)
    return total / len(reports)


def _confirmed(tracks: TrackTable) -> TrackTable:
    return tracks.at(np.flatnonzero(tracks.status != TENTATIVE))


def _foreseen(
    tracks: TrackTable, now: np.ndarray[Any, Any], time: float, noise: float
) -> tuple[FloatArray, FloatArray]:
    """Return where tracks will be, (tracks, dim), and with which covariance."""
    mean, spread = tracks.mean[now], tracks.covariance[now]
    dim = mean.shape[1] // 2
    lapse = (time - tracks.time[now])[:, None]
    move = np.concatenate([np.eye(dim), np.eye(dim)], axis=1)[None].repeat(len(mean), 0)
    move[:, :, dim:] *= lapse[:, :, None]
    pushed = noise * lapse[:, :, None] ** 3 / 3 * np.eye(dim)
    return mean[:, :dim] + lapse * mean[:, dim:], move @ spread @ move.swapaxes(1, 2) + pushed


def _scan(
    place: FloatArray,
    sigma: FloatArray,
    seen: tuple[FloatArray, FloatArray],
    sensor: Sensor,
    volume: float,
) -> float:
    """Return the log-likelihood of one scan's reports."""
    where, spread = seen
    density = np.full(len(place), sensor.clutter_density)
    expected = sensor.clutter_density * volume + sensor.detection_probability * len(where)
    if len(where):
        dim = place.shape[1]
        whole = spread[None] + sigma[:, None, :, None] ** 2 * np.eye(dim)
        apart = place[:, None] - where[None]
        distance = np.einsum("rti,rtij,rtj->rt", apart, np.linalg.inv(whole), apart)
        level = np.linalg.slogdet(2 * np.pi * whole)[1]
        density += sensor.detection_probability * np.exp(-0.5 * (distance + level)).sum(axis=1)
    return float(np.log(density).sum() - expected)
