"""Wiranto & Bonok (2018), repeated: three radars, three courses, 100 scans."""

from collections.abc import Mapping

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.plotting.courses import CoursePanel, Layer, Look, picture_of_courses
from trackweave.plotting.panels_of_curves import Panel, SpreadCurve, picture_of_panels
from trackweave.studies import Part, Study, WriteUp
from trackweave.studies.judging import mean_curve, mean_of
from trackweave.studies.wiranto_claims import CLASSIFIED, EXCESS, FIRST, FORMATIONS, SAY, claims_of
from trackweave.studies.wiranto_plots import COLONIES, DEFAULT, EXACT, GREEDY, search, sorting
from trackweave.studies.wiranto_scenes import SKIES, STRAIGHT, TURN, TURNING
from trackweave.studies.wiranto_tracks import (
    IMM,
    LEGS,
    NOISES,
    PLOTS,
    PRESET,
    SELECTED,
    by_noise,
    figures,
    tracking,
)  # fmt: skip
from trackweave.studies.writing import Table, claims_text, numbers, text_by

__all__ = ["STUDY"]

EAST, NORTH, TIME = "east [km]", "north [km]", "time [s]"
SHOWN = {
    "figure5": (STRAIGHT[0], (20.0, 40.0)), "figure6": (TURNING, (TURN[0] - 5.0, TURN[1] + 10.0)),
}  # fmt: skip
NOISE = "noise [m²/s³]"
GROUPED = {
    "sorting": ("sky", "method"), "search": ("sky", "method", "cycles"), "tracking": ("tracker",),
    "courses": ("leg", "what"), "noise": ("tracker", NOISE, "leg"),
}  # fmt: skip


def _n_skies(quick: bool) -> dict[str, int]:
    return dict(zip(SKIES, (2, 1, 1) if quick else (30, 8, 6), strict=True))


def _write_up(tables: Mapping[str, Table], quick: bool) -> WriteUp:
    """Return the report, claims and figures that the tables make."""
    claims = claims_of(tables)
    sections = []
    for name, words in SAY.sections().items():
        table, by = tables[name], GROUPED[name]
        # Between the keys and the figures stands the number of the draw.
        figures = [column for column in table.columns[len(by) + 1 :] if column not in by]
        told = text_by(table, by, figures, _short)
        sections.append(f"{words}\n\n{told}\n\nNumbers: {name}.csv")
    draws = ", ".join(f"{count} {name}" for name, count in _n_skies(quick).items())
    begin, drawn = SAY.text("begin"), SAY.text("figures")
    text = f"{begin}{claims_text(claims)}{drawn}Draws of skies: {draws}.\n\n"
    return WriteUp(text + "\n\n".join(sections) + "\n", claims, _pictures(tables))


STUDY = Study(
    (
        Part("figures", lambda rng, quick, tick: figures(rng, tick)),
        Part("sorting", lambda rng, quick, tick: sorting(
            rng, _n_skies(quick), 40 if quick else 100, tick
        )),
        Part("search", lambda rng, quick, tick: search(rng, 1 if quick else 8, tick)),
        Part("tracking", lambda rng, quick, tick: tracking(rng, 1 if quick else 12, tick)),
        Part("noise", lambda rng, quick, tick: by_noise(
            rng, NOISES[3:4] if quick else NOISES, 1 if quick else 3, tick
        )),
    ),
    _write_up,
)  # fmt: skip


def _short(own: Table, name: str) -> str:
    """Return a mean over draws with its interval, as far as there are any."""
    found = mean_of(numbers(own, name), "%" if name.endswith("[%]") else "")
    if not found.count:
        return "–"
    ends = f" ({found.low:.4g} to {found.high:.4g})" if found.low < found.high else ""
    return f"{found.value:.4g}{ends if np.isfinite(found.low) else ''}"


def _pictures(tables: Mapping[str, Table]) -> dict[str, bytes]:
    return {
        "figure3.png": _selected(tables["figure3"]),
        "figure4.png": _estimates(tables["figure4"]),
        "figure5.png": _zoom(tables, "figure5", "Figure 5: constant velocity"),
        "figure6.png": _zoom(tables, "figure6", "Figure 6: manoeuvre"),
        "search.png": _curves(tables["search"]),
        "noise.png": _by_noise(tables["noise"]),
    }


def _places(look: Look, name: str, place: FloatArray) -> Layer:
    return Layer(name, look, place[:, 0] / 1e3, place[:, 1] / 1e3)


def _selected(table: Table) -> bytes:
    place = np.stack([numbers(table, "x"), numbers(table, "y")], axis=1)
    is_object, told = (np.array([row[at] is not None for row in table.rows()]) for at in (4, 5))
    wrong = told != is_object
    before = (
        _places("false", "false alarms", place[~is_object]),
        _places("plot", "plots of aircraft", place[is_object]),
    )
    after = (
        _places("plot", "selected", place[told]),
        _places("wrong", "false alarms selected", place[wrong & told]),
        _places("missed", "plots of aircraft left out", place[wrong & ~told]),
    )
    return picture_of_courses([
        CoursePanel("All plots of three radars, 100 scans", EAST, NORTH, before),
        CoursePanel("Figure 3: selected by the Ant System", EAST, NORTH, after),
    ])  # fmt: skip


def _lines(table: Table, what: str, within: tuple[float, float]) -> FloatArray:
    """Return the points of some kind within a time, with a gap between names."""
    place: list[tuple[float, ...]] = []
    before = None
    for kind, name, time, *where in table.rows():
        if kind == what and within[0] <= time <= within[1]:
            place += [(np.nan, np.nan)] * (name != before and what != SELECTED)
            place.append(tuple(where))
            before = name
    return np.array(place, dtype=float).reshape(-1, 2)


def _estimates(table: Table) -> bytes:
    always = (-np.inf, np.inf)
    layers = (
        _places("truth", "true trajectories", _lines(table, "truth", always)),
        _places("estimate", "estimated trajectories", _lines(table, "estimate", always)),
    )
    return picture_of_courses([
        CoursePanel("Figure 4: nearest-neighbour Kalman filter", EAST, NORTH, layers)
    ])  # fmt: skip


def _zoom(tables: Mapping[str, Table], figure: str, title: str) -> bytes:
    """Return an aircraft's course from near, and how far off it is over time."""
    (name, span), off = SHOWN[figure], tables[figure]
    plots, points = tables["figure3"], tables["figure4"]
    time = numbers(plots, "time", target=name)
    chosen = (time >= span[0]) & (time <= span[1])
    own = np.stack([numbers(plots, axis, target=name)[chosen] for axis in ("x", "y")], axis=1)
    low, high = own.min(axis=0) - 100.0, own.max(axis=0) + 100.0

    def near(what: str) -> FloatArray:
        place = _lines(points, what, span)
        # No comparison holds for a gap.
        found: FloatArray = place[~np.any((place < low) | (place > high), axis=1)]
        return found

    near_by = (
        _places("truth", "true trajectory", near("truth")),
        _places("plot", "plots", own), _places("fused", SELECTED, near(SELECTED)),
        _places("estimate", "estimate", near("estimate")),
    )  # fmt: skip
    looks: tuple[tuple[str, Look], ...] = (
        (PLOTS, "plot"), (SELECTED, "fused"), ("estimate", "estimate"), (IMM, "other estimate"),
    )  # fmt: skip
    over_time = [
        Layer(what, look, *(numbers(off, n, what=what) for n in ("time", "to the right [m]")))
        for what, look in looks
    ]
    if figure == "figure6":
        ends = np.array([-150.0, 150.0, np.nan] * 2)
        over_time.append(Layer("the turn's ends", "mark", np.repeat(TURN, 3), ends))
    return picture_of_courses([
        # A straight course is a thin line in any plan: its scatter is drawn larger.
        CoursePanel(f"{title}, {span[0]:g}–{span[1]:g} s", EAST, NORTH, near_by,
                    is_plan=name == TURNING),
        CoursePanel("To the right of the course", TIME, "offset [m]", tuple(over_time),
                    is_plan=False),
    ])  # fmt: skip


def _curves(table: Table) -> bytes:
    panels = []
    for sky in (FIRST, FORMATIONS):
        for y in (EXCESS, CLASSIFIED):
            curves = {
                name: mean_curve(table.filter(sky=sky, method=name), "cycles", y, "evaluations")
                for name in COLONIES
            }
            ends = np.array([min(c.x.min() for c in curves.values()),
                             max(c.x.max() for c in curves.values())])  # fmt: skip
            for name in (GREEDY, EXACT, DEFAULT)[: 3 if y == CLASSIFIED else 2]:
                level = mean_of(numbers(table, y, sky=sky, method=name)).value
                curves[name] = SpreadCurve(ends, np.full(2, level))
            panels.append(Panel(sky, "tours", y, curves, x_logarithmic=True))
    return picture_of_panels(panels)


def _by_noise(table: Table) -> bytes:
    wanted = (
        ("Displacement in the turn", "to the right [m]", LEGS[1]),
        ("Error in the turn", "RMSE [m]", LEGS[1]),
        ("Error on straight courses", "RMSE [m]", LEGS[0]),
    )
    return picture_of_panels([
        Panel(title, "process noise [m²/s³]", name, {
            tracker: mean_curve(table.filter(tracker=tracker, leg=leg), NOISE, name)
            for tracker in (PRESET, IMM)
        }, x_logarithmic=True)
        for title, name, leg in wanted
    ])  # fmt: skip
