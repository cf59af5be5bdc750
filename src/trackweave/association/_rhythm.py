"""At which intervals an object reports itself, as its sequence tells. Nothing here checks.

A row of a sequence's ``rhythm`` holds the sensor that hears it (-1 for none), when that last did
[s], the logarithm of the reporting interval, the variance of the logarithm, how many intervals
tell of both (0 after the first report), and how probable it is that it keeps none.
"""

import math
from typing import TYPE_CHECKING

from trackweave.arrays import FloatArray
from trackweave.jit import jit

if TYPE_CHECKING:
    from trackweave.association._nodes import ScanInput

SIZE = 6
SENSOR, TIME, INTERVAL, VARIANCE, COUNT, FREE = range(SIZE)

CHANGED, LOST, MOST_LOST = 0.05, 0.3, 4
"""How often the next report comes at another interval or after a silence, and how often one is
lost; with more lost in a row nothing is known of the next."""
NO_RHYTHM, MOST_FREE = 0.003, 0.95
"""How many objects report whenever they like, and how sure that is of one at most."""
RANGE = 5.0
"""Reporting intervals of which nothing is known are so many powers of e apart."""
USUAL_PACE, ASIDE, MOST_PACE, PACED = 10.0, 3.0, 20.0, 3.0
"""Between reports of objects in general [s], or so many times quicker or slower at most than what
the chance says to be heard within a second; so many times slower or quicker counts, and no more;
and from so many intervals on: one report soon after another is no sign that both are of one."""
USUAL_VARIANCE, LEAST_VARIANCE = 0.15**2, 0.01**2
"""Of the logarithm of an interval: before any tells, which counts as one, and never less."""
MOST_COUNT, FORGOTTEN = 8.0, 0.25
"""So many intervals are remembered; after one that does not fit, this share of them."""


@jit
def begin_rhythm(rhythm: FloatArray, node: int, sensor: int, moment: float) -> None:
    """Write what one report tells, the sequence's first; a negative sensor for none heard."""
    rhythm[node, SENSOR], rhythm[node, TIME] = sensor, moment
    rhythm[node, INTERVAL], rhythm[node, VARIANCE], rhythm[node, COUNT] = 0.0, USUAL_VARIANCE, 0.0
    rhythm[node, FREE] = NO_RHYTHM


@jit
def _odds(row: FloatArray, waited: float, lost: int) -> float:
    """Return how much likelier the next report is then, so many lost, than of who is unknown."""
    spread = row[VARIANCE] * (1.0 + 1.0 / row[COUNT])
    off = math.log(waited / (lost + 1.0)) - row[INTERVAL]
    share = (1.0 - CHANGED) * (1.0 - LOST) * LOST**lost
    return share * RANGE * math.exp(-0.5 * off * off / spread) / math.sqrt(2.0 * math.pi * spread)


@jit
def _rarity(row: FloatArray, lost: int, often: float) -> float:
    """Return how much rarer than usual reports are at its interval, so many of them lost.

    The density of a wait's logarithm over the wait is that of the wait: without it two tracks
    that take turns on one object would be worth more than the one, being more regular.
    """
    if row[COUNT] < PACED:
        return 1.0
    heard = -1.0 / math.log1p(-often)
    usual = min(max(USUAL_PACE, heard / ASIDE), heard * ASIDE)
    pace = math.exp(row[INTERVAL]) * (lost + 1.0) / usual
    return min(max(pace, 1.0 / MOST_PACE), MOST_PACE)


@jit
def rhythm_cost(rhythm: FloatArray, node: int, scan: "ScanInput", index: int) -> float:
    """Return what it costs that a report is the next that is heard of an object [nats].

    Against a report of which no rhythm tells: the interval is log-normal about the object's own,
    or about a multiple of it where reports are lost, or it is any; always, of who keeps none.
    """
    row = rhythm[node]
    if row[SENSOR] != scan.sensor or row[COUNT] == 0.0:
        return 0.0
    waited = abs(scan.moment[index] - row[TIME])
    odds = CHANGED
    if waited > 0.0:
        for lost in range(MOST_LOST):
            odds += _odds(row, waited, lost) / _rarity(row, lost, scan.detection_probability)
    return -math.log(row[FREE] + (1.0 - row[FREE]) * odds)


@jit
def hear(rhythm: FloatArray, node: int, sensor: int, moment: float) -> None:
    """Take in that a sensor hears the object at a moment, in place."""
    row = rhythm[node]
    if row[SENSOR] < 0.0:
        begin_rhythm(rhythm, node, sensor, moment)
        return
    waited = abs(moment - row[TIME])
    if row[SENSOR] != sensor or waited == 0.0:
        return
    best, odds = 0, 0.0
    if row[COUNT] > 0.0:
        kept = CHANGED
        for lost in range(MOST_LOST):
            value = _odds(row, waited, lost)
            kept += value
            if value > odds:
                best, odds = lost, value
        free = row[FREE] / (row[FREE] + (1.0 - row[FREE]) * kept)
        row[FREE] = min(max(free, NO_RHYTHM), MOST_FREE)
    row[TIME] = max(moment, row[TIME])
    if odds > CHANGED:
        off, count = math.log(waited / (best + 1.0)) - row[INTERVAL], row[COUNT]
        row[INTERVAL] += off / (count + 1.0)
        spread = (row[VARIANCE] * (count + 1.0) + off * off) / (count + 2.0)
        row[VARIANCE] = max(spread, LEAST_VARIANCE)
        row[COUNT] = min(count + 1.0, MOST_COUNT)
        return
    row[COUNT] *= FORGOTTEN
    interval = math.log(waited)
    if row[COUNT] < 1.0 or interval < row[INTERVAL]:
        # A longer one may be a silence; a shorter one is how it reports now.
        row[INTERVAL], row[VARIANCE], row[COUNT] = interval, USUAL_VARIANCE, 1.0
