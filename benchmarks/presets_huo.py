"""Preset huo beside the default: tracks of sensors tracked apart, fused, against truth.

    python benchmarks/presets_huo.py                 # a minute

The tracks are what ``track`` makes of each sensor's reports alone; nothing is trimmed. Autoferry's
radar and lidar: at the truth's times at which a track of each is within 30 m of a vessel, whether
these two are of one object (*together*), how far the object nearest to the vessel is, and how many
objects that was. The demo's three radars: metrics of the fused tracks over all objects.
"""

import argparse
import tomllib
from typing import Any

import numpy as np
import polars as pl
from fusion_autoferry import SCENARIOS, SENSORS, nearest, tracked
from recordings_data import add_arguments, example
from text_tables import command, heading, table

from trackweave import fuse, track
from trackweave.cli.simulate import simulated_tables
from trackweave.errors import InvalidInputError
from trackweave.io.tracks_in import read_local_tracks
from trackweave.metrics import evaluate
from trackweave.run.fusing import FusionResult
from trackweave.simulation import demo_configuration, demo_scenario, simulate

PRESETS = (None, "huo", "huo-2008")
VESSELS = ("havfruen", "other")


def fused(tables: dict[str, Any], preset: str | None) -> FusionResult | None:
    """Return what a preset makes of tracks; None where it refuses them."""
    try:
        return fuse(tables, preset=preset, rng=np.random.default_rng(1))
    except InvalidInputError:
        return None


def together(found: FusionResult, tables: dict[str, Any], truth: pl.DataFrame) -> list[Any]:
    """Return how the vessels' tracks were associated."""
    owner: dict[tuple[str, int], list[Any]] = {}
    for pairing in found.values.pairings:
        owner.setdefault((pairing.sensor, pairing.track), []).append(pairing)

    def object_of(sensor: str, number: int, time: float) -> int:
        own = [one for one in owner.get((sensor, number), []) if one.begin <= time]
        return max(own, key=lambda one: one.begin).object if own else -1

    same, errors, objects = [], [], set()
    for time, vessel, x, y in truth.select("time", "target", "x", "y").iter_rows():
        seen = [(name, nearest(own, time, np.array([x, y]))) for name, own in tables.items()]
        if any(number < 0 for _, (number, _) in seen):
            continue
        mine = [object_of(name, number, time) for name, (number, _) in seen]
        same.append(len(set(mine)) == 1)
        number, error = nearest(found.values.tracks, time, np.array([x, y]))
        objects.add((vessel, number))
        errors.append(error)
    rmse = float(np.sqrt(np.nanmean(np.square(errors))))
    return [len(same), 100.0 * float(np.mean(same)), rmse, len(objects)]


def recording(data: Any) -> list[list[Any]]:
    """Return the rows of the recording's table."""
    reader, rows = example("autoferry"), []
    for number in SCENARIOS:
        reports, truth = reader.read(data / "autoferry" / f"scenario{number}")
        frames = {sensor: tracked(reports, sensor) for sensor in SENSORS}
        local = {name: read_local_tracks(frame).tracks for name, frame in frames.items()}
        for preset in PRESETS:
            found = fused(frames, preset)
            cells = [None] * 6
            if found is not None:
                cells = [
                    *together(found, local, truth), found.run["totals"]["split"],
                    found.run["timing"]["median_cpu_ms"],
                ]  # fmt: skip
            rows.append([number, preset or "default", *cells])
    return rows


def demo() -> list[list[Any]]:
    """Return the rows of the demo's table."""
    scenario, rows = demo_scenario(), []
    scene = simulate(scenario, np.random.default_rng(1))
    hand = tomllib.loads(demo_configuration(scenario, 1))
    reports = pl.read_csv(simulated_tables(scene)["reports.csv"])
    frames = {}
    for name, section in hand["sensors"].items():
        own = reports.filter(pl.col("sensor") == name).drop("target", strict=False)
        config = {"motion": hand["motion"], "sensors": {name: section}}
        frames[name] = track(own, config, rng=np.random.default_rng(1)).tracks
    for preset in PRESETS:
        found = fused(frames, preset)
        cells = [None] * 5
        if found is not None:
            score = evaluate(scene.truth, found.values.tracks).as_dict()
            cells = [score[key] for key in ("idf1", "gospa", "switches")]
            totals = found.run["totals"]
            cells += [totals["split"], found.run["timing"]["median_cpu_ms"]]
        rows.append([preset or "default", *cells])
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    add_arguments(parser)
    data = parser.parse_args().recordings
    print(heading(command("presets_huo.py")), end="\n\n")
    head = ["preset", "IDF1", "GOSPA m", "switches", "splits", "CPU ms an update"]
    print(table(head, demo()))
    if (data / "autoferry").exists():
        head = ["scenario", "preset", "times", "together %", "RMSE m", "objects of two vessels"]
        print("", table([*head, "splits in all", "CPU ms an update"], recording(data)), sep="\n")


if __name__ == "__main__":
    main()
