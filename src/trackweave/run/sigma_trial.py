"""Whether a noise that was told too small breaks tracks that hold under what reports tell of it.

Under a noise that is far too small tracks are short and few, and what they hold lies as near as
they let it: their own scatter says nothing. What reports tell without it stands trial against it.
"""

import numpy as np

from trackweave.arrays import IntArray
from trackweave.config import Configuration
from trackweave.config.fill import Settings, known_sigma
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimate import estimate
from trackweave.run.noise_check import with_scaled
from trackweave.run.stretches import Stretch, middle_part

__all__ = ["broken_by_sigma"]

# Few reports are in tracks, or most are in such that last for a small share of a sensor's looks.
FEW, SHORT = 0.5, 0.35
# What reports tell is so many times as large, and tracks are so much likelier under it.
TIMES, LIKELIER, MOST_REPORTS = 2.5, 0.1, 1500


def broken_by_sigma(
    reports: ReportTable, configuration: Configuration, settings: Settings, track: IntArray
) -> dict[str, float]:
    """Return how many times the noise told of sensors is clearly likelier, by name.

    Parameters
    ----------
    reports
        All of a run.
    configuration
        As told.
    settings
        What the run used.
    track
        The track of each report, -1 for none.

    Returns
    -------
    Nothing where tracks are whole, and where those under another noise are no likelier.
    """
    told = _told(reports, configuration, settings)
    if not told or not _are_broken(reports, track):
        return {}
    looks = {
        name: True for name in reports.sensors if configuration.sensor(name).get("scan_period")
    }
    seen = estimate(reports, {}, looks).sensors
    times = {name: seen[name].plane_sigma / sigma for name, sigma in told.items() if name in seen}
    factors = {name: each for name, each in times.items() if each >= TIMES}
    if not factors:
        return {}
    part = middle_part(reports, MOST_REPORTS)
    as_told = _cost(part, configuration)
    otherwise = _cost(part, with_scaled(configuration, factors))
    return factors if otherwise < as_told - LIKELIER * abs(as_told) else {}


def _told(
    reports: ReportTable, configuration: Configuration, settings: Settings
) -> dict[str, float]:
    """Return the one number that is told of each sensor's noise of positions [m]."""
    if any(sensor.scans is False for sensor in settings.sensors):
        # Whose reports come one by one is asked otherwise.
        return {}
    if reports.kinds or reports.dim != 2 or np.isfinite(reports.sigma).any():
        return {}
    trusted = {sensor.name for sensor in settings.sensors if sensor.trusts("sigma")}
    told = {name: configuration.sensor(name).get("sigma") for name in reports.sensors}
    return {
        name: float(sigma)
        for name, sigma in told.items()
        if isinstance(sigma, float | int)
        and name not in trusted
        and f"sensors.{name}.sigma" not in settings.confirmed
    }


def _are_broken(reports: ReportTable, track: IntArray) -> bool:
    """Tell whether most reports are in no track, or in one that does not last."""
    found = np.flatnonzero(track >= 0)
    if found.size < FEW * len(reports):
        return True
    _, of, hits = np.unique(track[found], return_inverse=True, return_counts=True)
    looks = np.unique(np.stack([reports.look, reports.sensor]), axis=1).shape[1]
    return bool(np.median(hits[of]) < SHORT * looks)


def _cost(reports: ReportTable, configuration: Configuration) -> float:
    """Return what tracks cost under a configuration and what reports tell beside it [nats]."""
    stretch = Stretch.of_positions(reports, configuration)
    return stretch.tracked(estimate(reports, known_sigma(configuration, reports.sensors))).cost
