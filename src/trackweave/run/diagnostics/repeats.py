"""Objects that give several reports a scan, of which a track can take one."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.trees import ball_volume, tree_of
from trackweave.run.diagnostics.case import Case, Finding

__all__ = ["BY_CHANCE", "are_named_apart", "beside", "repeated_reports"]

# Of so many reports this part lie so near another of their scan that chance would put that part
# there; and as large a part is on no track, or their noise is at least so much of how near they
# are: objects that go in a group are told apart. Or so many do, and times are rounded.
FEWEST, BESIDE, BY_CHANCE, OF_ALL, AS_NOISE, MOST_OF = 100, 0.6, 0.1, 0.25, 0.5, 0.7
# Of objects that give one report a scan, so many have a name twice in one.
RARELY = 0.02
WEIGHT, REACH = 75.0, 3.0
# The first so many of a sensor's reports are looked at.
MOST = 20_000


def repeated_reports(case: Case) -> Iterator[Finding]:
    """Yield which sensors' reports lie beside others of the same scan, too near to be tracked."""
    reports = case.reports
    moment = reports.look
    for index in case.examined:
        rows = case.rows[index][:MOST]
        rows = rows[np.isfinite(case.place[rows, 0])]
        # What stands where false alarms come again and again is known already.
        rows = rows[~_is_echo(case.position[rows], case.sensors[index].echoes)]
        if case.sensors[index].scans is False or rows.size < FEWEST:
            continue
        if are_named_apart(reports, rows):
            continue
        apart, near = beside(np.unique(moment[rows], return_inverse=True)[1], case.place[rows])
        alone = case.track[rows] < 0
        is_rounded = np.mean(apart <= near) >= MOST_OF and _is_whole(moment[rows])
        is_left = np.count_nonzero(alone) >= max(FEWEST, OF_ALL * rows.size) and not is_rounded
        looked = apart[alone] if is_left else apart
        close = looked[looked <= near]
        usual = float(np.median(close)) if close.size else np.inf
        is_noise = case.plane_sigma(index) >= AS_NOISE * usual
        if close.size < BESIDE * looked.size or not (is_left or is_noise or is_rounded):
            continue
        yield Finding(
            "repeats",
            reports.sensors[index],
            f"sensor {reports.sensors[index]}: {close.size:,} of {looked.size:,} reports"
            f"{' on no track' if is_left else ''} lie beside another of their scan, {usual:.2g} m "
            f"off as a median, where chance would put {BY_CHANCE:.0%} of them: if objects give "
            "several reports a scan, as to lidar and fine radar or where times are rounded, give "
            "their extent, merge those of one object first, or tell the scans apart",
            weight=WEIGHT,
            told=float(looked.size),
            seen=float(close.size),
        )


def _is_whole(moment: FloatArray | IntArray) -> bool:
    """Tell whether all times are whole multiples of the time from one to the next."""
    steps = np.diff(np.unique(moment.astype(np.float64)))
    counts = moment / float(np.median(steps)) if steps.size else np.zeros(1)
    return bool(np.all(np.abs(counts - np.round(counts)) < 1e-6))


def are_named_apart(reports: ReportTable, rows: IntArray) -> bool:
    """Tell whether those of a sensor's ``rows`` that have a name have it alone in their scan."""
    if reports.identity is None:
        return False
    named = rows[reports.identity[rows] >= 0]
    each = np.column_stack([reports.look[named], reports.identity[named]])
    n_again = named.size - len(np.unique(each, axis=0))
    return bool(named.size >= FEWEST and n_again <= RARELY * named.size)


def beside(scan: IntArray, place: FloatArray) -> tuple[FloatArray, float]:
    """Return how far each report is from its nearest of the same scan, and what is near."""
    # Scans are put so far apart that the nearest is of the same one, where there is any.
    extent = np.maximum(np.ptp(place, axis=0), 1e-9)
    places = np.column_stack([place, 10.0 * float(np.linalg.norm(extent)) * scan])
    distance = tree_of(places).query(places, k=min(2, len(places)))[0].reshape(len(places), -1)
    density = len(places) / (int(scan.max()) + 1) / float(np.prod(extent))
    volume = -np.log(1.0 - BY_CHANCE) / density
    near = float((volume / ball_volume(1.0, place.shape[1])) ** (1.0 / place.shape[1]))
    return np.asarray(distance[:, -1]), near


def _is_echo(position: FloatArray, echoes: Sequence[Sequence[float]]) -> NDArray[np.bool_]:
    """Tell which reports lie within three radii of a known place of false alarms."""
    found = np.zeros(len(position), dtype=np.bool_)
    for x, y, radius, *_ in echoes:
        found |= np.linalg.norm(position - (x, y), axis=1) < REACH * radius
    return found
