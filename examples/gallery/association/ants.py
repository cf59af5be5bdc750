"""
Ants on plots of several sensors
================================

Wiranto and Bonok (2018) let ants walk over the plots of three radars: a tour names plots in turn,
decoded into groups, one plot of each radar at most; cheap tours lay more pheromone. By themselves
ants soon agree on what is only good. Where prices come first (``seeded``), they prove the answer
here before an ant has to walk.
"""

import matplotlib.pyplot as plt
import numpy as np

import trackweave as tw
from trackweave.association.plots_rule import scene_plots
from trackweave.simulation.scenes import PositionKind, draw_scene

scene = draw_scene(PositionKind(n_sensors=3, n_objects=12, spacing=5.0), rng=5)
rule = tw.PlotsRule(object_density=scene.object_density, area=scene.area, negative_only=True)
found = rule(scene_plots(scene))
problem = found.problem()
kinds = {
    "ants alone": tw.AntSystem(decompose=False, evaluations=4_000),
    "less fixed on trails": tw.AntSystem(
        pheromone_weight=0.5, visibility_weight=3.0, decompose=False, evaluations=4_000, cycles=200
    ),
    "prices first": tw.AntSystem(seeded=True, decompose=False, evaluations=4_000),
}
figure, (course, plan) = plt.subplots(1, 2, figsize=(10, 4.6))
for name, ants in kinds.items():
    state, tried, cost = ants.start(problem, rng=1), [], []
    while not state.done and state.evaluations < 4_000:
        state = ants.advance(state, evaluations=100)
        tried.append(state.evaluations)
        cost.append(ants.answer(state).cost)
    last = ants.answer(state).cost
    course.step(
        [*(tried or [0]), 4_000],
        [*(cost or [last]), last],
        where="post",
        label=f"{name}: {last:.1f}",
        lw=3 if ants.seeded else 1.5,
    )
# What is proven lies on the bound: the bound is drawn over it, thin.
course.axhline(tw.solve(problem).lower_bound, color="k", ls=":", lw=1.2, label="lower bound")
course.set(xlabel="tours", ylabel="cost [nats]", title="The best tour so far")
course.legend()
for plots, mark, number in zip(scene.plots, "os^", (1, 2, 3), strict=True):
    plan.plot(*plots.T, mark, ms=5, alpha=0.7, label=f"radar {number}")
answer = ants.answer(state)
for row in problem.row[answer.nodes]:
    group = [scene.plots[k][plot - 1] for k, plot in enumerate(found.tuples[row]) if plot]
    plan.plot(*np.array([*group, group[0]]).T, color="k", lw=1)
plan.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title="The groups, prices first")
plan.legend(frameon=True, fontsize=8)
figure.savefig("ants.png")
