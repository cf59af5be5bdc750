"""
People on a square
==================

Sixty people cross a square, seen from above and found frame by frame. They stop, turn and pass
each other closely. No configuration is given. Each line is a track, grey dots are detections of
no track; ``result.plot(pixels=True)`` draws it with what the run says of itself.
"""

import matplotlib.pyplot as plt
import numpy as np
import polars as pl

import trackweave as tw

rng, rows = np.random.default_rng(9), []
for who in range(60):
    place, heading = rng.uniform(0.0, (900.0, 600.0)), rng.uniform(0.0, 2.0 * np.pi)
    pace = rng.uniform(2.0, 5.0)  # pixels a frame
    for frame in range(60):
        heading += rng.normal(0.0, 0.12)
        place = place + (
            pace * np.array([np.cos(heading), np.sin(heading)]) if rng.random() < 0.97 else 0.0
        )
        if (place > 0).all() and (place < (900, 600)).all() and rng.random() < 0.93:
            rows.append((frame, *(place + rng.normal(0.0, 1.5, 2)), who))
for frame in range(60):
    rows += [(frame, *rng.uniform(0.0, (900.0, 600.0)), None) for _ in range(rng.poisson(2))]
detections = pl.DataFrame(rows, ["frame", "x", "y", "target"], orient="row").sort("frame")
result = tw.track(detections)

figure, axes = plt.subplots(figsize=(8.5, 5.8))
alone = result.reports.filter(pl.col("track").is_null())
axes.plot(alone["x"], alone["y"], ".", color="0.75", ms=4)
confirmed = result.history.filter(pl.col("status") != "tentative")
for _, path in confirmed.group_by("track", maintain_order=True):
    (line,) = axes.plot(path["x"], path["y"], lw=1.5)
    axes.plot(path["x"][-1], path["y"][-1], "o", color=line.get_color(), ms=4)
n_tracks, n_people = confirmed["track"].n_unique(), detections["target"].n_unique() - 1
axes.set(title=f"{n_people} people were seen, {n_tracks} tracks found; dots are where they end")
axes.set(xlabel="x [pixels]", ylabel="y [pixels]", aspect="equal")
axes.invert_yaxis()
figure.savefig("people.png")
