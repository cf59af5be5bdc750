"""
Bearings and ghosts
===================

Five direction finders see ten objects. Every pair of bearings crosses somewhere, and most
crossings are ghosts. Which bearings belong together is an assignment problem over all sensors at
once: the circles are the objects that it finds, the crosses where they are.
"""

import matplotlib.pyplot as plt
import numpy as np

import trackweave as tw
from trackweave.association.plots_rule import scene_plots
from trackweave.simulation.scenes import BearingKind, draw_scene

scene = draw_scene(BearingKind(n_sensors=5, n_objects=10, sigma=0.001), rng=4)
rule = tw.PlotsRule(object_density=scene.object_density, area=scene.area, negative_only=True)
found = rule(scene_plots(scene))
answer = tw.solve(found.problem())
places = found.positions[found.problem().row[answer.nodes]]

figure, axes = plt.subplots(figsize=(7, 6.5))
for place, bearings in zip(scene.places, scene.plots, strict=True):
    for bearing in bearings:
        away = 20e3 * np.array([np.sin(bearing), np.cos(bearing)])
        axes.plot(*np.transpose([place, place + away]) / 1e3, color="0.85", lw=0.7, zorder=0)
axes.plot(*found.positions.T[:2] / 1e3, ".", color="0.6", ms=3, label="candidates")
axes.plot(*scene.places.T / 1e3, "k^", ms=8, label="direction finders")
axes.plot(*scene.objects.T / 1e3, "x", color="tab:red", ms=8, mew=2, label="objects")
axes.plot(*places.T / 1e3, "o", mfc="none", color="tab:blue", ms=15, mew=1.5, label="found")
limit = 1.02 * np.array([-1, 1]) * np.abs(scene.places).max() / 1e3 + np.mean(scene.area) / 1e3
axes.set(xlabel="x [km]", ylabel="y [km]", xlim=limit, ylim=limit, aspect="equal")
found_all = f"{len(places)} of {len(scene.objects)} found"
axes.set_title(f"{len(found.tuples)} candidate groups, {found_all}, gap {answer.gap:.2g}")
axes.grid(visible=False)
axes.legend(loc="upper right", frameon=True)
figure.savefig("ghosts.png")
