"""What each solver's answer to the same scenes of plots is worth."""

import argparse
from typing import Any

import numpy as np
from plots_practice import by_pairs, by_triples
from plots_scenes import families, judged, likeliest, scored_tuples
from solvers_families import Family, solver_named, warm_up
from text_tables import command, heading, table

import trackweave as tw
from trackweave.simulation.scenes import Scene, draw_scene

SOLVERS = (
    "Greedy", "Dual", "Exact", "AntSystem", "Annealing", "TabuSearch", "Genetic",
    "ListGenetic", "Auto",
)  # fmt: skip
SCENES = {20: 4, 50: 2}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=1, help="so many times the scenes")
    parser.add_argument("--limit", type=float, default=0.5, help="CPU time of an answer [s]")
    arguments = parser.parse_args()
    solvers = {name: solver_named(name) for name in SOLVERS}
    warm_up(*solvers.values())
    rows = []
    for family in families(tuple(SCENES), (3, 5)):
        n = SCENES[family.kind.n_objects] * arguments.times
        columns: dict[str, list[dict[str, float]]] = {}
        for seed in range(1, n + 1):
            scene = draw_scene(family.kind, np.random.default_rng(seed))
            for name, value in _measured(scene, family, solvers, arguments.limit, seed).items():
                columns.setdefault(name, []).append(value)
        rows.append([family.name, n, *(_cell(values) for values in columns.values())])
    print(heading(command("plots_solvers.py")), end="\n\n")
    print(table(["scenes", "how many", "practice", *SOLVERS, "finder"], rows))


def _measured(
    scene: Scene, family: Family, solvers: dict[str, Any], limit: float, seed: int
) -> dict[str, dict[str, float]]:
    """Return the measures of the practice, of each solver's answer and of the finder's."""
    reach = family.reach
    practice = by_pairs(scene, "evidence") if scene.places is None else by_triples(scene)
    found = {"practice": judged(scene, practice.groups, practice.places, reach)}
    scored, _ = scored_tuples(scene)
    for name, solver in solvers.items():
        told, _ = likeliest(scored, solver, limit, seed)
        found[name] = judged(scene, told.groups, told.places, reach)
    objects = tw.ObjectFinder(reach)(scored, rng=np.random.default_rng(seed))
    found["finder"] = judged(scene, scored.tuples[objects.groups] - 1, objects.positions, reach)
    return found


def _cell(values: list[dict[str, float]]) -> str:
    right, false, total = (
        float(np.mean([value[name] for value in values])) for name in ("right", "false", "GOSPA")
    )
    return f"{100.0 * right:.0f} · {false:.1f} · {total:.0f}"


if __name__ == "__main__":
    main()
