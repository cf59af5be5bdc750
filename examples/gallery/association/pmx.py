"""
Partially matched crossover
===========================

Huo and others (2008) search the pairing of tracks with genes: a permutation for each sensor. A
child takes a stretch of one parent; a gene that this would make double becomes the one that it
was exchanged for, so that a child is a permutation again. Below, how ``ListGenetic`` gets on with
it on a problem of four lists.
"""

import matplotlib.pyplot as plt
import numpy as np

import trackweave as tw

first, second, begin, end = [0, 1, 2, 3, 4, 5, 6, 7], [3, 7, 5, 1, 6, 0, 2, 4], 2, 5
child = first[:begin] + second[begin:end] + first[end:]
for place in [*range(begin), *range(end, 8)]:
    while child[place] in second[begin:end]:
        child[place] = first[second.index(child[place])]

n, rng = 12, np.random.default_rng(3)
points = rng.uniform(0.0, 100.0, (n, 2)) + rng.normal(0.0, 6.0, (4, n, 2))
apart = [np.linalg.norm(points[k][:, None] - points[k + 1][None], axis=2) for k in range(3)]
costs = apart[0][:, :, None, None] + apart[1][None, :, :, None] + apart[2][None, None]
problem = tw.AssignmentProblem.from_array(costs)
search = tw.ListGenetic(seeded=False, decompose=False, improvement=False, evaluations=40_000)
state, tried, cost = search.start(problem, rng=1), [], []
while not state.done and state.evaluations < 40_000:
    state = search.advance(state, evaluations=500)
    tried.append(state.evaluations)
    cost.append(search.answer(state).cost)

figure, (genes, course) = plt.subplots(2, 1, figsize=(8, 5.5), height_ratios=(1, 1.3))
for row, (name, values) in enumerate({"first": first, "second": second, "child": child}.items()):
    for place, gene in enumerate(values):
        taken = begin <= place < end and name != "first"
        mended = name == "child" and not taken and gene != first[place]
        colour = "tab:orange" if taken else "tab:green" if mended else "tab:blue"
        genes.add_patch(plt.Rectangle((place, -row), 0.92, 0.8, color=colour, alpha=0.45))
        genes.text(place + 0.46, 0.4 - row, gene, ha="center", va="center")
    genes.text(-0.2, 0.4 - row, name, ha="right", va="center")
genes.set(xlim=(-1.6, 8), ylim=(-2.1, 0.9))
genes.axis("off")
course.plot(tried, cost, label="best of the population")
course.axhline(tw.solve(problem).lower_bound, color="k", ls="--", lw=1, label="lower bound")
course.set(xlabel="answers tried", ylabel="cost [m]")
course.legend()
figure.savefig("pmx.png")
