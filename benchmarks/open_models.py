"""What models from outside cost: constant velocity and positions, ours and as NumPy classes.

python benchmarks/open_models.py          # a table: CPU of a run of twenty objects, five times
"""

import copy
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from bench_data import BESIDE, CACHE, Bench
from runs import CONFIGURATION, configuration_for, reports_of
from text_tables import command, heading, table

from trackweave import track

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
POINTS = {
    "trackweave.motions": {"straight": "oracles.plugins:Straight"},
    "trackweave.measurements": {"place": "oracles.plugins:Place"},
}
WAYS = ((False, False), (True, False), (False, True), (True, True))
REPEATS = 5


def told(used: dict[str, Any], *, motion: bool, measurement: bool) -> dict[str, Any]:
    """Return what a run used, told anew with models of others."""
    own = copy.deepcopy({name: used[name] for name in ("motion", "sensors", "lifecycle")})
    keys = ("model", "process_noise", "max_speed")
    own["motion"] = {key: own["motion"][key] for key in keys}
    if motion:
        own["motion"]["model"] = "straight"
    for name, sensor in own["sensors"].items():
        own["sensors"][name] = {k: v for k, v in sensor.items() if v is not None} | {"trust": True}
        if measurement:
            own["sensors"][name]["measurement"] = "place"
    own["lifecycle"] = {k: v for k, v in own["lifecycle"].items() if v is not None}
    return own


def main() -> None:
    from oracles.plugin_site import installed

    scene = Bench(BESIDE / "bench", CACHE).scene(20, 1, 1)
    reports = reports_of(scene)
    used = track(reports, configuration_for(scene, CONFIGURATION, {}), rng=1).run["configuration"]
    rows, ours = [], None
    with tempfile.TemporaryDirectory() as folder, installed(folder, POINTS):
        for motion, measurement in WAYS:
            values = told(used, motion=motion, measurement=measurement)
            track(reports, values, rng=1)
            cpu = []
            for _ in range(REPEATS):
                begin = time.process_time()
                track(reports, values, rng=1)
                cpu.append(time.process_time() - begin)
            usual = float(np.median(cpu))
            ours = ours or usual
            words = ["from outside" if each else "ours" for each in (motion, measurement)]
            rows.append([*words, f"{usual:.2f}", f"{usual / ours:.1f}"])
    print(heading(command("open_models.py")), "", sep="\n")
    print(table(["motion", "measurement", "CPU [s]", "times ours"], rows))


if __name__ == "__main__":
    main()
