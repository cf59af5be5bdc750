"""One object's states over all of its reports: forward in time, and back. Nothing here checks.

With one mode of motion this is Rauch, Tung and Striebel's smoother. With several it is the
interacting multiple model forward; backward each mode's step is smoothed from the mixture that it
started from, what that adds is laid on each part of the mixture, and the pairs of a mode and the
one after it are merged as Kim (1994) does, with the evidence of each (Barber 2006).
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave._loops import overwrite, overwrite_rows
from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.measurements import MeasurementKind
from trackweave.filters._kernels import correct, update
from trackweave.filters._measuring import innovation, invert, invert_many, measure
from trackweave.filters._relinearising import relinearise
from trackweave.filters._states import advance, changes, combine, linearise, mix
from trackweave.filters._straight import let_back
from trackweave.filters._tails import mix_with, share_after, share_of_wide
from trackweave.jit import jit
from trackweave.models.motion import MotionRule

_POSITION = int(MeasurementKind.POSITION)


class Readings(NamedTuple):
    """An object's moments, ascending in ``time`` [s], and its report at each.

    ``kind`` is what the report holds, -1 for none, and ``width`` how many numbers that are, of
    ``measurement`` with standard deviations ``sigma``, shape (moments, ≥ width). ``platform``
    holds the sensor's x, y, z [m] and their rates [m/s], shape (moments, 6). ``tail`` is how
    probable it is that the noise is wider, how many times, and how far that persists from report
    to report, shape (moments, 3).
    """

    time: FloatArray
    kind: IntArray
    width: IntArray
    measurement: FloatArray
    sigma: FloatArray
    platform: FloatArray
    tail: FloatArray


class Course(NamedTuple):
    """States by moment and mode: (moments, modes, n), (…, n, n), and probabilities."""

    mean: FloatArray
    covariance: FloatArray
    weight: FloatArray


@jit
def receive(
    readings: Readings,
    moment: int,
    motion: MotionRule,
    mean: FloatArray,
    covariance: FloatArray,
    weight: FloatArray,
    wild: float,
) -> float:
    """Take a moment's report into the state in place; one that fits no mode changes nothing.

    ``wild`` is how probably the noise of the last report before it was wide, -1 for nothing known;
    returned is that after this one.
    """
    share, scale, persistence = readings.tail[moment]
    if share == 0.0:
        _take(readings, moment, 1.0, motion, mean, covariance, weight)
        return wild
    share = share_after(wild, share, persistence)
    far_mean, far, far_weight = mean.copy(), covariance.copy(), weight.copy()
    narrow = _take(readings, moment, 1.0, motion, mean, covariance, weight)
    wide = _take(readings, moment, scale, motion, far_mean, far, far_weight)
    part = share_of_wide(narrow, wide, share)
    for mode in range(weight.shape[0]):
        total = (1.0 - part) * weight[mode] + part * far_weight[mode]
        own = part * far_weight[mode] / total if total > 0.0 else part
        weight[mode] = total
        mix_with(far_mean[mode], far[mode], own, mean[mode], covariance[mode])
    return part if persistence > 0.0 else wild


@jit
def _take(
    readings: Readings,
    moment: int,
    scale: float,
    motion: MotionRule,
    mean: FloatArray,
    covariance: FloatArray,
    weight: FloatArray,
) -> float:
    """Do so with noise so many times as wide as told; return the log likelihood."""
    modes, size = mean.shape
    kind, width = readings.kind[moment], readings.width[moment]
    foreseen, apart = np.empty(width), np.empty(width)
    spread, inverse = np.empty((width, width)), np.empty((width, width))
    cross = np.empty((size, width))
    fit = np.empty(modes)
    best = -math.inf
    for mode in range(modes):
        measure(
            kind, mean[mode], covariance[mode], readings.platform[moment], motion.dim,
            motion.unscented, foreseen, spread, cross,
        )  # fmt: skip
        for row in range(width):
            spread[row, row] += (scale * readings.sigma[moment, row]) ** 2
        log_determinant = invert(spread, inverse)
        fit[mode] = -math.inf
        if not log_determinant < math.inf:
            continue
        innovation(kind, readings.measurement[moment, :width], foreseen, apart)
        distance = 0.0
        for row in range(width):
            for column in range(width):
                distance += apart[row] * inverse[row, column] * apart[column]
        if weight[mode] > 0.0:
            fit[mode] = math.log(weight[mode]) - 0.5 * (distance + log_determinant)
            best = max(best, fit[mode])
        if kind == _POSITION:
            for row in range(width):
                for column in range(width):
                    spread[row, column] = 0.0
                spread[row, row] = (scale * readings.sigma[moment, row]) ** 2
            update(
                mean[mode].copy(), covariance[mode].copy(), readings.measurement[moment, :width],
                spread, mean[mode], covariance[mode],
            )  # fmt: skip
        else:
            before, wide = mean[mode].copy(), covariance[mode].copy()
            correct(before, wide, apart, spread, cross, mean[mode], covariance[mode])
            if not motion.unscented:
                for row in range(width):
                    for column in range(width):
                        spread[row, column] = 0.0
                    spread[row, row] = (scale * readings.sigma[moment, row]) ** 2
                relinearise(
                    kind, readings.measurement[moment, :width], spread, readings.platform[moment],
                    motion.dim, before, wide, mean[mode], covariance[mode],
                )  # fmt: skip
    if best == -math.inf:
        return best
    total = 0.0
    for mode in range(modes):
        weight[mode] = math.exp(fit[mode] - best)
        total += weight[mode]
    for mode in range(modes):
        weight[mode] /= total
    return float(best + math.log(total) - 0.5 * width * math.log(2.0 * math.pi))


@jit
def go_forward(readings: Readings, start: Course, motion: MotionRule, out: Course) -> None:
    """Write the state after each moment's report; ``start`` is that before the first's."""
    wild = -1.0
    for moment in range(readings.time.shape[0]):
        if moment == 0:
            out.mean[0], out.covariance[0] = start.mean[0], start.covariance[0]
            out.weight[0] = start.weight[0]
        else:
            advance(
                out.mean[moment - 1], out.covariance[moment - 1], out.weight[moment - 1],
                readings.time[moment] - readings.time[moment - 1], motion,
                out.mean[moment], out.covariance[moment], out.weight[moment],
            )  # fmt: skip
        if readings.kind[moment] >= 0:
            wild = receive(
                readings, moment, motion,
                out.mean[moment], out.covariance[moment], out.weight[moment], wild,
            )  # fmt: skip


@jit
def go_back(time: FloatArray, motion: MotionRule, course: Course) -> None:
    """Turn the states after each moment's report into those given all reports, in place."""
    n_moments, modes, size = course.mean.shape
    # What each mode started from, and that given all reports.
    mixed = _room(2, modes, size)
    # Pairs: the mode up to a moment and the one after it.
    pairs = _room(modes, modes, size)
    coming = np.empty((modes, modes))
    for moment in range(n_moments - 2, -1, -1):
        interval = time[moment + 1] - time[moment]
        if interval == 0.0:
            course.mean[moment] = course.mean[moment + 1]
            course.covariance[moment] = course.covariance[moment + 1]
            course.weight[moment] = course.weight[moment + 1]
            continue
        if modes == 1:
            mixed.mean[0, 0] = course.mean[moment, 0]
            mixed.covariance[0, 0] = course.covariance[moment, 0]
            _step_back(moment, 0, interval, motion, course, mixed)
            course.mean[moment, 0] = mixed.mean[1, 0]
            course.covariance[moment, 0] = mixed.covariance[1, 0]
            continue
        mix(
            course.mean[moment], course.covariance[moment], course.weight[moment], interval,
            motion.basis, motion.decay, mixed.mean[0], mixed.covariance[0], mixed.weight[0],
        )  # fmt: skip
        changes(course.weight[moment], interval, motion.basis, motion.decay, coming)
        for after in range(modes):
            _step_back(moment, after, interval, motion, course, mixed)
            _part(moment, after, coming[after], course, mixed, pairs)
        _gather(moment, course, pairs)


@jit
def _room(rows: int, modes: int, size: int) -> Course:
    """Return room for states."""
    return Course(
        np.empty((rows, modes, size)), np.empty((rows, modes, size, size)), np.empty((rows, modes))
    )


@jit
def _step_back(
    moment: int, mode: int, interval: float, motion: MotionRule, course: Course, mixed: Course
) -> None:
    """Write to row 1 of ``mixed`` what row 0 becomes given the mode's next state."""
    size = course.mean.shape[2]
    own_mean, own = mixed.mean[0, mode], mixed.covariance[0, mode]
    mean_out, covariance_out = mixed.mean[1, mode], mixed.covariance[1, mode]
    ahead, moving = np.empty(size), np.empty((size, size))
    spread, cross = np.empty((size, size)), np.empty((size, size))
    linearise(mode, own_mean, own, interval, motion, ahead, moving, spread)
    _multiply(own, moving, cross)
    for row in range(size):
        for column in range(row, size):
            for inner in range(size):
                spread[row, column] += moving[row, inner] * cross[inner, column]
            spread[column, row] = spread[row, column]
    overwrite(mean_out, own_mean)
    overwrite_rows(covariance_out, own)
    let_back(
        cross, ahead, spread, course.mean[moment + 1, mode], course.covariance[moment + 1, mode],
        mean_out, covariance_out,
    )  # fmt: skip


@jit
def _part(
    moment: int, after: int, coming: FloatArray, course: Course, mixed: Course, pairs: Course
) -> None:
    """Write the states and weights of all modes before one mode, given all reports.

    What later reports say through the mode after is the ratio of two normal densities, of row 1
    of ``mixed`` and row 0, which are the same mixture after and before; it is laid on each part
    of the mixture by itself.
    """
    modes, size = course.mean.shape[1:]
    late, early = np.empty((size, size)), np.empty((size, size))
    own, sharp = np.empty((size, size)), np.empty((size, size))
    push = np.empty(size)
    late_log = invert_many(mixed.covariance[1, after], late)
    early_log = invert_many(mixed.covariance[0, after], early)
    proper = late_log < math.inf and early_log < math.inf
    best = -math.inf
    for before in range(modes):
        mean, covariance = course.mean[moment, before], course.covariance[moment, before]
        pairs.mean[before, after] = mixed.mean[1, after]
        pairs.covariance[before, after] = mixed.covariance[1, after]
        pairs.weight[before, after] = (
            math.log(coming[before]) if coming[before] > 0.0 else -math.inf
        )
        narrow = invert_many(covariance, own)
        if proper and narrow < math.inf:
            for row in range(size):
                for column in range(size):
                    sharp[row, column] = own[row, column] + late[row, column] - early[row, column]
            wide = invert_many(sharp, own)
            # What several modes may become can be wider than what one of them was: then the ratio
            # is no density, and the mixture as a whole stands for its part.
            trusted = wide < math.inf
            for row in range(size):
                widest = max(covariance[row, row], mixed.covariance[1, after, row, row])
                trusted = trusted and own[row, row] <= widest * (1.0 + 1e-9)
            if trusted:
                fit = 0.5 * (early_log - late_log - narrow - wide)
                for row in range(size):
                    push[row] = 0.0
                    for column in range(size):
                        far = mixed.mean[1, after, column] - mean[column]
                        near = mixed.mean[0, after, column] - mean[column]
                        push[row] += late[row, column] * far - early[row, column] * near
                        fit -= (
                            0.5 * late[row, column] * far * (mixed.mean[1, after, row] - mean[row])
                        )
                        fit += (
                            0.5
                            * early[row, column]
                            * near
                            * (mixed.mean[0, after, row] - mean[row])
                        )
                for row in range(size):
                    shift = 0.0
                    for column in range(size):
                        shift += own[row, column] * push[column]
                    fit += 0.5 * shift * push[row]
                    pairs.mean[before, after, row] = mean[row] + shift
                overwrite_rows(pairs.covariance[before, after], own)
                pairs.weight[before, after] += fit
        best = max(best, pairs.weight[before, after])
    total = 0.0
    for before in range(modes):
        pairs.weight[before, after] = math.exp(pairs.weight[before, after] - best)
        total += pairs.weight[before, after]
    for before in range(modes):
        pairs.weight[before, after] *= course.weight[moment + 1, after] / total


@jit
def _gather(moment: int, course: Course, pairs: Course) -> None:
    """Merge the pairs of each mode with all that may come after it."""
    modes = course.mean.shape[1]
    for before in range(modes):
        total = 0.0
        for after in range(modes):
            total += pairs.weight[before, after]
        course.weight[moment, before] = total
        if total > 0.0:
            for after in range(modes):
                pairs.weight[before, after] /= total
            combine(
                pairs.mean[before], pairs.covariance[before], pairs.weight[before],
                course.mean[moment, before], course.covariance[moment, before],
            )  # fmt: skip


@jit
def merge(course: Course, mean_out: FloatArray, covariance_out: FloatArray) -> None:
    """Write the mean and covariance of each moment over all modes."""
    for moment in range(course.mean.shape[0]):
        combine(
            course.mean[moment], course.covariance[moment], course.weight[moment],
            mean_out[moment], covariance_out[moment],
        )  # fmt: skip


@jit
def _multiply(left: FloatArray, right: FloatArray, out: FloatArray) -> None:
    """Write left times the transpose of right."""
    size = left.shape[0]
    for row in range(size):
        for column in range(size):
            total = 0.0
            for inner in range(size):
                total += left[row, inner] * right[column, inner]
            out[row, column] = total
