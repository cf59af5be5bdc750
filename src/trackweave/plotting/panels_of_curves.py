"""Figures of studies: panels of curves side by side, each curve with its spread."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from trackweave.arrays import FloatArray
from trackweave.plotting._canvas import own_style, png_of

__all__ = ["Panel", "SpreadCurve", "picture_of_panels"]

WIDTH_IN, HEIGHT_IN = 3.6, 3.6
# Okabe and Ito's colours; marks and lines tell the curves apart without them.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#333333", "#E69F00", "#56B4E9")
MARKS = "os^Dv*P"
LINES = ("-", "--", "-.", ":", "-", "--", "-.")


@dataclass(frozen=True, slots=True, eq=False)
class SpreadCurve:
    """A curve and how far what it is the mean of spreads."""

    x: FloatArray
    y: FloatArray  # Its points, each of shape (points,); a point that is not finite is left out
    # Half the length of the bar at each point, or its parts below and above, shape (2, points);
    # None for none.
    spread: FloatArray | None = None


@dataclass(frozen=True, slots=True)
class Panel:
    """Curves over one axis."""

    title: str
    x_name: str
    y_name: str  # What stands above and beside it
    # The curves by their names; a name has one look in all panels.
    curves: Mapping[str, SpreadCurve]
    x_logarithmic: bool = False
    y_logarithmic: bool = False  # Whether an axis is logarithmic; along y it is linear below 1


def picture_of_panels(panels: Sequence[Panel]) -> bytes:
    """Return panels side by side as PNG, with one legend below where curves need one."""
    names = list(dict.fromkeys(name for panel in panels for name in panel.curves))
    with own_style():
        figure = Figure(
            figsize=(WIDTH_IN * len(panels), HEIGHT_IN), facecolor="white", layout="constrained"
        )
        known: dict[str, Any] = {}
        for axes, panel in zip(
            figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True
        ):
            known |= _draw(axes, panel, names)
        # A single curve is what the panel's title says.
        if any(len(panel.curves) > 1 for panel in panels):
            figure.legend(
                [known[name] for name in names], names, loc="outside lower center",
                ncols=min(len(names), 2 * len(panels)), frameon=False, fontsize=8,
            )  # fmt: skip
        return png_of(figure)


def _draw(axes: Axes, panel: Panel, names: Sequence[str]) -> dict[str, Any]:
    drawn: dict[str, Any] = {}
    for name, curve in panel.curves.items():
        look = names.index(name) % len(COLOURS)
        # Many points would hide the line behind their marks.
        drawn[name] = axes.errorbar(
            curve.x, curve.y, yerr=curve.spread, color=COLOURS[look], linestyle=LINES[look],
            marker=MARKS[look], markersize=4, markevery=max(1, len(curve.x) // 12),
            linewidth=1.4, elinewidth=0.8, capsize=2.5,
        )  # fmt: skip
    axes.set_title(panel.title, loc="left", fontsize=9)
    axes.set_xlabel(panel.x_name, fontsize=9)
    axes.set_ylabel(panel.y_name, fontsize=9)
    if panel.x_logarithmic:
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter(_shown)
    if panel.y_logarithmic:
        axes.set_yscale("symlog", linthresh=1.0)
        highest = max(float(np.nanmax(curve.y, initial=1.0)) for curve in panel.curves.values())
        axes.set_ylim(-0.2, 2.0 * highest)
        axes.yaxis.set_major_formatter("{x:g}")
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.tick_params(labelsize=8)
    return drawn


def _shown(value: float, _place: float) -> str:
    """Return a number as short as neighbouring ticks need it, a million as 1M."""
    for size, letter in ((1e6, "M"), (1e3, "k")):
        if value >= size:
            return f"{value / size:g}{letter}"
    return f"{value:g}"
