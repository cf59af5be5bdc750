"""US patent 6,055,523 (filed 1997), repeated: its drawings, its window, its search."""

import numpy as np

from trackweave.plotting.hypotheses import Drawing, picture_of_hypotheses
from trackweave.plotting.panels_of_curves import Panel, SpreadCurve, picture_of_panels
from trackweave.studies import Claim, Progress, Study
from trackweave.studies.hillis_claims import Findings, claims_of
from trackweave.studies.hillis_example import (
    FIGURES,
    PLACES,
    REPORTS,
    Run,
    decoded_figure,
    least_cost_with,
    name_of,
    run_example,
)
from trackweave.studies.hillis_fitness import document_search
from trackweave.studies.hillis_islands import on_islands
from trackweave.studies.hillis_parts import (
    METHODS,
    Table,
    arriving,
    by_depth,
    by_size,
    costs_by_scan,
    distinct_hypotheses,
    generations_table,
    stopping,
    thresholds_table,
)
from trackweave.studies.writing import claims_text, csv_table, text_table

__all__ = ["reproduce"]

DEPTHS = (1, 2, 3, 4, 5, 6, 7)
SIZES = (5, 10, 20, 50)
SIZE_OF_STOPS = 10
MEASURES = ("right [%]", "switches", "GOSPA [m]")


def reproduce(
    rng: np.random.Generator, quick: bool = False, progress: Progress | None = None
) -> Study:
    """Return the study: what the patent says, measured on scenes of ours.

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
    depths, sizes = ((1, 3, 5), SIZES[:2]) if quick else (DEPTHS, SIZES)
    n_scenes, n_windows = ((2, 1), 2) if quick else ((20, 2), 5)
    n_scans = 6 if quick else 9
    done, total = 0, n_scenes[0] + len(sizes) + 4

    def step() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done, total)

    window = run_example(5, rng)
    one, searched = run_example(1, rng), run_example(5, rng, document_search())
    example = costs_by_scan(window, rng)
    step()
    depth = by_depth(rng, depths, n_scenes, n_scans, step)
    size, evolutions = by_size(rng, sizes, n_windows, step)
    thresholds = thresholds_table(evolutions[SIZE_OF_STOPS])
    stops, whole, ordered = stopping(rng, SIZE_OF_STOPS, n_windows)
    step()
    arrivals = arriving(rng, min(n_scenes[0], 8), n_scans)
    step()
    islands, alike = on_islands(rng, SIZE_OF_STOPS, n_windows)
    step()
    tables = {
        "example": example, "depths": depth, "sizes": size,
        "generations": generations_table(evolutions), "thresholds": thresholds,
        "interruptions": stops, "arrivals": arrivals, "islands": islands,
    }  # fmt: skip
    findings = Findings(
        window, one, searched, distinct_hypotheses(window), tables, whole, ordered, alike
    )
    claims = claims_of(findings)
    files = _files(tables, window, one, rng)
    return Study(_report(tables, claims, (*n_scenes, n_scans), n_windows), claims, files)


def _files(
    tables: dict[str, Table], window: Run, one: Run, rng: np.random.Generator
) -> dict[str, bytes]:
    """Return figures and numbers by their names."""
    files: dict[str, bytes] = {}
    for name, table in tables.items():
        files |= csv_table(table.head, table.rows, f"{name}.csv")
    files |= csv_table(
        ("figure", "string", "tracks", "cost [nats]"),
        [(each, FIGURES[each][0], *_said(each, window)) for each in FIGURES], "figures.csv",
    )  # fmt: skip
    files["figures.png"] = picture_of_hypotheses(
        [
            _drawing(f"Figure {figure}", *decoded_figure(figure, window)[:2][::-1])
            for figure in FIGURES
        ],
        columns=2,
    )
    files["example.png"] = _picture_of_choice(window, one, rng)
    files["depths.png"] = _picture_of_depths(tables["depths"])
    files["generations.png"] = _picture_of_generations(tables["generations"])
    files["stops.png"] = _picture_of_stops(tables["thresholds"], tables["interruptions"])
    return dict(sorted(files.items()))


def _said(figure: str, run: Run) -> tuple[str, float]:
    cost, tracks, _ = decoded_figure(figure, run)
    return name_of(tracks), cost


def _drawing(title: str, tracks: frozenset[tuple[int, ...]], cost: float | None = None) -> Drawing:
    count = sum(len(track) for track in tracks)
    words = title if cost is None else f"{title}: {cost:.1f} nats".replace("-", "−")
    return Drawing(words, PLACES[:count], REPORTS[:count], tracks)


def _picture_of_choice(window: Run, one: Run, rng: np.random.Generator) -> bytes:
    drawings = []
    for scan in (1, 2):
        for figure in ("2", "3"):
            cost, tracks = least_cost_with(figure, window.problems[scan], rng)
            begun = f"Begun as in Figure {figure}, {scan + 1} scans"
            drawings.append(_drawing(begun, tracks, cost))
    drawings.append(_drawing("Window of one scan, 3 scans", one.hypotheses[-1]))
    drawings.append(_drawing("Window of five scans, 3 scans", window.hypotheses[-1]))
    return picture_of_hypotheses(drawings, columns=2)


def _summary(table: Table) -> Table:
    """Return each method's means and standard deviations by depth."""
    rows: list[tuple[object, ...]] = []
    for depth in sorted({int(value) for value in table.column("depth")}):
        for method in METHODS:
            scenes = table.column("scene", depth=depth, method=method)
            if scenes.size == 0:
                continue
            cells: list[object] = [depth, method, scenes.size]
            for name in (*MEASURES, "amended", "excess [nats]", "at the best [%]"):
                values = table.column(name, depth=depth, method=method)
                known = not np.isnan(values).any()
                cells.append(f"{values.mean():.1f} ± {values.std():.1f}" if known else None)
            rows.append(tuple(cells))
    head = ("depth", "method", "scenes", *MEASURES, "amended", "excess [nats]", "at the best [%]")
    return Table(head, tuple(rows))


def _picture_of_depths(table: Table) -> bytes:
    panels = []
    titles = ("Reports assigned rightly", "Identity switches", "Distance from the truth")
    for title, measure in zip(titles, MEASURES, strict=True):
        curves = {}
        for place, method in enumerate(METHODS):
            depths = np.unique(table.column("depth", method=method))
            found = [table.column(measure, depth=d, method=method) for d in depths.tolist()]
            curves[method] = SpreadCurve(
                depths + 0.06 * (place - 2), np.array([each.mean() for each in found]),
                np.array([each.std() / np.sqrt(each.size) for each in found]),
            )  # fmt: skip
        panels.append(Panel(title, "depth of the window [scans]", measure, curves))
    return picture_of_panels(panels)


def _picture_of_generations(table: Table) -> bytes:
    generation = table.column("generation")
    panels = []
    for kind, title in (("best", "Fittest so far"), ("mean", "Mean of the population")):
        curves = {
            name.partition(",")[0]: SpreadCurve(generation, table.column(name))
            for name in table.head[1:]
            if name.endswith(f"{kind} [nats]")
        }
        panels.append(
            Panel(
                title,
                "generation",
                "above the best there is [nats]",
                curves,
                x_logarithmic=True,
                y_logarithmic=True,
            )
        )
    return picture_of_panels(panels)


def _picture_of_stops(thresholds: Table, stops: Table) -> bytes:
    by_threshold = SpreadCurve(
        thresholds.column("threshold [nats]"), thresholds.column("excess [nats]")
    )
    by_look = SpreadCurve(stops.column("looks"), stops.column("excess [nats]"))
    y_name = "above the best there is [nats]"
    return picture_of_panels([
        Panel(
            "Stopped by the threshold", "mean less fittest [nats]", y_name,
            {"threshold": by_threshold}, x_logarithmic=True, y_logarithmic=True,
        ),
        Panel(
            "Stopped by the next scan", "looks at the clock", y_name,
            {"next scan": by_look}, x_logarithmic=True, y_logarithmic=True,
        ),
    ])  # fmt: skip


def _report(
    tables: dict[str, Table],
    claims: tuple[Claim, ...],
    n_scenes: tuple[int, int, int],
    n_windows: int,
) -> str:
    shown = {**tables, "depths": _summary(tables["depths"])}
    parts = {
        "example": "## An early choice\n\nReports of one radar; the patent gives no places, these "
        "are ours. Cost of the best hypothesis whose links between the first two scans are those "
        "of a figure; Figure 4 goes on from Figure 3.\n\n![](example.png)",
        "depths": f"## Depth of the window\n\n{n_scenes[0]} scenes of two sensors (the patent's "
        f"search on {n_scenes[1]} of them; only the first few at every depth): five objects, "
        f"three and two of which cross, false alarms, misses, {n_scenes[2]} scans of each; every "
        "method sets out from the same tracks. Mean ± standard deviation over scenes; in the "
        "figure, bars of one standard error. *document*: the preset. *its best*: the proven best "
        "by the same fitness. *exact*: the proven best where a report that joins nothing may be "
        "a false alarm. *default*: ours. *nearest*: one scan, the cheapest pair first. *excess*: "
        "cost above that of *its best*, per window.\n\n![](depths.png)",
        "sizes": f"## Number of objects\n\nFull windows of five scans of one sensor over 1 km², "
        f"{n_windows} of each size. *with false alarms*: the same search where poor tracks may "
        "dissolve; *default genetic*: ours, which begins from prices and improves its best.",
        "generations": "## Convergence\n\nThe same windows, without the threshold.\n\n"
        "![](generations.png)",
        "thresholds": f"## Stopping\n\n{SIZE_OF_STOPS} objects. When the mean comes within a "
        "threshold of the fittest:\n\n![](stops.png)",
        "interruptions": "When the next scan arrives, after so many looks at the clock (a few "
        "milliseconds apart):",
        "arrivals": "## Reports that come alone\n\nThe scenes of above with a third sensor that "
        "does not scan; in the third case its reports come up to two seconds late. *none*: "
        "without it. Window of five scans, exact answers.",
        "islands": f"## Islands\n\nWindows of {SIZE_OF_STOPS} objects, as many evaluations in all "
        "as the preset's. Each island has a population of the preset's size; at the end of each "
        "epoch the fittest that it ever had takes the place of the next island's worst. The "
        "preset's one population keeps no such individual: its generations do not overlap.",
    }
    sections = [
        f"{text}\n\n{text_table(shown[name].head, shown[name].rows)}\n\nNumbers: {name}.csv"
        for name, text in parts.items()
    ]
    begin = (
        "# hillis-1997, repeated\n\nD. B. Hillis, *Method and apparatus for multi-sensor, "
        "multi-target tracking using a genetic algorithm*, US patent 6,055,523, filed 1997.\n\n"
        "**The patent prints no results**, no scene, no score and no sizes of the search: these "
        "are ours. Costs are in nats against all reports being false alarms; less is better."
        "\n\n## Claims\n\n"
    )
    drawn = (
        "\n\n## The drawings\n\nEach string, decoded by the tracker's own decoder from the "
        "example's reports.\n\n![](figures.png) Numbers: figures.csv\n\n"
    )
    return begin + claims_text(claims) + drawn + "\n\n".join(sections) + "\n"
