"""
Ships that report themselves
============================

Ships send their position with their number (MMSI) when they please: every few seconds under way,
every three minutes moored. Two of these use one number, one changes hers, one falls silent for
four minutes. The number is evidence, not truth: tracks stay with ships. Each colour is a track,
named by the number that its ship sends, which may change or be another's too.
"""

import matplotlib.pyplot as plt
import numpy as np
import polars as pl

import trackweave as tw

rng, rows = np.random.default_rng(3), []
ships = [  # longitude, latitude, knots east and north, seconds between messages, number
    (8.10, 54.02, 14.0, 1.0, 6, "111"), (8.13, 54.10, 11.0, -6.0, 10, "222"),
    (8.30, 54.09, -12.0, 3.0, 6, "222"), (8.22, 54.12, 2.0, -16.0, 6, "444"),
    (8.20, 54.04, 0.0, 0.0, 180, "555"), (8.12, 54.07, 16.0, 0.0, 6, "666"),
]  # fmt: skip
for lon, lat, east, north, period, number in ships:
    for time in np.arange(rng.uniform(0, period), 1500.0, period):
        if number == "666" and 600 < time < 840:  # silent
            continue
        now = "445" if number == "444" and time > 400 else number  # hers changes
        off = rng.normal(0.0, 5.0, 2) / 111e3
        rows.append((float(round(time)), lat + (north * 0.514 * time) / 111e3 + off[0],
                     lon + (east * 0.514 * time) / 65e3 + off[1], now))  # fmt: skip
reports = pl.DataFrame(rows, ["time", "lat", "lon", "identity"], orient="row").sort("time")
result = tw.track(reports)

figure, axes = plt.subplots(figsize=(8.5, 5.2))
found, n_tracks = result.reports.drop_nulls("track"), 0
for (track,), path in found.group_by("track", maintain_order=True):
    if len(path) < 3:  # a wild report by itself
        continue
    n_tracks += 1
    time, lon, lat, number = (path[name].to_numpy() for name in ("time", "lon", "lat", "identity"))
    (line,) = axes.plot(lon, lat, ".", ms=3)
    notes = [(f"track {track}: {number[0]}", 0)]
    notes += [(f"from here {number[k]}", k) for k in np.flatnonzero(number[1:] != number[:-1]) + 1]
    pause = np.diff(time)
    for k in np.flatnonzero((pause > 120) & (np.median(pause) < 60)):
        notes.append((f"silent {pause[k]:.0f} s", k))
    for said, k in notes:
        axes.plot(lon[k], lat[k], "o", ms=6, color=line.get_color())
        axes.annotate(said, (lon[k], lat[k]), fontsize=9, color=line.get_color(),
                      xytext=(5, -15 if "silent" in said else 6),
                      textcoords="offset points")  # fmt: skip
axes.set(
    title=f"{len(ships)} ships, {n_tracks} tracks", xlabel="longitude [°]", ylabel="latitude [°]"
)
axes.set_aspect(1 / np.cos(np.radians(54)))
axes.margins(x=0.12)
figure.savefig("ships.png")
