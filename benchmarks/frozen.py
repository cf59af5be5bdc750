"""What every answer is, to the byte: recorded before a wall of the house moves, compared after.

    python benchmarks/frozen.py --write before.json      # everything
    python benchmarks/frozen.py --against before.json    # exit status 1 if anything differs
    python benchmarks/frozen.py --against before.json --only demo bench

A hash for every file that a run would write; of ``run.json`` all but timing. Beside it the CPU
time, which decides nothing. Groups whose data are not there are left out, and said.
"""

import argparse
import hashlib
import json
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from bench_data import BESIDE, CACHE, Bench
from recordings_data import HIDDEN, example
from recordings_formats import cells, kitti_detections, mot_detections
from runs import CONFIGURATION, configuration_for, priors_of, reports_of

from trackweave import (
    Annealing,
    AntSystem,
    AssignmentProblem,
    Auto,
    Exact,
    Genetic,
    Greedy,
    ListGenetic,
    TabuSearch,
    TrackweaveError,
    fuse,
    solve,
    track,
)
from trackweave.association.plots_rule import PlotsRule, scene_plots
from trackweave.cli.simulate import simulated_tables
from trackweave.simulation import demo_scenario, simulate
from trackweave.simulation.scenes import BearingKind, PositionKind, SceneKind, draw_scene

Content = dict[str, bytes]
Run = Callable[[], Content]
PRESETS = ("hillis", "huo", "wiranto")
SOLVERS = (
    Auto(), Exact(), Greedy(), Genetic(evaluations=400), ListGenetic(generations=20),
    AntSystem(cycles=10), Annealing(evaluations=4000), TabuSearch(evaluations=4000),
)  # fmt: skip


def content(result: Any) -> Content:
    """Return a run's files, and its record without what differs from run to run."""
    return {**result.files(), "run.json": _record(result.run)}


def _record(run: Any) -> bytes:
    told = {key: value for key, value in run.items() if key != "timing"}
    return json.dumps(told, default=str).encode()


def followed(reports: Any, config: Any, **options: Any) -> Content:
    """Return what tracking gives, or in which words it is refused."""
    try:
        return content(track(reports, config, rng=np.random.default_rng(1), **options))
    except TrackweaveError as error:
        return {"refused": str(error).encode()}


def demos(_: Path) -> Iterator[tuple[str, Run]]:
    """Yield the demo, with nothing told and with each preset."""
    scene = simulate(demo_scenario(), np.random.default_rng(1))
    reports = pl.read_csv(simulated_tables(scene)["reports.csv"])
    yield "nothing told", partial(followed, reports, None)
    for preset in PRESETS:
        yield preset, partial(followed, reports, None, preset=preset)


def bench(shared: Path) -> Iterator[tuple[str, Run]]:
    """Yield twelve scenes of the bench."""
    scenes = Bench(shared / "bench", CACHE)
    for targets, sensors, repeat in (
        (20, 1, 1), (20, 1, 2), (20, 1, 6), (20, 3, 1), (50, 1, 1), (50, 1, 6),
    ):  # fmt: skip
        scene = scenes.scene(targets, sensors, repeat)
        for priors in (True, False):
            told = configuration_for(scene, CONFIGURATION, {})
            first = priors_of(scene) if priors else None
            name = f"{scene.name}, {'priors' if priors else 'no priors'}"
            yield name, partial(followed, reports_of(scene), told, priors=first)


def recordings(shared: Path) -> Iterator[tuple[str, Run]]:
    """Yield recordings, with nothing told."""
    data = shared / "data"
    for number in (2, 13):
        reports, _ = example("autoferry").read(data / "autoferry" / f"scenario{number}")
        yield f"autoferry {number}", partial(_hidden, reports)
    yield "cells", partial(_hidden, cells(data / "cell_btrack")[0])
    joyride, _ = example("joyride").read(data / "ntnu_joyride" / "joyride.mat")
    yield "joyride", partial(_hidden, joyride)
    for kind in ("Car", "Pedestrian"):
        boxes = kitti_detections(data / "kitti" / "0002", kind)
        yield f"kitti {kind}", partial(_hidden, boxes)
    people = mot_detections(data / "mot_tud_campus" / "dets" / "det" / "det.txt")
    yield "people", partial(_hidden, people)


def _hidden(reports: pl.DataFrame) -> Content:
    return followed(reports.drop(HIDDEN, strict=False), None)


def fusions(_: Path) -> Iterator[tuple[str, Run]]:
    """Yield six fusions of the demo's radars, each tracked by itself."""
    for seed, preset in ((1, None), (1, "huo"), (2, None), (2, "huo"), (3, None), (3, "huo")):
        yield f"seed {seed}, {preset or 'default'}", partial(_fused, seed, preset)


def _fused(seed: int, preset: str | None) -> Content:
    scene = simulate(demo_scenario(), np.random.default_rng(seed))
    reports = pl.read_csv(simulated_tables(scene)["reports.csv"])
    radars = reports.partition_by("sensor", maintain_order=True)
    tracks = {str(part["sensor"][0]): track(part, rng=1).tracks for part in radars}
    result = fuse(tracks, preset=preset, rng=1)
    tables = {"tracks": result.tracks, "associations": result.associations}
    files = {name: one.write_csv().encode() for name, one in tables.items()}
    return {**files, "run.json": _record(result.run)}


def problems(_: Path) -> Iterator[tuple[str, Run]]:
    """Yield thirty assignment problems, each solved in every way."""
    kinds = (PositionKind(3, 5), PositionKind(3, 20, 30.0), BearingKind(3, 10))
    for kind in kinds:
        for seed in range(10):
            yield f"{kind}, seed {seed}", partial(_solved, kind, seed)


def _solved(kind: SceneKind, seed: int) -> Content:
    rule = PlotsRule(cost="equation-1", negative_only=True)
    problem = rule(scene_plots(draw_scene(kind, np.random.default_rng(seed)))).problem()
    return {type(solver).__name__: _answer(problem, solver, seed) for solver in SOLVERS}


def _answer(problem: AssignmentProblem, solver: Any, seed: int) -> bytes:
    try:
        answer = solve(problem, solver, rng=seed)
    except TrackweaveError as error:
        return str(error).encode()
    return repr((answer.nodes.tolist(), answer.cost, answer.lower_bound, answer.status)).encode()


GROUPS = {
    "demo": demos, "bench": bench, "recordings": recordings, "fusion": fusions,
    "assignment": problems,
}  # fmt: skip


def measured(shared: Path, only: list[str]) -> dict[str, dict[str, Any]]:
    """Return for each run its files' hashes and CPU time [s]."""
    found: dict[str, dict[str, Any]] = {}
    for group in only:
        try:
            for name, run in GROUPS[group](shared):
                begun = time.process_time()
                files = {n: hashlib.sha256(c).hexdigest() for n, c in sorted(run().items())}
                cpu = round(time.process_time() - begun, 2)
                found[f"{group}: {name}"] = {"files": files, "cpu": cpu}
        except FileNotFoundError as error:
            print(f"{group} left out: {error}", file=sys.stderr)
    return found


def differences(before: dict[str, Any], now: dict[str, Any]) -> Iterator[str]:
    """Yield what is no longer as it was, a line each."""
    for name, run in now.items():
        if name not in before:
            yield f"{name}: not measured before"
            continue
        old, new = before[name]["files"], run["files"]
        names = sorted(n for n in old.keys() | new.keys() if old.get(n) != new.get(n))
        if names:
            yield f"{name}: {', '.join(names)}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--shared", type=Path, default=BESIDE, help="folder of data and bench")
    parser.add_argument("--only", nargs="+", choices=list(GROUPS), default=list(GROUPS))
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--write", type=Path, metavar="FILE")
    what.add_argument("--against", type=Path, metavar="FILE")
    arguments = parser.parse_args()
    now = measured(arguments.shared, arguments.only)
    if arguments.write:
        arguments.write.write_text(json.dumps(now, indent=1), encoding="utf-8")
        return 0
    before = json.loads(arguments.against.read_text(encoding="utf-8"))
    changed = list(differences(before, now))
    print("\n".join(changed) or f"{len(now)} runs, the same to the byte")
    cpu = [sum(each[name]["cpu"] for name in now if name in before) for each in (before, now)]
    print(f"CPU {cpu[0]:.0f} s before, {cpu[1]:.0f} s now")
    return int(bool(changed))


if __name__ == "__main__":
    sys.exit(main())
