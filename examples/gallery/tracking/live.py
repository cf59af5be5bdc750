"""
Live, step by step
==================

A live tracker takes one scan at a time. After each it says which tracks there are, how its
earlier answers changed (*amendments*), which reports are decided for good, and how far its answer
can be from the best (*gap*). A window of six scans means that a report is final six scans after
it came.
"""

import matplotlib.pyplot as plt

import trackweave as tw
from trackweave.simulation import Area, RandomTargets, Scenario, SimulatedSensor, simulate

scene = Scenario(
    area=Area((0.0, 0.0), (800.0, 800.0)),
    duration=39.0,
    sensors=(SimulatedSensor("radar", sigma=10.0, scan_period=1.0, clutter_per_scan=25.0),),
    random=RandomTargets(count=25, speed=(5.0, 15.0)),
)
tracker = tw.MultiHypothesisTracker.from_config({
    "motion": {"process_noise": 0.05, "max_speed": 20.0},
    "sensors": {"radar": {"sigma": 10.0, "scan_period": 1.0, "clutter_density": 25.0 / 800.0**2}},
    "window": {"depth": 6},
})  # fmt: skip
told = []
for scan in simulate(scene, rng=6).reports.scans():
    said = tracker.step(scan, rng=1)
    confirmed = int((said.tracks.status == 1).sum())
    told.append(
        (said.time, confirmed, len(said.amendments), said.n_sequences, 100 * said.certificate.gap)
    )
time, confirmed, amended, sequences, gap = zip(*told, strict=True)

names = {"confirmed tracks (25 are there)": confirmed, "reports amended": amended,
         "sequences to choose from": sequences, "gap [%]: 0 is proven best": gap}  # fmt: skip
figure, panels = plt.subplots(2, 2, sharex=True, figsize=(9, 5))
for axes, (name, values) in zip(panels.flat, names.items(), strict=True):
    axes.step(time, values, where="mid")
    axes.set_title(name)
panels[1, 1].set_ylim(-0.05, 1.0)
panels[1, 0].set_xlabel("time [s]")
panels[1, 1].set_xlabel("time [s]")
figure.savefig("live.png")
