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
mother = dict(history.group_by("track").agg(pl.first("parent")).sort("track").iter_rows())


def between_daughters(track):
    """Return a family in the order in which no line crosses another: mothers between daughters."""
    daughters = [each for each, its_mother in mother.items() if its_mother == track]
    families = [between_daughters(each) for each in daughters] or [[]]
    return [*families[0], track, *(each for family in families[1:] for each in family)]


first = [track for track, its_mother in mother.items() if its_mother is None]
order = [(track, f"C{k}") for k, each in enumerate(first) for track in between_daughters(each)]
for place, (track, color) in enumerate(order):
    path = history.filter(track=track)
    plan.plot(path["x"], path["y"], lw=1.5, color=color)
    time = path["time"]
    tree.plot([time[0], time[-1]], [place] * 2, lw=3, color=color)
    if mother[track] is not None:
        up = [each for each, _ in order].index(mother[track])
        tree.plot([time[0]] * 2, [up, place], color=color, lw=1)
plan.set(
    xlabel="x [pixels]", ylabel="y [pixels]", aspect="equal", title="a colour for each family"
)
divisions = history.drop_nulls("parent")["parent"].n_unique()
tree.set(xlabel="frame", yticks=[], title=f"{len(order)} tracks, {divisions} divisions")
figure.savefig("cells.png")
