"""What is drawn on the plan: reports, truth, tracks and sensors."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.tracks import COASTING, CONFIRMED, TrackTable
from trackweave.domain.truth import TruthTable
from trackweave.plotting._canvas import COLOURS, Canvas, Look, label_offsets

__all__ = [
    "MOST_DECORATED",
    "TrackLine",
    "draw_reports",
    "draw_sensor_paths",
    "draw_sensors",
    "draw_tracks",
    "draw_truth",
    "legend_of_tracks",
    "track_lines",
]

TRUTH_COLOUR, REPORT_COLOUR, FALSE_COLOUR = "#222222", "#777777", "#A6A6A6"
MOST_LABELS, MOST_ELLIPSES_EACH, MOST_DECORATED = 60, 4, 200
APART_POINTS = 30.0  # sensors that end closer share a name
# How names are laid beside what they belong to.
BESIDE: dict[str, Any] = {
    "textcoords": "offset points", "ha": "center", "va": "center", "zorder": 8,
}  # fmt: skip
LABEL_BOX = {
    "boxstyle": "round,pad=0.18", "facecolor": "white", "linewidth": 1.1, "alpha": 0.92,
}  # fmt: skip
# Each scan for which a track has coasted leaves so much of its ellipse, but never less.
FADING, FAINTEST = 0.75, 0.2
NINETY_FIVE_PER_CENT = 2.4477468306808166  # root of the chi-square quantile, two degrees


class TrackLine(NamedTuple):
    """One track's rows in order of time."""

    name: str
    time: FloatArray
    mean: FloatArray
    covariance: FloatArray
    coasted: IntArray  # For how many rows in succession it has coasted


def track_lines(tracks: TrackTable) -> Iterator[TrackLine]:
    """Yield each confirmed track's confirmed and coasting rows."""
    shown = np.flatnonzero(tracks.status >= CONFIRMED)
    order = shown[np.lexsort((tracks.time[shown], tracks.track[shown]))]
    names, first = np.unique(tracks.track[order], return_index=True)
    for name, rows in zip(names, np.split(order, first)[1:], strict=True):
        yield TrackLine(
            str(name), tracks.time[rows], tracks.mean[rows], tracks.covariance[rows],
            _run_lengths(tracks.status[rows] == COASTING),
        )  # fmt: skip


def _run_lengths(flags: NDArray[np.bool_]) -> IntArray:
    """Return at each place how many flags in succession are set, it included."""
    counted = np.cumsum(flags)
    return counted - np.maximum.accumulate(np.where(flags, 0, counted))


def draw_reports(places: FloatArray, assignment: Mapping[int, int] | None, canvas: Canvas) -> None:
    """Draw reports, and those that are false alarms otherwise than the others."""
    known = ~np.isnan(places).any(axis=1)
    laid = canvas.on_axes(places)
    # Fewer reports, larger marks; a hundred thousand become a haze.
    size = float(np.clip(200 / np.sqrt(max(len(places), 1)), 0.6, 3.4))
    if not known.all():
        label = f"reports without a position, not drawn ({int(np.count_nonzero(~known))})"
        canvas.axes.plot([], [], linestyle="", label=label)
    if assignment is None:
        _dots(canvas.axes, laid[known], size, "reports")
        return
    taken = np.zeros(len(places), dtype=bool)
    taken[np.fromiter(assignment, dtype=np.int64, count=len(assignment))] = True
    false = laid[known & ~taken]
    label = f"false alarms ({len(false)})"
    canvas.axes.plot(
        *false.T, "x", color=FALSE_COLOUR, ms=size, mew=0.25 * size, label=label, zorder=1
    )
    own = laid[known & taken]
    _dots(canvas.axes, own, size, f"reports of tracks ({len(own)})")


def _dots(axes: Axes, places: FloatArray, size: float, label: str) -> None:
    axes.plot(*places.T, "o", color=REPORT_COLOUR, ms=size, mew=0, label=label, zorder=2)


def draw_truth(truth: TruthTable | None, canvas: Canvas) -> None:
    """Draw where targets really were, thinly."""
    if truth is None or not len(truth):
        return
    order = np.lexsort((truth.time, truth.target.astype(str)))
    borders = np.flatnonzero(truth.target[order][1:] != truth.target[order][:-1]) + 1
    paths = np.split(canvas.on_axes(truth.position[order]), borders)
    style = {"linewidths": 0.9, "linestyles": [(0, (2.2, 2.2))], "colors": TRUTH_COLOUR}
    canvas.axes.add_collection(
        LineCollection(paths, zorder=5, label=f"truth ({len(paths)})", **style)
    )


def draw_tracks(lines: list[TrackLine], looks: list[Look], canvas: Canvas) -> None:
    """Draw tracks with their starts and ends, and as many decorations as can be read."""
    decorated = len(lines) <= MOST_DECORATED
    for line, (colour, dashes) in zip(lines, looks, strict=True):
        place = canvas.on_axes(line.mean)
        width = 1.9 if decorated else 0.8
        (drawn,) = canvas.axes.plot(*place.T, color=colour, linewidth=width, zorder=4)
        if dashes and decorated:
            drawn.set_dashes(dashes)
        if decorated:
            _draw_ellipses(line, colour, canvas)
            canvas.axes.plot(*place[0], "o", color=colour, mfc="white", ms=4.5, mew=1.3, zorder=6)
            canvas.axes.plot(*place[-1], "o", color=colour, ms=4.5, mec="white", mew=0.6, zorder=6)
        else:
            canvas.axes.plot(*place[0], "o", color=colour, mfc="white", ms=1.6, mew=0.5, zorder=6)
    if len(lines) <= MOST_LABELS:
        _draw_labels(lines, looks, canvas)


def _draw_ellipses(line: TrackLine, colour: str, canvas: Canvas) -> None:
    """Draw the 95 % ellipse at the track's end and a few times before."""
    # Where the track coasts there is an outline alone, the fainter the longer nobody saw it.
    step = max(len(line.mean) // MOST_ELLIPSES_EACH, 1)
    rows = np.arange(len(line.mean) - 1, -1, -step)
    variances, axes = np.linalg.eigh(line.covariance[rows, :2, :2])
    full = 2 * NINETY_FIVE_PER_CENT * np.sqrt(np.maximum(variances, 0)) / canvas.unit_m
    angles = np.degrees(np.arctan2(axes[:, 1, 1], axes[:, 0, 1]))
    coasted = line.coasted[rows]
    outline = 0.9 * np.maximum(FADING**coasted, FAINTEST)
    canvas.axes.add_collection(
        EllipseCollection(
            full[:, 1],
            full[:, 0],
            -angles if canvas.down else angles,
            units="xy",
            offsets=canvas.on_axes(line.mean[rows]),
            transOffset=canvas.axes.transData,
            facecolors=[to_rgba(colour, 0.0 if many else 0.18) for many in coasted],
            edgecolors=[to_rgba(colour, alpha) for alpha in outline.tolist()],
            linewidths=0.9,
            zorder=3.0,
        )
    )


def _draw_labels(lines: list[TrackLine], looks: list[Look], canvas: Canvas) -> None:
    if not lines:
        return
    paper = [canvas.on_paper(line.mean) for line in lines]
    ends = np.array([path[-1] for path in paper])
    directions = np.array([path[-1] - path[max(-4, -len(path))] for path in paper])
    offsets = label_offsets(ends, directions, [line.name for line in lines], np.concatenate(paper))
    for line, look, offset in zip(lines, looks, offsets, strict=True):
        # Black on white reads in grey too; the frame's colour says whose it is.
        end = tuple(canvas.on_axes(line.mean[-1]))
        canvas.axes.annotate(
            line.name, end, xytext=(offset[0], offset[1]), annotation_clip=False, color="#111111",
            bbox={**LABEL_BOX, "edgecolor": look.colour}, fontsize=9, fontweight="bold", **BESIDE,
        )  # fmt: skip


def draw_sensors(positions: Mapping[str, tuple[float, ...]], canvas: Canvas) -> None:
    """Draw where sensors stand."""
    if not positions:
        return
    places = canvas.on_axes(np.array([position[:2] for position in positions.values()]))
    canvas.axes.plot(*places.T, "^", color="black", ms=9, mec="white", label="sensors", zorder=7)
    edge = [withStroke(linewidth=2.4, foreground="white")]
    for name, place in zip(positions, places, strict=True):
        canvas.axes.annotate(
            name, (place[0], place[1]), xytext=(0, 11), fontsize=8.5, path_effects=edge, **BESIDE
        )


def draw_sensor_paths(
    paths: Mapping[str, FloatArray], canvas: Canvas
) -> dict[str, tuple[float, ...]]:
    """Draw where sensors went; return where they ended, under the names of all that went there."""
    riders: list[list[str]] = []
    for name, path in paths.items():
        end = canvas.on_paper(path[-1])
        for others in riders:
            if np.linalg.norm(canvas.on_paper(paths[others[0]][-1]) - end) < APART_POINTS:
                others.append(name)
                break
        else:
            riders.append([name])
    for names in riders:
        laid = canvas.on_axes(max((paths[name] for name in names), key=len))
        canvas.axes.plot(*laid.T, color="black", lw=0.8, alpha=0.6, zorder=3)
    return {", ".join(names): tuple(paths[names[0]][-1].tolist()) for names in riders}


def legend_of_tracks(n_tracks: int) -> list[Line2D]:
    """Return what a legend shows of the marks on tracks."""
    colour = COLOURS[0]
    start = Line2D([], [], color=colour, marker="o", mfc="white", ls="", ms=5)
    start.set_label("track's start")
    if n_tracks > MOST_DECORATED:
        return [start]
    ends = "track's end, identifier" if n_tracks <= MOST_LABELS else "track's end"
    return [
        start,
        Line2D([], [], color=colour, marker="o", ls="", ms=5, label=ends),
        Line2D(
            [], [], color=colour, marker="o", mfc="#0072B22E", ls="", ms=9, label="95 % ellipse"
        ),
    ]
