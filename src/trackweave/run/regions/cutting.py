"""The plane in regions with about as many reports each, and how far each looks beyond itself."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.config.fill import Settings
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan
from trackweave.models.measurements import to_position
from trackweave.models.sensors import Sensor
from trackweave.run.polar_to_cartesian import platforms_of
from trackweave.trackers._arguments import slowest_of
from trackweave.trackers.scan_preparation import longest_unseen

__all__ = [
    "Region",
    "cut",
    "margin_of",
    "part_of",
    "positions_of",
    "unplaced_sensors",
    "why_whole",
]

LEAST = 5_000
"""Reports of its own that a region has at least: fewer are not worth a worker."""
CROWD = 50
"""… and so many in each step in which it has any: of fewer, a step takes as long as of none."""
MOST_REGIONS = 256
NARROWEST = 4.0
"""Margins that a region is wide at least, that most of what it tracks is its own."""
WINDOWS, SIGMAS = 2.0, 10.0
"""How many windows' flight and deviations of reports the margin holds: one window to begin a
track and be sure of it, one for what its neighbours' reports depend on."""


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """A rectangle of the plane; its lower borders are its own, the upper ones its neighbours'."""

    low: FloatArray  # x, y [m], -inf where nothing bounds it
    high: FloatArray

    def holds(self, position: FloatArray) -> NDArray[np.bool_]:
        """Tell of each position whether it is in the region."""
        inside: NDArray[np.bool_] = (position >= self.low) & (position < self.high)
        return inside[:, 0] & inside[:, 1]

    def distance(self, position: FloatArray) -> FloatArray:
        """Return how far outside each position is [m], 0 inside and on a border."""
        beyond = np.maximum(np.maximum(self.low - position, position - self.high), 0.0)
        away: FloatArray = np.hypot(beyond[:, 0], beyond[:, 1])
        return away

    def wider(self, margin: float) -> "Region":
        """Return the region with a margin [m] on each side."""
        return Region(self.low - margin, self.high + margin)


def cut(
    position: FloatArray,
    margin: float,
    step: IntArray | None = None,
    *,
    least: int | None = None,
    most: int = MOST_REGIONS,
) -> list[Region]:
    """Return regions that cover the plane, each position in one of them.

    The plane is halved at the median of the positions, along the axis on which they are spread
    more, and so on with each half (J. L. Bentley, Multidimensional binary search trees used for
    associative searching, Comm. ACM 18(9), 1975), as long as the halves have reports enough and
    are wide enough. That depends on the reports alone, never on how many workers there are.

    Parameters
    ----------
    position
        Where reports are on the plane [m], shape (reports, 2).
    margin
        How far beyond itself a region looks [m].
    step
        In which step of the tracker each report is taken, shape (reports,); None where steps
        do not matter.
    least
        Reports of its own that a region has at least; left out, `LEAST`.
    most
        How many regions there are at most.

    Returns
    -------
    At least one region, without overlap.
    """
    least = LEAST if least is None else least
    everywhere = Region(np.full(2, -np.inf), np.full(2, np.inf))
    waiting, found = [(everywhere, np.arange(len(position)))], list[Region]()
    while waiting:
        region, rows = waiting.pop(0)
        halves = None
        if len(found) + len(waiting) + 2 <= most and rows.size >= 2 * least:
            halves = _halves(region, position[rows], margin)
        parts = [(half, rows[half.holds(position[rows])]) for half in halves or ()]
        if parts and (step is None or all(_is_crowd(step[own]) for _, own in parts)):
            waiting += parts
        else:
            found.append(region)
    return found


def _is_crowd(step: IntArray) -> bool:
    """Tell whether steps hold reports enough each, where they hold any."""
    return step.size >= CROWD * np.unique(step).size


def _halves(region: Region, position: FloatArray, margin: float) -> tuple[Region, Region] | None:
    """Return the two halves of a region, None where they would be too narrow."""
    begin, end = position.min(axis=0), position.max(axis=0)
    axis = int(np.argmax(end - begin))
    at = float(np.median(position[:, axis]))
    if min(at - begin[axis], end[axis] - at) < NARROWEST * margin:
        return None
    high, low = region.high.copy(), region.low.copy()
    high[axis] = low[axis] = at
    return Region(region.low, high), Region(low, region.high)


def why_whole(position: FloatArray, margin: float) -> str:
    """Return why a recording is not cut."""
    if len(position) < 2 * LEAST:
        return f"its halves would have fewer than {LEAST:,} reports"
    if len(cut(position, margin)) > 1:
        return f"its halves would have fewer than {CROWD} reports a step, which then saves nothing"
    return (
        f"its halves would be narrower than {NARROWEST:g} margins of {margin / 1e3:.3g} km, which "
        "an object may come while it is followed"
    )


def unplaced_sensors(reports: ReportTable) -> list[str]:
    """Return the sensors whose reports tell no place."""
    return [
        name
        for name, kind in zip(reports.sensors, reports.kinds, strict=False)
        if isinstance(kind, ForeignKind) or not kind.gives_position(reports.dim)
    ]


def positions_of(reports: ReportTable, settings: Settings) -> FloatArray:
    """Return where each report is on the plane [m], shape (reports, 2)."""
    if not reports.kinds:
        return np.ascontiguousarray(reports.measurement[:, :2])
    places = {each.name: each.position for each in settings.sensors if each.position is not None}
    platform = platforms_of(reports, places)
    position = np.empty((len(reports), 2))
    for index, kind in enumerate(reports.kinds):
        rows = reports.sensor == index
        if isinstance(kind, ForeignKind) or not rows.any():
            continue
        measured = reports.measurement[rows, : kind.n_components(reports.dim)]
        there, _ = to_position(
            kind, measured, np.zeros_like(measured), platform[rows], reports.dim
        )
        position[rows] = there[:, :2]
    return position


def margin_of(
    reports: ReportTable, settings: Settings, steps: Sequence[tuple[Scan, ...]]
) -> float:
    """Return how far beyond itself a region looks [m]."""
    # Where nobody looks, an object is expected for minutes at whatever place it comes to
    # meanwhile: its last report has to be in sight as well.
    _, unseen = longest_unseen(settings.lifecycle, settings.sensors)
    is_lone = any(each.scans is False for each in settings.sensors)
    reach = WINDOWS * _window(settings, steps, unseen) + (unseen if is_lone else 0.0)
    noise = max(_noise(reports, settings, index) for index in range(len(reports.sensors)))
    return settings.motion.max_speed * reach + SIGMAS * noise


def _window(settings: Settings, steps: Sequence[tuple[Scan, ...]], unseen: float) -> float:
    """Return how long the window is [s]; without scan periods, where it is longest."""
    depth = settings.window.depth
    slowest = slowest_of(settings.sensors)
    if slowest is not None:
        return depth * (slowest.scan_period or 0.0)
    times = np.unique([scan.time for scans in steps for scan in scans])
    # Of what was before a pause in which all objects are given up, nothing is left.
    passed = np.r_[0.0, np.cumsum(np.minimum(np.diff(times), unseen))]
    depth = min(depth, passed.size - 1)
    return float(np.max(passed[depth:] - passed[: passed.size - depth]))


def _noise(reports: ReportTable, settings: Settings, index: int) -> float:
    """Return the standard deviation of a sensor's reports on the plane, the farthest ones' [m]."""
    rows = reports.sensor == index
    if not rows.any():
        return 0.0
    sensor = next(each for each in settings.sensors if each.name == reports.sensors[index])
    kind = reports.kinds[index] if reports.kinds else MeasurementKind.POSITION
    assert not isinstance(kind, ForeignKind)
    size = kind.n_components(reports.dim)
    told = reports.sigma[rows, :size]
    sigma = sensor.noise(told, reports.measurement[rows, :size], reports.dim)
    if kind.is_position:
        return float(np.quantile(sigma[:, :2].max(axis=1), 0.99))
    across = reports.measurement[rows, 0] * sigma[:, 1]
    return float(np.quantile(np.hypot(sigma[:, 0], across), 0.99))


def part_of(
    scan: Scan, sensor: Sensor, keep: NDArray[np.bool_], number: NDArray[np.int64]
) -> Scan:
    """Return a scan with the reports that are kept; without any it is an empty scan.

    ``number`` is that of each report from then on, of those that are not kept too. What all of
    the scan says of objects that it does not report, its part says.

    Returns
    -------
    The scan, of the same time.
    """
    # An empty scan is one of opportunity: it stays, with its time and where its sensor was.
    if not len(scan):
        return scan
    own: dict[str, Any] = {"report": number[keep]}
    if scan.platform is not None and scan.platform.ndim == 2 and not keep.any():
        own["platform"] = scan.platform.mean(axis=0)
    if scan.tells_silence is None:
        own["tells_silence"] = sensor.tells_silence(len(scan))
    return scan.part(keep, **own)
