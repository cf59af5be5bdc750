"""
Two radars, one of them misplaced
=================================

The tracks of the second radar are turned by 1.5 degrees and shifted by 300 m and -200 m, so that
every boat is there twice. From the tracks alone, without being told which are of one boat,
registration finds the shift and the turn, says how sure it is, and puts them right.
"""

import matplotlib.pyplot as plt
import numpy as np

import trackweave as tw

rng, angle = np.random.default_rng(2), np.radians(1.5)
turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
begin, speed = rng.uniform(-8e3, 8e3, (12, 2)), rng.normal(0.0, 8.0, (12, 2))
spread = np.tile(np.diag([400.0, 400.0, 1.0, 1.0]), (12, 1, 1))


def pictures(name, *, wrong):
    for time in np.arange(0.0, 300.0, 10.0):
        place, velocity = begin + time * speed, speed
        if wrong:
            place, velocity = place @ turn.T + [300.0, -200.0], velocity @ turn.T
        state = np.hstack([place, velocity]) + rng.normal(0.0, [20.0, 20.0, 1.0, 1.0], (12, 4))
        yield tw.LocalPicture(name, time, np.arange(12), state, spread)


first, second = (list(pictures(name, wrong=wrong)) for name, wrong in (("A", False), ("B", True)))
model = tw.BiasModel(estimate=("translation", "rotation"))
found = tw.register(first, second, process_noise=0.0, model=model)
mended = [found.apply(picture) for picture in second]

figure, panels = plt.subplots(1, 2, sharex=True, sharey=True, figsize=(10, 4.8))
for axes, other, title in zip(
    panels, (second, mended), ("as they came", "registered"), strict=True
):
    for name, sensor, mark in (("A", first, "."), ("B", other, "x")):
        all_places = np.concatenate([picture.mean[:, :2] for picture in sensor]) / 1e3
        axes.plot(*all_places.T, mark, ms=4, label=f"radar {name}", alpha=0.6)
    axes.set(title=title, xlabel="x [km]", aspect="equal")
panels[0].set_ylabel("y [km]")
panels[0].legend(frameon=True)
said = ", ".join(
    f"turned by {np.degrees(value):.2f}°"
    if name == "rotation"
    else f"shifted by {value:.0f} m in {name[-1]}"
    for name, value in zip(found.names, found.bias, strict=True)
    if value
)
figure.suptitle(f"radar B: {said} (true: 300 m, −200 m, 1.5°)")
figure.savefig("bias.png")
