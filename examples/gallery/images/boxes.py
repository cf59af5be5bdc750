"""
Boxes of a detector
===================

Two people walk past each other behind a pillar; the detector misses some boxes and finds others
where nobody is. ``BoxTracker`` gives the same person the same name in all frames. Every eighth
frame is drawn, a colour for each name; grey boxes are of nobody.
"""

import matplotlib.pyplot as plt
import numpy as np

import trackweave as tw

rng = np.random.default_rng(4)
tracker = tw.BoxTracker(period=0.04)
figure, panels = plt.subplots(2, 4, sharex=True, sharey=True, figsize=(10, 4.2))
colours = {}
for k in range(65):
    middle = np.array(
        [[20.0 + 5.5 * k, 105.0], [390.0 - 5.5 * k, 115.0], [*rng.uniform(0, (400, 200))]]
    )
    middle += rng.normal(0.0, 1.0, middle.shape)
    half = np.array([[16.0, 42.0], [18.0, 46.0], [14.0, 30.0]])
    boxes = np.hstack([middle - half, middle + half])
    seen = rng.random(3) < [0.92, 0.92, 0.4]
    seen[:2] &= np.abs(middle[:2, 0] - 205.0) > 25.0  # behind the pillar
    frame = tracker.update(boxes[seen], np.array([0.9, 0.85, 0.35])[seen])
    if k % 8:
        continue
    axes = panels.flat[k // 8] if k < 64 else None
    if axes is None:
        break
    axes.add_patch(plt.Rectangle((185, 0), 40, 200, color="0.9"))
    for (left, top, right, bottom), name in zip(boxes[seen], frame.identifiers, strict=True):
        colour = "0.6" if name < 0 else colours.setdefault(name, f"C{len(colours)}")
        axes.add_patch(
            plt.Rectangle((left, top), right - left, bottom - top, fill=False, ec=colour, lw=2)
        )
        if name >= 0:
            axes.text((left + right) / 2, top - 4, name, color=colour, ha="center")
    axes.set(title=f"frame {k}", xlim=(0, 410), ylim=(200, 0), xticks=[], yticks=[])
    axes.grid(visible=False)
figure.savefig("boxes.png")
