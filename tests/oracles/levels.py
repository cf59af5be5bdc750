"""What reports cost by the heights that they tell beside their places."""

import math

STEADY, APART, CLIMB, FASTEST = 30.0, 100.0, 15.0, 100.0
LEVEL, WRONG, FIT, SOONEST = 0.5, 0.03, 5.0, 0.5


def off(known, told):
    """Return how far off a height is and may be, for what is known: height, time, sensor, rate."""
    (last, since, by, rate), (height, moment, sensor) = known, told
    wait, moved = moment - since, height - last
    least = STEADY if by == sensor else APART
    if rate is None:
        return abs(moved), math.hypot(least, FASTEST * wait)
    return min(abs(moved), abs(moved - rate * wait)), math.hypot(least, CLIMB * wait)


def level(told):
    """Return what is known of a sequence's height by its reports, each a view and an index."""
    # One that does not fit is wrong, unless the next does not fit either.
    known, misfit = None, False
    for height, moment, sensor in map(heard, told):
        if math.isnan(height):
            continue
        rate = None
        if known is not None:
            far, width = off(known, (height, moment, sensor))
            if far > FIT * width and not misfit:
                misfit = True
                continue
            last, since, by, rate = known
            if by == sensor and moment - since > SOONEST:
                rate = (height - last) / (moment - since)
        known, misfit = (height, moment, sensor, rate), False
    return known


def heard(report):
    """Return the height that a report tells, NaN for none, when, and its sensor."""
    view, index = report
    height = math.nan if view.scan.height is None else float(view.scan.height[index])
    return height, view.moment(index), view.sensor.name


def height_cost(report, told):
    """Return what it costs that a report has its height, after reports before it [nats]."""
    here, known = heard(report), level(told)
    if math.isnan(here[0]) or known is None:
        return 0.0
    far, width = off(known, here)
    fits = math.exp(-((far / width) ** 2) / 2)
    if known[2] == here[2] and known[3] is not None:
        parts = ((LEVEL, STEADY), (1 - LEVEL, width))
        fits = sum(share * math.exp(-((far / s) ** 2) / 2) / s for share, s in parts)
        fits /= sum(share / s for share, s in parts)
    return -math.log(WRONG + (1 - WRONG) * fits)
