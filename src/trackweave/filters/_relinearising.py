"""The correction of an extended Kalman filter that a far report makes, taken where it leads.

Slopes hold near the place at which they were taken. After a long silence a state is known to
kilometres and the report to metres: a correction across the line of sight follows the tangent and
ends far outside the report's own noise, with a covariance that denies it, and the next report of
the same object fits nothing. The iterated filter [1]_ takes the slopes anew where the last
correction led, until it stays. Nothing here checks or raises.

.. [1] B. M. Bell and F. W. Cathey, The iterated Kalman filter update as a Gauss-Newton method,
   1993.
"""

import numpy as np

from trackweave._loops import overwrite, overwrite_rows
from trackweave.arrays import FloatArray
from trackweave.domain.measurements import MeasurementKind
from trackweave.filters._kernels import correct
from trackweave.filters._measuring import innovation, measure, slopes_at, width_of_influence
from trackweave.jit import jit

_FIRST = int(MeasurementKind.RANGE_AZIMUTH)
_LAST = int(MeasurementKind.RANGE_AZIMUTH_ELEVATION_RATE)
_AZIMUTH = 1
# Gauss-Newton doubles its digits: what has not settled by now will not.
_MOST_ROUNDS = 5


@jit
def relinearise(
    kind: int,
    measurement: FloatArray,
    noise: FloatArray,
    platform: FloatArray,
    dim: int,
    mean: FloatArray,
    covariance: FloatArray,
    mean_out: FloatArray,
    covariance_out: FloatArray,
) -> None:
    """Replace a corrected state, in place, where the correction left the tangent's neighbourhood.

    ``mean`` and ``covariance`` are of before the report. Nothing changes, to the last bit, where
    the correction is short or longer than the range, for reports without a range, or where it
    would not settle.
    """
    if kind < _FIRST or kind > _LAST:
        return
    # A step s across the line of sight leaves the circle of range r by s² / 2r, and the azimuth
    # is off by as much over r: half a standard deviation of either is let pass.
    reach = max(measurement[0], 0.0)
    passed = reach * min(np.sqrt(noise[0, 0]), reach * np.sqrt(noise[_AZIMUTH, _AZIMUTH]))
    # A step beyond the range itself leads past the sensor, from where no azimuth was foreseen and
    # the report's likelihood is not worth the correction: what begins at an airfield is another's.
    step = _apart(mean, mean_out, dim)
    if not passed < step < reach * reach:
        return
    size, width = mean.shape[0], measurement.shape[0]
    influence = width_of_influence(kind, dim)
    slope, cross = np.empty((width, influence)), np.empty((size, width))
    predicted, off, spread = np.empty(width), np.empty(width), np.empty((width, width))
    here, there, narrowed = mean_out.copy(), np.empty(size), np.empty((size, size))
    for _ in range(_MOST_ROUNDS):
        measure(kind, here, covariance, platform, dim, False, predicted, spread, cross)
        slopes_at(kind, here, covariance, platform, dim, slope)
        innovation(kind, measurement, predicted, off)
        for row in range(width):
            for inner in range(influence):
                off[row] -= slope[row, inner] * (mean[inner] - here[inner])
            for column in range(width):
                spread[row, column] += noise[row, column]
        correct(mean, covariance, off, spread, cross, there, narrowed)
        moved = _apart(here, there, dim)
        overwrite(here, there)
        if moved <= passed:
            overwrite(mean_out, there)
            overwrite_rows(covariance_out, narrowed)
            return


@jit
def _apart(one: FloatArray, other: FloatArray, dim: int) -> float:
    """Return the squared distance of two states' places."""
    total = 0.0
    for axis in range(dim):
        total += (one[axis] - other[axis]) ** 2
    return total
