"""Heights that reports tell beside where they are, as evidence of whose they are.

What flies one above the other is known by its height where the plane does not tell it apart. A
report's height is near the object's last one, or near where its last climb leads, or it is wrong.
What fits costs nothing: of heights of false alarms nothing is supposed. Nothing here checks or
raises.
"""

import math

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.jit import jit

HEIGHT, SINCE, RATE, MISFIT, SENSOR = 0, 1, 2, 3, 4
"""An object's level: its last height [m], when that was told [s], how fast it changed [m/s], NaN
for unknown, whether one since did not fit, and which sensor told it."""
SIZE = 5
STEADY, APART, CLIMB, FASTEST = 30.0, 100.0, 15.0, 100.0
"""Heights come in steps of 100 feet, sensors differ by so much [m]; climbs change by so much, and
are as fast where nothing has told them yet [m/s]."""
LEVEL, WRONG = 0.5, 0.03
"""Share of the time for which objects fly on as before, and of heights that are garbled."""
FIT, SOONEST = 5.0, 0.5
"""What lies so many standard deviations off does not fit; sooner nothing tells a climb [s]."""


@jit
def level_cost(levels: FloatArray, node: int, told: float, moment: float, sensor: int) -> float:
    """Return what it costs that a report has its height, beside one that fits [nats]."""
    if math.isnan(told) or math.isnan(levels[node, HEIGHT]):
        return 0.0
    off, width = _off(levels, node, told, moment, sensor)
    wide = math.exp(-0.5 * (off / width) ** 2)
    if levels[node, SENSOR] == sensor and not math.isnan(levels[node, RATE]):
        near, share = math.exp(-0.5 * (off / STEADY) ** 2) / STEADY, (1.0 - LEVEL) / width
        wide = (LEVEL * near + share * wide) / (LEVEL / STEADY + share)
    return -math.log((1.0 - WRONG) * wide + WRONG)


@jit
def begin_level(levels: FloatArray, node: int, told: float, moment: float, sensor: int) -> None:
    """Begin with the height that an object's first report tells, NaN for none."""
    levels[node, HEIGHT], levels[node, SINCE], levels[node, RATE] = told, moment, math.nan
    levels[node, MISFIT], levels[node, SENSOR] = 0.0, sensor


@jit
def take_level(levels: FloatArray, node: int, told: float, moment: float, sensor: int) -> None:
    """Take in the height that an object's report tells: one that does not fit, the second time."""
    if math.isnan(told):
        return
    last, rate = levels[node, HEIGHT], math.nan
    if not math.isnan(last):
        off, width = _off(levels, node, told, moment, sensor)
        if off > FIT * width and levels[node, MISFIT] == 0.0:
            levels[node, MISFIT] = 1.0
            return
        wait = moment - levels[node, SINCE]
        # Two sensors' heights may differ for good, which is no climb.
        is_own = levels[node, SENSOR] == sensor and wait > SOONEST
        rate = (told - last) / wait if is_own else levels[node, RATE]
    begin_level(levels, node, told, moment, sensor)
    levels[node, RATE] = rate


@jit
def _off(
    levels: FloatArray, node: int, told: float, moment: float, sensor: int
) -> tuple[float, float]:
    """Return how far off a height is, and how far it may be [m]."""
    wait = moment - levels[node, SINCE]
    moved, rate = told - levels[node, HEIGHT], levels[node, RATE]
    least = STEADY if levels[node, SENSOR] == sensor else APART
    if math.isnan(rate):
        return abs(moved), np.hypot(least, FASTEST * wait)
    return min(abs(moved), abs(moved - rate * wait)), np.hypot(least, CLIMB * wait)
