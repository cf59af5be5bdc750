"""The small scenes of gen_cases.py and the ships of gen_ais.py, on seeds nothing was chosen on.

Each scene has one trait of real sensors. Beside the multi-hypothesis tracker stands our own
nearest-neighbour tracker with the same configuration.
"""

import argparse
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from bench_data import BESIDE, CACHE
from text_tables import command, heading, table

from trackweave import track
from trackweave.config import load_configuration
from trackweave.metrics import assignment_quality

# What each scene has to reach, as a mean; where the sites of radars must be told, they are.
MUST = {
    "side_by_side": 0.99, "shared_stamps": 1.00, "whole_seconds": 0.99, "drifting_turn": 0.98,
    "interleaved": 0.98, "fast_minority": 0.99, "short_reach": 0.98, "silent_minute": 0.95,
}  # fmt: skip
AIS = {80: (11, 12, 13), 300: (11,)}
AIS_MUST = 0.95
NEAREST = {"tracker": {"kind": "nearest-neighbour"}}
SIGMA = {"sensors": {"default": {"sigma": 10.0}}}


def made(bench: Path, script: str, name: str, options: Sequence[str]) -> Path:
    """Return the folder of a scene that a generator makes, made once."""
    folder = CACHE / "cases" / name
    if not folder.exists():
        given = [sys.executable, str(bench / script), str(folder), *options]
        subprocess.run(given, check=True, stdout=subprocess.DEVNULL)
    return folder


def followed(folder: Path, told: dict[str, Any]) -> tuple[float, float]:
    """Return IDF1 of a scene's reports, its identities hidden, and the CPU time [s]."""
    reports = pl.read_csv(folder / "reports.csv", schema_overrides={"target": pl.String})
    begun = time.process_time()
    result = track(reports.drop("target"), told, rng=np.random.default_rng(0))
    spent = time.process_time() - begun
    found = result.assignments["track"].fill_null(-1).to_numpy()
    quality = assignment_quality(reports["target"].fill_null("").to_list(), found)
    return quality.idf1 or 0.0, spent


def ways(folder: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield what is told of a scene: nothing, where something can be tracked so, and its file."""
    if folder.name != "short_reach":
        yield "nothing", {}
    if (folder / "tracker.toml").exists():
        yield "`tracker.toml`", load_configuration(folder / "tracker.toml").values


def summary(values: Sequence[float]) -> str:
    """Return a mean, and the least of several."""
    return f"{np.mean(values):.3f} ({min(values):.3f})"


def scene_rows(bench: Path, seeds: range, only: Sequence[str]) -> Iterator[list[str]]:
    """Yield a row for each scene and what is told of it."""
    folders = [made(bench, "gen_cases.py", f"s{s}", ["--seed", str(s)]) for s in seeds]
    for scene, must in MUST.items():
        if scene not in only:
            continue
        for name, _ in ways(folders[0] / scene):
            ours, nearest, spent = [], [], []
            for folder in folders:
                told = dict(ways(folder / scene))[name]
                found, cpu = followed(folder / scene, told)
                ours.append(found)
                spent.append(cpu)
                nearest.append(followed(folder / scene, told | NEAREST)[0])
            yield [
                f"`{scene}`", name, f"{must:.2f}", summary(ours), summary(nearest),
                f"{np.mean(spent):.1f}",
            ]  # fmt: skip


def ship_rows(bench: Path) -> Iterator[list[str]]:
    """Yield a row for each number of ships and what is told of them."""
    for ships, seeds in AIS.items():
        options = [["--ships", str(ships), "--minutes", "60", "--seed", str(s)] for s in seeds]
        folders = [made(bench, "gen_ais.py", f"ais-{o[1]}-{o[-1]}", o) for o in options]
        for name, told in (("nothing", {}), ("sigma = 10", SIGMA)):
            found = [followed(folder, told) for folder in folders]
            nearest = [followed(folder, told | NEAREST)[0] for folder in folders]
            count = [pl.read_csv(folder / "reports.csv").height for folder in folders]
            spent = sum(cpu for _, cpu in found) / sum(count) * 1e4
            yield [
                f"{ships} ships, an hour", name, f"{AIS_MUST:.2f}",
                summary([value for value, _ in found]), summary(nearest), f"{spent:.1f}",
            ]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bench", type=Path, default=BESIDE / "bench")
    parser.add_argument("--first", type=int, default=11)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--only", nargs="+", choices=list(MUST), default=list(MUST))
    parser.add_argument("--ships", choices=["yes", "no", "only"], default="yes")
    arguments = parser.parse_args()
    if not (arguments.bench / "gen_cases.py").exists():
        print(f"Skipped: {arguments.bench} is not there; name a folder with --bench")
        return
    seeds = range(arguments.first, arguments.first + arguments.seeds)
    told, ours, other = "told", "IDF1: default", "IDF1: nearest-neighbour"
    print(heading(command("eight_scenes.py")), end="\n\n")
    if arguments.ships != "only":
        head = ["scene", told, "wanted", ours, other, "CPU s a scene"]
        print(table(head, list(scene_rows(arguments.bench, seeds, arguments.only))), end="\n\n")
    if arguments.ships != "no":
        head = ["ships", told, "wanted", ours, other, "CPU s per 10,000 reports"]
        print(table(head, list(ship_rows(arguments.bench))))


if __name__ == "__main__":
    main()
