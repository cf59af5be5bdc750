"""Stretches of the climb to what prices can prove, cut short enough to look at the clock."""

from typing import NamedTuple

from trackweave.solvers._ascent import begin_climb, deflect, smooth
from trackweave.solvers._dual import answer_at
from trackweave.solvers.components import Components
from trackweave.solvers.protocol import Stop

__all__ = ["STRETCHES", "Stretch", "climb"]

SLICE_WORK = 2_000_000
"""Sequences priced between two looks at the clock."""
HOT, COLD = 2.0, 0.06
"""First and last temperature of the smoothed dual, in units of the gap per family."""
BETWEEN_ANSWERS = 25
"""How many bounds are computed before an answer is made at the prices as they are."""
IMPROVEMENTS = 3
"""How often the last answer is improved locally."""
FACTOR = 0.1
"""First step of the subgradients, as a part of Polyak's."""


class Stretch(NamedTuple):
    """So many bounds, by deflected subgradients or on the smoothed dual."""

    bounds: int
    is_smooth: bool


# Early answers and reductions pay: where prices alone can prove an answer, they mostly have
# after the second stretch. The smoothed dual is slow, and goes on where subgradients stall.
STRETCHES = (
    Stretch(150, False),
    Stretch(150, False),
    Stretch(300, False),
    Stretch(800, True),
    Stretch(500, False),
)


def climb(
    components: Components, index: int, stretch: Stretch, stop: Stop | None
) -> tuple[int, bool]:
    """Raise a component's bound and answer it, in place; return bounds computed, if stopped."""
    component = components.component(index)
    price = components.price[components.items(index)]
    selection = components.taken[components.families(index)]
    upper, lower = float(components.cost[index]), float(components.lower[index])
    start = begin_climb(component, price, lower, 1.0 if stretch.is_smooth else FACTOR)
    unit = (upper - lower) / max(1, component.must.shape[0])
    more = max(1, min(BETWEEN_ANSWERS, SLICE_WORK // component.parent.shape[0]))
    over = stopped = False
    while not over and not stopped:
        if stretch.is_smooth:
            heat = HOT * unit, COLD * unit
            over = smooth(component, price, start, *heat, more, stretch.bounds)
        else:
            over = deflect(component, price, start, upper, more, stretch.bounds)
        upper = answer_at(component, start.current, selection, upper, 0)
        stopped = stop is not None and stop()
    upper = answer_at(component, price, selection, upper, IMPROVEMENTS)
    components.cost[index] = upper
    components.lower[index] = min(upper, max(lower, float(start.value[0])))
    return int(start.steps[0]), stopped
