"""
Formats out, and back again
===========================

One run goes out as GeoJSON, KML, CZML, ASTERIX category 062 and more, each with what it can
carry (``trackweave formats`` says it in words; some of it is on the right). The picture on the
left is drawn from the GeoJSON alone, as any map program would.
"""

import json

import matplotlib.pyplot as plt
import numpy as np
import polars as pl

import trackweave as tw
from trackweave.formats.writing import writers_named, written
from trackweave.simulation import Area, RandomTargets, Scenario, SimulatedSensor, simulate

scene = Scenario(
    area=Area((0.0, 0.0), (8000.0, 5000.0)),
    duration=240.0,
    sensors=(SimulatedSensor("coast", sigma=12.0, scan_period=4.0, clutter_per_scan=3.0),),
    random=RandomTargets(count=12, speed=(4.0, 14.0)),
)
table = simulate(scene, rng=5).reports
x, y = table.measurement.T
reports = pl.DataFrame({"time": table.time, "lat": 54.0 + y / 111e3, "lon": 8.0 + x / 65.4e3})
result = tw.track(reports)
files = written(writers_named(["geojson,kml,czml,asterix-062"]), result.output())
# What some of the formats carry of a track.
parts = ("place", "height", "speed", "uncertainty", "identity")
writers = {
    "geojson": (1, 1, 1, 1, 1),
    "kml": (1, 1, 1, 1, 1),
    "czml": (1, 1, 1, 1, 1),
    "cot": (1, 1, 1, 1, 1),
    "asterix-062": (1, 1, 1, 1, 1),
    "readsb": (1, 1, 1, 0, 1),
    "mot": (1, 0, 0, 0, 0),
}
carried = np.array(list(writers.values()))

figure, (plan, carries) = plt.subplots(1, 2, figsize=(11, 4.8), layout="constrained")
geojson = next(content for name, content in files.items() if name.endswith("geojson"))
for feature in json.loads(geojson)["features"]:
    plan.plot(*np.array(feature["geometry"]["coordinates"])[:, :2].T, lw=2)
plan.set(xlabel="longitude [°]", ylabel="latitude [°]", title="from the GeoJSON alone")
plan.set_aspect(1 / np.cos(np.radians(54)))
carries.imshow(carried, cmap="Greens", vmax=1.6, aspect="auto")
for row, column in np.argwhere(carried):
    carries.text(column, row, "✓", ha="center", va="center")
carries.set_xticks(range(len(parts)), parts)
carries.set_yticks(range(len(writers)), writers)
carries.grid(visible=False)
carries.set_title("what some of the formats carry")
figure.savefig("formats.png")
