"""
Silent objects keep their names
===============================

An island hides two of five boats for a minute. Misses in a row are no proof that an object is
gone: it may be hidden, and how often and how long objects hide is learned. Rows of a track stop
while too little is known; the name is taken up again on the other side.
"""

import matplotlib.pyplot as plt
import numpy as np
import polars as pl

import trackweave as tw
from trackweave.simulation import Area, Scenario, SimulatedSensor, Target, simulate

scene = Scenario(
    area=Area((0.0, 0.0), (2400.0, 1000.0)),
    duration=198.0,
    sensors=(SimulatedSensor("radar", sigma=8.0, scan_period=2.0, clutter_per_scan=3.0),),
    targets=tuple(Target((100.0, 140.0 + 170.0 * k), (11.0 - 0.2 * k, 0.3 * k)) for k in range(5)),
)
simulation = simulate(scene, rng=1)
x, y = simulation.reports.measurement.T
hidden = (np.abs(x - 1200.0) < 330.0) & (np.abs(y - 400.0) < 170.0)
reports = pl.DataFrame({"time": simulation.reports.time, "x": x, "y": y}).filter(~hidden)
result = tw.track(reports)

figure, axes = plt.subplots(figsize=(9, 4.4))
axes.add_patch(plt.Rectangle((870.0, 230.0), 660.0, 340.0, color="0.88"))
axes.text(1200.0, 400.0, "hidden", ha="center", va="center", color="0.5")
axes.plot(x[~hidden], y[~hidden], ".", color="0.8", ms=3)
for (name,), path in result.tracks.filter(result.tracks["status"] != "tentative").group_by(
    "track", maintain_order=True
):
    (line,) = axes.plot(path["x"], path["y"], ".", ms=4)
    axes.annotate(
        f"track {name}",
        path.select("x", "y").row(-1),
        color=line.get_color(),
        ha="right",
        va="bottom",
    )
axes.set(
    xlim=(0, 2400),
    xlabel="x [m]",
    ylabel="y [m]",
    title=f"{result.run['totals']['tracks']} tracks of 5 boats",
)
figure.savefig("silences.png")
