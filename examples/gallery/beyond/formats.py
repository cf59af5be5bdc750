"""
Formats out, and back again
===========================

One run goes out as GeoJSON, KML, CZML, ASTERIX category 062 and more, each with what it can
carry. Here the bars say how large each file of the same twelve tracks is, and the picture is
drawn from the GeoJSON alone, as any map program would.
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
files = written(writers_named(["geojson,kml,czml,cot,readsb,asterix-062"]), result.output())
sizes = {name: len(content) / 1e3 for name, content in (files | result.files()).items()}

figure, (plan, bars) = plt.subplots(1, 2, figsize=(10, 4.4))
geojson = next(content for name, content in files.items() if name.endswith("geojson"))
for feature in json.loads(geojson)["features"]:
    plan.plot(*np.array(feature["geometry"]["coordinates"])[:, :2].T, lw=2)
plan.set(xlabel="longitude [°]", ylabel="latitude [°]", title="from the GeoJSON alone")
plan.set_aspect(1 / np.cos(np.radians(54)))
names = sorted(sizes, key=sizes.get)
bars.set_axisbelow(True)
bars.bar_label(bars.barh(names, [sizes[name] for name in names]), fmt="%.0f kB", padding=2)
bars.set(xlabel="kB", title="the same run, file by file")
figure.savefig("formats.png")
