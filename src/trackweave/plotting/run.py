"""One picture of a run: reports, false alarms, truth and tracks from above."""

import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import matplotlib.style
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from trackweave.arrays import FloatArray
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.domain.truth import TruthTable
from trackweave.errors import OutputError
from trackweave.plotting._canvas import LEGEND_TOP_IN, Canvas, open_canvas
from trackweave.plotting._labels import label_offsets

__all__ = ["Scene", "picture_of_run", "plot_run"]

# Okabe and Ito's colours, told apart by colour-blind people; dark and light ones take turns so
# that neighbours differ in grey too, and each round has another kind of line.
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#333333", "#D55E00", "#56B4E9")
LINES: tuple[tuple[float, ...], ...] = ((), (7, 1.6), (9, 1.6, 1.6, 1.6), (3, 1.2))
TRUTH_COLOUR, REPORT_COLOUR, FALSE_COLOUR = "#222222", "#777777", "#A6A6A6"
MOST_LABELS, MOST_ELLIPSES_EACH, MOST_DECORATED = 60, 4, 200
NINETY_FIVE_PER_CENT = 2.4477468306808166  # root of the chi-square quantile, two degrees
DOTS_PER_INCH = 150
LEAST_LEGEND_MARK = 3.4  # so that the haze of very many reports has a legend to read


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """What is to be seen.

    Parameters
    ----------
    reports
        All reports.
    tracks
        Rows of tracks; confirmed and coasting ones are drawn. May be empty.
    truth
        Where targets really were, None where it is not known.
    assignment
        From a report's row number to its track; a report without one is a false alarm. None
        where it is not known.
    sensor_positions
        Where sensors stand [m], by name.
    title
        Heading; None for a count of what there is.
    """

    reports: ReportTable
    tracks: TrackTable
    truth: TruthTable | None = None
    assignment: Mapping[int, int] | None = None
    sensor_positions: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    title: str | None = None


class _Line(NamedTuple):
    """One track's rows in order of time."""

    name: str
    mean: FloatArray
    covariance: FloatArray


def plot_run(scene: Scene, path: str | Path) -> None:
    """Write the picture of a run as a PNG file.

    Parameters
    ----------
    scene
        What is to be seen.
    path
        The file.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    picture = picture_of_run(scene)
    try:
        Path(path).write_bytes(picture)
    except OSError as err:
        raise OutputError(f"{path}: {err.strerror}; the picture cannot be written") from err


def picture_of_run(scene: Scene) -> bytes:
    """Return the picture of a run as PNG, seen from above.

    Parameters
    ----------
    scene
        What is to be seen.

    Returns
    -------
    The file's bytes; equal scenes give equal bytes with one version of matplotlib.
    """
    # The user's own style files must not change the picture.
    with matplotlib.style.context("default"):
        lines = list(_track_lines(scene.tracks))
        canvas = open_canvas(_all_places(scene, lines))
        _draw_reports(scene, canvas)
        _draw_truth(scene.truth, canvas)
        _draw_tracks(lines, canvas)
        _draw_sensors(scene.sensor_positions, canvas)
        _draw_frame(scene, canvas, len(lines))
        FigureCanvasAgg(canvas.figure)
        file = io.BytesIO()
        # Without the version in the file, its bytes depend on what is drawn alone.
        canvas.figure.savefig(file, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None})
    return file.getvalue()


def _track_lines(tracks: TrackTable) -> Iterator[_Line]:
    shown = np.flatnonzero(tracks.status >= CONFIRMED)
    order = shown[np.lexsort((tracks.time[shown], tracks.track[shown]))]
    names, first = np.unique(tracks.track[order], return_index=True)
    for name, rows in zip(names, np.split(order, first)[1:], strict=True):
        yield _Line(str(name), tracks.mean[rows], tracks.covariance[rows])


def _all_places(scene: Scene, lines: list[_Line]) -> FloatArray:
    parts = [scene.reports.measurement[:, :2], *(line.mean[:, :2] for line in lines)]
    if scene.truth is not None:
        parts.append(scene.truth.position[:, :2])
    parts.extend(np.array([position[:2]]) for position in scene.sensor_positions.values())
    return np.concatenate(parts)


def _draw_reports(scene: Scene, canvas: Canvas) -> None:
    places = canvas.on_axes(scene.reports.measurement)
    # Fewer reports, larger marks; a hundred thousand become a haze.
    size = float(np.clip(200 / np.sqrt(max(len(places), 1)), 0.6, 3.4))
    if scene.assignment is None:
        _dots(canvas.axes, places, size, "reports")
        return
    taken = np.zeros(len(places), dtype=bool)
    rows = np.fromiter(scene.assignment, dtype=np.int64, count=len(scene.assignment))
    taken[rows] = True
    false = places[~taken]
    canvas.axes.plot(
        false[:, 0],
        false[:, 1],
        linestyle="",
        marker="x",
        markersize=size,
        markeredgewidth=0.25 * size,
        color=FALSE_COLOUR,
        label=f"false alarms ({len(false)})",
        zorder=1,
    )
    _dots(canvas.axes, places[taken], size, f"reports of tracks ({int(taken.sum())})")


def _dots(axes: Axes, places: FloatArray, size: float, label: str) -> None:
    axes.plot(
        places[:, 0],
        places[:, 1],
        linestyle="",
        marker="o",
        markersize=size,
        markeredgewidth=0,
        color=REPORT_COLOUR,
        label=label,
        zorder=2,
    )


def _draw_truth(truth: TruthTable | None, canvas: Canvas) -> None:
    if truth is None or not len(truth):
        return
    order = np.lexsort((truth.time, truth.target.astype(str)))
    changes = np.flatnonzero(truth.target[order][1:] != truth.target[order][:-1]) + 1
    paths = np.split(canvas.on_axes(truth.position[order]), changes)
    style = {"linewidths": 0.9, "linestyles": [(0, (2.2, 2.2))], "colors": TRUTH_COLOUR}
    canvas.axes.add_collection(
        LineCollection(paths, zorder=5, label=f"truth ({len(paths)})", **style)
    )


def _draw_tracks(lines: list[_Line], canvas: Canvas) -> None:
    decorated = len(lines) <= MOST_DECORATED
    for number, line in enumerate(lines):
        colour = COLOURS[number % len(COLOURS)]
        dashes = LINES[number // len(COLOURS) % len(LINES)]
        place = canvas.on_axes(line.mean)
        (drawn,) = canvas.axes.plot(
            place[:, 0], place[:, 1], color=colour, linewidth=1.9 if decorated else 0.8, zorder=4
        )
        if dashes:
            drawn.set_dashes(dashes)
        if decorated:
            _draw_ellipses(line, colour, canvas)
            canvas.axes.plot(*place[0], "o", color=colour, mfc="white", ms=4.5, mew=1.3, zorder=6)
            canvas.axes.plot(*place[-1], "o", color=colour, ms=4.5, mec="white", mew=0.6, zorder=6)
    if len(lines) <= MOST_LABELS:
        _draw_labels(lines, canvas)


def _draw_ellipses(line: _Line, colour: str, canvas: Canvas) -> None:
    """Draw the 95 % ellipse at the track's end and a few times before."""
    step = max(len(line.mean) // MOST_ELLIPSES_EACH, 1)
    rows = np.arange(len(line.mean) - 1, -1, -step)
    variances, axes = np.linalg.eigh(line.covariance[rows, :2, :2])
    full = 2 * NINETY_FIVE_PER_CENT * np.sqrt(np.maximum(variances, 0)) / canvas.unit_m
    angles = np.degrees(np.arctan2(axes[:, 1, 1], axes[:, 0, 1]))
    for face, edge, width, zorder in ((colour, "none", 0.0, 3.0), ("none", colour, 0.9, 3.5)):
        canvas.axes.add_collection(
            EllipseCollection(
                full[:, 1],
                full[:, 0],
                angles,
                units="xy",
                offsets=canvas.on_axes(line.mean[rows]),
                transOffset=canvas.axes.transData,
                facecolors=face,
                edgecolors=edge,
                linewidths=width,
                alpha=0.18 if width == 0 else 0.9,
                zorder=zorder,
            )
        )


def _draw_labels(lines: list[_Line], canvas: Canvas) -> None:
    if not lines:
        return
    paper = [canvas.on_paper(line.mean) for line in lines]
    ends = np.array([path[-1] for path in paper])
    directions = np.array([path[-1] - path[max(-4, -len(path))] for path in paper])
    offsets = label_offsets(ends, directions, [line.name for line in lines], np.concatenate(paper))
    for number, (line, offset) in enumerate(zip(lines, offsets, strict=True)):
        # Black on white reads in grey too; the frame's colour says whose it is.
        canvas.axes.annotate(
            line.name,
            tuple(canvas.on_axes(line.mean[-1])),
            xytext=(offset[0], offset[1]),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=9,
            fontweight="bold",
            color="#111111",
            bbox={
                "boxstyle": "round,pad=0.18",
                "facecolor": "white",
                "edgecolor": COLOURS[number % len(COLOURS)],
                "linewidth": 1.1,
                "alpha": 0.92,
            },
            annotation_clip=False,
            zorder=8,
        )


def _draw_sensors(positions: Mapping[str, tuple[float, ...]], canvas: Canvas) -> None:
    if not positions:
        return
    places = canvas.on_axes(np.array([position[:2] for position in positions.values()]))
    canvas.axes.plot(
        places[:, 0],
        places[:, 1],
        "^",
        color="black",
        ms=9,
        mec="white",
        label="sensors",
        zorder=7,
    )
    for name, place in zip(positions, places, strict=True):
        canvas.axes.annotate(
            name,
            (place[0], place[1]),
            xytext=(0, 11),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=8.5,
            path_effects=[withStroke(linewidth=2.4, foreground="white")],
            zorder=8,
        )


def _draw_frame(scene: Scene, canvas: Canvas, n_tracks: int) -> None:
    axes = canvas.axes
    unit = "km" if canvas.unit_m > 1 else "m"
    axes.set_xlabel(f"x, east [{unit}]")
    axes.set_ylabel(f"y, north [{unit}]")
    axes.ticklabel_format(style="plain", useOffset=False)
    axes.grid(color="#ECECEC", linewidth=0.7)
    axes.set_axisbelow(True)
    for side in axes.spines.values():
        side.set_color("#BBBBBB")
    axes.tick_params(color="#BBBBBB", labelsize=9)
    axes.set_title(_title(scene, n_tracks), loc="left", fontsize=12, pad=10)
    handles, _ = axes.get_legend_handles_labels()
    if n_tracks:
        handles.insert(0, Line2D([], [], color=COLOURS[0], lw=1.9, label=f"tracks ({n_tracks})"))
        if n_tracks <= MOST_DECORATED:
            handles += _legend_of_marks()
    if handles:
        legend = canvas.figure.legend(
            handles=handles,
            loc="upper center",
            bbox_to_anchor=(0.5, LEGEND_TOP_IN / canvas.figure.get_figheight()),
            ncols=4,
            frameon=False,
            fontsize=9,
        )
        for mark in legend.get_lines():
            mark.set_markersize(max(mark.get_markersize(), LEAST_LEGEND_MARK))
            if mark.get_marker() == "x":
                mark.set_markeredgewidth(max(mark.get_markeredgewidth(), 0.8))


def _legend_of_marks() -> list[Line2D]:
    colour = COLOURS[0]
    return [
        Line2D([], [], color=colour, marker="o", mfc="white", ls="", ms=5, label="track's start"),
        Line2D([], [], color=colour, marker="o", ls="", ms=5, label="track's end, identifier"),
        Line2D(
            [],
            [],
            color=colour,
            marker="o",
            markerfacecolor="#0072B22E",
            ls="",
            ms=9,
            label="95 % ellipse",
        ),
    ]


def _title(scene: Scene, n_tracks: int) -> str:
    if scene.title is not None:
        return scene.title
    span = float(np.ptp(scene.reports.time)) if len(scene.reports) else 0.0
    view = " (seen from above)" if scene.reports.dim == 3 else ""
    tracks, reports = _counted(n_tracks, "track"), _counted(len(scene.reports), "report")
    return f"{tracks} from {reports} in {span:,.0f} s{view}"


def _counted(count: int, thing: str) -> str:
    return f"{count:,} {thing}{'' if count == 1 else 's'}"
