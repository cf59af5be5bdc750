"""The preset ``hillis`` beside the default: on the demo, the shared bench and two recordings."""

import argparse
from collections.abc import Mapping
from typing import Any

import numpy as np
import polars as pl
import recordings_data
from bench_data import Bench, Scene, add_arguments, bench_of
from recordings_data import example, follow
from runs import CONFIGURATION, configuration_for, reports_of
from text_tables import command, heading, table

from trackweave import track
from trackweave.domain.truth import TruthTable
from trackweave.metrics import assignment_quality
from trackweave.simulation import demo_scenario, simulate

PRESETS = (None, "hillis")
HEAD = ["reports", "configuration", "preset", "IDF1 of reports", "switches"]
HEAD += ["CPU ms/scan, mean", "largest", "scan period / 10, ms"]
BOAT_HEAD = ["recording", "preset", "tracked %", "switches", "tracks", "CPU ms/scan, mean"]
NEAR_M, LONGEST_GAP_S = 50.0, 8.0
TENTH_MS = 100.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser, seeds=1)
    recordings_data.add_arguments(parser)
    arguments = parser.parse_args()
    print(heading(command("presets_hillis.py")), end="\n\n")
    rows = _demo() + _bench(bench_of(arguments))
    print(table(HEAD, rows))
    if arguments.recordings.is_dir():
        print(f"\n{table(BOAT_HEAD, _boats(arguments.recordings))}")


def _tracked(
    reports: Any, configuration: Mapping[str, Any] | None, preset: str | None
) -> tuple[Any, list[float]]:
    """Return a run and the CPU time of each scan [ms]."""
    result = track(reports, configuration, preset=preset, rng=np.random.default_rng(0))
    return result, [scan["cpu_ms"] for scan in result.run["timing"]["scans"]]


def _judged(
    name: tuple[str, str], reports: Any, targets: list[str], configuration: Any, period_s: float
) -> list[list[Any]]:
    rows = []
    for preset in PRESETS:
        _tracked(reports, configuration, preset)  # compiles
        result, cpu = _tracked(reports, configuration, preset)
        found = np.full(len(targets), -1)
        for row, number in result.values.assignment.items():
            found[int(row)] = number
        quality = assignment_quality(targets, found)
        rows.append([
            *name, preset or "default", f"{quality.idf1 or 0:.3f}", quality.switches,
            float(np.mean(cpu)), max(cpu), TENTH_MS * period_s,
        ])  # fmt: skip
    return rows


def _demo() -> list[list[Any]]:
    """Return the demo's rows: its scans come once in a second or two."""
    scenario = demo_scenario()
    scene = simulate(scenario, np.random.default_rng(1))  # as the command does
    targets = [str(name) for name in scene.reports.carried["target"]]
    period = min(sensor.scan_period for sensor in scenario.sensors)
    return _judged(("demo, 9 objects", "none"), scene.reports, targets, None, period)


def _bench(bench: Bench) -> list[list[Any]]:
    scene = bench.scene(20, 1, 1)
    return _judged(
        ("T20, 20 objects", "`bench.toml`"), reports_of(scene), _targets(scene),
        configuration_for(scene, CONFIGURATION, {}), 1.0,
    )  # fmt: skip


def _targets(scene: Scene) -> list[str]:
    return [str(int(one)) if one >= 0 else "" for one in scene.detections["origin"]]


def _boats(data: Any) -> list[list[Any]]:
    """Return how vessels were followed, with no configuration."""
    radar = example("autoferry").read(data / "autoferry" / "scenario2")
    chosen = radar[0].filter(pl.col("sensor") == "radar")
    chosen = chosen[[one.name for one in chosen if one.null_count() < len(one)]]
    boat = example("joyride").read(data / "ntnu_joyride" / "joyride.mat")
    rows = []
    for name, reports, true in (
        ("Autoferry 2, radar", chosen, radar[1]), ("Joyride", *boat),
    ):  # fmt: skip
        truth = TruthTable.from_columns(
            true["time"].to_numpy(), true["target"].to_list(), true.select("x", "y").to_numpy()
        )
        for preset in PRESETS:
            shown = reports.drop(recordings_data.HIDDEN, strict=False)
            result, cpu = _tracked(shown, None, preset)
            followed = follow(truth, result.values.tracks, NEAR_M, LONGEST_GAP_S)
            shares = " ".join(f"{100 * one.share:.0f}" for one in followed.values())
            known = np.unique(result.values.tracks.track[result.values.tracks.status >= 1])
            rows.append([
                name, preset or "default", shares, sum(one.switches for one in followed.values()),
                known.size, float(np.mean(cpu)),
            ])  # fmt: skip
    return rows


if __name__ == "__main__":
    main()
