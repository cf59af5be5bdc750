"""
A radar's evening
=================

Ten minutes of a turning radar: ranges and azimuths, each plot with the time at which the beam met
it, forty aircraft, misses and false alarms. Nothing else is told than where the radar stands.
Grey are the plots, in colour the tracks.
"""

import matplotlib.pyplot as plt
import numpy as np
import polars as pl

import trackweave as tw

rng, turn, reach = np.random.default_rng(11), 10.0, 120e3
begin, heading = rng.uniform(-90e3, 90e3, (40, 2)), rng.uniform(0.0, 2.0 * np.pi, 40)
velocity = rng.uniform(120.0, 240.0, (40, 1)) * np.column_stack([np.sin(heading), np.cos(heading)])
plots = []
for k in range(60):
    for place, speed in zip(begin, velocity, strict=True):
        now = place + speed * turn * k
        share = (np.arctan2(*now) % (2 * np.pi)) / (
            2 * np.pi
        )  # of the turn, when the beam is there
        now = now + speed * turn * share
        if np.hypot(*now) < reach and rng.random() < 0.93:
            plots.append((turn * (k + share), np.hypot(*now) + rng.normal(0, 60.0),
                          np.degrees(np.arctan2(*now)) + rng.normal(0, 0.08)))  # fmt: skip
    for share in rng.random(rng.poisson(15)):
        plots.append((turn * (k + share), reach * np.sqrt(rng.random()), 360.0 * share))
plots = pl.DataFrame(plots, ["time", "range_m", "azimuth_deg"], orient="row")
plots = plots.with_columns(pl.col("azimuth_deg") % 360.0).sort("time")
result = tw.track(plots, {"sensors": {"default": {"position": [0.0, 0.0]}}})

figure, axes = plt.subplots(figsize=(7, 7))
azimuth, far = np.radians(plots["azimuth_deg"].to_numpy()), plots["range_m"].to_numpy() / 1e3
axes.plot(far * np.sin(azimuth), far * np.cos(azimuth), ".", color="0.8", ms=2.5)
for _, path in result.history.group_by("track", maintain_order=True):
    axes.plot(path["x"] / 1e3, path["y"] / 1e3, lw=1.8)
for radius in (40, 80, 120):
    axes.add_patch(plt.Circle((0, 0), radius, fill=False, color="0.6", lw=0.6))
axes.plot(0, 0, "k^")
axes.set(xlabel="x [km]", ylabel="y [km]", aspect="equal")
axes.set_title(f"{len(plots):,} plots, {result.run['totals']['tracks']} tracks")
figure.savefig("radar_evening.png")
