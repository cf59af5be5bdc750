"""Huo, Zhang, Bai, Song, Xiong (2008), repeated: M = 3, n = 10 as in its Fig. 1, and beyond."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from trackweave.association.chain_rule import track_chains
from trackweave.fusion.confirmation import Confirmation
from trackweave.solvers import Auto, Dual, Exact, ListGenetic
from trackweave.solvers.genetic._list_operators import SWAP, mutate
from trackweave.studies import Part, Study, Tick
from trackweave.studies.huo_claims import write_up
from trackweave.studies.huo_methods import (
    COMPLETE,
    METHODS,
    TWO_NODES,
    curve,
    decoded,
    document_search,
    groups,
    successive,
    two_nodes,
)
from trackweave.studies.scenes import SceneShape, TrackScene, draw_scene
from trackweave.studies.writing import Table, frame

__all__ = ["STUDY"]

# Fig. 1: the tuples of objects 1, 2 and 10 are the document's, the others' are ours.
CHROMOSOME = np.array([
    range(1, 11), [9, 10, 3, 7, 1, 8, 2, 6, 4, 5], [4, 7, 9, 1, 10, 3, 5, 8, 6, 2]
])  # fmt: skip
SWAPPED = 2, 6
SPACINGS = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0)
SIZES = ((3, 10), (3, 20), (3, 50), (4, 10), (4, 20), (5, 10))
LARGEST_OF_THE_DOCUMENT = 40
"""Genes of the largest problem that its search takes part in: more take minutes a scene."""
MARKS = (300, 1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000)
SETTINGS = ((50, 0.6), (200, 0.6), (1000, 0.6), (1000, 0.8))
RULES = ("1/1", "2/3", "3/4", "4/5", "6/8")
CROWDED, LOOSE = 2.0, 6.0
Tables = Mapping[str, Table]


def _ticked(tick: Tick, of: int) -> Iterator[int]:
    for number in range(of):
        tick(number, of)
        yield number


def _strings(rng: np.random.Generator, quick: bool, tick: Tick) -> Tables:
    """Return Figs. 1 and 2: what the chromosome decodes to, and a swap of two of its genes."""
    genes = CHROMOSOME[2].copy()
    mutate(genes, *SWAPPED, SWAP)
    rows = [
        (place + 1, *CHROMOSOME[:, place].tolist(), str(found), int(genes[place]))
        for place, found in enumerate(decoded(CHROMOSOME))
    ]
    head = ("place", "a", "b", "c", "decoded", "c after the swap")
    return {"strings": frame(head, rows)}


def _shares(
    scene: TrackScene, methods: Sequence[str], rng: np.random.Generator
) -> list[float | None]:
    """Return the share of tracks that each method associates rightly [%]."""
    found = {name: 100.0 * scene.right(own) for name, own in groups(scene, methods, rng).items()}
    return [found.get(name) for name in METHODS]


def _spacing(rng: np.random.Generator, quick: bool, tick: Tick) -> Tables:
    spacings, n_scenes = (SPACINGS[2:6:3], 3) if quick else (SPACINGS, 10)
    rows = []
    for number in _ticked(tick, len(spacings) * n_scenes):
        spacing = spacings[number // n_scenes]
        rows.append(
            (spacing, *_shares(draw_scene(SceneShape(spacing=spacing), rng), METHODS, rng))
        )
    return {"spacing": frame(("spacing", *METHODS), tuple(rows))}


def _sizes(rng: np.random.Generator, quick: bool, tick: Tick) -> Tables:
    every = [(*size, seen) for size in (SIZES[:1] if quick else SIZES) for seen in (1.0, 0.8)]
    rows = []
    for number in _ticked(tick, len(every)):
        sensors, objects, seen = every[number]
        genes = (sensors - 1) * objects
        for _ in range(2 if quick else 12 if genes <= 30 else 3):
            shape = SceneShape(sensors, objects, spacing=LOOSE, seen=seen)
            # The document has no tuple without a track of each sensor.
            left_out = set(COMPLETE) if seen < 1.0 else set()
            left_out |= {"document"} if genes > LARGEST_OF_THE_DOCUMENT else set()
            methods = tuple(name for name in METHODS if name not in left_out)
            rows.append((*every[number], *_shares(draw_scene(shape, rng), methods, rng)))
    return {"sizes": frame(("sensors", "objects", "seen", *METHODS), tuple(rows))}


def _endless(search: ListGenetic) -> ListGenetic:
    most = 10**9
    return replace(search, generations=most, evaluations=most, patience=most)


def _search(rng: np.random.Generator, quick: bool, tick: Tick) -> Tables:
    """Return J beside the least one after so many evaluations, for sizes and settings."""
    # Sensors, objects, scenes, greatest number of evaluations, and whether settings are varied.
    plan = [(3, 10, 3, 10_000, True), (3, 20, 1, 30_000, False)] if quick else [
        (3, 10, 10, 100_000, True), (3, 20, 3, 300_000, True), (3, 30, 2, 1_000_000, False),
        (5, 10, 3, 300_000, False),
    ]  # fmt: skip
    rows: list[tuple[object, ...]] = []
    for number in _ticked(tick, len(plan)):
        sensors, objects, n_scenes, most, is_varied = plan[number]
        marks = [mark for mark in MARKS if mark <= most]
        preset = document_search()
        own = preset.for_genes((sensors - 1) * objects).population
        settings = sorted({(own, preset.mutation), *(SETTINGS if is_varied else ())})
        for place in range(n_scenes):
            scene = draw_scene(SceneShape(sensors, objects, spacing=LOOSE), rng)
            problem = track_chains(scene.estimates).problem()
            least = Exact()(problem, rng=rng).cost
            size = (f"{sensors} × {objects}", place + 1)
            for population, mutation in settings:
                search = replace(
                    _endless(preset), by_size=False, population=population, mutation=mutation
                )
                for mark, cost in zip(marks, curve(problem, search, marks, rng), strict=True):
                    whose = "preset" if population == own else f"population {population}"
                    name = f"{whose}, P_m {mutation:g}"
                    rows.append((*size, name, mark, _excess(cost, least)))
            for name, solver in (("default", Auto()), ("exact", Exact()), ("relaxation", Dual())):
                answer = solver(problem, rng=rng)
                # Of the exact answer, by how much it could be above the least.
                base = answer.lower_bound if name == "exact" else least
                rows.append((*size, name, answer.evaluations, _excess(answer.cost, base)))
    return {"search": frame(("M × n", "scene", "search", "evaluations", "excess"), tuple(rows))}


def _excess(cost: float, least: float) -> float:
    """Return by how much a J exceeds the least [%], 0 up to rounding."""
    excess = 100.0 * (cost / least - 1.0)
    return excess if excess > 1e-7 else 0.0


def _stops(rng: np.random.Generator, quick: bool, tick: Tick) -> Tables:
    """Return J beside the least one where the preset ends, with and without stop rule 2."""
    few = [(10, LOOSE, "with")] * 4 + [(10, LOOSE, "without")] * 4
    plan = few if quick else few * 20 + [(20, LOOSE, "with")] * 6 + [(20, CROWDED, "with")] * 5
    rows: list[tuple[object, ...]] = []
    for number in _ticked(tick, len(plan)):
        objects, spacing, rule = plan[number]
        scene = draw_scene(SceneShape(objects=objects, spacing=spacing), rng)
        problem = track_chains(scene.estimates).problem()
        least, search = Exact()(problem, rng=rng).cost, document_search()
        if rule == "without":
            search = replace(search, patience=10**9)
        answer = search(problem, rng=rng)
        rows.append((*plan[number], answer.evaluations, _excess(answer.cost, least)))
    head = ("objects", "spacing", "rule 2", "evaluations", "excess")
    return {"stops": frame(head, rows)}


def _confirmation(rng: np.random.Generator, quick: bool, tick: Tick) -> Tables:
    """Return what is declared by each rule after eight associations of a crowded scene."""
    rows: list[tuple[object, ...]] = []
    for _ in _ticked(tick, 1 if quick else 8):
        scene = draw_scene(SceneShape(times=8, spacing=CROWDED), rng)
        truth = scene.tuples()
        for memory in ("all times", "one time"):
            outcomes = successive(scene, rng, full=memory == "all times")
            for rule in RULES:
                declared = Confirmation.parse(rule).declared(outcomes)
                right, said = len(declared & truth), len(declared)
                wrong = 100.0 * (said - right) / said if said else None
                rows.append((memory, rule, 100.0 * right / len(truth), wrong))
    head = ("memory", "N/M", "objects declared rightly", "wrong among declared")
    return {"confirmation": frame(head, rows)}


def _two_nodes(rng: np.random.Generator, quick: bool, tick: Tick) -> Tables:
    """Return right associations of two nodes' tracks, errors with and without a common part."""
    plan = [(shared, spacing) for shared in (0.0, 0.5) for spacing in (2.0, 4.0, 8.0)]
    n_scenes, rows = 3 if quick else 15, []
    for number in _ticked(tick, len(plan)):
        shared, spacing = plan[number]
        for _ in range(n_scenes):
            scene = draw_scene(SceneShape(2, spacing=spacing, shared=shared), rng)
            own = [100.0 * scene.right(two_nodes(method, scene)) for method in TWO_NODES]
            rows.append((shared, spacing, *own, *_shares(scene, METHODS, rng)))
    return {"two-nodes": frame(("shared", "spacing", *TWO_NODES, *METHODS), tuple(rows))}


STUDY = Study(
    (
        Part("strings", _strings),
        Part("search", _search),
        Part("stops", _stops),
        Part("spacing", _spacing),
        Part("sizes", _sizes),
        Part("two-nodes", _two_nodes),
        Part("confirmation", _confirmation),
    ),
    write_up,
)
