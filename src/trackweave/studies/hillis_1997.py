"""US patent 6,055,523 (filed 1997), repeated: its drawings, its window, its search."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from trackweave.plotting._canvas import own_style, png_of
from trackweave.plotting.hypotheses import Drawing, picture_of_hypotheses
from trackweave.plotting.panels_of_curves import Panel, SpreadCurve, picture_of_panels
from trackweave.studies import Claim, Part, Study, WriteUp
from trackweave.studies.hillis_claims import SAY, claims_of, last_of, searches_of, sizes_of
from trackweave.studies.hillis_example import PLACES, REPORTS, drawn, tracks_of
from trackweave.studies.hillis_search import (
    CLOSE,
    DEFAULT,
    GRID,
    METHODS,
    arriving,
    by_depth,
    on_islands,
    searching,
    stopping,
)
from trackweave.studies.judging import mean_curve, mean_of, share_where
from trackweave.studies.writing import Table, claims_text, numbers, text_by, text_table

__all__ = ["STUDY"]

MEASURES = ("right [%]", "switches", "GOSPA [m]")
# The patent's Figure 5 and what stands for it here: place, words.
APPARATUS = (
    ((0.10, 0.5), "objects 30\n\nwhat simulate draws,\nor the world"),
    ((0.34, 0.5), "sensors 40\n\nSensor: noise, detection\nprobability, clutter,\nscan period"),
    (
        (0.61, 0.80),
        "computer 50: memory\n\nWindow, association tree,\nfixed history of the tracks",
    ),
    (
        (0.61, 0.20),
        "computer 50: processors\n\nGenetic: decode, score, breed;\non threads: Islands",
    ),
    ((0.90, 0.5), "hypothesis\n\ntracks, assignments,\namendments"),
)
ARROWS = (((0, 1), "seen"), ((1, 2), "reports"), ((2, 3), ""), ((3, 2), ""), ((2, 4), ""))


def _drawing(title: str, tracks: str, cost: float | None = None) -> Drawing:
    found = tracks_of(tracks)
    count = sum(len(track) for track in found)
    words = title if cost is None else f"{title}: {cost:.1f} nats".replace("-", "−")
    return Drawing(words, PLACES[:count], REPORTS[:count], found)


def _picture_of_choice(tables: Mapping[str, Table]) -> bytes:
    drawings = [
        _drawing(
            f"Begun as in Figure {row['as in Figure']}, {row['scans']} scans", row["tracks"],
            row["cost [nats]"],
        )
        for row in tables["example"].to_dicts()
        if row["scans"] > 1 and str(row["as in Figure"]) in "23"
    ]  # fmt: skip
    drawings += [
        _drawing(f"Window of {row['window']}, 3 scans", row["tracks"])
        for row in tables["said"].to_dicts()
        if row["scans"] == 3 and row["window"] in ("one scan", "five scans")
    ]
    return picture_of_hypotheses(drawings, columns=2)


def _picture_of_apparatus() -> bytes:
    """Return the patent's Figure 5 with the names of our parts."""
    with own_style():
        figure = Figure(figsize=(10.0, 3.2), facecolor="white")
        axes: Axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        box = {"boxstyle": "round,pad=0.6", "facecolor": "#EAF2F8", "edgecolor": "#0072B2"}
        boxes = [
            axes.text(*place, words, ha="center", va="center", fontsize=8.5, bbox=box)
            for place, words in APPARATUS
        ]
        for (begin, end), words in ARROWS:
            axes.annotate(
                words, APPARATUS[end][0], APPARATUS[begin][0], fontsize=8, ha="center",
                arrowprops={
                    "arrowstyle": "-|>", "color": "#333333", "patchA": boxes[begin],
                    "patchB": boxes[end], "shrinkA": 12, "shrinkB": 12,
                },
            ).set_text("")  # fmt: skip
        return png_of(figure)


def _curve(table: Table, objects: int, search: str, *, share: bool) -> SpreadCurve:
    """Return a search's mean over windows, at those numbers that all of them have reached."""
    course = table.filter(objects=objects, search=search)
    spent, excess, window = (
        numbers(course, name) for name in ("evaluations", "excess [nats]", "window")
    )
    points: list[tuple[float, ...]] = []
    last, end = last_of(table, objects, search)
    for x in (*(at for at in GRID if at < end), end):
        # A search that is over stays where it ended.
        done = [np.flatnonzero((window == each) & (spent <= x)) for each in np.unique(window)]
        own = np.array([excess[rows[-1]] if rows.size else np.nan for rows in done])
        own = last if x == end else own
        if not np.isfinite(own).all():
            continue
        if share:
            points.append((x, share_where(own <= CLOSE).value, 0.0, 0.0))
        else:
            mean = mean_of(own)
            half = float(np.nan_to_num(mean.high - mean.value, posinf=0.0))
            # On the logarithmic axis a lower end below nothing would hide the curve.
            points.append((x, mean.value, min(half, mean.value), half))
    x, y, *ends = np.array(points).T
    return SpreadCurve(x, y, None if share else np.array(ends))


def _pictures_of_search(table: Table) -> dict[str, bytes]:
    pictures = {}
    for share, name in ((False, "excess"), (True, "share")):
        panels = []
        for objects in sizes_of(table):
            names = [each for each in searches_of(table, objects) if each != DEFAULT]
            curves = {each: _curve(table, objects, each, share=share) for each in names}
            y_name = "windows at the best [%]" if share else "above the best there is [nats]"
            panels.append(
                Panel(f"{objects} objects", "individuals decoded", y_name, curves, True, not share)
            )
        pictures[f"{name}.png"] = picture_of_panels(panels)
    return pictures


def _mean(own: Table, name: str) -> str:
    return str(mean_of(numbers(own, name)))


def _last(table: Table) -> str:
    """Return where each search ends, by number of objects."""
    rows: list[tuple[object, ...]] = []
    for objects in sizes_of(table):
        for name in searches_of(table, objects):
            excess, spent = last_of(table, objects, name)
            best = share_where(excess <= CLOSE)
            rows.append((objects, name, f"{spent:.0f}", mean_of(excess), best))
    return text_table(("objects", "search", "evaluations", "excess [nats]", "at the best"), rows)


def _picture_of_depths(table: Table) -> bytes:
    panels = []
    titles = ("Reports assigned rightly", "Identity switches", "Distance from the truth")
    for title, measure in zip(titles, MEASURES, strict=True):
        curves = {}
        for place, method in enumerate(METHODS):
            curve = mean_curve(table.filter(method=method), "depth", measure)
            curves[method] = replace(curve, x=curve.x + 0.06 * (place - 2.5))
        panels.append(Panel(title, "depth of the window [scans]", measure, curves))
    return picture_of_panels(panels)


def _means_alone(table: Table, by: str) -> SpreadCurve:
    return replace(mean_curve(table, by, "excess [nats]"), spread=None)


def _picture_of_stops(tables: Mapping[str, Table]) -> bytes:
    thresholds, stops = tables["thresholds"], tables["interruptions"]
    by_threshold = {
        f"{objects} objects": _means_alone(own, "threshold [nats]")
        for (objects,), own in thresholds.sort("objects").group_by("objects", maintain_order=True)
        if own["generation"].count()
    }
    late = _means_alone(stops, "looks")
    y_name = "above the best there is [nats]"
    return picture_of_panels([
        Panel(
            "Stopped by the threshold", "mean less fittest [nats]", y_name, by_threshold,
            True, True,
        ),
        Panel(
            "Stopped by the next scan", "looks at the clock", y_name, {"10 objects": late},
            True, True,
        ),
    ])  # fmt: skip


def _report(tables: Mapping[str, Table], claims: tuple[Claim, ...]) -> str:
    example = tables["example"]
    shown = {
        "example": text_table(example.columns, example.rows()),
        "search": _last(tables["search"]),
        "depths": text_by(tables["depths"], ("depth", "method"), MEASURES, _mean),
        "islands": text_by(tables["islands"], ("search",), ("excess [nats]",), _mean),
    }
    sections = [
        f"{text}\n\n{shown[name]}\n\nNumbers: {name}.csv" for name, text in SAY.sections().items()
    ]
    begin, drawings, end = (SAY.text(name) for name in ("begin", "drawings", "end"))
    return f"{begin}{claims_text(claims)}{drawings}" + "\n\n".join(sections) + end


def _write_up(tables: Mapping[str, Table], quick: bool) -> WriteUp:
    claims = claims_of(tables)
    drawings = [
        _drawing(f"Figure {row['figure']}", row["decoded"], row["cost [nats]"])
        for row in tables["figures"].to_dicts()
    ]
    pictures = {
        "figures.png": picture_of_hypotheses(drawings, columns=2),
        "figure5.png": _picture_of_apparatus(),
        "example.png": _picture_of_choice(tables),
        **_pictures_of_search(tables["search"]),
        "depths.png": _picture_of_depths(tables["depths"]),
        "stops.png": _picture_of_stops(tables),
    }
    return WriteUp(_report(tables, claims), claims, pictures)


STUDY = Study(
    (
        Part("drawings", drawn),
        Part("depth", by_depth),
        Part("search", searching),
        Part("stopping", stopping),
        Part("alone", arriving),
        Part("islands", on_islands),
    ),
    _write_up,
)
