"""A sensor's scans, thinned to what an estimate needs."""

from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.trees import ball_volume, tree_of

__all__ = ["Frames", "frames_of", "is_absurd_period", "scan_period", "scan_times", "usual_gap"]

# Enough to estimate from in about a second; more reports change no estimate visibly.
MAX_SCANS_PER_BLOCK = 60
MAX_REPORTS = 24_000
MAX_REPORTS_PER_SCAN = 1_000
N_BLOCKS = 3
# Scans further apart than this many periods are not followed through.
LONGEST_GAP = 3.5
# Nearer in time than this [s], scans say nothing of speeds.
SHORTEST_GAP = 1e-6
# Of gaps that tell a period so many are whole multiples of it.
REGULAR = 0.75
# The density about a place is told by so many scans, and by as much space as holds so many
# reports of each.
SCANS_OF_DENSITY, OTHERS_AND_OWN = 20, 4
# What looks so often [s] is seen to: not so few of its scans hold a report.
BRIEF, LEAST_FILLED = 1e-3, 0.02


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """Successive scans of one sensor without long gaps between them."""

    time: FloatArray  # Of each scan [s], ascending
    # Reports of each scan [m], each of shape (reports, dim); none is empty.
    position: list[FloatArray]
    share: float = 1.0  # Share of the sensor's covered space that was kept, up to 1

    def __len__(self) -> int:
        return len(self.position)

    def density_about(self, place: FloatArray) -> FloatArray:
        """Return how dense a scan's reports are about places [m], per m² (m³)."""
        # One a scan is an object's own, wherever it stands, and none of those it could be mixed
        # up with.
        some = self.position[:: -(-len(self) // SCANS_OF_DENSITY)]
        gathered = np.concatenate(some)
        count = min(OTHERS_AND_OWN * len(some), gathered.shape[0])
        distance = tree_of(gathered).query(place, k=count)[0].reshape(place.shape[0], -1)[:, -1]
        volume = ball_volume(np.maximum(distance, 1e-9), place.shape[1])
        return np.asarray((count / len(some) - 1.0) / volume)


def scan_period(time: FloatArray) -> float | None:
    """Return the time from scan to scan, the median gap [s] of ascending times, no two equal."""
    # It is robust against missing scans; None for fewer than two scans and where gaps have no
    # common size, as with a sensor that reports whenever it likes.
    gaps = np.diff(time)
    gaps = gaps[gaps > SHORTEST_GAP]
    if gaps.size == 0:
        return None
    period = float(np.median(gaps))
    if gaps.size < 4:
        return period
    # Missing scans make whole multiples; anything else says that there is no period, but that
    # times were rounded.
    multiple = gaps / period
    regular = np.abs(multiple - np.round(multiple)) < 0.2 * np.maximum(np.round(multiple), 1)
    regular &= multiple > 0.5
    if np.mean(regular) <= REGULAR:
        return _rounded_period(gaps)
    return None if is_absurd_period(time, period) else period


def _rounded_period(gaps: FloatArray) -> float | None:
    """Return the period of which most gaps are, rounded down and up; None for none."""
    values, counts = np.unique(np.round(gaps, 6), return_counts=True)
    if values.size < 2:
        return None
    grain = float(np.diff(values).min())
    is_next = np.diff(values) < 1.5 * grain
    both = np.where(is_next, counts[:-1] + counts[1:], 0)
    low = int(np.argmax(both))
    if both[low] <= REGULAR * gaps.size:
        return None
    return float(np.average(values[low : low + 2], weights=counts[low : low + 2]))


def scan_times(reports: ReportTable, sensor: int) -> FloatArray:
    """Return when each of a sensor's scans ends [s], ascending."""
    own = reports.sensor == sensor
    number = reports.look
    _, at = np.unique(number[own], return_inverse=True)
    time = np.full(at.max(initial=-1) + 1, -np.inf)
    np.maximum.at(time, at, reports.time[own])
    return np.sort(time)


def usual_gap(reports: ReportTable, sensor: int) -> float:
    """Return the median time from a sensor's scan to the next, however they differ [s]."""
    time = scan_times(reports, sensor)
    return float(np.median(np.diff(time))) if time.size > 1 else 0.0


def is_absurd_period(time: FloatArray, period: float) -> bool:
    """Tell whether a scan period [s] is the grain of a clock and not a sensor's."""
    # That is one below a millisecond of whose scans hardly any holds a report.
    filled = time.size * period
    return SHORTEST_GAP < period < BRIEF and filled < LEAST_FILLED * float(time[-1] - time[0])


def frames_of(reports: ReportTable, sensor: int) -> tuple[list[Frames], float | None]:
    """Return a sensor's scans in up to three blocks, the longest first, and their period [s]."""
    # A block has no long gaps. There may be no period.
    rows = np.flatnonzero(reports.sensor == sensor)
    number = reports.look[rows]
    order = np.argsort(number, kind="stable")
    rows, number = rows[order], number[order]
    starts = np.flatnonzero(np.r_[True, np.diff(number) != 0])
    ends = np.r_[starts[1:], rows.size]
    time = np.array([reports.time[rows[a:b]].max() for a, b in zip(starts, ends, strict=True)])
    by_time = np.argsort(time, kind="stable")
    time, starts, ends = time[by_time], starts[by_time], ends[by_time]
    period = scan_period(time)
    apart = np.diff(time)[np.diff(time) > SHORTEST_GAP]
    gap = LONGEST_GAP * (period or (float(np.median(apart)) if apart.size else 1.0))
    cuts = np.flatnonzero((np.diff(time) > gap) | (np.diff(time) <= SHORTEST_GAP)) + 1
    blocks = sorted(np.split(np.arange(time.size), cuts), key=len, reverse=True)
    blocks = _thin(blocks, ends - starts)
    keep, share = _window(reports.measurement[rows], rows.size / time.size)
    frames = []
    for block in blocks:
        scans = [rows[starts[k] : ends[k]][keep[starts[k] : ends[k]]] for k in block]
        full = [k for k, scan in enumerate(scans) if scan.size]
        position = [np.ascontiguousarray(reports.measurement[scans[k]]) for k in full]
        frames.append(Frames(time[block][full], position, share))
    return frames, period


def _thin(blocks: list[np.ndarray], size: np.ndarray) -> list[np.ndarray]:
    """Cut long blocks into a few short ones, spread over the time, within the budget."""
    if len(blocks) == 1 and blocks[0].size > N_BLOCKS * MAX_SCANS_PER_BLOCK:
        blocks = np.array_split(blocks[0], N_BLOCKS)
    budget = MAX_REPORTS // min(N_BLOCKS, len(blocks))
    thinned = []
    for block in blocks[:N_BLOCKS]:
        counts = np.cumsum(np.minimum(size[block], MAX_REPORTS_PER_SCAN))
        n_scans = max(int(np.searchsorted(counts, budget)), 10)
        thinned.append(block[: min(n_scans, MAX_SCANS_PER_BLOCK)])
    return thinned


def _window(position: FloatArray, per_scan: float) -> tuple[np.ndarray, float]:
    """Return which reports lie in a middle part that holds few enough per scan, and its share."""
    keep = np.ones(position.shape[0], dtype=bool)
    if per_scan <= MAX_REPORTS_PER_SCAN:
        return keep, 1.0
    centre = np.median(position, axis=0)
    distance = np.abs(position - centre).max(axis=1)
    share = MAX_REPORTS_PER_SCAN / per_scan
    keep = distance <= np.quantile(distance, share)
    return keep, share
