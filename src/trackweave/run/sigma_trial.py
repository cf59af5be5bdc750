"""Whether a noise that was told breaks tracks that would hold under what reports tell of it.

Under a noise that is far too small tracks are short and few, and what they hold lies as near as
they let it: their own scatter says nothing. What reports tell without it stands trial against it.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from trackweave.arrays import IntArray
from trackweave.config import Configuration
from trackweave.config.fill import Settings, known_sigma
from trackweave.config.sensing import UNKNOWN_SENSOR
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimate import estimate
from trackweave.run.noise_check import scaled
from trackweave.run.stretches import Stretch

__all__ = ["broken_by_sigma"]

# Few reports are in tracks, or most are in such that last for a small share of a sensor's looks.
FEW, SHORT = 0.5, 0.35
# The noise is so many times another, and tracks are so much likelier under that.
OTHER, LIKELIER, MOST_REPORTS = 2.5, 0.1, 1500


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
    factors = {
        name: seen[name].plane_sigma / sigma for name, sigma in told.items() if name in seen
    }
    factors = {name: f for name, f in factors.items() if f >= OTHER}
    if not factors:
        return {}
    skip = max(0, (len(reports) - MOST_REPORTS) // 2)
    part = reports.part(np.arange(skip, min(len(reports), skip + MOST_REPORTS)))
    costs = [
        _cost(part, configuration.changed(sensors=_with(configuration, each)))
        for each in ({}, factors)
    ]
    return factors if costs[1] < costs[0] - LIKELIER * abs(costs[0]) else {}


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
    looks = np.unique(np.stack([reports.time, reports.sensor]), axis=1).shape[1]
    return bool(np.median(hits[of]) < SHORT * looks)


def _with(configuration: Configuration, factors: Mapping[str, float]) -> dict[str, Any]:
    """Return the table of sensors with so many times the noise that is told of some."""
    sensors = configuration.table("sensors")
    for name, factor in factors.items():
        sigma = scaled(configuration.sensor(name)["sigma"], {"": factor})
        sensors[name] = {**sensors.get(name, {}), "sigma": sigma}
    return sensors


def _cost(reports: ReportTable, configuration: Configuration) -> float:
    """Return what tracks cost under a configuration and what reports tell beside it [nats]."""
    stretch = Stretch(reports, configuration, dict.fromkeys(reports.sensors, UNKNOWN_SENSOR))
    return stretch.tracked(estimate(reports, known_sigma(configuration, reports.sensors))).cost
