"""A sheet with equal axes in m or km, whose places on paper are known before it is drawn."""

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from trackweave.arrays import FloatArray

__all__ = ["LEGEND_TOP_IN", "Canvas", "open_canvas"]

LEAST_WIDTH_IN, GREATEST_WIDTH_IN = 7.0, 9.6
LEAST_HEIGHT_IN, GREATEST_HEIGHT_IN = 4.2, 9.6
LEFT_IN, RIGHT_IN, BOTTOM_IN, TOP_IN = 0.85, 0.35, 1.15, 0.5
LEGEND_TOP_IN = 0.6  # from the sheet's lower edge: just below the axis' name
KILOMETRES_FROM_M = 5000.0
POINTS_PER_INCH = 72.0


class Canvas(NamedTuple):
    """The sheet and how places are laid on it.

    Parameters
    ----------
    figure
        The sheet.
    axes
        Its only axes.
    unit_m
        What one unit on the axes is [m]: 1 or 1000.
    low
        Lower left corner of the axes [m].
    points_per_m
        Scale on paper [points/m], the same along both axes.
    """

    figure: Figure
    axes: Axes
    unit_m: float
    low: FloatArray
    points_per_m: float

    def on_axes(self, places: FloatArray) -> FloatArray:
        """Return places [m] in the axes' unit, in the plane."""
        return places[..., :2] / self.unit_m

    def on_paper(self, places: FloatArray) -> FloatArray:
        """Return places [m] in points from the axes' lower left corner."""
        return (places[..., :2] - self.low) * self.points_per_m


def open_canvas(places: FloatArray) -> Canvas:
    """Return a sheet that shows all places.

    Parameters
    ----------
    places
        Whatever must be seen [m], shape (places, dim).

    Returns
    -------
    A sheet whose sides follow the places' extent within limits.
    """
    low, high = _limits(places)
    size = high - low
    slope = size[1] / size[0]
    height = float(np.clip(GREATEST_WIDTH_IN * slope, LEAST_HEIGHT_IN, GREATEST_HEIGHT_IN))
    width = float(np.clip(height / slope, LEAST_WIDTH_IN, GREATEST_WIDTH_IN))
    # Where a side was limited, the other axis shows more, so that the scales stay equal.
    scale = max(size[0] / width, size[1] / height)
    grown = scale * np.array([width, height])
    low, high = low - (grown - size) / 2, high + (grown - size) / 2
    unit_m = 1000.0 if grown.max() > KILOMETRES_FROM_M else 1.0
    sheet = np.array([LEFT_IN + width + RIGHT_IN, BOTTOM_IN + height + TOP_IN])
    figure = Figure(figsize=(sheet[0], sheet[1]), facecolor="white")
    box = (LEFT_IN / sheet[0], BOTTOM_IN / sheet[1], width / sheet[0], height / sheet[1])
    axes = figure.add_axes(box)
    axes.set_xlim(low[0] / unit_m, high[0] / unit_m)
    axes.set_ylim(low[1] / unit_m, high[1] / unit_m)
    axes.set_autoscale_on(False)
    return Canvas(figure, axes, unit_m, low, POINTS_PER_INCH / scale)


def _limits(places: FloatArray) -> tuple[FloatArray, FloatArray]:
    flat = places[:, :2] if len(places) else np.zeros((1, 2))
    low, high = flat.min(axis=0), flat.max(axis=0)
    # One place, or places on a line, still need a sheet with two sides.
    side = float((high - low).max()) or max(100.0, 1e-6 * float(np.abs(flat).max()))
    centre = (low + high) / 2
    half = np.maximum(high - low, 0.05 * side) / 2 + 0.035 * side
    return centre - half, centre + half
