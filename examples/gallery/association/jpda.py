"""
Probabilities, as a JPDA has them
=================================

Two tracks, four reports, and every way to explain them: each report is of one track or a false
alarm. The cheapest hypotheses, as ``MBest`` ranks them, weighed by exp(-cost), give each pairing
the probability that joint probabilistic data association sums over *all* of them; the title says
how far the two are apart.
"""

from itertools import product

import matplotlib.pyplot as plt
import numpy as np

import trackweave as tw

tracks = np.array([[0.0, 0.0], [30.0, 8.0]])
reports = np.array([[6.0, -9.0], [15.0, 6.0], [36.0, 16.0], [48.0, -12.0]])
sigma, detected, clutter = 12.0, 0.9, 1e-4
away = np.linalg.norm(tracks[:, None] - reports[None], axis=2)
odds = detected / clutter * np.exp(-0.5 * (away / sigma) ** 2) / (2 * np.pi * sigma**2)
rows = [[i + 1, j + 1] for i, j in product(range(2), range(4))] + [[1, 0], [2, 0]]
costs = np.append(-np.log(odds).ravel(), [-np.log(1 - detected)] * 2)
problem = tw.AssignmentProblem.from_tuples(rows, costs, alone=[np.inf, np.inf, 0, 0, 0, 0])
ranking = tw.MBest(hypotheses=100).rank(problem)

jpda, ways = np.zeros((2, 4)), 0.0
for first, second in product(range(-1, 4), repeat=2):  # -1: the track was missed
    if first != second or first < 0:
        weight = np.prod(
            [odds[i, j] if j >= 0 else 1 - detected for i, j in enumerate((first, second))]
        )
        ways += weight
        for i, j in enumerate((first, second)):
            jpda[i, j] += weight * (j >= 0)
jpda /= ways
ours = np.zeros((2, 4))
for node, row in enumerate(problem.row):
    if 0 <= row < 8:
        ours.flat[row] += ranking.probability[node]

figure, axes = plt.subplots(figsize=(8, 4.6))
for i, j in product(range(2), range(4)):
    axes.plot(
        *np.array([tracks[i], reports[j]]).T, color="tab:blue", lw=8 * ours[i, j] + 0.2, alpha=0.5
    )
    axes.text(
        *(0.62 * reports[j] + 0.38 * tracks[i]), f"{ours[i, j]:.2f}", ha="center", va="center",
        fontsize=9, bbox={"color": "white", "pad": 1.0},
    )  # fmt: skip
axes.plot(*tracks.T, "s", color="k", ms=9, label="tracks, as predicted")
axes.plot(*reports.T, "o", color="tab:red", ms=8, label="reports")
axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
axes.set_title(
    f"{len(ranking.cost)} hypotheses; greatest difference to JPDA {np.abs(ours - jpda).max():.0e}"
)
axes.legend(loc="upper left")
figure.savefig("jpda.png")
