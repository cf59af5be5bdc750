"""At which intervals an object reports itself, from all its times and from the beginning."""

import math
from itertools import pairwise
from operator import truediv

CHANGED, LOST, RANGE, MOST = 0.05, 0.3, 5.0, 8.0
NONE, SURE = 0.003, 0.95
USUAL, LEAST = 0.15**2, 0.01**2


def _chances(interval, variance, count, waited):
    """Return how likely each number of lost reports makes a wait, as a multiple of anybody's."""
    spread = math.sqrt(variance * (1 + 1 / count))
    chances = []
    for lost in range(4):
        away = (math.log(waited) - math.log(lost + 1) - interval) / spread
        density = math.exp(-(away**2) / 2) / (spread * math.sqrt(2 * math.pi))
        chances.append(0.95 * 0.7 * LOST**lost * RANGE * density)
    return chances


def rhythm_costs(times, often):
    """Return what each report costs for its time; usual is to be heard so often in a second."""
    costs, known, free = [0.0], None, NONE
    for last, now in pairwise(times):
        waited = now - last
        if known is None:
            costs.append(0.0)
            known = (math.log(waited), USUAL, 1.0) if waited > 0 else None
            continue
        interval, variance, count = known
        chances = _chances(*known, waited) if waited > 0 else [0.0]
        heard = -1 / math.log(1 - often)
        usual = min(max(10.0, heard / 3), heard * 3)
        slow = [
            math.exp(interval) * (lost + 1) / usual if count >= 3 else 1.0 for lost in range(4)
        ]
        rare = [min(max(one, 1 / 20), 20.0) for one in slow]
        costs.append(-math.log(free + (1 - free) * (CHANGED + sum(map(truediv, chances, rare)))))
        if waited == 0:
            continue
        likeliest = max(range(4), key=chances.__getitem__)
        one = math.log(waited / (likeliest + 1))
        kept = CHANGED + sum(chances)
        free = min(max(free / (free + (1 - free) * kept), NONE), SURE)
        if chances[likeliest] > CHANGED:
            off = one - interval
            variance = max((variance * (count + 1) + off**2) / (count + 2), LEAST)
            known = interval + off / (count + 1), variance, min(count + 1, MOST)
        elif count / 4 < 1 or math.log(waited) < interval:
            known = math.log(waited), USUAL, 1.0
        else:
            known = interval, variance, count / 4
    return costs


class Hearing:
    """When a sensor hears an object; only the first sensor that does counts."""

    def __init__(self):
        self.sensor, self.times = None, []

    def cost(self, look):
        """Return what it costs that the object is reported at the time of a look."""
        if look.sensor.scans is not False or self.sensor not in (None, look.sensor):
            return 0.0
        self.sensor = look.sensor
        self.times.append(look.time)
        return rhythm_costs(self.times, look.sensor.detection_probability)[-1]
