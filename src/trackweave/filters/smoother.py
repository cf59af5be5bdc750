"""States conditioned on all reports, later ones included."""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.measurements import MeasurementKind
from trackweave.filters._smoothing import Course, Readings, go_back, go_forward, merge
from trackweave.filters._straight import smooth_straight
from trackweave.models.motion import CONSTANT_VELOCITY, MotionRule

__all__ = ["Course", "Readings", "filtered", "gone_back", "merged", "smoothed"]


def filtered(
    readings: Readings, start: tuple[FloatArray, FloatArray], motion: MotionRule
) -> Course:
    """Return an object's states by moment and mode, each conditioned on its reports so far."""
    # ``start`` is mean and covariance at the first moment, before its report, as the motion lays
    # out a state. Each mode of motion starts from them, with its long-run share.
    modes, size, length = motion.kind.shape[0], motion.prior.shape[0], readings.time.shape[0]
    first = Course(
        np.repeat(start[0][None, None], modes, axis=1),
        np.repeat(start[1][None, None], modes, axis=1),
        motion.share[None].copy(),
    )
    course = Course(
        np.empty((length, modes, size)),
        np.empty((length, modes, size, size)),
        np.empty((length, modes)),
    )
    go_forward(readings, first, motion, course)
    return course


def smoothed(
    readings: Readings, start: tuple[FloatArray, FloatArray], motion: MotionRule
) -> Course:
    """Return an object's states by moment and mode, each conditioned on all of its reports."""
    # One mode of motion: the fixed-interval smoother [1], about the filter's states where motion
    # or reports are not linear. Several modes: each pair of a mode and the one after it is
    # smoothed and the pairs are merged [2], weighted by their evidence [3]. ``start`` is as in
    # ``filtered``.
    # [1] H. E. Rauch, F. Tung, C. T. Striebel, Maximum likelihood estimates of linear dynamic
    #     systems, 1965, eqs. 3.28 and 3.30. doi:10.2514/3.3166
    # [2] C.-J. Kim, Dynamic linear models with Markov-switching, 1994.
    #     doi:10.1016/0304-4076(94)90036-1
    # [3] D. Barber, Expectation correction for smoothed inference in switching linear dynamical
    #     systems, 2006, sec. 3.1.
    if _is_straight(readings, motion):
        return _straight(readings, start, motion)
    course = filtered(readings, start, motion)
    go_back(readings.time, motion, course)
    return course


def gone_back(time: FloatArray, motion: MotionRule, course: Course) -> None:
    """Turn states after each moment's report into those given all of them, in place."""
    go_back(time, motion, course)


def _is_straight(readings: Readings, motion: MotionRule) -> bool:
    """Tell whether one constant velocity and whole positions without tails are all there is."""
    is_report = readings.kind >= 0
    return bool(
        motion.kind.tolist() == [CONSTANT_VELOCITY]
        and motion.prior.shape[0] == 2 * motion.dim
        and np.all(readings.kind[is_report] == MeasurementKind.POSITION)
        and np.all(readings.width[is_report] == motion.dim)
        and not np.any(readings.tail[is_report, 0])
        and np.all(np.diff(readings.time) >= 0.0)
    )


def _straight(
    readings: Readings, start: tuple[FloatArray, FloatArray], motion: MotionRule
) -> Course:
    length, size = readings.time.shape[0], motion.prior.shape[0]
    mean, covariance = np.empty((length, size)), np.empty((length, size, size))
    mean[0], covariance[0] = start
    smooth_straight(
        readings.time,
        (readings.kind >= 0).astype(np.int64),
        np.ascontiguousarray(readings.measurement[:, : motion.dim]),
        np.ascontiguousarray(readings.sigma[:, : motion.dim]),
        float(motion.noise[0, 0]),
        mean,
        covariance,
    )
    return Course(mean[:, None], covariance[:, None], np.ones((length, 1)))


def merged(course: Course) -> tuple[FloatArray, FloatArray]:
    """Return mean (moments, n) and covariance of each moment over all modes of motion."""
    length, modes, size = course.mean.shape
    if modes == 1:
        return course.mean[:, 0].copy(), course.covariance[:, 0].copy()
    mean, covariance = np.empty((length, size)), np.empty((length, size, size))
    merge(course, mean, covariance)
    return mean, covariance
