"""What the reports of a scan say, and those of a kind from outside of new objects."""

from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association._nodes import ForeignReports
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.scans import Scan
from trackweave.models.foreign_motion import AnyMotion

__all__ = ["Said", "blur_of_foreign", "said_by_foreign"]

FAR = 1e4
"""Ahead of a sensor, a place at which its reports may be [m]."""


class Said(NamedTuple):
    """What reports say: where objects are and how surely, their noise, and of new objects."""

    is_located: bool
    place: FloatArray
    spread: FloatArray
    covariance: FloatArray
    log_begin: FloatArray
    foreign: ForeignReports | None = None


def said_by_foreign(
    kind: ForeignKind,
    scan: Scan,
    told: tuple[FloatArray, FloatArray, FloatArray],
    within: tuple[AnyMotion, int],
) -> Said:
    """Return what reports of a kind from outside say."""
    # ``told`` are numbers, noise and platforms, ``within`` is how objects move and the number of
    # dimensions.
    (measurement, sigma, platform), (motion, dim) = told, within
    count = measurement.shape[0]
    reported = kind.reported(measurement, sigma, scan.context, scan.covariance)
    foreign, is_located = ForeignReports(kind, reported), kind.gives_position(dim)
    if is_located:
        place, spread = kind.first_state(platform, reported, dim)
        log_begin = _log_begin(foreign, (place, spread), platform, motion)
    else:
        place, spread = platform[:, :dim].copy(), np.zeros((count, dim, dim))
        log_begin = np.zeros(count)
    return Said(is_located, place, spread, reported.covariance, log_begin, foreign)


def blur_of_foreign(
    kind: ForeignKind, noise: FloatArray, platform: FloatArray, dim: int
) -> FloatArray:
    """Return how far reports lie beside their objects, as `Coverage` has it; 0 if unknown."""
    # ``noise`` is the covariance of a report's numbers. What it comes to on the plane is told by
    # two places ahead, one twice as far: what is across grows with the distance, or not. Nobody
    # knows what a report would say beside its numbers.
    if kind.context or not kind.gives_position(dim):
        return np.zeros(3)
    mean = np.zeros((2, 2 * dim))
    mean[:, :2] = platform[:2] + FAR * np.array([[1.0, 0.0], [2.0, 0.0]])
    sigma, both = np.tile(np.sqrt(np.diagonal(noise)), (2, 1)), np.tile(noise, (2, 1, 1))
    reported = kind.reported(np.zeros_like(sigma), sigma, np.empty((2, 0)), both)
    _, slope = kind.expect(mean, np.tile(platform, (2, 1)), reported)
    told = slope[:, :, :2].swapaxes(1, 2) @ np.linalg.inv(noise) @ slope[:, :, :2]
    if not np.isfinite(told).all() or np.linalg.det(told).min() <= 0.0:
        return np.zeros(3)
    spread = np.linalg.inv(told)
    near, far = spread[:, 1, 1]
    angle = max((far - near) / (3.0 * FAR**2), 0.0)
    return np.sqrt([angle, spread[0, 0, 0], max(near - angle * FAR**2, 0.0)])


def _log_begin(
    foreign: ForeignReports,
    begun: tuple[FloatArray, FloatArray],
    platform: FloatArray,
    motion: AnyMotion,
) -> FloatArray:
    """Return what each report adds to a new object's log evidence beyond the density [nats]."""
    # ``begun`` are positions and covariances as of ``first_state``.
    # The integral of the report's likelihood over the places that it may be of, by Laplace:
    # sqrt(|2πC| / |2πR|) exp(-½ of what the best place leaves unexplained). For as many numbers as
    # dimensions that is |∂x/∂z|, and nothing is left.
    place, spread = begun
    (count, dim), reported = place.shape, foreign.reported
    width = reported.values.shape[1]
    if not count:
        return np.zeros(count)
    mean = np.concatenate([place, np.zeros((count, dim))], axis=1)
    value, slope = foreign.kind.expect(mean, platform, reported)
    # The velocity, of which nothing is known, blurs what is told of it.
    speed = slope[:, :, dim:]
    noise = reported.covariance + motion.velocity_variance(dim) * speed @ speed.swapaxes(1, 2)
    volume = 0.5 * (np.linalg.slogdet(spread)[1] - np.linalg.slogdet(noise)[1])
    volume += 0.5 * (dim - width) * np.log(2.0 * np.pi)
    if width > dim:
        off = foreign.kind.difference(reported.values, value)
        whitened = np.linalg.solve(noise, off[:, :, None])[:, :, 0]
        volume -= 0.5 * np.einsum("ri,ri->r", off, whitened)
    return np.asarray(volume)
