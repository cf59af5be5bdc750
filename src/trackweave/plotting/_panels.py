"""Curves over time beside the plan."""

from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.ticker import FuncFormatter, MaxNLocator

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.tracks import COASTING, CONFIRMED, TENTATIVE, TrackTable
from trackweave.plotting._canvas import Canvas, Look
from trackweave.plotting._plan import TrackLine
from trackweave.plotting.scene import ScanSeries

__all__ = ["Curves", "counts_by_status", "draw_panels", "time_axis"]

BLUE, ORANGE, PALE, RED = "#0072B2", "#E69F00", "#D0D0D0", "#D55E00"
MOST_CURVES = 25  # more are drawn as a band
MOST_STEPS = 200  # more flicker
LEAST_GAP, GREATEST_GAP = 1e-9, 1e3
CALENDAR_FROM_S = 1e9  # later times are taken for seconds from 1970, in 2001 and after
# Times are stray where so few lie so many times as far out as the others reach.
STRAY, BEYOND = (0.02, 0.98), 2.0
MINUTES_FROM_S, HOURS_FROM_S = 600.0, 7200.0


class TimeAxis(NamedTuple):
    """How times are written: seconds from an origin, in a unit, under a name."""

    origin: float
    unit_s: float
    label: str

    def of(self, time: FloatArray) -> FloatArray:
        """Return times [s] in the axis' unit."""
        return (time - self.origin) / self.unit_s


class Curves(NamedTuple):
    """What the panels show."""

    series: ScanSeries
    lines: list[TrackLine]
    dim: int
    length: str  # unit of positions
    looks: Sequence[Look] = ()  # how each track is drawn on the plan

    @property
    def panels(self) -> list[Callable[[Axes, "Curves", TimeAxis], None]]:
        """What draws each panel, from the top."""
        timed = [_draw_cpu] if self.series.cpu_ms is not None else []
        solid = [_draw_height] if self.dim == 3 else []
        return [_draw_counts, _draw_reports, _draw_gap, *timed, _draw_speed, *solid]


def draw_panels(canvas: Canvas, curves: Curves) -> None:
    """Draw one panel in each of the canvas' boxes."""
    times = time_axis(curves.series)
    span = times.of(np.array(_shown_span(curves.series.time)))
    margin = 0.02 * float(np.ptp(span)) or 0.5
    lowest = {box[0]: min(b[1] for b in canvas.panels if b[0] == box[0]) for box in canvas.panels}
    for draw, box in zip(curves.panels, canvas.panels, strict=True):
        axes = canvas.figure.add_axes(box)
        axes.set_xlim(span[0] - margin, span[1] + margin)
        axes.grid(color="#ECECEC", linewidth=0.7)
        axes.set_axisbelow(True)
        axes.tick_params(color="#BBBBBB", labelsize=8)
        for side in axes.spines.values():
            side.set_color("#BBBBBB")
        draw(axes, curves, times)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        if box[1] == lowest[box[0]]:
            axes.set_xlabel(times.label, fontsize=9)


def time_axis(series: ScanSeries) -> TimeAxis:
    """Return how times are best written: seconds, minutes or hours from 0 or the first scan."""
    begin, end = _shown_span(series.time)
    span = end - begin
    n_beyond = int(np.count_nonzero((series.time < begin) | (series.time > end)))
    beyond = f", {n_beyond} scans beyond" if n_beyond else ""
    unit_s, unit = 1.0, "s"
    if span > HOURS_FROM_S:
        unit_s, unit = 3600.0, "h"
    elif span > MINUTES_FROM_S:
        unit_s, unit = 60.0, "min"
    if series.iso_time or begin > CALENDAR_FROM_S:
        date = datetime.fromtimestamp(begin, tz=UTC)
        return TimeAxis(begin, unit_s, f"time from {date:%Y-%m-%d %H:%M:%S} UTC [{unit}]{beyond}")
    if 0 <= begin <= span:
        return TimeAxis(0.0, unit_s, f"time [{unit}]{beyond}")
    return TimeAxis(begin, unit_s, f"time from {begin:.10g} s [{unit}]{beyond}")


def _shown_span(time: FloatArray) -> tuple[float, float]:
    """Return from when to when curves are shown [s]: a few stray stamps squeeze no others."""
    low, high = np.quantile(time, STRAY)
    reach = BEYOND * (high - low)
    shown = time[(time >= low - reach) & (time <= high + reach)]
    return float(shown.min()), float(shown.max())


def counts_by_status(tracks: TrackTable) -> tuple[FloatArray, IntArray]:
    """Return the times [s] of rows, and how many there are of each of ``STATUSES``."""
    times, place = np.unique(tracks.time, return_inverse=True)
    counts = np.zeros((times.size, 3), dtype=np.int64)
    np.add.at(counts, (place.reshape(-1), tracks.status), 1)
    return times, counts


def _thinned(time: FloatArray, counts: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return at most so many steps as can be told apart, each the mean of its times."""
    place = np.arange(time.size) * min(MOST_STEPS, time.size) // max(time.size, 1)
    step, first, n_times = np.unique(place, return_index=True, return_counts=True)
    mean = np.zeros((step.size, 3))
    np.add.at(mean, place, counts)
    return time[first], mean / n_times[:, None]


def _head(axes: Axes, title: str) -> None:
    axes.set_title(title, loc="left", fontsize=9, fontweight="bold", pad=5)
    if axes.get_legend_handles_labels()[0]:
        legend = axes.legend(
            loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=3, frameon=False, fontsize=8,
            borderaxespad=0.1, handlelength=1.2, columnspacing=1.0,
        )  # fmt: skip
        for mark in legend.get_lines():
            mark.set_markersize(max(mark.get_markersize(), 4.0))


def _draw_counts(axes: Axes, curves: Curves, times: TimeAxis) -> None:
    when, counts = _thinned(*counts_by_status(curves.series.known))
    low = np.zeros(when.size)
    order = ((CONFIRMED, BLUE, "confirmed"), (COASTING, ORANGE, "coasting"))
    for status, colour, word in (*order, (TENTATIVE, PALE, "tentative")):
        high = low + counts[:, status]
        axes.fill_between(
            times.of(when), low, high, step="post", color=colour, linewidth=0, label=word
        )
        low = high
    axes.set_ylim(0, max(1.0, 1.05 * float(low.max(initial=0.0))))
    axes.yaxis.set_major_locator(MaxNLocator(4, integer=True))
    _head(axes, "tracks")


def _dots(axes: Axes, x: FloatArray, y: FloatArray, colour: str, label: str) -> None:
    size = float(np.clip(60 / np.sqrt(max(x.size, 1)), 1.8, 4.0))
    axes.plot(x, y, "o", color=colour, ms=size, mew=0, alpha=0.85, label=label or None)


def _draw_reports(axes: Axes, curves: Curves, times: TimeAxis) -> None:
    series = curves.series
    when = times.of(series.time)
    # An area beneath: where all reports are assigned, dots would hide one another.
    axes.fill_between(when, 0, series.reports, step="mid", color=PALE, linewidth=0, label="all")
    _dots(axes, when, series.assigned, BLUE, "assigned to tracks")
    axes.set_ylim(0, max(1.0, 1.08 * float(series.reports.max(initial=0.0))))
    axes.yaxis.set_major_locator(MaxNLocator(4, integer=True))
    _head(axes, "reports per scan")


def _draw_gap(axes: Axes, curves: Curves, times: TimeAxis) -> None:
    series = curves.series
    when, gap = times.of(series.time), np.clip(series.gap, LEAST_GAP, GREATEST_GAP)
    proven, unknown = series.proven, ~series.proven & np.isnan(series.gap) & (series.reports > 0)
    among = ~proven & (series.gap <= LEAST_GAP)
    still = ~proven & ~among & ~np.isnan(gap)
    exponents = np.log10(gap[still]) if still.any() else np.array([-2.0, 0.0])
    low, high = np.floor(exponents.min()) - 1.0, max(np.ceil(exponents.max()), 0.0)
    axes.set_yscale("log")
    axes.set_ylim(10 ** (low - 0.4), 10 ** (high + 0.3))
    # An answer that meets its bound has gap 0, which no logarithm shows: a row at the foot.
    foot = np.full(when.size, 10**low)
    _dots(axes, when[proven], foot[proven], BLUE, f"proven optimal ({int(proven.sum())})")
    if among.any():
        label = f"optimal among kept ({int(among.sum())})"
        _dots(axes, when[among], foot[among], ORANGE, label)
    if still.any():
        _dots(axes, when[still], gap[still], RED, f"still open ({int(still.sum())})")
    if unknown.any():
        top = np.full(int(unknown.sum()), 10**high)
        axes.plot(when[unknown], top, "x", color=RED, ms=3, label=f"not known ({len(top)})")
    ticks = np.arange(low + 1, high + 1, max(1, np.ceil((high - low) / 4)))
    names = ["0", *(f"{100 * 10**tick:g} %" for tick in ticks)]
    axes.set_yticks([10**low, *(10**tick for tick in ticks)], names)
    axes.minorticks_off()
    _head(axes, "gap to the bound")


def _draw_cpu(axes: Axes, curves: Curves, times: TimeAxis) -> None:
    series = curves.series
    if series.cpu_ms is None:
        return
    cpu = np.maximum(series.cpu_ms, 1e-3)
    median = float(np.median(cpu))
    axes.set_yscale("log")
    axes.axhline(median, color=ORANGE, lw=1.0, zorder=1, label=f"median {median:.3g} ms")
    _dots(axes, times.of(series.time), cpu, BLUE, "")
    # From decade to decade, so that there are labels however alike the scans are.
    low, high = np.floor(np.log10(cpu.min())), np.ceil(np.log10(cpu.max()))
    axes.set_ylim(10**low, 10 ** max(high, low + 1))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.minorticks_off()
    _head(axes, "CPU per scan [ms]")


def _draw_speed(axes: Axes, curves: Curves, times: TimeAxis) -> None:
    n = curves.dim
    speeds = [np.linalg.norm(line.mean[:, n : 2 * n], axis=1) for line in curves.lines]
    _draw_curves(axes, curves, speeds, times)
    axes.set_ylim(bottom=0)
    _head(axes, f"speed of tracks [{curves.length}/s]")


def _draw_height(axes: Axes, curves: Curves, times: TimeAxis) -> None:
    _draw_curves(axes, curves, [line.mean[:, 2] for line in curves.lines], times)
    _head(axes, f"height of tracks, z [{curves.length}]")


def _draw_curves(axes: Axes, curves: Curves, values: list[FloatArray], times: TimeAxis) -> None:
    """Draw one curve for each track, in its colour on the plan, or a band where they are many."""
    lines = curves.lines
    if not lines:
        return
    if len(lines) <= MOST_CURVES:
        paths = [
            np.stack([times.of(line.time), value], axis=1)
            for line, value in zip(lines, values, strict=True)
        ]
        colours = [look.colour for look in curves.looks]
        axes.add_collection(LineCollection(paths, colors=colours, linewidths=1.1))
        every = np.concatenate(values)
        axes.set_ylim(_with_margin(float(every.min()), float(every.max())))
        return
    time, value = np.concatenate([line.time for line in lines]), np.concatenate(values)
    order = np.argsort(time, kind="stable")
    when, first = np.unique(time[order], return_index=True)
    groups = np.split(value[order], first[1:])
    low, middle, high = np.array([np.percentile(group, (10, 50, 90)) for group in groups]).T
    x = times.of(when)
    axes.fill_between(x, low, high, color=BLUE, alpha=0.2, linewidth=0, label="10–90 % of tracks")
    axes.plot(x, middle, color=BLUE, lw=1.2, label="median")
    axes.set_ylim(_with_margin(float(low.min()), float(high.max())))


def _with_margin(low: float, high: float) -> tuple[float, float]:
    margin = 0.06 * (high - low) or 0.5
    return low - margin, high + margin
