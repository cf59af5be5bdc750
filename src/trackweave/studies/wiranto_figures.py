"""Figures 3 to 6 of the document, drawn from a sky of ours."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.plotting.courses import CoursePanel, Layer, Look, picture_of_courses
from trackweave.studies.wiranto_parts import sort_sky
from trackweave.studies.wiranto_plots import DOCUMENT, Sorted
from trackweave.studies.wiranto_scenes import (
    PERIOD,
    STRAIGHT,
    TURN_BEGINS,
    TURN_ENDS,
    TURNING,
    RadarSky,
    SkyShape,
    draw_sky,
)
from trackweave.studies.wiranto_tracks import (
    IMM,
    PRESET,
    Tracked,
    offsets_from,
    offsets_of_plots,
    run_tracker,
)
from trackweave.studies.writing import csv_table

__all__ = ["FigureSky", "document_figures", "draw_figure_sky"]

EAST, NORTH, TIME = "east [km]", "north [km]", "time [s]"
SHOWN_STRAIGHT, SHOWN_TURN = (20.0, 40.0), (TURN_BEGINS - 5.0, TURN_ENDS + 10.0)
KILO = 1e3


@dataclass(frozen=True, slots=True, eq=False)
class FigureSky:
    """The sky of the figures, and what came of it.

    Parameters
    ----------
    sky
        The sky.
    selected
        Its plots as the Ant System sorts them.
    document, imm
        What the preset and our default with several motions make of it.
    """

    sky: RadarSky
    selected: Sorted
    document: Tracked
    imm: Tracked


def draw_figure_sky(rng: np.random.Generator) -> FigureSky:
    """Return a sky as chosen for the study, sorted and tracked.

    Parameters
    ----------
    rng
        Source of randomness.

    Returns
    -------
    The sky and what came of it.
    """
    sky = draw_sky(SkyShape(), rng)
    selected = sort_sky(sky, [DOCUMENT], rng)[DOCUMENT]
    return FigureSky(sky, selected, run_tracker(sky, PRESET, rng), run_tracker(sky, IMM, rng))


def document_figures(drawn: FigureSky) -> dict[str, bytes]:
    """Return the pictures and their numbers.

    Parameters
    ----------
    drawn
        The sky.

    Returns
    -------
    Files by their names.
    """
    return {
        "figure3.png": _selected_plots(drawn),
        **_numbers_of_plots(drawn),
        "figure4.png": _estimates(drawn),
        **_numbers_of_tracks(drawn),
        "figure5.png": _straight_course(drawn),
        **_numbers_of_course(drawn, STRAIGHT[0], "figure5.csv"),
        "figure6.png": _turn(drawn),
        **_numbers_of_course(drawn, TURNING, "figure6.csv"),
    }


def _places(look: Look, name: str, place: FloatArray) -> Layer:
    return Layer(name, look, place[:, 0] / KILO, place[:, 1] / KILO)


def _courses(drawn: FigureSky, names: Sequence[str], begin: float, end: float) -> Layer:
    """Return courses within a time, with gaps between them."""
    parts = []
    for name in names:
        time, place, _ = drawn.sky.course(name)
        parts += [place[(time >= begin) & (time <= end)], np.full((1, 2), np.nan)]
    return _places("truth", "truth", np.concatenate(parts))


def _selected_plots(drawn: FigureSky) -> bytes:
    sky, told = drawn.sky, drawn.selected.group >= 0
    place, is_object = sky.reports.measurement, sky.target >= 0
    wrong = told != is_object
    before = CoursePanel(
        "All plots of three radars", EAST, NORTH,
        (
            _places("false", "false alarms", place[~is_object]),
            _places("plot", "plots of aircraft", place[is_object]),
        ),
    )  # fmt: skip
    after = CoursePanel(
        "Figure 3: selected by the Ant System", EAST, NORTH,
        (
            _places("false", "taken for false alarms", place[~told]),
            _places("plot", "selected", place[told]),
            _places("wrong", "false alarms selected", place[wrong & told]),
            _places("missed", "plots of aircraft left out", place[wrong & ~told]),
        ),
    )  # fmt: skip
    return picture_of_courses([before, after])


def _lines(tracks: TrackTable, begin: float, end: float) -> FloatArray:
    """Return the estimates of confirmed tracks within a time, with gaps between them."""
    shown = (tracks.status >= CONFIRMED) & (tracks.time >= begin) & (tracks.time <= end)
    parts = [np.empty((0, 2))]
    for track in np.unique(tracks.track[shown]):
        own = shown & (tracks.track == track)
        parts += [tracks.mean[own, :2], np.full((1, 2), np.nan)]
    return np.concatenate(parts)


def _estimates(drawn: FigureSky) -> bytes:
    names, everything = (*STRAIGHT, TURNING), (-np.inf, np.inf)
    panel = CoursePanel(
        "Figure 4: nearest-neighbour Kalman filter", EAST, NORTH,
        (
            _places("estimate", "estimates", _lines(drawn.document.tracks, *everything)),
            _courses(drawn, names, *everything),
        ),
    )  # fmt: skip
    return picture_of_courses([panel])


def _plots_of(drawn: FigureSky, name: str, begin: float, end: float) -> NDArray[np.bool_]:
    """Return which plots are of an aircraft within a time."""
    reports = drawn.sky.reports
    own = np.asarray(reports.carried["target"]) == name
    chosen: NDArray[np.bool_] = own & (reports.time >= begin) & (reports.time <= end)
    return chosen


def _near(place: FloatArray, plots: FloatArray) -> FloatArray:
    """Return the places that lie about some plots, and the gaps between them."""
    low, high = plots.min(axis=0) - 100.0, plots.max(axis=0) + 100.0
    # No comparison holds for a gap.
    found: FloatArray = place[~np.any((place < low) | (place > high), axis=1)]
    return found


def _zoom(drawn: FigureSky, name: str, span: tuple[float, float], title: str) -> CoursePanel:
    plots = drawn.sky.reports.measurement[_plots_of(drawn, name, *span)]
    selected = drawn.selected
    during = (selected.time >= span[0]) & (selected.time <= span[1])
    lines = _lines(drawn.document.tracks, *span)
    return CoursePanel(
        title, EAST, NORTH,
        (
            _places("plot", "plots", plots),
            _places("fused", "selected, fused", _near(selected.place[during], plots)),
            _places("estimate", "estimate", _near(lines, plots)),
            _courses(drawn, [name], *span),
        ),
        # A straight course is a thin line in any plan: its scatter is drawn larger.
        is_plan=name == TURNING,
    )  # fmt: skip


def _straight_course(drawn: FigureSky) -> bytes:
    name, selected = STRAIGHT[0], drawn.selected
    fused = offsets_from(drawn.sky, name, selected.time, selected.place)
    own = drawn.document.offsets[name]
    over_time = CoursePanel(
        "Distance from the truth", TIME, "[m]",
        (
            Layer("selected, fused", "fused", fused.time, fused.distance),
            Layer("estimate", "estimate", own.time, own.distance),
        ),
        is_plan=False,
    )  # fmt: skip
    span = SHOWN_STRAIGHT
    title = f"Figure 5: constant velocity, {span[0]:g}–{span[1]:g} s"
    return picture_of_courses([_zoom(drawn, name, span, title), over_time])


def _turn(drawn: FigureSky) -> bytes:
    plots = offsets_of_plots(drawn.sky, TURNING)
    own, imm = drawn.document.offsets[TURNING], drawn.imm.offsets[TURNING]
    ends = np.array([TURN_BEGINS, TURN_ENDS])
    over_time = CoursePanel(
        "To the right of the course, outside of the turn", TIME, "[m]",
        (
            Layer("plots", "plot", plots.time, plots.right),
            Layer("begin and end of the turn", "mark", np.repeat(ends, 3), _bars()),
            Layer("estimate", "estimate", own.time, own.right),
            Layer("our default, imm", "other estimate", imm.time, imm.right),
        ),
        is_plan=False,
    )  # fmt: skip
    title = "Figure 6: manoeuvre"
    return picture_of_courses([_zoom(drawn, TURNING, SHOWN_TURN, title), over_time])


def _bars() -> FloatArray:
    """Return heights of two upright bars with a gap between them."""
    return np.array([-150.0, 150.0, np.nan] * 2)


def _numbers_of_plots(drawn: FigureSky) -> dict[str, bytes]:
    reports, group = drawn.sky.reports, drawn.selected.group
    rows = [
        (
            float(reports.time[row]), reports.sensors[reports.sensor[row]],
            *reports.measurement[row].tolist(), str(reports.carried["target"][row]) or None,
            int(group[row]) if group[row] >= 0 else None,
        )
        for row in range(len(reports))
    ]  # fmt: skip
    return csv_table(("time", "sensor", "x", "y", "target", "group"), rows, "figure3.csv")


def _numbers_of_tracks(drawn: FigureSky) -> dict[str, bytes]:
    tracks = drawn.document.tracks
    rows = [
        (float(tracks.time[row]), int(tracks.track[row]), *tracks.mean[row, :2].tolist())
        for row in np.flatnonzero(tracks.status >= CONFIRMED).tolist()
    ]
    return csv_table(("time", "track", "x", "y"), rows, "figure4.csv")


def _numbers_of_course(drawn: FigureSky, name: str, file: str) -> dict[str, bytes]:
    """Return how far off the course the measurement and the estimates are at each time."""
    selected = drawn.selected
    shown = {
        "selected, fused": offsets_from(drawn.sky, name, selected.time, selected.place),
        "estimate": drawn.document.offsets[name],
        "our default, imm": drawn.imm.offsets[name],
    }
    time, place, _ = drawn.sky.course(name)
    columns: list[list[float | None]] = []
    for off in shown.values():
        at = np.round(off.time / PERIOD).astype(np.int64).tolist()
        for values in (off.ahead, off.right):
            known = dict(zip(at, values.tolist(), strict=True))
            columns.append([known.get(moment) for moment in range(time.size)])
    names = [f"{what}: {axis} [m]" for what in shown for axis in ("ahead", "right")]
    rows = zip(time.tolist(), *place.T.tolist(), *columns, strict=True)
    return csv_table(["time", "x", "y", *names], [list(row) for row in rows], file)
