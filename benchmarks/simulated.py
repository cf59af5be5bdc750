"""Simulated sensors of every kind: turning, moving and failing.

A target is tracked while a track that is not tentative lies within the scene's cutoff, taken one
to one at each second; a track without a target is false. A switch is a target whose track has
another name than before.
"""

import argparse
import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import polars as pl
import simulated_scenes as scenes
from scipy.optimize import linear_sum_assignment
from simulated_scenes import Scene
from text_tables import command, heading, table

from trackweave import TrackingResult, track

KNOWN = ("confirmed", "coasting")


class Judged(NamedTuple):
    """What a run was worth: shares and counts over its seconds, and what it took."""

    tracked: float
    false: float
    switches: float
    rmse: float
    names: float
    cpu: float


def tracked(scene: Scene, seed: int) -> tuple[TrackingResult, float]:
    """Return a run and the CPU time that it took [s]."""
    begin = time.process_time()
    result = track(scene.reports, scene.config, rng=np.random.default_rng(seed))
    return result, time.process_time() - begin


def judged(
    scene: Scene, result: TrackingResult, cpu: float, span: tuple[float, float], cutoff: float
) -> Judged:
    """Compare with the truth each second from the first to the last [s]."""
    rows = result.tracks.filter(pl.col("status").is_in(KNOWN))
    moments = np.unique(result.tracks["time"].to_numpy())
    last: dict[int, int] = {}
    found = false = switches = seconds = 0
    squares: list[float] = []
    for second in np.arange(span[0], span[1]):
        # Rows stand at the end of each scan: the first one of this second or later.
        place = int(np.searchsorted(moments, second - 1e-9))
        if place == moments.size:
            break
        seconds += 1
        now = rows.filter(pl.col("time") == moments[place])
        names = now["track"].to_list()
        apart = np.linalg.norm(
            scene.at(moments[place])[:, None] - now.select("x", "y").to_numpy()[None], axis=2
        )
        # Names that go on come first where two tracks are near.
        for target, name in last.items():
            if name in names:
                apart[target, names.index(name)] *= 0.5
        pairs = np.array(linear_sum_assignment(np.minimum(apart, cutoff)))
        for target, column in pairs.T:
            if apart[target, column] >= cutoff:
                continue
            goes_on = last.get(int(target)) == names[column]
            switches += int(target) in last and not goes_on
            last[int(target)] = names[column]
            found += 1
            squares.append(apart[target, column] ** 2 * (4.0 if goes_on else 1.0))
        false += len(names) - int(np.sum(apart[pairs[0], pairs[1]] < cutoff))
    count = max(1, seconds)
    return Judged(
        tracked=found / (count * len(scene.start)), false=false / count, switches=switches,
        rmse=float(np.sqrt(np.mean(squares))) if squares else np.nan,
        names=rows["track"].n_unique(), cpu=cpu,
    )  # fmt: skip


def mean_row(name: str, runs: Sequence[Judged], seconds: float) -> list[Any]:
    """Return a row of the means over runs; the last cell is CPU per simulated second [ms]."""
    mean = Judged(*np.mean(np.array(runs), axis=0).tolist())
    rmse = None if np.isnan(mean.rmse) else mean.rmse
    return [
        name, f"{mean.tracked:.1%}".replace("%", " %"), mean.names, mean.false, mean.switches,
        rmse, mean.cpu / seconds * 1e3,
    ]  # fmt: skip


HEAD = ["", "tracked", "tracks", "false at a time", "switches", "RMSE m", "CPU ms/s"]


def repeated(
    name: str, make: Callable[[int], Scene], span: tuple[float, float], seeds: Sequence[int],
    cutoff: float,
) -> list[Any]:  # fmt: skip
    """Return the row of a scene over seeds."""
    tracked(make(seeds[0]), 0)  # compiles
    runs = []
    for seed in seeds:
        scene = make(seed)
        runs.append(judged(scene, *tracked(scene, seed), span, cutoff))
    return mean_row(name, runs, span[1])


def doubles_on_two(scene: Scene, result: TrackingResult) -> tuple[int, int]:
    """Return how many reports came twice, and how many of these are on two tracks."""
    rows = np.array([int(row) - 1 for row in result.assignments["report"].to_list()])
    track_of = np.full(len(rows), -1)
    track_of[rows] = result.assignments["track"].fill_null(-1).to_numpy()
    sensor, when = scene.reports["sensor"].to_numpy(), scene.reports["time"].to_numpy()
    count = apart = 0
    for name in np.unique(sensor):
        own = np.flatnonzero((sensor == name) & (scene.origin >= 0))
        own = own[np.lexsort((when[own], scene.origin[own]))]
        same = np.diff(scene.origin[own]) == 0
        near = np.flatnonzero(same & (np.diff(when[own]) < 0.1))
        pairs = np.stack([track_of[own[near]], track_of[own[near + 1]]])
        count += near.size
        apart += int(np.sum((pairs[0] != pairs[1]) & np.all(pairs >= 0, axis=0)))
    return count, apart


def rotating(seeds: Sequence[int]) -> str:
    seconds, rows = 120.0, []
    inputs = {"rotation known": scenes.Scene, "turns numbered, rotation unknown": scenes.turns}
    for name, change in inputs.items():
        runs, doubles = [], np.zeros(2, dtype=int)
        for place, seed in enumerate([seeds[0], *seeds]):
            scene = scenes.rotating(seed, seconds=seconds)
            scene = change(scene) if change is scenes.turns else scene
            result, cpu = tracked(scene, seed)
            if place:  # the first run compiles
                runs.append(judged(scene, result, cpu, (20.0, seconds), 2000.0))
                doubles += doubles_on_two(scene, result)
        rows.append([*mean_row(name, runs, seconds), f"{doubles[1]} of {doubles[0]}"])
    return table([*HEAD, "doubles on two tracks"], rows)


def platform(seeds: Sequence[int]) -> str:
    def only(*sensors: str) -> Callable[[int], Scene]:
        def make(seed: int) -> Scene:
            scene = scenes.platform(seed)
            keep = np.isin(scene.reports["sensor"].to_numpy(), sensors)
            reports = scene.reports.filter(pl.Series(keep))
            reports = reports.drop([c for c in reports.columns if reports[c].is_null().all()])
            config = {**scene.config, "sensors": {s: scene.config["sensors"][s] for s in sensors}}
            return scene._replace(reports=reports, origin=scene.origin[keep], config=config)

        return make

    cases = {
        "radar alone": ("radar",), "radar and bearings of the aircraft": ("radar", "aircraft"),
        "bearings of the aircraft alone": ("aircraft",),
    }  # fmt: skip
    span = 20.0, 160.0
    return table(
        HEAD, [repeated(name, only(*s), span, seeds, 2000.0) for name, s in cases.items()]
    )


def fading(seeds: Sequence[int]) -> str:
    def case(
        later: float, configured: float, patience: int | None = None
    ) -> Callable[[int], Scene]:
        def make(seed: int) -> Scene:
            scene = scenes.fading(seed, later=later)
            scene.config["sensors"]["default"]["detection_probability"] = configured
            if patience:
                scene.config["lifecycle"]["delete_after_misses"] = patience
            return scene

        return make

    def bare(seed: int) -> Scene:
        return scenes.fading(seed)._replace(config={})

    cases = {
        "0.9 throughout, configured 0.9": case(0.9, 0.9),
        "drops to 0.4, configured 0.9": case(0.4, 0.9), "drops, configured 0.65": case(0.4, 0.65),
        "drops, configured 0.65, given up after 15 misses": case(0.4, 0.65, 15),
        "drops, no configuration": bare,
    }  # fmt: skip
    rows = [repeated(name, make, (60.0, 120.0), seeds, 50.0) for name, make in cases.items()]
    return table(["detection probability", *HEAD[1:]], rows)


PARTS: dict[str, tuple[str, Callable[[Sequence[int]], str]]] = {
    "rotating": (
        "Ten radars turn in 4 to 4.36 s; 30 aircraft over a square of 200 km, 120 s; 70 m and "
        "0.08°, P_D 0.97, 1.2 false alarms a turn, one report in a hundred comes twice.",
        rotating,
    ),
    "platform": (
        "Six targets over 40 km; a radar reports each 4 s with 60 m and 0.6°, P_D 0.8 and ten "
        "false alarms a scan; an aircraft that flies by reports bearings each second with 0.15°.",
        platform,
    ),
    "fading": (
        "Ten targets over a square of 2 km, σ = 10 m, ten false alarms a scan; P_D is 0.9 for 60 "
        "scans, then 0.4. Judged over the second half.",
        fading,
    ),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3, help="scenes, by seed")
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=list(PARTS))
    arguments = parser.parse_args()
    seeds = range(1, arguments.repeats + 1)
    print(heading(command("simulated.py")))
    for name in arguments.parts:
        text, run = PARTS[name]
        print(f"\n{text}\n\n{run(seeds)}", flush=True)


if __name__ == "__main__":
    main()
