"""
People on a square
==================

Sixty people cross a square, seen from above and found frame by frame. They stop, turn and pass
each other closely. No configuration is given; the picture is the library's own, with
``pixels=True``: tracks, detections of no track, and what the run says of itself.
"""

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

figure = result.plot(pixels=True, history=True)
figure.savefig("people.png")
