"""Chains of reports beside which hardly any other lies: those of a crowd change their objects."""

import numpy as np

from trackweave.arrays import IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.trees import n_within, tree_of

__all__ = ["in_the_clear"]

# A chain is in the clear beside whose reports so few others are, within so many standard
# deviations and half of the usual interval; such chains tell alone where there are so many.
NEAR, OTHERS = 5.6, 0.3
FEWEST_CHAINS, FEWEST_REPORTS = 8, 80


def in_the_clear(
    chains: list[IntArray], of: tuple[ReportTable, int], sigma: float
) -> list[IntArray]:
    """Return the chains of a sensor's rows that are in the clear, all where those are too few."""
    # One that takes a neighbour's report seems to turn, and a few such in a fleet are enough to
    # have all objects turn. Where everybody is in a crowd there are no others to tell.
    reports, index = of
    rows = np.flatnonzero(reports.sensor == index)
    steps = [np.diff(reports.time[chain]) for chain in chains]
    interval = float(np.median(np.concatenate(steps))) if chains else 0.0
    if interval <= 0.0:
        return chains
    moment = (2.0 * NEAR * sigma / interval) * (reports.time - reports.time[0])
    places = np.column_stack([reports.measurement, moment])
    tree = tree_of(places[rows])
    others = [np.mean(n_within(tree, places[chain], NEAR * sigma)) - 1.0 for chain in chains]
    clear = [chain for chain, count in zip(chains, others, strict=True) if count < OTHERS]
    is_enough = len(clear) >= FEWEST_CHAINS and sum(map(len, clear)) >= FEWEST_REPORTS
    return clear if is_enough else chains
