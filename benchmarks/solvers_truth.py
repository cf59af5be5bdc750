"""What the answers are worth: objects found, false objects, GOSPA, for two costs of tuples."""

import argparse
import math
from typing import Any

import numpy as np
from solvers_families import BEARINGS, Family, on_tuples, percent, solver_named, warm_up
from text_tables import command, heading, table

from trackweave.association.plots_rule import PlotsRule, ScoredTuples, scene_plots
from trackweave.metrics import gospa
from trackweave.simulation.scenes import PositionKind, Scene

COSTS = ("equation-1", "evidence")
REACH = 50.0
PARTS = ("objects told", "found", "false", "GOSPA m")


def families(scenes: int) -> list[Family]:
    """Return the scenes: positions of all sizes and spacings, and the bearings."""
    seeds = tuple(range(1, scenes + 1))
    positions = [
        Family(
            f"position {sensors}×{objects}, spacing {spacing}",
            PositionKind(sensors, objects, float(spacing)), seeds, REACH,
        )
        for sensors in (3, 5) for objects in (30, 100) for spacing in (4, 10)
    ]  # fmt: skip
    return [*positions, *(Family(f.name, f.kind, seeds, f.reach) for f in BEARINGS)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--scenes", type=int, default=3, help="scenes of each kind, seeds 1 and up"
    )
    parser.add_argument("--solvers", nargs="+", default=["Greedy", "default", "Exact"])
    parser.add_argument("--limit", type=float, default=3.0, help="CPU time of an answer [s]")
    arguments = parser.parse_args()
    solvers = {name: solver_named(name) for name in arguments.solvers}
    warm_up(*solvers.values())
    rows = []
    for family in families(arguments.scenes):
        for cost in COSTS:
            scenes = [family.scene(seed) for seed in family.seeds]
            scored = [_scored(scene, cost) for scene in scenes]
            for name, solver in solvers.items():
                parts = [
                    _judged(scene, tuples, solver, (family.reach, arguments.limit))
                    for scene, tuples in zip(scenes, scored, strict=True)
                ]
                rows.append(_row(family, cost, name, parts))
    print(heading(command("solvers_truth.py")), end="\n\n")
    head = ["scenes", "objects", "seen twice or more", "cost", "solver", *PARTS, "mean gap"]
    print(table(head, rows))


def _scored(scene: Scene, cost: str) -> ScoredTuples:
    rule = PlotsRule(
        object_density=scene.object_density,
        cost=cost,
        negative_only=True,
        area=scene.area,
        max_tuples=2_000_000,
    )  # type: ignore[arg-type]
    return rule(scene_plots(scene))


def _judged(
    scene: Scene, scored: ScoredTuples, solver: Any, limits: tuple[float, float]
) -> dict[str, float]:
    reach, seconds = limits
    found = on_tuples(scored, solver, seconds)
    told = scored.positions[found.rows]
    judged = gospa(scene.objects, told, cutoff=reach)
    n_objects, n_told = scene.objects.shape[0], told.shape[0]
    seen = np.bincount(
        np.concatenate([label[label >= 0] for label in scene.label]), minlength=n_objects
    )
    return {
        "objects": n_objects, "seen": int(np.sum(seen >= 2)), "objects told": n_told,
        "found": n_told - judged.n_false, "false": judged.n_false, "GOSPA m": judged.total,
        "gap": found.answer.gap,
    }  # fmt: skip


def _row(family: Family, cost: str, name: str, parts: list[dict[str, float]]) -> list[Any]:
    mean = {key: math.fsum(part[key] for part in parts) / len(parts) for key in parts[0]}
    return [
        family.name, int(mean["objects"]), f"{mean['seen']:.1f}", cost, name,
        *(f"{mean[key]:.1f}" for key in PARTS), percent(mean["gap"]),
    ]  # fmt: skip


if __name__ == "__main__":
    main()
