"""
Crossing targets, told apart by a window
========================================

Three boats cross at a small angle, among false alarms. Whoever decides each scan for good takes
one boat for another where their reports lie the wrong way round, and stays with it. A window
keeps the last scans open, and settles who was who once the boats have parted.
"""

import matplotlib.pyplot as plt

import trackweave as tw
from trackweave.simulation import Area, Crossing, Scenario, SimulatedSensor, simulate

scene = Scenario(
    area=Area((0.0, 0.0), (700.0, 300.0)),
    duration=59.0,
    sensors=(SimulatedSensor("radar", sigma=9.0, scan_period=1.0, clutter_per_scan=3.0),),
    crossings=(Crossing((350.0, 150.0), time=30.0, speed=11.0, count=3, angle_deg=16.0),),
)
simulation = simulate(scene, rng=4)
known = {
    "motion": {"process_noise": 0.05, "max_speed": 20.0},
    "sensors": {"radar": {"sigma": 9.0, "clutter_per_scan": 3.0, "scan_period": 1.0}},
}
figure, panels = plt.subplots(2, 1, sharex=True, sharey=True, figsize=(8, 6))
for axes, kind in zip(panels, ("nearest-neighbour", "multi-hypothesis"), strict=True):
    result = tw.track(simulation.reports, {**known, "tracker": {"kind": kind}})
    judged = result.evaluate(simulation.truth)
    axes.plot(*simulation.reports.measurement.T, ".", color="0.8", ms=4)
    known_then = result.tracks.filter(result.tracks["status"] != "tentative")
    for _, path in known_then.group_by("track", maintain_order=True):
        axes.plot(path["x"], path["y"], lw=2)
    for target in sorted(set(simulation.truth.target)):
        true = simulation.truth.position[simulation.truth.target == target]
        axes.plot(*true.T, "k--", lw=1, zorder=3, label="truth")
    axes.set(title=f"{kind}: {judged.switches} switches, IDF1 {judged.idf1:.2f}", ylabel="y [m]")
panels[1].set_xlabel("x [m]")
panels[0].legend(*(each[:1] for each in panels[0].get_legend_handles_labels()), loc="upper right")
figure.savefig("crossing.png")
