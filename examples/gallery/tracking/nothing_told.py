"""
Nothing told, everything estimated
==================================

Without a configuration, noise, clutter, detection probability and motion are estimated from the
reports alone, and the run says so; in a crowd it says that some value had better be told. Each
dot is one of nine scenes with its own noise and clutter, drawn against what the scene really had.
"""

import matplotlib.pyplot as plt

import trackweave as tw
from trackweave.simulation import Area, RandomTargets, Scenario, SimulatedSensor, simulate

figure, panels = plt.subplots(1, 3, figsize=(10, 3.6))
for sigma, clutter, detected in [
    (s, c, p) for s in (5.0, 10.0, 20.0) for c, p in ((5, 0.95), (10, 0.9), (20, 0.85))
]:
    scene = Scenario(
        area=Area((0.0, 0.0), (3000.0, 3000.0)),
        duration=60.0,
        sensors=(SimulatedSensor("radar", sigma, 2.0, detected, clutter),),
        random=RandomTargets(count=15, speed=(5.0, 20.0)),
    )
    run = tw.track(simulate(scene, rng=3).reports).run
    found = run["configuration"]["sensors"]["radar"]
    density = clutter / 3000.0**2 * 1e6
    for axes, real, estimated in zip(
        panels,
        (sigma, detected, density),
        (found["sigma"], found["detection_probability"], found["clutter_density"] * 1e6),
        strict=True,
    ):
        estimated = max(estimated.values()) if isinstance(estimated, dict) else estimated
        axes.plot(real, estimated, "o", color="tab:blue", alpha=0.6)
for axes, name in zip(
    panels, ("noise [m]", "detection probability", "false alarms per km² and scan"), strict=True
):
    low, high = axes.get_xlim()
    axes.plot([low, high], [low, high], "k--", lw=0.8)
    axes.set(title=name, xlabel="in the scene (dashed: right)", aspect="equal")
panels[0].set_ylabel("estimated")
figure.savefig("nothing_told.png")
