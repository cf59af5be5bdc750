"""Heights that reports tell beside where they are, as evidence of whose they are.

What flies one above the other is known by its height where the plane does not tell it apart. A
report's height is near the object's last one, or near where its last climb leads, or it is wrong.
What fits costs nothing: of heights of false alarms nothing is supposed. Nothing here checks or
raises.
"""

import math
from typing import TypeAlias

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.jit import jit

Heard: TypeAlias = tuple[float, float, float]
"""What a report tells: its height [m], NaN for none, when [s], and how exact it is [m]."""

HEIGHT, SINCE, RATE, MISFIT, SENSOR, SPREAD = 0, 1, 2, 3, 4, 5
"""An object's level: its height [m], when that was last told [s], how fast it changed [m/s], NaN
for unknown, whether one since did not fit, which sensor told it, and how exact it is [m]."""
SIZE = 6
APART, CLIMB, FASTEST = 100.0, 15.0, 100.0
"""Sensors differ by so much [m]; climbs change by so much, and are as fast where nothing has told
them yet [m/s]."""
LEVEL, WRONG = 0.5, 0.03
"""Share of the time for which objects fly on as before, and of heights that are garbled."""
FIT, SOONEST = 5.0, 0.5
"""What lies so many standard deviations off does not fit; sooner nothing tells a climb [s]."""


@jit
def level_cost(levels: FloatArray, node: int, heard: Heard, sensor: int) -> float:
    """Return what it costs that a report has its height, beside one that fits [nats]."""
    if math.isnan(heard[0]) or math.isnan(levels[node, HEIGHT]):
        return 0.0
    off, least, width = _off(levels, node, heard, sensor)
    wide = math.exp(-0.5 * (off / width) ** 2)
    if levels[node, SENSOR] == sensor and not math.isnan(levels[node, RATE]):
        near, share = math.exp(-0.5 * (off / least) ** 2) / least, (1.0 - LEVEL) / width
        wide = (LEVEL * near + share * wide) / (LEVEL / least + share)
    return -math.log((1.0 - WRONG) * wide + WRONG)


@jit
def begin_level(levels: FloatArray, node: int, heard: Heard, sensor: int) -> None:
    """Begin with the height that an object's first report tells, NaN for none."""
    levels[node, HEIGHT], levels[node, SINCE] = heard[0], heard[1]
    levels[node, RATE], levels[node, MISFIT] = math.nan, 0.0
    levels[node, SENSOR], levels[node, SPREAD] = sensor, heard[2]


@jit
def take_level(levels: FloatArray, node: int, heard: Heard, sensor: int) -> None:
    """Take in the height that an object's report tells: one that does not fit, the second time."""
    told, last = heard[0], levels[node, HEIGHT]
    if math.isnan(told):
        return
    if math.isnan(last):
        begin_level(levels, node, heard, sensor)
        return
    off, _, width = _off(levels, node, heard, sensor)
    fits = abs(off) <= FIT * width
    if not fits and levels[node, MISFIT] == 0.0:
        levels[node, MISFIT] = 1.0
        return
    gain = 1.0 - (heard[2] / width) ** 2 if fits else 1.0
    now = told - (1.0 - gain) * off
    wait = heard[1] - levels[node, SINCE]
    # Two sensors' heights may differ for good, which is no climb.
    is_own = levels[node, SENSOR] == sensor and wait > SOONEST
    rate = (now - last) / wait if is_own else levels[node, RATE]
    begin_level(levels, node, heard, sensor)
    levels[node, HEIGHT], levels[node, RATE] = now, rate
    levels[node, SPREAD] = heard[2] * math.sqrt(gain)


@jit
def _off(levels: FloatArray, node: int, heard: Heard, sensor: int) -> tuple[float, float, float]:
    """Return how far off a height is, and may be of what flies on as before or not [m]."""
    wait = heard[1] - levels[node, SINCE]
    moved, rate = heard[0] - levels[node, HEIGHT], levels[node, RATE]
    least = np.hypot(levels[node, SPREAD], heard[2])
    if levels[node, SENSOR] != sensor:
        least = np.hypot(least, APART)
    if math.isnan(rate):
        return moved, least, np.hypot(least, FASTEST * wait)
    led = moved - rate * wait
    return led if abs(led) < abs(moved) else moved, least, np.hypot(least, CLIMB * wait)
