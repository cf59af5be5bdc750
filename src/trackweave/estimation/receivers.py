"""Sensors each of which always reports one place, its own: receivers that hear tags nearby."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import SensorEstimate, digits, positive

__all__ = ["as_one", "note_on_receivers", "receivers_in", "shared"]

# Receivers are so many sensors at least, each of which reports the very same place so often.
FEWEST, LEAST_REPORTS = 3, 3


def receivers_in(reports: ReportTable, others: Iterable[str] = ()) -> list[str]:
    """Return the sensors that report nothing but one place each, where reports say whose they are.

    Parameters
    ----------
    reports
        Reports of positions.
    others
        Sensors of which something is known, so that they are looked at on their own.

    Returns
    -------
    None where hardly any does: one or two may see a single object at rest.
    """
    if reports.identity is None:
        return []
    known, found = set(others), []
    for index, name in enumerate(reports.sensors):
        rows = np.flatnonzero(reports.sensor == index)
        if name in known or not np.any(reports.identity[rows] >= 0):
            continue
        place = reports.measurement[rows]
        if rows.size >= LEAST_REPORTS and np.all(place == place[0]):
            found.append(name)
    return found if len(found) >= FEWEST else []


def as_one(reports: ReportTable, names: Sequence[str]) -> ReportTable:
    """Return reports with those of some sensors as if the first of these had all."""
    if not names:
        return reports
    indices = [reports.sensors.index(name) for name in names]
    own = np.isin(reports.sensor, indices)
    return replace(reports, sensor=np.where(own, indices[0], reports.sensor))


def shared(
    together: SensorEstimate, reports: ReportTable, names: Sequence[str]
) -> dict[str, SensorEstimate]:
    """Return the estimate of each of some sensors from that of all together, by name."""
    counts = [np.count_nonzero(reports.sensor == reports.sensors.index(name)) for name in names]
    found = {}
    for name, count in zip(names, counts, strict=True):
        share = count / sum(counts)
        detection = -np.expm1(share * np.log1p(-together.detection_probability))
        found[name] = replace(
            together,
            detection_probability=digits(float(detection)),
            clutter_density=positive(share * together.clutter_density),
        )
    return found


def note_on_receivers(names: Sequence[str]) -> list[str]:
    """Return a sentence on such sensors, where there are any."""
    if not names:
        return []
    return [
        f"sensors {names[0]}, {names[1]} and {len(names) - 2} more report one place each, as "
        "receivers do that tell where they stand themselves: whoever they hear is somewhere "
        "about it, as far off as from one of them to the next"
    ]
