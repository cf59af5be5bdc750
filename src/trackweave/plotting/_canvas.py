"""A sheet with equal axes in m or km, whose places on paper are known before it is drawn."""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import matplotlib as mpl
import matplotlib.style
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from trackweave.arrays import FloatArray

__all__ = [
    "COLOURS",
    "LEGEND_TOP_IN",
    "METADATA",
    "Canvas",
    "Look",
    "encoded",
    "label_offsets",
    "looks_of",
    "open_canvas",
    "own_style",
    "png_of",
]

# Okabe and Ito's colours, told apart by colour-blind people; dark and light ones take turns so
# that neighbours differ in grey too, and each use of a colour has another kind of line.
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#333333", "#D55E00", "#56B4E9")
LINES: tuple[tuple[float, ...], ...] = ((), (7, 1.6), (9, 1.6, 1.6, 1.6), (3, 1.2))
MOST_COMPARED = 200
POINTS_OF_A_PATH = 24


class Look(NamedTuple):
    """How a track is drawn: its colour and its dashes, none for a solid line."""

    colour: str
    dashes: tuple[float, ...]


def looks_of(paths: list[FloatArray]) -> list[Look]:
    """Return a look for each track, such that no neighbours look alike."""
    # Paths run in one unit along both axes, each of shape (places, 2). The colour is that whose
    # last use lies farthest from the track, the first of equals; of very many tracks, which are
    # hairlines, the colours go in turn.
    if len(paths) > MOST_COMPARED:
        return [Look(COLOURS[number % len(COLOURS)], ()) for number in range(len(paths))]
    drawn: list[list[FloatArray]] = [[] for _ in COLOURS]
    looks = []
    for path in paths:
        places = path[np.linspace(0, len(path) - 1, POINTS_OF_A_PATH).round().astype(int)]
        colour = int(np.argmax([_distance(places, others) for others in drawn]))
        looks.append(Look(COLOURS[colour], LINES[len(drawn[colour]) % len(LINES)]))
        drawn[colour].append(places)
    return looks


def _distance(places: FloatArray, others: list[FloatArray]) -> float:
    """Return how near other paths come, infinity for none."""
    if not others:
        return np.inf
    apart = places[:, None] - np.concatenate(others)[None]
    return float(np.sum(apart**2, axis=2).min())


CHARACTER_POINTS, LINE_POINTS = 6.6, 12.0  # with the frame around the text
REACH_POINTS = 10.0
# Turns from the direction of movement, in the order of preference [degrees].
TURNS_DEG = (0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0)
SIZES = (1.0, 1.8, 2.8)


def label_offsets(
    anchors: FloatArray, directions: FloatArray, texts: list[str], obstacles: FloatArray
) -> FloatArray:
    """Return where the middle of each text goes, relative to its anchor [points]."""
    # It is for each text in turn the candidate that covers the fewest others, the first of equals.
    # Obstacles are places on paper that texts should rather not cover; directions are where texts
    # would like to lie from their anchors, of any length.
    offsets = np.zeros((len(texts), 2))
    boxes = np.empty((0, 4))
    for number, words in enumerate(texts):
        half = np.array([CHARACTER_POINTS * len(words), LINE_POINTS]) / 2
        tries = _candidates(directions[number], half)
        centres = anchors[number] + tries
        trial = np.concatenate([centres - half, centres + half], axis=1)
        price = 20.0 * _overlaps(trial, boxes) + _covered(trial, obstacles)
        best = int(np.argmin(price + 0.1 * np.arange(len(tries))))
        offsets[number] = tries[best]
        boxes = np.concatenate([boxes, trial[best : best + 1]])
    return offsets


def _candidates(direction: FloatArray, half: FloatArray) -> FloatArray:
    angle = np.arctan2(direction[1], direction[0])
    turned = angle + np.radians(np.array(TURNS_DEG))
    unit = np.stack([np.cos(turned), np.sin(turned)], axis=1)
    # The text's own half width and height keep its edge, not its middle, at the reach.
    return np.concatenate([unit * (half + size * REACH_POINTS) for size in SIZES])


def _overlaps(trial: FloatArray, boxes: FloatArray) -> FloatArray:
    """Return how many boxes each trial box touches."""
    apart = (trial[:, None, :2] >= boxes[None, :, 2:]) | (trial[:, None, 2:] <= boxes[None, :, :2])
    return np.asarray((~apart.any(axis=2)).sum(axis=1), dtype=np.float64)


def _covered(trial: FloatArray, obstacles: FloatArray) -> FloatArray:
    """Return how many obstacles each trial box covers."""
    inside = (obstacles[None] > trial[:, None, :2]) & (obstacles[None] < trial[:, None, 2:])
    return np.asarray(inside.all(axis=2).sum(axis=1), dtype=np.float64)


DOTS_PER_INCH = 150
# Without versions and dates in the file, its bytes depend on what is drawn alone.
METADATA = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


@contextmanager
def own_style() -> Iterator[None]:
    """Keep the user's own style files from changing the picture."""
    with matplotlib.style.context("default"), mpl.rc_context({"svg.hashsalt": "trackweave"}):
        yield


def encoded(figure: Figure, file_format: str, dots_per_inch: float = DOTS_PER_INCH) -> bytes:
    """Return a figure as a file, with nothing in it of who drew it."""
    file = io.BytesIO()
    figure.savefig(file, format=file_format, dpi=dots_per_inch, metadata=METADATA[file_format])
    return file.getvalue()


def png_of(figure: Figure) -> bytes:
    """Return a figure that has no canvas yet as PNG."""
    FigureCanvasAgg(figure)
    return encoded(figure, "png")


LEAST_WIDTH_IN, GREATEST_WIDTH_IN = 7.0, 9.6
LEAST_HEIGHT_IN, GREATEST_HEIGHT_IN = 4.2, 9.6
LEFT_IN, RIGHT_IN, BOTTOM_IN, TOP_IN = 0.85, 0.35, 1.15, 0.5
LEGEND_TOP_IN = 0.6  # below the plan's lower edge, less BOTTOM_IN: just below the axis' name
KILOMETRES_FROM_M = 5000.0
POINTS_PER_INCH = 72.0
# Panels of curves: beside a high plan in one column, below a wide one in two.
PANEL_WIDTH_IN, PANEL_LEFT_IN, PANEL_RIGHT_IN = 5.2, 0.9, 0.25
PANEL_HEIGHT_IN, PANEL_PITCH_IN = 1.2, 1.62
PANEL_GAP_IN, PANEL_TOP_IN, FOOT_IN = 0.42, 0.4, 0.55
BESIDE_FROM = 0.6  # height of the plan over its width

Box = tuple[float, float, float, float]


class Sheet(Figure):
    """A figure that a notebook shows, although pyplot, which would see to it, is not imported."""

    def _repr_png_(self) -> bytes:
        file = io.BytesIO()
        self.savefig(file, format="png")
        return file.getvalue()


class Canvas(NamedTuple):
    """The sheet and how places are laid on it."""

    figure: Figure  # The sheet
    axes: Axes  # Those of the plan
    unit_m: float  # What one unit on the axes is [m]: 1 or 1000
    low: FloatArray  # Lower left corner of the axes [m]; in an image, the upper left one
    points_per_m: float  # Scale on paper [points/m], the same along both axes
    # Middle of the plan's legend's upper edge, as a share of the sheet.
    legend_at: tuple[float, float]
    # Boxes for curves as shares of the sheet: left, bottom, width, height.
    panels: tuple[Box, ...] = ()
    down: bool = False  # Whether y runs downwards, as in an image

    def on_axes(self, places: FloatArray) -> FloatArray:
        """Return places [m] in the axes' unit, in the plane."""
        return places[..., :2] / self.unit_m

    def on_paper(self, places: FloatArray) -> FloatArray:
        """Return places [m] in points from the axes' corner, y upwards."""
        upwards = np.array([1.0, -1.0 if self.down else 1.0])
        paper: FloatArray = (places[..., :2] - self.low) * self.points_per_m * upwards
        return paper


def open_canvas(places: FloatArray, *, n_panels: int = 0, down: bool = False) -> Canvas:
    """Return a sheet that shows all places [m], beside panels; downwards y is in pixels."""
    low, high = _limits(places)
    size = high - low
    slope = size[1] / size[0]
    height = float(np.clip(GREATEST_WIDTH_IN * slope, LEAST_HEIGHT_IN, GREATEST_HEIGHT_IN))
    width = float(np.clip(height / slope, LEAST_WIDTH_IN, GREATEST_WIDTH_IN))
    # Where a side was limited, the other axis shows more, so that the scales stay equal.
    scale = max(size[0] / width, size[1] / height)
    grown = scale * np.array([width, height])
    low, high = low - (grown - size) / 2, high + (grown - size) / 2
    unit_m = 1000.0 if grown.max() > KILOMETRES_FROM_M and not down else 1.0
    sheet, plan, panels = _arranged(width, height, n_panels)
    figure = Sheet(figsize=(sheet[0], sheet[1]), facecolor="white")
    axes = figure.add_axes(_share(plan, sheet))
    axes.set_xlim(low[0] / unit_m, high[0] / unit_m)
    vertical = (high[1], low[1]) if down else (low[1], high[1])
    axes.set_ylim(vertical[0] / unit_m, vertical[1] / unit_m)
    axes.set_autoscale_on(False)
    return Canvas(
        figure,
        axes,
        unit_m,
        low,
        POINTS_PER_INCH / scale,
        ((plan[0] + width / 2) / sheet[0], (plan[1] - BOTTOM_IN + LEGEND_TOP_IN) / sheet[1]),
        tuple(_share(panel, sheet) for panel in panels),
        down,
    )


def _arranged(width: float, height: float, n_panels: int) -> tuple[FloatArray, Box, list[Box]]:
    """Return the sheet's size and the boxes of plan and panels [in]."""
    margins = np.array([LEFT_IN + RIGHT_IN, BOTTOM_IN + TOP_IN])
    own = np.array([width, height]) + margins
    if n_panels == 0:
        return own, (LEFT_IN, BOTTOM_IN, width, height), []
    column = PANEL_LEFT_IN + PANEL_WIDTH_IN + PANEL_RIGHT_IN
    if height >= BESIDE_FROM * width:
        tall = max(own[1], n_panels * PANEL_PITCH_IN + FOOT_IN)
        pitch = (tall - FOOT_IN) / n_panels
        panels = [
            (
                own[0] + PANEL_LEFT_IN,
                tall - PANEL_TOP_IN - (number + 1) * pitch + PANEL_GAP_IN,
                PANEL_WIDTH_IN,
                pitch - PANEL_GAP_IN,
            )
            for number in range(n_panels)
        ]
        plan = (LEFT_IN, tall - TOP_IN - height, width, height)
        return np.array([own[0] + column, tall]), plan, panels
    n_rows = -(-n_panels // 2)
    below = n_rows * PANEL_PITCH_IN + FOOT_IN
    half = own[0] / 2
    panels = [
        (
            PANEL_LEFT_IN + (number // n_rows) * half,
            below - PANEL_TOP_IN - (number % n_rows) * PANEL_PITCH_IN - PANEL_HEIGHT_IN,
            half - PANEL_LEFT_IN - PANEL_RIGHT_IN,
            PANEL_HEIGHT_IN,
        )
        for number in range(n_panels)
    ]
    plan = (LEFT_IN, below + BOTTOM_IN, width, height)
    return own + np.array([0.0, below]), plan, panels


def _share(box: Box, sheet: FloatArray) -> Box:
    left, bottom, width, height = box
    return (
        float(left / sheet[0]),
        float(bottom / sheet[1]),
        float(width / sheet[0]),
        float(height / sheet[1]),
    )


def _limits(places: FloatArray) -> tuple[FloatArray, FloatArray]:
    flat = places[:, :2] if len(places) else np.zeros((1, 2))
    low, high = flat.min(axis=0), flat.max(axis=0)
    # One place, or places on a line, still need a sheet with two sides.
    side = float((high - low).max()) or max(100.0, 1e-6 * float(np.abs(flat).max()))
    centre = (low + high) / 2
    half = np.maximum(high - low, 0.05 * side) / 2 + 0.035 * side
    return centre - half, centre + half
