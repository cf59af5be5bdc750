"""What invented scenes allow at best: each scan's reports given to the true ways at least cost.

No tracker knows the true ways. What is wrong even so, nothing tells apart but what comes before
and after.
"""

import argparse

import numpy as np
from invented_scenes import NOBODY, Array, Ways, crossing, stacks
from scipy.optimize import linear_sum_assignment
from text_tables import command, heading, table

from trackweave.metrics import assignment_quality

SIGMA = {"stacks": (70.0, np.radians(0.08)), "crossing": (0.2, 0.2)}
PERIOD = {"stacks": 12.0, "crossing": 0.1}
MAKE = {"stacks": stacks, "crossing": crossing}
# A report this far off is nobody's; a pair that cannot be costs more than all that can.
FARTHEST, NEVER = 60.0, 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--seeds", type=int, default=9)
    parser.add_argument("--only", nargs="+", default=list(MAKE), choices=list(MAKE))
    told = parser.parse_args()
    lines = []
    for name in told.only:
        for seed in range(told.first, told.first + told.seeds):
            ways: Ways = {}
            reports = MAKE[name](np.random.default_rng(seed), ways)
            whose, seen = reports["target"].to_list(), reports.drop("target").to_numpy()
            scored = assignment_quality(whose, given(name, seen, ways))
            false = np.array(whose) == NOBODY
            lines.append([name, seed, f"{scored.idf1:.3f}", scored.switches, int(false.sum())])
    print(heading(command("invented_ways.py")), end="\n\n")
    print(table(["scene", "seed", "IDF1, ways known", "switches", "false alarms"], lines))


def given(name: str, seen: Array, ways: Ways) -> Array:
    """Return the number of the way of each report, -1 for none."""
    scan = np.floor(seen[:, 0] / PERIOD[name] + 1e-6)
    number = np.full(len(seen), -1)
    for each in np.unique(scan):
        rows = np.flatnonzero(scan == each)
        costs = np.array([[_cost(name, seen[row], way) for way in ways.values()] for row in rows])
        alone = np.full((rows.size, rows.size), FARTHEST)
        report, way = linear_sum_assignment(np.hstack([costs, alone]))
        number[rows[report]] = np.where(way < len(ways), way, -1)
    return number


def _cost(name: str, report: Array, way: tuple) -> float:
    place, first, last = way
    if not first <= report[0] < last:
        return NEVER
    x, y = place(report[0])
    off = report[1:] - (x, y)
    if name == "stacks":
        turned = np.radians(report[2]) - np.arctan2(x, y)
        off = report[1] - np.hypot(x, y), (turned + np.pi) % (2 * np.pi) - np.pi
    return float(np.sum((np.array(off) / SIGMA[name]) ** 2))


if __name__ == "__main__":
    main()
