"""
Live, step by step
==================

A live tracker takes one scan at a time and says after each where every object is. Three moments
of one stream: the tracks that were confirmed by then, each with the way it has come since, over
the reports of the latest scan. An object that appears is confirmed some scans later, and false
alarms come to nothing.

The page can be downloaded as a notebook (``.ipynb``, below). Live in a notebook is the same loop
in a cell: keep the tracker in one cell, step it in another, and draw into the same figure with
``IPython.display.display(figure, clear=True)`` after each scan.
"""

import matplotlib.pyplot as plt
import numpy as np

import trackweave as tw
from trackweave.simulation import Area, RandomTargets, Scenario, SimulatedSensor, simulate

scene = Scenario(
    area=Area((0.0, 0.0), (800.0, 800.0)),
    duration=39.0,
    sensors=(SimulatedSensor("radar", sigma=8.0, scan_period=1.0, clutter_per_scan=15.0),),
    random=RandomTargets(count=8, speed=(8.0, 15.0), birth_rate=0.1),
)
tracker = tw.MultiHypothesisTracker.from_config({
    "motion": {"process_noise": 0.05, "max_speed": 20.0},
    "sensors": {"radar": {"sigma": 8.0, "scan_period": 1.0, "clutter_density": 15.0 / 800.0**2}},
})  # fmt: skip
figure, panels = plt.subplots(1, 3, sharex=True, sharey=True, figsize=(11, 4.2))
moments, ways = dict(zip((4.0, 14.0, 39.0), panels, strict=True)), {}
for scan in simulate(scene, rng=6).reports.scans():
    said = tracker.step(scan, rng=1).tracks
    for row in np.flatnonzero(said.status != 0):  # tentative ones may be false alarms
        ways.setdefault(int(said.track[row]), []).append(said.mean[row, :2])
    if scan.time in moments:
        axes = moments[scan.time]
        axes.plot(*scan.measurement.T, "x", color="0.6", ms=4, label="this scan's reports")
        for number, way in ways.items():
            axes.plot(*np.transpose(way), color=f"C{number % 10}", lw=2)
            if number in said.track:
                axes.plot(*way[-1], "o", color=f"C{number % 10}", ms=5)
        axes.set(title=f"after {scan.time:.0f} s: {len(ways)} tracks so far", xlabel="x [m]")
        axes.set_aspect("equal")
panels[0].set_ylabel("y [m]")
panels[0].legend(loc="upper left", frameon=True, fontsize=8)
figure.savefig("live.png")
