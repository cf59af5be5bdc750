"""
A study, with intervals
=======================

Is one tracker better than another, or was it lucky? Both see the same six scenes at each
density of false alarms; bars are 95 % intervals. On the left the means: scenes differ, and where
bars overlap, as with two and with eight false alarms, they tell nothing. On the right how much
is lost in the same scene: a bar that does not reach 0 was no luck.
"""

import matplotlib.pyplot as plt
import numpy as np
import polars as pl

import trackweave as tw

scene = {
    "duration": 36.0,
    "process_noise": 0.1,
    "area": {"low": [0.0, 0.0], "high": [800.0, 800.0]},
    "sensors": [{"name": "radar", "sigma": 10.0, "scan_period": 2.0}],
    "random": {"count": 6, "speed": [5.0, 15.0]},
}
swept = {"sensors": {"clutter_per_scan": [2, 8, 24]}}
result = tw.study({
    "study": {"seeds": 6, "tell_sensors": True, "baseline": "a window"},
    "scenarios": {"sea": {"scene": scene, "sweep": swept}},
    "configurations": {
        "a window": {},
        "scan by scan": {"set": {"tracker": {"kind": "nearest-neighbour"}}},
    },
})  # fmt: skip


def draw(axes, rows, value, **look):
    """Draw values with their intervals, over false alarms."""
    low, middle, high = (rows[name].to_numpy() for name in ("low", value, "high"))
    place = np.arange(len(rows)) + look.pop("aside", 0.0)
    axes.errorbar(place, middle, (middle - low, high - middle), fmt="o-", capsize=4, **look)
    axes.set_xticks(range(len(rows)), [f"{n:g}" for n in swept["sensors"]["clutter_per_scan"]])
    axes.set_xlabel("false alarms a scan")


figure, (means, apart) = plt.subplots(1, 2, figsize=(10, 4.4))
found = result.summary.filter(pl.col("metric") == "gospa")
for name, aside in (("a window", -0.05), ("scan by scan", 0.05)):
    draw(means, found.filter(configuration=name), "mean", label=name, aside=aside)
lost = result.differences.filter(metric="gospa", configuration="scan by scan")
draw(apart, lost, "difference", color="tab:red")
apart.axhline(0.0, color="k", lw=1)
means.set(ylabel="GOSPA [m]", title="Means of six scenes")
apart.set(ylabel="GOSPA [m]", title="How much worse scan by scan is, scene by scene")
means.legend(loc="upper left")
figure.savefig("study.png")
