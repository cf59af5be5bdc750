"""What reports cost by the heights that they tell beside their places."""

import math

STEADY, CLIMB, LEVEL, WRONG, FIT = 30.0, 12.0, 0.6, 0.05, 5.0


def level(told):
    """Return a sequence's last height and when it was told, of all its heights and times."""
    # One that no climb explains is wrong, unless the next is not explained either.
    last, misfit = None, False
    for height, moment in told:
        if math.isnan(height):
            continue
        if last is not None and not misfit:
            reached = math.hypot(STEADY, CLIMB * (moment - last[1]))
            if abs(height - last[0]) > FIT * reached:
                misfit = True
                continue
        last, misfit = (height, moment), False
    return last


def height_of(view, index):
    """Return the height that a report tells, NaN for none."""
    return math.nan if view.scan.height is None else float(view.scan.height[index])


def height_cost(view, index, told, spread):
    """Return what it costs that a report has its height, after those told before [nats]."""
    height = height_of(view, index)
    if math.isnan(height) or not spread or level(told) is None:
        return 0.0
    before, since = level(told)
    density = 0.0
    climb = math.hypot(STEADY, CLIMB * (view.moment(index) - since))
    for share, sigma in ((LEVEL, STEADY), (1 - LEVEL, climb)):
        ratio = (height - before) / sigma
        density += share * math.exp(-(ratio**2) / 2) / (math.sqrt(2 * math.pi) * sigma)
    return -math.log(WRONG + (1 - WRONG) * density * spread)
