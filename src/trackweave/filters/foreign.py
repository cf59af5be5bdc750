"""Prediction and update of many states at once, by models from outside the package or by ours."""

from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.foreign_kind import ForeignKind, Reported
from trackweave.filters._rows import advance_rows, correct_rows
from trackweave.models.foreign_motion import ForeignMotion
from trackweave.models.motion import MotionRule

__all__ = ["Foreseen", "States", "advanced", "foreseen", "taken_in"]

LOG_TWO_PI = float(np.log(2.0 * np.pi))


class States(NamedTuple):
    """States by row and mode: (rows, modes, n), (…, n, n), and probabilities (rows, modes)."""

    mean: FloatArray
    covariance: FloatArray
    weight: FloatArray

    def part(self, rows: IntArray) -> "States":
        """Return copies of some rows."""
        return States(*(np.ascontiguousarray(column[rows]) for column in self))


class Foreseen(NamedTuple):
    """What states expect of a report each, by mode, and how far that is off.

    ``innovation`` is the report minus what is expected, (rows, modes, m); ``spread`` its
    covariance and ``cross`` the state's with it; ``distance`` the squared distance and
    ``log_likelihood`` the report's, (rows, modes), infinite where the spread is no covariance.
    """

    innovation: FloatArray
    spread: FloatArray
    cross: FloatArray
    distance: FloatArray
    log_likelihood: FloatArray


def advanced(
    states: States, interval: FloatArray, motion: MotionRule, way: ForeignMotion | None
) -> States:
    """Return states after an interval each [s]; ``way`` is the model where it is from outside."""
    if way is None:
        out = States(*(np.empty_like(column) for column in states))
        advance_rows(*states, interval, motion, *out)
        return out
    moving = np.flatnonzero(interval != 0.0)
    out = States(*(column.copy() for column in states))
    if moving.size:
        mean, covariance, _ = way.predict(
            states.mean[moving, 0], states.covariance[moving, 0], interval[moving]
        )
        out.mean[moving, 0], out.covariance[moving, 0] = mean, covariance
    return out


def foreseen(
    kind: ForeignKind, states: States, platform: FloatArray, reported: Reported
) -> Foreseen:
    """Return what states expect of a report each, of a kind from outside."""
    rows, modes, size = states.mean.shape
    repeated = np.repeat(np.arange(rows), modes)
    if modes > 1:
        platform, reported = platform[repeated], reported.part(repeated)
    value, slope = kind.expect(states.mean.reshape(rows * modes, size), platform, reported)
    width = value.shape[1]
    cross = states.covariance.reshape(-1, size, size) @ slope.swapaxes(1, 2)
    spread = slope @ cross
    spread = (spread + spread.swapaxes(1, 2)) / 2.0 + reported.covariance
    off = kind.difference(reported.values, value)
    distance, log_likelihood = _judged(off, spread)
    return Foreseen(
        off.reshape(rows, modes, width),
        np.ascontiguousarray(spread).reshape(rows, modes, width, width),
        np.ascontiguousarray(cross).reshape(rows, modes, size, width),
        distance.reshape(rows, modes),
        log_likelihood.reshape(rows, modes),
    )


def _judged(off: FloatArray, spread: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return squared distances and log likelihoods of innovations."""
    count, width = off.shape
    if not count:
        return np.empty(0), np.empty(0)
    sign, log_determinant = np.linalg.slogdet(spread)
    proper = (sign > 0.0) & (np.diagonal(spread, axis1=1, axis2=2) > 0.0).all(axis=1)
    solvable = np.where(proper[:, None, None], spread, np.eye(width))
    whitened = np.linalg.solve(solvable, off[:, :, None])[:, :, 0]
    distance = np.where(proper, np.einsum("ri,ri->r", off, whitened), np.inf)
    return distance, -0.5 * (distance + log_determinant + width * LOG_TWO_PI)


def taken_in(states: States, seen: Foreseen) -> States:
    """Return states after the reports that they foresaw; one that fits no mode changes nothing."""
    out = States(*(column.copy() for column in states))
    correct_rows(*out, seen.innovation, seen.spread, seen.cross, seen.log_likelihood.copy())
    return out
