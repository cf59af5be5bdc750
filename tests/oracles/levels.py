"""What reports cost by the heights that they tell beside their places."""

import math

APART, CLIMB, FASTEST = 100.0, 15.0, 100.0
LEVEL, WRONG, FIT, SOONEST = 0.5, 0.03, 5.0, 0.5


def off(known, told):
    """Return how far off a height is and may be, for what is known: height, time, sensor, rate."""
    (last, since, by, rate, spread), (height, moment, sensor, sigma) = known, told
    wait, moved = moment - since, height - last
    least = math.hypot(spread, sigma, 0.0 if by == sensor else APART)
    if rate is None:
        return moved, least, math.hypot(least, FASTEST * wait)
    led = min(moved, moved - rate * wait, key=abs)
    return led, least, math.hypot(least, CLIMB * wait)


def level(told):
    """Return what is known of a sequence's height by its reports, each a view and an index."""
    # One that does not fit is wrong, unless the next does not fit either.
    known, misfit = None, False
    for height, moment, sensor, sigma in map(heard, told):
        if math.isnan(height):
            continue
        rate, now, spread = None, height, sigma
        if known is not None:
            far, _, width = off(known, (height, moment, sensor, sigma))
            if abs(far) > FIT * width and not misfit:
                misfit = True
                continue
            if abs(far) <= FIT * width:
                # The mean of what leads here and what is told, by how exact they are.
                led = width**2 - sigma**2
                now = ((height - far) * sigma**2 + height * led) / width**2
                spread = math.sqrt(led) * sigma / width
            last, since, by, rate, _ = known
            if by == sensor and moment - since > SOONEST:
                rate = (now - last) / (moment - since)
        known, misfit = (now, moment, sensor, rate, spread), False
    return known


def heard(report):
    """Return the height that a report tells, NaN for none, when, and its sensor."""
    view, index = report
    height = math.nan if view.scan.height is None else float(view.scan.height[index])
    height -= view.sensor.height_offset
    return height, view.moment(index), view.sensor.name, view.sensor.sigma_height


def height_cost(report, told):
    """Return what it costs that a report has its height, after reports before it [nats]."""
    here, known = heard(report), level(told)
    if math.isnan(here[0]) or known is None:
        return 0.0
    far, least, width = off(known, here)
    fits = math.exp(-((far / width) ** 2) / 2)
    if known[2] == here[2] and known[3] is not None:
        parts = ((LEVEL, least), (1 - LEVEL, width))
        fits = sum(share * math.exp(-((far / s) ** 2) / 2) / s for share, s in parts)
        fits /= sum(share / s for share, s in parts)
    return -math.log(WRONG + (1 - WRONG) * fits)
