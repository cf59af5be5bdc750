"""Huo, Zhang, Bai, Song, Xiong (2008), repeated: M = 3, n = 10 as in its Fig. 1, and beyond."""

from collections.abc import Iterator

import numpy as np

from trackweave.fusion.confirmation import Confirmation
from trackweave.plotting.fusion import Curve, Sheet, picture_of_curves
from trackweave.studies import Claim, Progress, Study
from trackweave.studies.huo_methods import (
    COMPLETE,
    METHODS,
    best_by_generation,
    groups,
    successive,
)
from trackweave.studies.scenes import SceneShape, draw_scene
from trackweave.studies.writing import claims_text, csv_table, text_table

__all__ = ["reproduce"]

SPACINGS = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0)
SIZES = ((3, 10), (3, 20), (3, 50), (4, 10), (4, 20), (5, 10))
GENERATIONS = (1, 2, 5, 10, 20, 35, 50, 75, 100, 150, 200, 300, 500)
RULES = ("1/1", "2/3", "3/4", "4/5", "6/8")
CROWDED, LOOSE = 2.0, 6.0

Table = tuple[list[str], list[list[object]]]


class _Counter:
    """Tells how many of a study's parts are done."""

    def __init__(self, total: int, progress: Progress | None) -> None:
        self._done, self._total, self._progress = 0, total, progress

    def step(self) -> None:
        self._done += 1
        if self._progress is not None:
            self._progress(self._done, self._total)


def reproduce(
    rng: np.random.Generator, quick: bool = False, progress: Progress | None = None
) -> Study:
    """Return the study: the document's method beside the usual practice and our default.

    Parameters
    ----------
    rng
        Source of randomness.
    quick
        Whether a fraction of the scenes will do.
    progress
        Called with the number of parts done and of all.

    Returns
    -------
    Report, claims and figures with their numbers.
    """
    n_scenes = 2 if quick else 12
    sizes = SIZES[:1] if quick else SIZES
    count = _Counter(len(SPACINGS) + len(sizes) + 2, progress)
    spacing = _by_spacing(rng, n_scenes, count)
    size = _by_size(rng, sizes, n_scenes, count)
    convergence = _converging(rng, (10,) if quick else (10, 20, 40), n_scenes, count)
    confirmation = _confirming(rng, 3 if quick else 12, count)
    tables = {
        "spacing": spacing, "sizes": size, "convergence": convergence,
        "confirmation": confirmation,
    }  # fmt: skip
    claims = _claims(tables)
    files: dict[str, bytes] = {}
    for name, (head, rows) in tables.items():
        files |= csv_table(head, rows, f"{name}.csv")
        files[f"{name}.png"] = _picture(name, head, rows)
    return Study(_report(tables, claims, n_scenes), claims, files)


def _shares(
    shape: SceneShape, rng: np.random.Generator, n_scenes: int, methods: tuple[str, ...]
) -> dict[str, float]:
    """Return the share of tracks that each method associates rightly [%]."""
    found: dict[str, list[float]] = {name: [] for name in methods}
    for _ in range(n_scenes):
        scene = draw_scene(shape, rng)
        for name in methods:
            found[name].append(scene.right(groups(name, scene, rng)))
    return {name: 100.0 * float(np.mean(values)) for name, values in found.items()}


def _by_spacing(rng: np.random.Generator, n_scenes: int, count: _Counter) -> Table:
    rows: list[list[object]] = []
    for spacing in SPACINGS:
        shares = _shares(SceneShape(spacing=spacing), rng, n_scenes, METHODS)
        rows.append([spacing, *shares.values()])
        count.step()
    return ["spacing [σ]", *(f"{name} [%]" for name in METHODS)], rows


def _by_size(
    rng: np.random.Generator, sizes: tuple[tuple[int, int], ...], n_scenes: int, count: _Counter
) -> Table:
    rows: list[list[object]] = []
    for sensors, objects in sizes:
        few = max(2, n_scenes // (1 if objects <= 10 else 4))
        for seen in (1.0, 0.8):
            shape = SceneShape(sensors, objects, spacing=LOOSE, seen=seen)
            # The document has no tuple without a track of each sensor.
            methods = tuple(name for name in METHODS if seen == 1.0 or name not in COMPLETE)
            shares = _shares(shape, rng, few, methods)
            rows.append([sensors, objects, seen, *(shares.get(name) for name in METHODS)])
        count.step()
    return ["sensors", "objects", "seen", *(f"{name} [%]" for name in METHODS)], rows


def _converging(
    rng: np.random.Generator, sizes: tuple[int, ...], n_scenes: int, count: _Counter
) -> Table:
    """Return by how much the best fitness exceeds the least J after so many generations."""
    head: list[str] = ["generation"]
    columns: list[list[object]] = [list(GENERATIONS)]
    for objects in sizes:
        few = max(2, n_scenes // {10: 1, 20: 2}.get(objects, 6))
        excess = np.array([
            best_by_generation(
                draw_scene(SceneShape(objects=objects, spacing=LOOSE), rng), GENERATIONS, rng
            )
            for _ in range(few)
        ])  # fmt: skip
        head += [f"n = {objects}: excess of J [%]", f"n = {objects}: at the least J [%]"]
        columns.append((100.0 * excess.mean(axis=0)).tolist())
        columns.append((100.0 * (excess <= 1e-9).mean(axis=0)).tolist())
    count.step()
    return head, [list(row) for row in zip(*columns, strict=True)]


def _confirming(rng: np.random.Generator, n_scenes: int, count: _Counter) -> Table:
    """Return what is declared by each rule after eight associations of a crowded scene."""
    counts = {(memory, rule): np.zeros(3) for memory in ("full", "one time") for rule in RULES}
    for _ in range(n_scenes):
        scene = draw_scene(SceneShape(times=8, spacing=CROWDED), rng)
        truth = scene.tuples()
        for memory in ("full", "one time"):
            outcomes = successive(scene, rng, memory=memory)
            for rule in RULES:
                declared = Confirmation.parse(rule).declared(outcomes)
                right = len(declared & truth)
                counts[memory, rule] += right, len(declared) - right, len(truth)
    count.step()
    rows: list[list[object]] = []
    for (memory, rule), (hits, wrong, objects) in counts.items():
        said = hits + wrong
        rows.append([memory, rule, 100.0 * hits / objects, 100.0 * wrong / said if said else None])
    return ["memory", "N/M", "objects declared rightly [%]", "wrong among declared [%]"], rows


def _column(table: Table, name: str) -> np.ndarray:
    head, rows = table
    place = head.index(name)
    return np.array([np.nan if row[place] is None else row[place] for row in rows], dtype=float)


def _claims(tables: dict[str, Table]) -> tuple[Claim, ...]:
    spacing, size, curve = tables["spacing"], tables["sizes"], tables["convergence"]
    document, exact = (_column(spacing, f"{name} [%]") for name in ("document", "exact"))
    pairwise, default = (_column(spacing, f"{name} [%]") for name in ("pairwise", "default"))
    at_least = _column(curve, "n = 10: at the least J [%]")
    large = _column(size, "document [%]"), _column(size, "exact [%]")
    worst = float(np.nanmax(large[1] - large[0]))
    sizes = _column(size, "default [%]") - _column(size, "pairwise [%]")
    rules = {(row[0], row[1]): row for row in tables["confirmation"][1]}
    wrong = {key: 0.0 if row[3] is None else float(str(row[3])) for key, row in rules.items()}
    both = [wrong["one time", rule] <= wrong["one time", "1/1"] for rule in RULES[1:]]
    return (
        Claim(
            "“Simulation experiments testify the correctness and validity” (abstract)", None,
            "The document prints no result, figure or number of an experiment to compare with.",
        ),
        Claim(
            "The genetic algorithm finds the least J for M = 3, n = 10", bool(at_least[-1] >= 95),
            f"It does in {at_least[-1]:.0f} % of the scenes within {GENERATIONS[-1]} generations.",
        ),
        Claim(
            "So it does for larger systems",
            bool(worst < 1.0) if len(size[1]) > 2 else None,
            f"At the worst of the sizes it associates {worst:.1f} points fewer tracks rightly "
            "than the exact answer of the same problem.",
        ),
        Claim(
            "For M ≥ 3 integer programming is powerless (introduction)", False,
            "Branch and bound proves the least J of every scene of this study.",
        ),
        Claim(
            "M-dimensional assignment beats the methods for two nodes, applied one by one",
            _is_above(exact - pairwise),
            "Right associations beside pairwise assignment's, over the spacings: the exact answer "
            f"{_points(exact - pairwise)}, the genetic one {_points(document - pairwise)}.",
        ),
        Claim(
            "The N/M rule lowers errors", all(both),
            "At 2 σ, each time judged alone, "
            + ", ".join(f"{rule}: {wrong['one time', rule]:.1f} %" for rule in RULES)
            + " of what is declared is wrong; with the full memory, where successive results "
            "rest on the same history, "
            + ", ".join(f"{wrong['full', rule]:.1f}" for rule in RULES) + " %.",
        ),
        Claim(
            "Our default associates more tracks rightly than pairwise assignment, on the whole",
            _is_above(np.concatenate([default - pairwise, sizes])),
            f"Right associations beside pairwise assignment's: over the spacings "
            f"{_points(default - pairwise)}, over the sizes {_points(sizes)}.",
        ),
    )  # fmt: skip


def _is_above(difference: np.ndarray) -> bool | None:
    """Tell whether a difference is above zero by twice its standard error; None for neither."""
    known = difference[np.isfinite(difference)]
    doubt = 2.0 * float(known.std(ddof=1)) / np.sqrt(known.size)
    mean = float(known.mean())
    return None if abs(mean) <= doubt else mean > 0.0


def _points(difference: np.ndarray) -> str:
    """Return points of percent, their mean and range."""
    known = difference[np.isfinite(difference)]
    return f"{known.mean():+.1f} points ({known.min():+.1f} to {known.max():+.1f})"


def _picture(name: str, head: list[str], rows: list[list[object]]) -> bytes:
    table = head, rows
    if name == "spacing":
        curves = {
            column.removesuffix(" [%]"): Curve(_column(table, head[0]), _column(table, column))
            for column in head[1:]
        }
        sheet = Sheet("Right associations, M = 3, n = 10", "spacing [σ]", "tracks [%]")
        return picture_of_curves(sheet, curves)
    if name == "convergence":
        curves = {
            column.partition(":")[0]: Curve(_column(table, head[0]), _column(table, column))
            for column in head[1::2]
        }
        sheet = Sheet(
            "Best fitness, M = 3", "generation", "excess over the least J [%]",
            x_logarithmic=True, y_logarithmic=True,
        )  # fmt: skip
        return picture_of_curves(sheet, curves)
    return _bars(name, head, rows)


def _bars(name: str, head: list[str], rows: list[list[object]]) -> bytes:
    if name == "sizes":
        place = np.arange(len(rows), dtype=float)
        ticks = {float(k): f"{row[0]}×{row[1]}\n{row[2]}" for k, row in enumerate(rows)}
        curves = {
            column.removesuffix(" [%]"): Curve(place, _column((head, rows), column))
            for column in head[3:]
        }
        sheet = Sheet("Right associations at 6 σ", "M × n, P(seen)", "tracks [%]", ticks=ticks)
        return picture_of_curves(sheet, curves)
    place = np.arange(len(RULES), dtype=float)
    curves = {
        f"{what}, memory: {memory}": Curve(
            place, _column((head, [row for row in rows if row[0] == memory]), column)
        )
        for memory, (what, column) in _pairs(head)
    }
    sheet = Sheet(
        "Declared after 8 associations at 2 σ",
        "N/M",
        "[%]",
        ticks={float(place): rule for place, rule in enumerate(RULES)},
    )
    return picture_of_curves(sheet, curves)


def _pairs(head: list[str]) -> Iterator[tuple[str, tuple[str, str]]]:
    for memory in ("full", "one time"):
        yield memory, ("right", head[2])
        yield memory, ("wrong", head[3])


def _report(tables: dict[str, Table], claims: tuple[Claim, ...], n_scenes: int) -> str:
    parts = {
        "spacing": "## Right associations against spacing\n\nM = 3, n = 10, five times; the share "
        "of tracks whose group is exactly the tracks of their object.",
        "sizes": "## More sensors, more objects, objects that some sensors do not see\n\nAt 6 σ. "
        "The document's problem needs every sensor to see every object: no numbers elsewhere.",
        "convergence": "## Convergence of the best fitness\n\nThe document's search, without its "
        "second stop rule, against the least J, which the exact solver proves.",
        "confirmation": "## What the N/M rule does to wrong declarations\n\nM = 3, n = 10 at 2 σ, "
        "eight successive associations; 1/1 declares the last one's result.",
    }
    sections = [
        f"{text}\n\n{text_table(*tables[name])}\n\n![]({name}.png) Numbers: {name}.csv"
        for name, text in parts.items()
    ]
    begin = (
        "# huo-2008, repeated\n\nHuo L., Zhang Z., Bai P., Song Y., Xiong X., *A sort of model of "
        "multi-sensor multi-object flight path connection based on GA*, 2008.\n\n**The document "
        "prints no result figures**, no scene and no parameters: scenes, rates and sizes are "
        f"ours, {n_scenes} scenes per point (fewer of large ones), errors independent as it "
        "assumes. *document*: its genetic algorithm on its problem (every track in exactly one "
        "tuple). *exact*: the proven answer of the same problem. *pairwise*: one optimal "
        "assignment per further sensor, the usual practice. *nearest*: each track in turn takes "
        "the nearest group. *default*: ours.\n\n## Claims\n\n"
    )
    return begin + claims_text(claims) + "\n\n" + "\n\n".join(sections) + "\n"
