"""Figures of studies: plots, courses and estimates, on a plan or over time."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from trackweave.arrays import FloatArray
from trackweave.plotting._canvas import own_style, png_of

__all__ = ["CoursePanel", "Layer", "Look", "picture_of_courses"]

WIDTH_IN, HEIGHT_IN = 4.6, 5.0
Look = Literal[
    "false", "plot", "wrong", "missed", "mark", "fused", "truth", "estimate", "other estimate"
]
# Okabe and Ito's colours by what is shown, on top of one another in the order of the layers.
LOOKS: dict[Look, dict[str, Any]] = {
    "false": {"marker": ".", "markersize": 2.5, "linestyle": "", "color": "#B8B8B8"},
    "plot": {"marker": ".", "markersize": 4.0, "linestyle": "", "color": "#0072B2"},
    "wrong": {
        "marker": "o", "markersize": 6.0, "linestyle": "", "color": "#D55E00",
        "markerfacecolor": "none", "markeredgewidth": 1.1,
    },
    "missed": {
        "marker": "s", "markersize": 5.0, "linestyle": "", "color": "#E69F00",
        "markerfacecolor": "none", "markeredgewidth": 1.1,
    },
    "mark": {"linestyle": ":", "linewidth": 1.0, "color": "#666666"},
    "fused": {
        "marker": "x", "markersize": 4.0, "linestyle": "", "color": "#56B4E9",
        "markeredgewidth": 1.0,
    },
    # Wide and light, so that an estimate on top of it can be seen on it and off it.
    "truth": {"linestyle": "-", "linewidth": 4.5, "color": "#C8C8C8", "solid_capstyle": "butt"},
    "estimate": {"linestyle": "-", "linewidth": 1.3, "color": "#D55E00"},
    "other estimate": {"linestyle": "--", "linewidth": 1.5, "color": "#009E73"},
}  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """Points or a line."""

    name: str  # What the legend calls it; empty for what is in it already
    look: Look  # What is shown
    x: FloatArray
    y: FloatArray  # Its points, each of shape (points,); a line has a gap where one is not finite


@dataclass(frozen=True, slots=True)
class CoursePanel:
    """Layers over one pair of axes."""

    title: str
    x_name: str
    y_name: str  # What stands above and beside it
    layers: tuple[Layer, ...]  # What it shows, the lowest first
    is_plan: bool = True  # Whether both axes have one scale


def picture_of_courses(panels: Sequence[CoursePanel]) -> bytes:
    """Return panels side by side, each with its legend below, as PNG."""
    with own_style():
        figure = Figure(
            figsize=(WIDTH_IN * len(panels), HEIGHT_IN), facecolor="white", layout="constrained"
        )
        every = figure.subplots(1, len(panels), squeeze=False)[0]
        for axes, panel in zip(every, panels, strict=True):
            _draw(axes, panel)
        if all(panel.is_plan for panel in panels):
            _show_alike(every)
        return png_of(figure)


def _show_alike(every: Sequence[Axes]) -> None:
    """Let plans that stand side by side show the same ground."""
    whole = Bbox.union([axes.dataLim for axes in every])
    for axes in every:
        axes.update_datalim(whole.get_points())
        axes.autoscale_view()


def _draw(axes: Axes, panel: CoursePanel) -> None:
    for layer in panel.layers:
        # A name that begins with an underscore stays out of the legend.
        axes.plot(layer.x, layer.y, label=layer.name or "_", **LOOKS[layer.look])
    axes.set_title(panel.title, loc="left", fontsize=10)
    axes.set_xlabel(panel.x_name, fontsize=9)
    axes.set_ylabel(panel.y_name, fontsize=9)
    if panel.is_plan:
        axes.set_aspect("equal", adjustable="datalim")
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=8)
    axes.legend(
        loc="upper center", bbox_to_anchor=(0.5, -0.11), ncols=2, frameon=False, fontsize=8
    )
