"""Scans of a recording whose stamps cannot be right: far from all others, and alone."""

import numpy as np
from numpy.typing import NDArray

from trackweave.domain.reports import ReportTable

__all__ = ["is_lone", "note_on_lone"]

# Farther than so many of the recording's own longer gaps; scans between may be lost.
GAPS, LONGER = 10.0, 0.9
# Where more stamps than this stand alone, that is how the recording is.
MOST_LONE = 0.1


def is_lone(reports: ReportTable, max_ahead: float) -> NDArray[np.bool_]:
    """Tell which reports are of a scan that stands alone, far from both its neighbours."""
    # Gaps of hours are no fault of a recording; a single scan between two of them, or before or
    # behind all others, is. It is judged by the order in time, because rows may come in any.
    # ``max_ahead`` is how far apart scans may be in any case [s].
    time = reports.time
    gaps = np.diff(np.unique(time))
    nobody = np.zeros(len(reports), dtype=np.bool_)
    if gaps.size == 0:
        return nobody
    far = max(max_ahead, GAPS * float(np.quantile(gaps, LONGER)))
    if not np.any(gaps > far):
        return nobody
    starts = np.concatenate([[0], np.flatnonzero(np.diff(time) > far) + 1])
    number = time if reports.scan is None else reports.scan
    lone = nobody.copy()
    n_lone = 0
    for first, end in zip(starts, [*starts[1:], len(reports)], strict=True):
        own = slice(first, end)
        if np.ptp(reports.sensor[own]) == 0 and np.ptp(number[own]) == 0:
            lone[own] = True
            n_lone += 1
    return lone if n_lone <= MOST_LONE * (gaps.size + 1) else nobody


def note_on_lone(reports: ReportTable, lone: NDArray[np.bool_]) -> list[str]:
    """Return a sentence on the reports that are set aside, none where none is."""
    times = np.unique(reports.time[lone])
    if times.size == 0:
        return []
    listed = ", ".join(f"{time:.15g}" for time in times[:3].tolist())
    more = ", …" if times.size > 3 else ""
    return [
        f"time: {int(lone.sum())} reports at {listed}{more} s stand alone, far from all others; "
        "their scans are set aside, and their reports are of no track (live.max_ahead)"
    ]
