"""
Reports that are wild
=====================

One report in five of this sensor is four times as wrong as the others: reflections, half a
target, a slip. A filter that takes all errors for normal lets such a report pull its track away,
or loses it. Told or learned how heavy the tails are (``tail_share``, ``tail_scale``), the filter
believes a wild report as little as it deserves.
"""

import matplotlib.pyplot as plt
import numpy as np
import polars as pl

import trackweave as tw

rng = np.random.default_rng(7)
time = np.arange(120.0)
true = np.column_stack([9.0 * time, 300.0 + 120.0 * np.sin(time / 22.0)])
wild = rng.random(len(time)) < 1 / 5
seen = true + rng.normal(0.0, np.where(wild, 24.0, 6.0)[:, None], true.shape)
reports = pl.DataFrame({"time": time, "x": seen[:, 0], "y": seen[:, 1]})
sensor = {"sigma": 6.0, "clutter_density": 1e-7, "scan_period": 1.0, "detection_probability": 0.98}
cases = {"all errors normal": 0.0, "one in five is wild": 1 / 5}

figure, (plan, error) = plt.subplots(2, 1, figsize=(9, 6))
plan.plot(*seen[~wild].T, ".", color="0.6", ms=4, label="reports")
plan.plot(*seen[wild].T, "x", color="tab:red", ms=6, label="wild ones")
for (name, share), colour in zip(cases.items(), ("tab:orange", "tab:blue"), strict=True):
    told = {"tail_share": share, "tail_scale": 4.0}
    result = tw.track(
        reports, {"motion": {"process_noise": 0.5}, "sensors": {"default": sensor | told}}
    )
    path = result.tracks.select("time", "x", "y").to_numpy()
    off = np.linalg.norm(path[:, 1:] - true[path[:, 0].astype(int)], axis=1)
    plan.plot(path[:, 1], path[:, 2], color=colour, lw=1.2)
    error.plot(
        path[:, 0], off, color=colour, label=f"{name}: {np.sqrt(np.mean(off**2)):.1f} m RMS"
    )
plan.set(xlabel="x [m]", ylabel="y [m]", ylim=(100, 500))
plan.legend(ncols=2)
error.set(xlabel="time [s]", ylabel="error of the track [m]")
error.legend()
figure.savefig("heavy_tails.png")
