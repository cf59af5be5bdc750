"""
Coverage, learned from what others see
======================================

Two radars watch the same boats. Nobody says that the western one sees no farther than 4 km, nor
that a hill hides the west from the other one. Where a radar is silent although the other goes on,
it does not see: taken for misses, these silences would end tracks. Lines are what the run
learned: the western radar's reach, and the sector that the hill leaves to the eastern one, drawn
to 6 km.
"""

import matplotlib.pyplot as plt
import numpy as np
import polars as pl

import trackweave as tw
from trackweave.simulation import Area, RandomTargets, Scenario, SimulatedSensor, simulate

places = {"west": (-3000.0, 0.0), "east": (3000.0, 0.0)}
scene = Scenario(
    area=Area((-7000.0, -6000.0), (7000.0, 6000.0)),
    duration=400.0,
    sensors=tuple(
        SimulatedSensor(
            name, 15.0, 4.0, 0.95, 2.0, start_offset=offset, position=places[name], max_range=reach
        )
        for name, offset, reach in (("west", 0.0, 4000.0), ("east", 2.0, 20000.0))
    ),
    random=RandomTargets(count=25, speed=(5.0, 20.0)),
)
table = simulate(scene, rng=2).reports
reports = pl.DataFrame({"time": table.time, "sensor": np.array(table.sensors)[table.sensor],
                        "x": table.measurement[:, 0], "y": table.measurement[:, 1]})  # fmt: skip
azimuth = np.degrees(np.arctan2(reports["x"].to_numpy() - 3000.0, reports["y"].to_numpy()))
hidden = (reports["sensor"] == "east").to_numpy() & (azimuth > -110.0) & (azimuth < -60.0)
reports = reports.filter(~hidden)
told = {name: {"position": list(place)} for name, place in places.items()}
run = tw.track(reports, {"sensors": told}).run

figure, panels = plt.subplots(1, 2, sharey=True, figsize=(10, 4.6))
for axes, name in zip(panels, places, strict=True):
    own, view = (
        reports.filter(sensor=name),
        run["configuration"]["sensors"][name]["field_of_view"] or {},
    )
    axes.plot(own["x"] / 1e3, own["y"] / 1e3, ".", color="0.75", ms=2)
    axes.plot(*np.array(places[name]) / 1e3, "k^")
    low, high = np.radians(view.get("azimuth_deg", [0, 360]))
    along = np.linspace(low, high if high > low else high + 2 * np.pi, 200)
    edge = view.get("max_range_m", 6000.0) * np.column_stack([np.sin(along), np.cos(along)])
    axes.plot(*(np.array(places[name]) + edge).T / 1e3, color="tab:blue", lw=2)
    told_so = []
    if "max_range_m" in view:
        told_so.append(f"up to {view['max_range_m'] / 1e3:.2f} km")
    if "azimuth_deg" in view:
        told_so.append("azimuths {:.0f}° to {:.0f}°".format(*view["azimuth_deg"]))
    told_so = ", ".join(told_so) or "everywhere"
    axes.set(title=f"{name} sees {told_so}", xlabel="x [km]", xlim=(-7.5, 9.5), ylim=(-6.5, 6.5))
    axes.set_aspect("equal")
panels[0].set_ylabel("y [km]")
figure.savefig("learned_coverage.png")
