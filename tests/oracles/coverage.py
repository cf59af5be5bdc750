"""How probable it is that what a scan reports of an object lies where the scan looked."""

import math

import numpy as np
from scipy.stats import norm

from trackweave.domain.measurements import MeasurementKind as Kind

RANGING = range(Kind.RANGE_AZIMUTH.value, Kind.RANGE_AZIMUTH_ELEVATION_RATE.value + 1)


def share(look, mean, covariance):
    """Return how probable it is that what a scan reports of a place lies in its view."""
    if look.sees_everything:
        return 1.0
    view = look.sensor.field_of_view
    assert view.polygon is None
    angle, length, beside = look.blur(len(mean) // 2)
    away = mean[:2] - np.array(view.position)
    distance = np.hypot(*away)
    along = away / distance
    across = np.array([along[1], -along[0]])
    spread = covariance[:2, :2]
    far = norm(distance, math.sqrt(along @ spread @ along + length**2))
    start, end = np.radians(view.azimuth_deg)
    width = 2 * math.pi if end - start >= 2 * math.pi - 1e-9 else (end - start) % (2 * math.pi)
    turn = math.remainder(math.atan2(*away) - start - width / 2, 2 * math.pi)
    side = math.sqrt(across @ spread @ across + (angle * distance) ** 2 + beside**2)
    if side > distance:
        swept = width / (2 * math.pi)
    else:
        # Whole turns on it is seen as well.
        around = [norm(turn + 2 * math.pi * k, side / distance) for k in (-1, 0, 1)]
        swept = sum(bounded(each, -width / 2, width / 2) for each in around)
    if width > 2 * math.pi - 1e-9:
        swept = 1.0
    return bounded(far, view.min_range or -math.inf, view.max_range) * swept


def bounded(normal, low, high):
    """Return how probably a number lies between two; four deviations from an edge it is sure."""
    mean, sigma = normal.mean(), 4 * normal.std()
    if mean < low - sigma or mean > high + sigma:
        return 0.0
    if low + sigma < mean < high - sigma:
        return 1.0
    return normal.cdf(high) - normal.cdf(low)


def blur_of(view, dim):
    """Return how far reports lie beside their objects, as a `Coverage` has it."""
    scan, sensor = view.scan, view.sensor
    own = [view.sigma(row, dim) ** 2 for row in range(len(scan))] or [sensor.sigmas(dim) ** 2]
    if scan.covariance is not None and len(scan):
        own = [np.diag(each) for each in scan.covariance]
    sigma = np.sqrt(np.mean(own, axis=0))
    if sensor.measurement is Kind.POSITION:
        return 0.0, sigma[:2].max(), sigma[:2].max()
    if sensor.measurement.value in RANGING:
        return sigma[1], sigma[0], 0.0
    return sigma[0], 0.0, 0.0
