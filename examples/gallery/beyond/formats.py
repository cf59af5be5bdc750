"""
Formats out, and back again
===========================

One run goes out as GeoJSON, KML, CZML, ASTERIX category 062 and more, each with what it can
carry: what the library says of its formats, as ``trackweave formats`` prints it, is the table on
the right. The picture on the left is drawn from the GeoJSON alone, as any map program would.
"""

import json
import re

import matplotlib.pyplot as plt
import numpy as np
import polars as pl

import trackweave as tw
from trackweave.formats.registry import formats
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
# A word of what a format carries, and how the library has it.
parts = {
    "place": "position|place|every",
    "height": "height|every",
    "speed": "speed|velocity|every",
    "uncertainty": "uncertainty|accuracies|every",
    "frames": "frame|every",
    "identity": "identit|address|target|every",
}
writers = {name: each.carries for name, each in formats().items() if each.writer}
carried = np.array([[bool(re.search(part, told)) for part in parts.values()]
                    for told in writers.values()])  # fmt: skip

figure, (plan, carries) = plt.subplots(1, 2, figsize=(11, 4.8))
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
carries.set_title("what each format that is written carries")
figure.savefig("formats.png")
