"""Heights that reports tell beside where they are, as evidence of whose they are.

Whoever flies in a stack over another, or by it, is known by its height although the plane does
not tell them apart. A report's height is near the object's last one, as it flies level, or as far
off as a climb takes it, or it is wrong; that of any other report is spread as all heights are.
Nothing here checks or raises.
"""

import math

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.jit import jit

HEIGHT, SINCE, MISFITS = 0, 1, 2
"""An object's level: its last height [m], when it was told [s], how many since do not fit."""
SIZE = 3
STEADY, CLIMB = 30.0, 12.0
"""Heights come in steps of 100 feet [m], and climbs are about as steep [m/s]."""
LEVEL, WRONG = 0.6, 0.05
"""Share of the time for which objects fly level, and of heights that are garbled."""
FIT = 5.0
"""What lies so many standard deviations of a climb off does not fit."""
ROOT_TWO_PI = math.sqrt(2.0 * math.pi)


@jit
def level_cost(levels: FloatArray, node: int, told: float, moment: float, spread: float) -> float:
    """Return what it costs that a report has its height, beside that of any report [nats]."""
    if not spread > 0.0:
        return 0.0
    off, width = _off(levels, node, told, moment)
    if not width > 0.0:
        return 0.0
    level = math.exp(-0.5 * (off / STEADY) ** 2) / STEADY
    climbing = math.exp(-0.5 * (off / width) ** 2) / width
    density = (LEVEL * level + (1.0 - LEVEL) * climbing) / ROOT_TWO_PI
    return -math.log((1.0 - WRONG) * density * spread + WRONG)


@jit
def begin_level(levels: FloatArray, node: int, told: float, moment: float) -> None:
    """Begin with the height that an object's first report tells, NaN for none."""
    levels[node, HEIGHT], levels[node, SINCE], levels[node, MISFITS] = told, moment, 0.0


@jit
def take_level(levels: FloatArray, node: int, told: float, moment: float) -> None:
    """Take in the height that an object's report tells: one that does not fit, the second time."""
    if math.isnan(told):
        return
    off, width = _off(levels, node, told, moment)
    if width > 0.0 and abs(off) > FIT * width and levels[node, MISFITS] == 0.0:
        levels[node, MISFITS] = 1.0
    else:
        begin_level(levels, node, told, moment)


@jit
def _off(levels: FloatArray, node: int, told: float, moment: float) -> tuple[float, float]:
    """Return how far off a height is and a climb could have taken it [m]; 0, 0 for unknown."""
    last = levels[node, HEIGHT]
    if math.isnan(told) or math.isnan(last):
        return 0.0, 0.0
    return told - last, np.hypot(STEADY, CLIMB * (moment - levels[node, SINCE]))
