"""Figures of hypotheses: reports as circles, and arrows from each to the next of its track."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from trackweave.arrays import FloatArray
from trackweave.plotting._canvas import own_style, png_of

__all__ = ["Drawing", "picture_of_hypotheses"]

WIDTH_IN, HEIGHT_IN = 3.5, 1.75
# Okabe and Ito's colours, told apart by colour-blind people; lines differ too.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
LINES = ("-", "--", "-.", ":")
LONE_COLOUR = "#777777"


@dataclass(frozen=True, slots=True, eq=False)
class Drawing:
    """A hypothesis to draw."""

    title: str  # What stands above it
    places: FloatArray  # Where each report is [m], shape (reports, 2)
    names: Sequence[str]  # What each is called
    tracks: Iterable[tuple[int, ...]]  # The reports of each track in order, as places in ``names``


def picture_of_hypotheses(drawings: Sequence[Drawing], columns: int) -> bytes:
    """Return a sheet of hypotheses in columns as PNG, all to one scale."""
    rows = math.ceil(len(drawings) / columns)
    with own_style():
        figure = Figure(
            figsize=(WIDTH_IN * columns, HEIGHT_IN * rows + 0.3), facecolor="white",
            layout="constrained",
        )  # fmt: skip
        grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
        for axes, drawing in zip(grid.flat, drawings, strict=False):
            _draw(axes, drawing)
        for axes in grid.flat[len(drawings) :]:
            axes.set_axis_off()
        for axes in grid[-1]:
            axes.set_xlabel("x [m]", fontsize=8)
        for axes in grid[:, 0]:
            axes.set_ylabel("y [m]", fontsize=8)
        return png_of(figure)


def _draw(axes: Axes, drawing: Drawing) -> None:
    linked = 0
    for track in sorted(drawing.tracks):
        colour = LONE_COLOUR
        if len(track) > 1:
            colour = COLOURS[linked % len(COLOURS)]
            _arrows(axes, drawing.places[list(track)], colour, LINES[linked % len(LINES)])
            linked += 1
        for report in track:
            _circle(axes, drawing.places[report], drawing.names[report], colour)
    axes.set_title(drawing.title, loc="left", fontsize=9)
    axes.set_aspect("equal", adjustable="box")
    axes.margins(0.16)
    axes.grid(visible=True, linewidth=0.4, alpha=0.5)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=7)


def _arrows(axes: Axes, places: FloatArray, colour: str, line: str) -> None:
    for begin, end in pairwise(places):
        style = {
            "arrowstyle": "-|>", "color": colour, "linewidth": 1.5, "linestyle": line,
            "shrinkA": 5.0, "shrinkB": 5.0,
        }  # fmt: skip
        axes.annotate("", xy=tuple(end), xytext=tuple(begin), arrowprops=style)


def _circle(axes: Axes, place: FloatArray, name: str, colour: str) -> None:
    axes.plot(
        *place, "o", color="white", markeredgecolor=colour, markeredgewidth=1.5, markersize=8
    )
    axes.annotate(
        name, tuple(place), xytext=(7.0, -3.0), textcoords="offset points", fontsize=8,
    )  # fmt: skip
