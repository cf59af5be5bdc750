"""What the reports of a scan say, and those of a kind from outside of new objects."""

from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association._nodes import ForeignReports
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.scans import Scan
from trackweave.models.foreign_motion import AnyMotion

__all__ = ["Said", "said_by_foreign"]


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
