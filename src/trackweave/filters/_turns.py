"""Coordinated turns: clockwise, at a rate that is part of the state. Nothing here checks."""

import math

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.jit import jit
from trackweave.models.motion import MotionRule


@jit
def factors(angle: float) -> tuple[float, float, float, float]:
    """Return what a turn of an angle a makes of a path of unit time, and its derivatives.

    sin(a)/a, (1 − cos(a))/a and their derivatives by a; a series where a is small.
    """
    if abs(angle) < 0.01:
        square = angle * angle
        return (
            1.0 - square / 6.0 * (1.0 - square / 20.0),
            angle / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0)),
            -angle / 3.0 * (1.0 - square / 10.0 * (1.0 - square / 28.0)),
            0.5 - square / 8.0 * (1.0 - square / 18.0),
        )
    sine, cosine = math.sin(angle), math.cos(angle)
    along, aside = sine / angle, (1.0 - cosine) / angle
    return along, aside, (cosine - along) / angle, (sine - aside) / angle


@jit
def signed_noise(mode: int, which: int, interval: float, motion: MotionRule) -> float:
    """Return a mode's process noise, negative over a negative interval.

    The noise of the way back is minus the integral that the way there would have.
    """
    noise = motion.noise[mode, which]
    return float(noise if interval >= 0.0 else -noise)


@jit
def _turned(
    velocity_x: float, velocity_y: float, rate: float, interval: float, out: FloatArray
) -> None:
    """Write by how much a clockwise turn moves an object, and its velocity after it."""
    along, aside, _, _ = factors(rate * interval)
    sine, cosine = math.sin(rate * interval), math.cos(rate * interval)
    out[0] = interval * (along * velocity_x + aside * velocity_y)
    out[1] = interval * (along * velocity_y - aside * velocity_x)
    out[2] = cosine * velocity_x + sine * velocity_y
    out[3] = cosine * velocity_y - sine * velocity_x


@jit
def turn(
    mode: int,
    mean: FloatArray,
    covariance: FloatArray,
    interval: float,
    motion: MotionRule,
    mean_out: FloatArray,
    moving_out: FloatArray,
    noise_out: FloatArray,
) -> None:
    """Bend what was written for a straight path."""
    dim, at = motion.dim, motion.turn_at
    # Rows of the result: x, y and their velocities; columns of what bends: velocities and rate.
    slope = np.empty((4, 3))
    after, extra = np.empty(4), np.zeros((4, 4))
    # A rate that is hardly known bends the ends of all paths into an arc. Derivatives do not see
    # that: with them the states of turning objects were far too certain.
    if not _turn_by_points(mean, covariance, interval, motion, after, slope, extra):
        _turn_by_slopes(mean, interval, motion, after, slope)
    for row in range(4):
        place = row if row < 2 else dim + row - 2
        moving_out[place, dim] = slope[row, 0]
        moving_out[place, dim + 1] = slope[row, 1]
        moving_out[place, at] = slope[row, 2]
        mean_out[place] = after[row] + (mean[row] if row < 2 else 0.0)
        for column in range(4):
            other = column if column < 2 else dim + column - 2
            noise_out[place, other] += extra[row, column]
    mean_out[at] = mean[at]
    moving_out[at, at] = 1.0
    # What changes the turn rate bends velocity and path as jerk across the velocity would.
    turn_noise = signed_noise(mode, 1, interval, motion)
    noise_out[at, at] = turn_noise * interval
    across = (after[3], -after[2])
    for row in range(2):
        place, speed = row, dim + row
        noise_out[place, at] = turn_noise * interval**3 / 6.0 * across[row]
        noise_out[at, place] = noise_out[place, at]
        noise_out[speed, at] = turn_noise * interval**2 / 2.0 * across[row]
        noise_out[at, speed] = noise_out[speed, at]
        for column in range(2):
            both = turn_noise * across[row] * across[column]
            noise_out[place, column] += both * interval**5 / 20.0
            noise_out[speed, dim + column] += both * interval**3 / 3.0
            noise_out[place, dim + column] += both * interval**4 / 8.0
            noise_out[speed, column] += both * interval**4 / 8.0


@jit
def _turn_by_slopes(
    mean: FloatArray,
    interval: float,
    motion: MotionRule,
    after_out: FloatArray,
    slope_out: FloatArray,
) -> None:
    """Write the turn of the mean and its derivatives by velocity and turn rate."""
    speed_x, speed_y, rate = mean[motion.dim], mean[motion.dim + 1], mean[motion.turn_at]
    _turned(speed_x, speed_y, rate, interval, after_out)
    along, aside, along_slope, aside_slope = factors(rate * interval)
    sine, cosine = math.sin(rate * interval), math.cos(rate * interval)
    slope_out[0, 0] = slope_out[1, 1] = interval * along
    slope_out[0, 1] = interval * aside
    slope_out[1, 0] = -interval * aside
    slope_out[2, 0] = slope_out[3, 1] = cosine
    slope_out[2, 1] = sine
    slope_out[3, 0] = -sine
    square = interval * interval
    slope_out[0, 2] = square * (along_slope * speed_x + aside_slope * speed_y)
    slope_out[1, 2] = square * (along_slope * speed_y - aside_slope * speed_x)
    slope_out[2, 2] = interval * after_out[3]
    slope_out[3, 2] = -interval * after_out[2]


@jit
def _turn_by_points(
    mean: FloatArray,
    covariance: FloatArray,
    interval: float,
    motion: MotionRule,
    after_out: FloatArray,
    slope_out: FloatArray,
    extra_out: FloatArray,
) -> bool:
    """Write the turn's mean, its best linear fit over six sigma points, and what the fit leaves.

    The points lie √3 standard deviations from the mean, as a normal distribution's fourth moments
    ask for. Returns False where velocity and turn rate have no proper covariance.
    """
    at = (motion.dim, motion.dim + 1, motion.turn_at)
    root = np.zeros((3, 3))
    for column in range(3):
        for row in range(column, 3):
            value = covariance[at[row], at[column]]
            for inner in range(column):
                value -= root[row, inner] * root[column, inner]
            if row == column:
                if not value > 1e-14 * covariance[at[row], at[row]]:
                    return False
                root[row, row] = math.sqrt(value)
            else:
                root[row, column] = value / root[column, column]
    reach = math.sqrt(3.0)
    points = np.empty((6, 4))
    for column in range(3):
        for side in range(2):
            step = reach if side == 0 else -reach
            _turned(
                mean[at[0]] + step * root[0, column],
                mean[at[1]] + step * root[1, column],
                mean[at[2]] + step * root[2, column],
                interval,
                points[2 * column + side],
            )
    for row in range(4):
        total = 0.0
        for point in range(6):
            total += points[point, row]
        after_out[row] = total / 6.0
    # slope·root = half the difference across each pair of points, per standard deviation.
    for row in range(4):
        for column in range(2, -1, -1):
            value = (points[2 * column, row] - points[2 * column + 1, row]) / (2.0 * reach)
            for inner in range(column + 1, 3):
                value -= slope_out[row, inner] * root[inner, column]
            slope_out[row, column] = value / root[column, column]
    for row in range(4):
        for column in range(4):
            total = 0.0
            for point in range(6):
                total += (points[point, row] - after_out[row]) * (
                    points[point, column] - after_out[column]
                )
            extra_out[row, column] = total / 6.0
            for pair in range(3):
                extra_out[row, column] -= (
                    (points[2 * pair, row] - points[2 * pair + 1, row])
                    * (points[2 * pair, column] - points[2 * pair + 1, column])
                    / 12.0
                )
    return True
