"""
What a gap is
=============

A search that gets no better has found the best, or is stuck: from its answers alone nobody can
tell. Prices on the reports give a *lower bound* that no answer can beat. How far apart the two
are, as a share of the cost, is the *gap*: where it closes, the answer is proven. Two searches
from scratch, each with ever more work, against the bound; the default begins with the prices, and
proves its answer.
"""

import matplotlib.pyplot as plt
import numpy as np

import trackweave as tw
from trackweave.association.plots_rule import scene_plots
from trackweave.simulation.scenes import PositionKind, draw_scene

scene = draw_scene(PositionKind(n_sensors=4, n_objects=40, spacing=3.0), rng=3)
rule = tw.PlotsRule(object_density=scene.object_density, area=scene.area, negative_only=True)
problem = rule(scene_plots(scene)).problem()

figure, axes = plt.subplots(figsize=(8, 4.6))
best, budgets = tw.solve(problem), np.geomspace(500, 64_000, 8).astype(int)
for name, kind in {"annealing": tw.Annealing, "genes": tw.Genetic}.items():
    searches = [kind(seeded=False, decompose=False, evaluations=int(budget)) for budget in budgets]
    costs = [tw.solve(problem, search, rng=1).cost for search in searches]
    gaps = 100.0 * (np.array(costs) - best.lower_bound) / np.abs(costs)
    (line,) = axes.loglog(budgets, gaps, "o-", label=f"{name} from scratch")
    axes.annotate(
        f"gap {gaps[-1]:.2f} %",
        (budgets[-1], gaps[-1]),
        (-4, 8 if name == "genes" else -14),
        color=line.get_color(),
        textcoords="offset points",
        ha="right",
    )
said = f"auto: proven after {best.evaluations:,} answers"
axes.plot(best.evaluations, 0.05, "s", color="tab:green", ms=9, label=said)
axes.annotate("gap 0: proven", (best.evaluations, 0.05), (10, -3), textcoords="offset points")
# A logarithm has no 0: it stands below the axis' last mark.
axes.set(xlabel="answers tried", ylabel="gap: cost above the lower bound [%]", ylim=(0.03, None))
axes.set_yticks([0.05, 0.1, 1.0, 10.0, 100.0], ["0", "0.1", "1", "10", "100"])
axes.minorticks_off()
axes.set_title(f"auto: cost {best.cost:.2f}, bound {best.lower_bound:.2f}, {best.status.value}")
axes.legend(loc="upper right")
figure.savefig("gap.png")
