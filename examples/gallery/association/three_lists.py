"""
Three-dimensional assignment, beside HiGHS
==========================================

Twelve machines, twelve workers, twelve jobs: each triple costs the length of the way around it,
everybody is needed once. The problem is NP-hard. ``tw.solve`` proves its answer best; HiGHS,
given the same as an integer program, finds the same cost.
"""

from itertools import product

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp

import trackweave as tw

n, rng = 12, np.random.default_rng(1)
lists = rng.uniform(0.0, 100.0, (3, n, 2))
between = [
    np.linalg.norm(lists[a][:, None] - lists[b][None], axis=2) for a, b in ((0, 1), (1, 2), (0, 2))
]
costs = between[0][:, :, None] + between[1][None, :, :] + between[2][:, None, :]
answer = tw.solve(tw.AssignmentProblem.from_array(costs))

triples = np.array(list(product(range(n), repeat=3)))
covers = np.concatenate([triples[:, axis] == np.arange(n)[:, None] for axis in range(3)]).astype(
    float
)
exact = milp(
    costs.ravel(), constraints=LinearConstraint(covers, 1, 1), integrality=1, bounds=Bounds(0, 1)
)

figure, axes = plt.subplots(figsize=(7, 6))
for triple in answer.tuples:
    corners = lists[range(3), triple]
    axes.add_patch(plt.Polygon(corners, alpha=0.25, color="tab:blue"))
for points, mark, name in zip(lists, "os^", ("machines", "workers", "jobs"), strict=True):
    axes.plot(*points.T, mark, ms=7, label=name)
axes.set(aspect="equal", xticks=[], yticks=[])
axes.set_title(f"ours {answer.cost:.3f} ({answer.status.value}), HiGHS {exact.fun:.3f}")
axes.legend(loc="upper left", bbox_to_anchor=(1, 1))
figure.savefig("three_lists.png")
