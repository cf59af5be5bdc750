"""What sensors measure, as textbooks write it: complex numbers, differences, sigma points."""

import numpy as np

from trackweave.domain.measurements import MeasurementKind as Kind


def expected(kind, state, platform, dim):
    """Return what a sensor without noise measures."""
    place = np.zeros(3)
    place[:dim] = (state[:dim] - platform[:dim])[:dim]
    speed = np.zeros(3)
    speed[:dim] = state[dim : 2 * dim] - platform[3 : 3 + dim]
    if kind is Kind.POSITION:
        return state[:dim].copy()
    distance = np.linalg.norm(place)
    azimuth = np.angle(place[1] + 1j * place[0]) % (2 * np.pi)
    parts = {
        "range": distance,
        "azimuth": azimuth,
        "elevation": np.arcsin(place[2] / distance),
        "rate": place @ speed / distance,
    }
    names = {
        Kind.RANGE_AZIMUTH: ["range", "azimuth"],
        Kind.RANGE_AZIMUTH_RATE: ["range", "azimuth", "rate"],
        Kind.RANGE_AZIMUTH_ELEVATION: ["range", "azimuth", "elevation"],
        Kind.RANGE_AZIMUTH_ELEVATION_RATE: ["range", "azimuth", "elevation", "rate"],
        Kind.BEARING: ["azimuth"],
        Kind.RANGE_RATE: ["rate"],
    }
    return np.array([parts[name] for name in names[kind]])


def difference(kind, one, other):
    """Return one measurement minus another, azimuths the short way round."""
    apart = one - other
    if kind not in (Kind.POSITION, Kind.RANGE_RATE):
        column = 0 if kind is Kind.BEARING else 1
        apart[column] = np.angle(np.exp(1j * apart[column]))
    return apart


def by_slopes(kind, mean, covariance, platform, dim, step=1e-3):
    """Return a measurement's moments by derivatives taken as differences."""
    columns = []
    for index in range(mean.size):
        shift = np.eye(mean.size)[index] * step
        up = expected(kind, mean + shift, platform, dim)
        down = expected(kind, mean - shift, platform, dim)
        columns.append(difference(kind, up, down) / (2 * step))
    slope = np.array(columns).T
    return (
        expected(kind, mean, platform, dim),
        slope @ covariance @ slope.T,
        covariance @ slope.T,
    )


def by_points(kind, mean, covariance, platform, dim):
    """Return a measurement's moments over sigma points of what it depends on."""
    if kind is Kind.BEARING:
        reach = 2
    else:
        reach = 2 * dim if kind.has_rate or kind is Kind.RANGE_RATE else dim
    kappa = max(3 - reach, 0)
    root = np.linalg.cholesky(covariance[:reach, :reach])
    along = covariance[:, :reach] @ np.linalg.inv(root).T * np.sqrt(reach + kappa)
    points = np.concatenate([mean[None], mean + along.T, mean - along.T])
    weight = np.r_[kappa, np.full(2 * reach, 0.5)] / (reach + kappa)
    centre = expected(kind, mean, platform, dim)
    apart = np.array(
        [difference(kind, expected(kind, point, platform, dim), centre) for point in points]
    )
    middle = weight @ apart
    apart -= middle
    return (
        centre + middle,
        (weight * apart.T) @ apart,
        (weight * (points - mean).T) @ apart,
    )
