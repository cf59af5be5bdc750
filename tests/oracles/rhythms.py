"""At which intervals an object reports itself, from all its times and from the beginning."""

import math
from itertools import pairwise

CHANGED, LOST, RANGE, MOST = 0.05, 0.3, 5.0, 8.0
USUAL, LEAST = 0.15**2, 0.01**2


def _chances(interval, variance, count, any_share, waited):
    """Return how likely each number of lost reports makes a wait, as a multiple of anybody's."""
    spread = math.sqrt(variance * (1 + 1 / count))
    chances = []
    for lost in range(4):
        away = (math.log(waited) - math.log(lost + 1) - interval) / spread
        density = math.exp(-(away**2) / 2) / (spread * math.sqrt(2 * math.pi))
        chances.append((1 - any_share) * 0.7 * LOST**lost * RANGE * density)
    return chances


def rhythm_costs(times, rate):
    """Return what each report of a sequence costs for its time, the first nothing."""
    costs, known, any_share = [0.0], None, CHANGED
    for last, now in pairwise(times):
        waited = now - last
        sooner = min(0.0, max(-RANGE / 2, math.log(max(waited * rate, 1e-9))))
        if known is None:
            costs.append(sooner)
            known = (math.log(waited), USUAL, 1.0) if waited > 0 else None
            continue
        interval, variance, count = known
        chances = _chances(*known, any_share, waited) if waited > 0 else [0.0]
        costs.append(sooner - math.log(any_share + sum(chances)))
        if waited == 0:
            continue
        surely = any_share / (any_share + sum(chances))
        any_share = max(CHANGED, any_share + (surely - any_share) / MOST)
        likeliest = max(range(4), key=chances.__getitem__)
        one = math.log(waited / (likeliest + 1))
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
        rate = look.sensor.detection_probability
        return rhythm_costs(self.times, rate)[-1]
