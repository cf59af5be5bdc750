"""How far reports lie beside a straight way between their track's reports before and after."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.models.motion import ConstantVelocity, Imm, RandomWalk
from trackweave.run.diagnostics.case import Case

__all__ = ["Scatter", "is_noise", "scatter_of", "without_motion"]

MOST_PATHS, MOST_REPORTS = 120, 120
# Scatter of which less is left is mostly motion, and says little of noise.
MOSTLY_NOISE = 0.3
# Two thirds of a normal distribution's median square to its variance; and its 95 % quantile.
OF_MEDIAN, OF_TAIL = 0.45494, 3.8415


@dataclass(frozen=True, slots=True, eq=False)
class Scatter:
    """Squares of what is beside the way, as the noise of one report, by component."""

    # Metres for positions and ranges, radians for azimuths; shape (triples, components).
    square: FloatArray
    drift: FloatArray  # What a process noise of one adds to a square [s³], shape (triples,)

    def __len__(self) -> int:
        return int(self.drift.size)

    def usual(self) -> FloatArray:
        """Return the variance that most squares speak of, one per component."""
        return np.asarray(np.median(self.square, axis=0) / OF_MEDIAN)

    def tail(self) -> FloatArray:
        """Return the variance that the largest squares speak of, one per component."""
        return np.asarray(np.quantile(self.square, 0.95, axis=0) / OF_TAIL)


def scatter_of(
    case: Case, index: int, stride: int, tracks: Sequence[IntArray] | None = None
) -> Scatter:
    """Return what a sensor's reports, so many apart, are beside the ways of their tracks."""
    # Of three reports of one track and sensor, so many apart, the middle one is compared with the
    # straight way between the others. By white noise of acceleration alone its variance would be q
    # a² b² / 3 (a + b), with a and b the times between them. Squares of positions on the plane are
    # of both axes. ``tracks`` are rows by time, instead of the case's paths. What walks at random
    # keeps no way, so that there are none.
    squares, drifts = [np.empty((0, 2))], [np.empty(0)]
    is_polar = case.reports.kind_of(index).has_range
    if isinstance(case.settings.motion, RandomWalk):
        tracks = []
    elif tracks is None:
        tracks = [path.rows for path in case.paths]
    for each in tracks[:MOST_PATHS]:
        rows = each[case.reports.sensor[each] == index][:MOST_REPORTS]
        if rows.size <= 2 * stride:
            continue
        time, place = case.reports.time[rows], case.place[rows]
        before = time[stride:-stride] - time[: -2 * stride]
        after = time[2 * stride :] - time[stride:-stride]
        both = np.maximum(before + after, 1e-12)
        share = (after / both)[:, None]
        way = share * place[: -2 * stride] + (1 - share) * place[2 * stride :]
        off = place[stride:-stride] - way
        if is_polar:
            off = _polar(off, (place - case.stand[rows])[stride:-stride])
        weight = 1 + (before**2 + after**2) / both**2
        squares.append(off[:, :2] ** 2 / weight[:, None])
        drifts.append(before**2 * after**2 / (3 * both) / weight)
    return Scatter(np.concatenate(squares), np.concatenate(drifts))


def without_motion(short: Scatter, long: Scatter, near: FloatArray, far: FloatArray) -> FloatArray:
    """Return the part of the variance beside short steps that is not motion, in its unit."""
    # What grows with the length of the steps is motion. ``near`` and ``far`` are the usual
    # variance beside short and long steps.
    grown = (np.median(short.drift), np.median(long.drift))
    process = np.maximum(far - near, 0.0) / max(grown[1] - grown[0], 1e-30)
    return np.asarray(near - process * grown[0])


def is_noise(
    case: Case, index: int, scatter: tuple[Scatter, Scatter], own: FloatArray, near: FloatArray
) -> NDArray[np.bool_]:
    """Tell of which components noise is what is left of the scatter over short steps."""
    # ``scatter`` is that over short and long steps, ``own`` what ``without_motion`` left of
    # ``near``, which may be in another unit than the scatter, and as one component for all.
    by_motion = _may_be_motion(case, index, *scatter)[: own.size]
    return np.asarray((own > MOSTLY_NOISE * near) & ~by_motion)


def _may_be_motion(case: Case, index: int, short: Scatter, long: Scatter) -> NDArray[np.bool_]:
    """Tell of which components motion alone may explain what is beside short steps."""
    # Manoeuvres that are over within a step add as much over short steps as over long ones, which
    # looks like noise. They may be all that is seen where the process noise told foresees as
    # much, and what is beside the way grows so much that, had it grown with the length of the
    # steps alone, hardly any of it would be noise.
    near, far = short.usual(), long.usual()
    kind = case.reports.kind_of(index)
    foreseen = np.full(near.shape, _process_noise(case) * np.median(short.drift))
    if kind.has_range:
        away = (case.place - case.stand)[case.rows[index], :2]
        foreseen[1] /= np.median(np.sum(away**2, axis=1))
    else:
        near, far = (np.full(each.shape, each.mean()) for each in (near, far))
    longer = np.cbrt(np.median(long.drift) / max(float(np.median(short.drift)), 1e-30))
    left = near - np.maximum(far - near, 0.0) / max(longer - 1.0, 1e-30)
    return np.asarray((foreseen >= near) & (left <= MOSTLY_NOISE * near))


def _process_noise(case: Case) -> float:
    """Return how much the velocity of what moves changes, as told [m²/s³]; 0 where nobody did."""
    # An estimate is made for what is told of noise, and would explain any scatter.
    if not case.is_told("motion.process_noise"):
        return 0.0
    motion = case.settings.motion
    models = motion.models if isinstance(motion, Imm) else (motion,)
    return max((m.process_noise for m in models if isinstance(m, ConstantVelocity)), default=0.0)


def _polar(off: FloatArray, relative: FloatArray) -> FloatArray:
    """Return offsets along the range [m] and across it [rad]."""
    # A range is a slant one: on the ground, a steep elevation's noise would look like its own.
    unit = relative / np.maximum(np.linalg.norm(relative, axis=1), 1e-9)[:, None]
    along = np.einsum("ij,ij->i", off, unit)
    ground = np.maximum(np.sum(relative[:, :2] ** 2, axis=1), 1e-18)
    across = (off[:, 0] * relative[:, 1] - off[:, 1] * relative[:, 0]) / ground
    return np.stack([along, across], axis=1)
