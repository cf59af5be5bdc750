"""Reports that repeat one place exactly, which tell nothing of noise or motion."""

import numpy as np

from trackweave.domain.reports import ReportTable

__all__ = ["without_echoes"]

# A place that comes again so often, and in so many of a sensor's scans, is no measurement of
# something that moves. What rounds its coordinates repeats itself by chance, but seldom here.
FEWEST, LEAST_SHARE = 5, 0.1
# Where nearly all reports repeat themselves, that is what there is to learn from.
MOST_LEFT_OUT = 0.9


def without_echoes(reports: ReportTable) -> tuple[ReportTable, list[str]]:
    """Return reports without those that repeat one place exactly, and sentences on these."""
    # What is left tells of noise and motion. A sentence is on each sensor that gave others.
    keep, notes = np.ones(len(reports), dtype=bool), []
    for index, name in enumerate(reports.sensors):
        rows = np.flatnonzero(reports.sensor == index)
        if rows.size < FEWEST:
            continue
        places, at, count = np.unique(
            reports.measurement[rows], axis=0, return_inverse=True, return_counts=True
        )
        scans = np.unique(reports.look[rows]).size
        often = count >= max(FEWEST, LEAST_SHARE * scans)
        again = often[at.reshape(-1)]
        if not 0 < again.sum() <= MOST_LEFT_OUT * rows.size:
            continue
        keep[rows[again]] = False
        usual = ", ".join(f"{value:.6g}" for value in places[np.argmax(count)])
        more = f" and {often.sum() - 1} more" if often.sum() > 1 else ""
        notes.append(
            f"sensor {name}: {again.sum()} of {rows.size} reports repeat one place exactly "
            f"(({usual}){more}), as fixed echoes and rows without a position do; they tell "
            "nothing of noise or motion and are left out of the estimates"
        )
    return (reports.part(np.flatnonzero(keep)) if notes else reports), notes
