"""
Cells that divide
=================

Cells creep and divide; the segmentation misses one in thirty. After the run, tracks that came of
others are looked for, all at once: a mother ends, and both her daughters have new numbers. Left
the places, right the family tree as it was found.
"""

import matplotlib.pyplot as plt
import numpy as np
import polars as pl

import trackweave as tw

rng, rows = np.random.default_rng(6), []
cells = [(rng.uniform(80, 420, 2), rng.integers(12, 30)) for _ in range(4)]
for frame in range(60):
    alive = []
    for place, divides in cells:
        place = place + rng.normal(0.0, 1.2, 2)
        if divides > frame:
            alive.append((place, divides))
        else:
            angle = rng.uniform(0.0, 2.0 * np.pi)
            off = 8.0 * np.array([np.cos(angle), np.sin(angle)])
            alive += [(place + side * off, frame + rng.integers(22, 34)) for side in (1, -1)]
    pushed = []
    for place, divides in alive:
        apart = [place - other for other, _ in alive]
        push = sum(away / max(np.hypot(*away), 6.0) for away in apart)
        pushed.append((np.clip(place + 0.4 * push, 0, 500), divides))
    cells = pushed
    rows += [
        (frame, *(place + rng.normal(0, 0.8, 2))) for place, _ in cells if rng.random() < 0.97
    ]
detections = pl.DataFrame(rows, ["frame", "x", "y"], orient="row")
result = tw.track(detections, {"lifecycle": {"divide": True}})
history = result.history

figure, (plan, tree) = plt.subplots(1, 2, figsize=(10, 4.8))
row = {track: k for k, track in enumerate(history["track"].unique(maintain_order=True))}
for (track,), path in history.group_by("track", maintain_order=True):
    (line,) = plan.plot(path["x"], path["y"], lw=1.5)
    time, parent = path["time"], path["parent"][0]
    tree.plot([time[0], time[-1]], [row[track]] * 2, lw=3, color=line.get_color())
    if parent is not None:
        tree.plot([time[0]] * 2, [row[parent], row[track]], color="0.5", lw=1)
plan.set(xlabel="x [pixels]", ylabel="y [pixels]", xlim=(0, 500), ylim=(0, 500))
divisions = history.drop_nulls("parent")["parent"].n_unique()
tree.set(xlabel="frame", yticks=[], title=f"{len(row)} tracks, {divisions} divisions")
figure.savefig("cells.png")
