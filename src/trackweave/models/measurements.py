"""Where reports put their objects."""

import numpy as np

from trackweave.arrays import ROUNDING, FloatArray
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.measurements import MeasurementKind

__all__ = ["NO_PLATFORM", "to_position", "with_rounding"]

NO_PLATFORM = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""A sensor that stands at the origin: x, y, z [m] and their rates [m/s]."""


def to_position(  # noqa: PLR0913 a report is all of these
    kind: MeasurementKind | ForeignKind,
    measurement: FloatArray,
    sigma: FloatArray,
    platform: FloatArray,
    dim: int,
    context: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return positions [m], shape (reports, dim), and covariances of where reports put objects."""
    # Ranges and angles are unbiased to second order in the angles' noise: the mean of a position
    # on an arc lies inside it [1]. Measurements and sigma have the shape (reports, components),
    # ``platform`` is where the sensor was, x, y, z [m] first. What comes is NaN where a report of
    # this kind does not tell. ``context`` is what a kind from outside the package asks for.
    # [1] D. Lerro, Y. Bar-Shalom, Tracking with debiased consistent converted measurements versus
    #     EKF, 1993, eqs. 13-16. doi:10.1109/7.220948
    count = measurement.shape[0]
    if not kind.gives_position(dim):
        return np.full((count, dim), np.nan), np.full((count, dim, dim), np.nan)
    if isinstance(kind, ForeignKind):
        width = kind.n_components(dim)
        reported = kind.reported(measurement[:, :width], sigma[:, :width], context)
        return kind.first_state(platform, reported, dim)
    if kind.is_position:
        covariance = sigma[:, :dim, None] ** 2 * np.eye(dim)
        return measurement[:, :dim].copy(), covariance
    distance, azimuth = measurement[:, 0], measurement[:, 1]
    if dim == 2:
        elevation, elevation_sigma = np.zeros(count), np.zeros(count)
    else:
        elevation, elevation_sigma = measurement[:, 2], sigma[:, 2]
    east, north = np.sin(azimuth), np.cos(azimuth)
    level, up = np.cos(elevation), np.sin(elevation)
    # The mean of a direction that wanders by s is shorter by exp(-s²/2); height knows no azimuth.
    bent, tilted = np.exp(sigma[:, 1] ** 2 / 2), np.exp(elevation_sigma**2 / 2)
    length = (distance * tilted)[:, None] * np.stack([bent, bent, np.ones(count)], axis=-1)
    along = np.stack([level * east, level * north, up], axis=-1)
    across = np.stack([level * north, -level * east, np.zeros(count)], axis=-1)
    over = np.stack([-up * east, -up * north, level], axis=-1)
    spread = (
        sigma[:, 0, None, None] ** 2 * _outer(along)
        + (distance * sigma[:, 1])[:, None, None] ** 2 * _outer(across)
        + (distance * elevation_sigma)[:, None, None] ** 2 * _outer(over)
    )
    position = platform[:, :3] + length * along
    return position[:, :dim].copy(), with_rounding(spread[:, :dim, :dim])


def with_rounding(covariance: FloatArray) -> FloatArray:
    """Return covariances, shape (rows, dim, dim), of turned positions, wider by lost rounding."""
    # A range a million times as precise as what an angle tells across it is else less than the
    # last digits, and the turned covariance not positive definite.
    trace = np.trace(covariance, axis1=1, axis2=2)
    lost = ROUNDING * trace[:, None, None] * np.eye(covariance.shape[1])
    return np.ascontiguousarray(covariance + lost)


def _outer(vector: FloatArray) -> FloatArray:
    product: FloatArray = vector[:, :, None] * vector[:, None, :]
    return product
