"""Figures of studies: some curves over one axis."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import matplotlib as mpl
import matplotlib.style
from matplotlib.figure import Figure

from trackweave.arrays import FloatArray
from trackweave.plotting._png import png_of

__all__ = ["Curve", "Sheet", "picture_of_curves"]

SIZE_IN = (7.2, 4.4)
# Told apart without colour too.
MARKS = "os^Dv*P"


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A curve of a figure.

    Parameters
    ----------
    x, y
        Its points, each of shape (points,); a point that is not finite is left out.
    """

    x: FloatArray
    y: FloatArray


@dataclass(frozen=True, slots=True)
class Sheet:
    """A figure but for its curves.

    Parameters
    ----------
    title, x_name, y_name
        What stands above and beside it.
    x_logarithmic, y_logarithmic
        Whether an axis is logarithmic.
    ticks
        Words for places along x.
    """

    title: str
    x_name: str
    y_name: str
    x_logarithmic: bool = False
    y_logarithmic: bool = False
    ticks: Mapping[float, str] = field(default_factory=dict)


def picture_of_curves(sheet: Sheet, curves: Mapping[str, Curve]) -> bytes:
    """Return a figure of curves as PNG.

    Parameters
    ----------
    sheet
        What it says.
    curves
        The curves by their names.

    Returns
    -------
    The file's bytes; equal curves give equal bytes with one version of matplotlib.
    """
    # The user's own style files must not change the picture.
    with matplotlib.style.context("default"), mpl.rc_context():
        figure = Figure(figsize=SIZE_IN, facecolor="white", layout="constrained")
        axes = figure.add_subplot()
        for mark, (name, curve) in zip(MARKS, curves.items(), strict=False):
            axes.plot(curve.x, curve.y, marker=mark, markersize=4, linewidth=1.4, label=name)
        axes.set_title(sheet.title, loc="left", fontsize=11)
        axes.set_xlabel(sheet.x_name)
        axes.set_ylabel(sheet.y_name)
        if sheet.x_logarithmic:
            axes.set_xscale("log")
        if sheet.y_logarithmic:
            axes.set_yscale("symlog", linthresh=0.1)
        if sheet.ticks:
            axes.set_xticks(list(sheet.ticks), list(sheet.ticks.values()))
        axes.grid(visible=True, linewidth=0.4, alpha=0.6)
        axes.legend(frameon=False, fontsize=9)
        return png_of(figure)
