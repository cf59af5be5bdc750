"""The presets of Wiranto and Bonok beside the default: three radars, the bench, recordings."""

import argparse
import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import polars as pl
import recordings_data
from bench_data import add_arguments, bench_of, repeats
from recordings_data import by_hand, example
from runs import CONFIGURATION, configuration_for
from text_tables import command, heading, table

from trackweave import track
from trackweave.io.truth import read_truth
from trackweave.metrics import assignment_quality, evaluate
from trackweave.simulation import Scenario, SimulatedSensor, simulate
from trackweave.simulation.demo import demo_scenario

PRESETS = {"default": None, "`wiranto`": "wiranto", "`wiranto-2018`": "wiranto-2018"}
NEAR_M = 25.0
"""How near to a vessel a track of a recording counts as its own."""
# Name: period and first scan of each radar [s]; the demo's take turns every six seconds.
RADARS = {
    "periods 4, 5 and 7 s": ((4.0, 0.0), (5.0, 1.3), (7.0, 2.9)),
    "periods 2.5, 6 and 6.5 s": ((2.5, 0.4), (6.0, 0.0), (6.5, 3.3)),
    "4 s, never together": ((4.0, 0.0), (4.0, 1.1), (4.0, 2.3)),
}
Scene = tuple[str, Any, Mapping[str, Any] | None, Any]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser, seeds=3)
    recordings_data.add_arguments(parser)
    arguments = parser.parse_args()
    found: dict[str, list[dict[str, list[float]]]] = {}
    for name, reports, configuration, truth in scenes(arguments):
        own = {method: judged(reports, configuration, truth, method) for method in PRESETS}
        found.setdefault(name, []).append(own)
    print(heading(command("presets_wiranto.py")), end="\n\n")
    print(
        "IDF1 is that of reports, of recordings that of positions within 25 m; the boats and "
        "radars of the demo, nothing told, in the first four. CPU with import and estimation.",
        end="\n\n",
    )
    rows = []
    for name, runs in found.items():
        means = {method: np.mean([run[method] for run in runs], axis=0) for method in PRESETS}
        share = means["`wiranto`"][0] / means["default"][0]
        per_run = [run["`wiranto`"][0] / run["default"][0] for run in runs]
        rows.append([
            name, len(runs), *(f"{means[method][0]:.3f}" for method in PRESETS),
            f"{share:.2f} ({min(per_run):.2f})", *(float(means[m][1]) for m in PRESETS),
            *(float(means[m][2]) for m in PRESETS),
        ])  # fmt: skip
    short = [f"{what}: {m}" for what in ("switches", "CPU ms a scan") for m in PRESETS]
    kinds = [f"IDF1: {method}" for method in PRESETS]
    print(table(["scene", "runs", *kinds, "`wiranto` / default (least)", *short], rows))


def scenes(arguments: argparse.Namespace) -> Iterator[Scene]:
    """Yield name, reports, configuration and truth of each scene."""
    scenario = demo_scenario()
    for seed in repeats(arguments):
        yield simulated("demo, 6 s in turn", scenario, seed)
    for name, radars in RADARS.items():
        for seed in repeats(arguments):
            yield simulated(name, with_radars(scenario, radars), seed)
    bench = bench_of(arguments)
    for repeat in repeats(arguments):
        scene = bench.scene(20, 1, repeat)
        columns = {name: scene.detections[name] for name in ("time", "x", "y")}
        columns["target"] = scene.detections["origin"].astype(int) + 1
        reports = pl.DataFrame(columns).with_columns(pl.col("target").replace(0, None))
        yield "bench T20, one sensor", reports, configuration_for(scene, CONFIGURATION, {}), None
    folder = arguments.recordings / "autoferry"
    for path in sorted(folder.glob("scenario*"))[:3]:
        reports, truth = example("autoferry").read(path)
        seen = reports.filter(pl.col("sensor").is_in(["radar", "lidar"]))
        there = seen.select("time", "sensor", "x", "y", "sensor_x", "sensor_y")
        sensors = by_hand("autoferry")
        kept = {name: sensors["sensors"][name] for name in ("radar", "lidar")}
        yield "Autoferry, radar and lidar", there, {**sensors, "sensors": kept}, truth
    reports, truth = example("joyride").read(arguments.recordings / "ntnu_joyride/joyride.mat")
    yield "joyride, one radar", reports, by_hand("joyride"), truth


def with_radars(scenario: Scenario, radars: tuple[tuple[float, float], ...]) -> Scenario:
    """Return a scenario whose radars scan at other times, seeing as well as before."""
    changed = [
        SimulatedSensor(
            sensor.name, sensor.sigma, period, sensor.detection_probability,
            sensor.clutter_per_scan, start_offset=first, position=sensor.position,
        )
        for sensor, (period, first) in zip(scenario.sensors, radars, strict=True)
    ]  # fmt: skip
    return replace(scenario, sensors=tuple(changed))


def simulated(name: str, scenario: Scenario, seed: int) -> Scene:
    """Return a drawn scene of which nothing is told."""
    made = simulate(scenario, np.random.default_rng(seed))
    return name, made.reports, {}, None


def judged(
    reports: Any, configuration: Mapping[str, Any] | None, truth: Any, method: str
) -> list[float]:
    """Return IDF1 of reports, or where those are of nobody of positions; switches; CPU [ms]."""
    begun = time.process_time()
    result = track(reports, configuration, preset=PRESETS[method], rng=np.random.default_rng(1))
    cpu = 1000.0 * (time.process_time() - begun)
    values = result.values
    cpu /= np.unique(values.reports.time).size
    if truth is not None:
        found = evaluate(read_truth(truth), values.tracks, cutoff=NEAR_M)
        return [found.idf1 or 0.0, float(found.switches), cpu]
    given = np.full(len(values.reports), -1)
    given[list(values.assignment)] = list(values.assignment.values())
    quality = assignment_quality(values.reports.carried["target"], given)
    return [quality.idf1 or 0.0, float(quality.switches), cpu]


if __name__ == "__main__":
    main()
