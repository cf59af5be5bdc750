"""
The patent's figures, decoded
=============================

US patent 6,055,523 (Hillis, filed 1997) writes a hypothesis as a string of reports, ``D2,1``
being the second report of the third scan. Read from the left, a report of a later scan goes on
with the track before it; any other begins one. Two of its strings, in places of our own, and what
the library chooses from the same reports.
"""

import matplotlib.pyplot as plt
import numpy as np

import trackweave as tw

places = {
    "D0,0": (0, 0), "D0,1": (100, 0), "D0,2": (200, 0), "D1,0": (40, 50),
    "D1,1": (160, 50), "D2,0": (-20, 100), "D2,1": (120, 100),
}  # fmt: skip


def decoded(string):
    tracks = []
    for name in string.split("-"):
        if tracks and name[1] > tracks[-1][-1][1]:  # of a later scan
            tracks[-1].append(name)
        else:
            tracks.append([name])
    return tracks


names = list(places)
tracker = tw.MultiHypothesisTracker(
    motion=tw.ConstantVelocity(process_noise=1.0, max_speed=100.0),
    sensors=[tw.Sensor("radar", sigma=8.0, clutter_density=1e-6, scan_period=1.0)],
)
for scan in "012":
    reports = [place for name, place in places.items() if name[1] == scan]
    tracker.step(tw.Scan(time=float(scan), sensor="radar", measurement=np.array(reports, float)))
pending, chosen = tracker.pending(), {}
for report, track in zip(pending.report, pending.track, strict=True):
    if track >= 0:
        chosen.setdefault(track, []).append(names[report])
drawings = {
    "Figure 3": decoded("D0,1-D1,0-D0,2-D1,1-D0,0"),
    "Figure 4": decoded("D0,1-D1,0-D2,0-D0,2-D1,1-D2,1-D0,0"),
    "what the library chooses": list(chosen.values()),
}
figure, panels = plt.subplots(1, 3, sharey=True, figsize=(10, 3.8))
for axes, (title, tracks) in zip(panels, drawings.items(), strict=True):
    for track in tracks:
        axes.plot(*np.transpose([places[name] for name in track]), "o-", lw=2)
    for name, (x, y) in places.items():
        if not any(name in track for track in tracks):
            axes.plot(x, y, "o", mfc="none", mec="0.5")  # of no track
        axes.annotate(
            name, (x, y), xytext=(-8, 0), textcoords="offset points", ha="right", va="center",
            fontsize=8,
        )  # fmt: skip
    axes.set(title=title, xlim=(-110, 240), ylim=(-15, 120), xlabel="x [m]")
panels[0].set_ylabel("y [m], up with each scan")
figure.savefig("patent.png")
