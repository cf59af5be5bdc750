"""Right groups, false objects and GOSPA: the sequential practice beside the default."""

import argparse
import math
import time
from collections import defaultdict
from typing import Any

import numpy as np
from plots_practice import by_pairs, by_triples
from plots_scenes import (
    MEASURES,
    OBJECTS,
    Limited,
    families,
    judged,
    likeliest,
    scored_tuples,
    true_groups,
)
from solvers_families import Family, warm_up
from text_tables import command, heading, table

import trackweave as tw
from trackweave.simulation.scenes import BearingKind, Scene, draw_scene

SCENES = {5: 16, 10: 10, 20: 4, 50: 2, 100: 2}
"""How many scenes of so many objects, before ``--times``."""
LETTER = {"distance": "d", "evidence": "e", "triples": "t"}
ANSWER, FINDER = "likeliest", "finder"
BINS = (0.02, 0.1, 0.2, 0.4, 0.6, 0.8, 0.95, 1.01)
Results = dict[str, dict[str, list[float]]]
Sure = list[tuple[float, bool]]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=1, help="so many times the scenes")
    parser.add_argument("--objects", type=int, nargs="+", choices=OBJECTS, default=list(OBJECTS))
    parser.add_argument("--only", nargs="+", default=[], help="scenes whose names begin so")
    parser.add_argument("--limit", type=float, default=2.0, help="CPU time of an answer [s]")
    arguments = parser.parse_args()
    warm_up()
    _results(Family("", BearingKind(3, 5), (1,), 90.0), arguments.limit, [])
    rows, sure = [], []
    for family in families(tuple(arguments.objects)):
        if not family.name.startswith(" ".join(arguments.only)):
            continue
        n = SCENES[family.kind.n_objects] * arguments.times
        seeds = tuple(range(1, n + 1))
        results = _results(
            Family(family.name, family.kind, seeds, family.reach), arguments.limit, sure
        )
        rows.append([family.name, n, *_cells(results)])
    print(heading(command("plots_truth.py")), end="\n\n")
    print(table(_head(), rows), end="\n\n")
    print(table(["probability told", "groups", "its mean", "share right"], _calibration(sure)))


def _results(family: Family, limit: float, sure: Sure) -> Results:
    """Return each method's measures, one entry for each scene; add to what groups were told."""
    results: Results = defaultdict(lambda: defaultdict(list))
    for seed in family.seeds:
        scene = draw_scene(family.kind, np.random.default_rng(seed))
        for name, told, cpu in _practice(scene):
            _enter(results[name], judged(scene, told.groups, told.places, family.reach), cpu)
        scored, cpu = scored_tuples(scene)
        told, own = likeliest(scored, None, limit, seed)
        _enter(results[ANSWER], judged(scene, told.groups, told.places, family.reach), cpu + own)
        begun = time.process_time()
        finder = tw.ObjectFinder(family.reach, solver=Limited(tw.Auto(), limit))
        found = finder(scored, rng=np.random.default_rng(seed))
        own = time.process_time() - begun
        groups = scored.tuples[found.groups] - 1
        _enter(results[FINDER], judged(scene, groups, found.positions, family.reach), cpu + own)
        true = true_groups(scene)
        sure += [
            (float(chance), tuple(group) in true)
            for chance, group in zip(found.group_probability, groups.tolist(), strict=True)
        ]
    return results


def _practice(scene: Scene) -> list[tuple[str, Any, float]]:
    """Return what each variant of the practice tells, and its CPU time."""
    found = []
    for name in LETTER:
        if name == "triples" and scene.places is None:
            continue
        begun = time.process_time()
        told = by_triples(scene) if name == "triples" else by_pairs(scene, name)  # type: ignore[arg-type]
        found.append((name, told, time.process_time() - begun))
    return found


def _enter(lists: dict[str, list[float]], measures: dict[str, float], cpu: float) -> None:
    for name, value in {**measures, "cpu": cpu}.items():
        lists[name].append(value)


def _head() -> list[str]:
    head = ["scenes", "how many"]
    for name in ("right groups %", "false objects", "GOSPA m"):
        head += [f"{name}: practice", "likeliest", "finder", "finder − practice"]
    return [*head, "CPU ms: practice", "likeliest", "finder"]


def _cells(results: Results) -> list[str]:
    """Return the cells of a row: of each measure the practice's best variant, and ours."""
    cells = []
    practice = [name for name in LETTER if name in results]
    for measure in MEASURES:
        sign = -1.0 if measure == "right" else 1.0
        best = min(practice, key=lambda name: sign * float(np.mean(results[name][measure])))
        scale = 100.0 if measure == "right" else 1.0
        values = {
            name: scale * np.array(results[name][measure]) for name in (best, ANSWER, FINDER)
        }
        gain = values[FINDER] - values[best]
        error = float(np.std(gain, ddof=1)) / math.sqrt(len(gain)) if len(gain) > 1 else 0.0
        cells += [
            f"{values[best].mean():.1f} {LETTER[best]}",
            f"{values[ANSWER].mean():.1f}",
            f"{values[FINDER].mean():.1f}",
            f"{gain.mean():+.1f} ± {error:.1f}",
        ]
    slowest = max(float(np.mean(results[name]["cpu"])) for name in practice)
    times = [slowest, *(float(np.mean(results[name]["cpu"])) for name in (ANSWER, FINDER))]
    return [*cells, *(f"{1000.0 * seconds:.0f}" for seconds in times)]


def _calibration(sure: Sure) -> list[list[Any]]:
    """Return for each range of probabilities how many groups were told so, and how many right."""
    chance, right = np.array([c for c, _ in sure]), np.array([r for _, r in sure])
    rows = []
    for low, high in zip((0.0, *BINS[:-1]), BINS, strict=True):
        within = (chance >= low) & (chance < high)
        if within.any():
            rows.append([
                f"{100 * low:.0f} to {100 * min(high, 1.0):.0f} %", int(within.sum()),
                f"{100 * chance[within].mean():.1f} %", f"{100 * right[within].mean():.1f} %",
            ])  # fmt: skip
    return rows


if __name__ == "__main__":
    main()
