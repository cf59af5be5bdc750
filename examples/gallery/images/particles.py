"""
Particles that wander
=====================

Beads of three sizes diffuse in a fluid and blink. Tracked as a random walk, the mean squared
displacement of each track over the time passed tells its diffusion coefficient D: it grows by 4 D
a frame, above what the noise of two positions makes of none.
"""

import matplotlib.pyplot as plt
import numpy as np
import polars as pl

import trackweave as tw

rng, rows, sizes = np.random.default_rng(5), [], (0.5, 2.0, 6.0)
for bead in range(45):
    steps = rng.normal(0.0, np.sqrt(2.0 * sizes[bead % 3]), (100, 2))
    path = rng.uniform(0.0, 800.0, 2) + np.cumsum(steps, axis=0)
    for frame in np.flatnonzero(rng.random(100) < 0.9):
        rows.append((frame, *(path[frame] + rng.normal(0.0, 0.5, 2))))
detections = pl.DataFrame(rows, ["frame", "x", "y"], orient="row").sort("frame")
beads = tw.track(detections, {"motion": {"model": "random-walk"}}).reports.drop_nulls("track")

figure, (plan, spread) = plt.subplots(1, 2, figsize=(10, 4.6))
found, lags = [], np.arange(1, 11)
for _, path in beads.group_by("track", maintain_order=True):
    if len(path) < 60:
        continue
    frame, place = path["frame"].to_numpy(), path.select("x", "y").to_numpy()
    whole = np.column_stack([np.interp(np.arange(100), frame, axis) for axis in place.T])
    msd = [np.mean(np.sum((whole[lag:] - whole[:-lag]) ** 2, axis=1)) for lag in lags]
    found.append(np.polyfit(lags, msd, 1)[0] / 4.0)
    color = f"C{np.argmin(np.abs(np.log(found[-1] / np.array(sizes))))}"
    plan.plot(*place.T, lw=0.8, color=color)
    spread.loglog(lags, msd, lw=0.8, color=color)
for number, size in enumerate(sizes):
    near = [each for each in found if np.argmin(np.abs(np.log(each / np.array(sizes)))) == number]
    said = f"D {size:g}: {np.mean(near):.2f} ± {np.std(near):.2f} found"
    spread.loglog(lags, 4.0 * size * lags + 4.0 * 0.5**2, "--", color="k", lw=1)
    spread.plot([], [], color=f"C{number}", label=said)
spread.legend()
plan.set(
    xlabel="x [pixels]", ylabel="y [pixels]", aspect="equal", title=f"{len(found)} beads followed"
)
spread.set(
    xlabel="frames passed",
    ylabel="mean squared displacement [pixels²]",
    title="dashed: as simulated",
)
figure.savefig("particles.png")
