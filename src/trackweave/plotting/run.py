"""One picture of a run: the plan from above and, where scans are known, curves over time."""

import io

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from trackweave.arrays import FloatArray
from trackweave.errors import InvalidInputError
from trackweave.plotting._canvas import (
    COLOURS,
    METADATA,
    Canvas,
    encoded,
    looks_of,
    open_canvas,
    own_style,
)
from trackweave.plotting._panels import Curves, draw_panels
from trackweave.plotting._plan import (
    MOST_DECORATED,
    TrackLine,
    draw_reports,
    draw_sensor_paths,
    draw_sensors,
    draw_tracks,
    draw_truth,
    legend_of_tracks,
    track_lines,
)
from trackweave.plotting.scene import ScanSeries, Scene, paths_of_sensors, places_of_reports
from trackweave.summaries import counted

__all__ = ["FORMATS", "figure_of_run", "picture_of_run", "small_png"]

FORMATS = tuple(METADATA)
SMALL_DOTS_PER_INCH, SMALL_COLOURS, SMALL_BYTES = (72, 54, 40, 30), 64, 60_000
MOST_IN_TWO_ROWS = 8
LEAST_LEGEND_MARK = 3.4  # so that the haze of very many reports has a legend to read


def picture_of_run(
    scene: Scene, scans: ScanSeries | None = None, file_format: str = "png"
) -> bytes:
    """Return the picture of a run as a file: one of png, svg and pdf."""
    if file_format not in FORMATS:
        raise InvalidInputError(f"file_format: {file_format!r}; expected {', '.join(FORMATS)}")
    with own_style():
        return encoded(figure_of_run(scene, scans), file_format)


def small_png(figure: Figure) -> bytes:
    """Return a figure as a PNG that a notebook bears: as fine as it may be with few bytes."""
    from PIL import Image  # which matplotlib needs too

    for dots in SMALL_DOTS_PER_INCH:
        file = io.BytesIO()
        with own_style(), Image.open(io.BytesIO(encoded(figure, "png", dots))) as image:
            few = image.convert("RGB").quantize(SMALL_COLOURS, dither=Image.Dither.NONE)
            few.save(file, format="png", optimize=True)
        if len(file.getvalue()) <= SMALL_BYTES:
            break
    return file.getvalue()


def figure_of_run(scene: Scene, scans: ScanSeries | None = None) -> Figure:
    """Return the picture of a run: a plan seen from above, with curves over time."""
    # The curves are the number of tracks by status, reports and those assigned in each scan, the
    # gap to the bound with the scans told apart that were proven optimal, CPU per scan, the speed
    # of tracks and, in three dimensions, their height. Without scans there is the plan alone. The
    # figure belongs to no window.
    with own_style():
        lines = list(track_lines(scene.tracks))
        places, sensor_paths = np.empty((0, 2)), {}
        if scene.reports is not None:
            places = places_of_reports(scene.reports, scene.sensor_positions)
            sensor_paths = paths_of_sensors(scene.reports)
        curves = _curves(scene, scans, lines)
        canvas = open_canvas(
            np.concatenate([_all_places(scene, lines, places), *sensor_paths.values()]),
            n_panels=len(curves.panels) if curves else 0,
            down=scene.pixels,
        )
        if scene.reports is not None:
            draw_reports(places, scene.assignment, canvas)
        draw_truth(scene.truth, canvas)
        looks = looks_of([canvas.on_paper(line.mean) for line in lines])
        draw_tracks(lines, looks, canvas)
        stands = {
            name: at for name, at in scene.sensor_positions.items() if name not in sensor_paths
        }
        draw_sensors(stands | draw_sensor_paths(sensor_paths, canvas), canvas)
        _draw_frame(scene, canvas, len(lines))
        if curves:
            draw_panels(canvas, curves._replace(looks=looks))
        FigureCanvasAgg(canvas.figure)
    return canvas.figure


def _curves(scene: Scene, scans: ScanSeries | None, lines: list[TrackLine]) -> Curves | None:
    if scans is None or scans.time.size == 0:
        return None
    return Curves(scans, lines, scene.tracks.dim, "px" if scene.pixels else "m")


def _all_places(scene: Scene, lines: list[TrackLine], places: FloatArray) -> FloatArray:
    parts = [places[~np.isnan(places).any(axis=1)], *(line.mean[:, :2] for line in lines)]
    if scene.truth is not None:
        parts.append(scene.truth.position[:, :2])
    parts.extend(np.array([position[:2]]) for position in scene.sensor_positions.values())
    return np.concatenate(parts)


def _draw_frame(scene: Scene, canvas: Canvas, n_tracks: int) -> None:
    axes = canvas.axes
    across, upwards = _axis_names(scene, canvas)
    axes.set_xlabel(across)
    axes.set_ylabel(upwards)
    axes.ticklabel_format(style="plain", useOffset=False)
    axes.grid(color="#ECECEC", linewidth=0.7)
    axes.set_axisbelow(True)
    for side in axes.spines.values():
        side.set_color("#BBBBBB")
    axes.tick_params(color="#BBBBBB", labelsize=9)
    axes.set_title(_title(scene, n_tracks), loc="left", fontsize=12, pad=10)
    _draw_legend(canvas, n_tracks)


def _axis_names(scene: Scene, canvas: Canvas) -> tuple[str, str]:
    if scene.pixels:
        return "x, to the right [px]", "y, downwards [px]"
    unit = "km" if canvas.unit_m > 1 else "m"
    if scene.origin is None:
        return f"x, east [{unit}]", f"y, north [{unit}]"
    latitude, longitude = scene.origin
    north = f"{abs(latitude):g}° {'N' if latitude >= 0 else 'S'}"
    east = f"{abs(longitude):g}° {'E' if longitude >= 0 else 'W'}"
    return f"x, east of {east} [{unit}]", f"y, north of {north} [{unit}]"


def _draw_legend(canvas: Canvas, n_tracks: int) -> None:
    handles, _ = canvas.axes.get_legend_handles_labels()
    if n_tracks:
        width = 1.9 if n_tracks <= MOST_DECORATED else 0.8
        label = f"tracks ({n_tracks})"
        handles.insert(0, Line2D([], [], color=COLOURS[0], lw=width, label=label))
        handles += legend_of_tracks(n_tracks)
    if not handles:
        return
    in_two_rows = len(handles) <= MOST_IN_TWO_ROWS
    legend = canvas.figure.legend(
        handles=handles, loc="upper center", bbox_to_anchor=canvas.legend_at, ncols=4,
        frameon=False, fontsize=9 if in_two_rows else 8, labelspacing=0.5 if in_two_rows else 0.25,
    )  # fmt: skip
    for mark in legend.get_lines():
        mark.set_markersize(max(mark.get_markersize(), LEAST_LEGEND_MARK))
        if mark.get_marker() == "x":
            mark.set_markeredgewidth(max(mark.get_markeredgewidth(), 0.8))


def _title(scene: Scene, n_tracks: int) -> str:
    if scene.title is not None:
        return scene.title
    tracks = counted(n_tracks, "track")
    view = " (seen from above)" if scene.tracks.dim == 3 else ""
    if scene.reports is None:
        return f"{tracks}{view}"
    span = float(np.ptp(scene.reports.time)) if len(scene.reports) else 0.0
    return f"{tracks} from {counted(len(scene.reports), 'report')} in {span:,.0f} s{view}"
