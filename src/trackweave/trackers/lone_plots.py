"""Plots that only their own sensor can tell of, kept as reports."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.sensor_plots import SensorPlots
from trackweave.domain.scans import Scan
from trackweave.models._kernels import is_covered

__all__ = ["Standing", "with_lone"]


class Standing(NamedTuple):
    """What becomes a report.

    ``taken`` holds the plots of each as ``ScoredTuples`` has them, ``position`` [m] where it is,
    with ``covariance`` [m²], and ``moments`` when [s].
    """

    taken: IntArray
    position: FloatArray
    covariance: FloatArray
    moments: FloatArray


def with_lone(
    made: Standing,
    scans: Sequence[Scan],
    plots: Sequence[SensorPlots],
    measured: Sequence[SensorPlots],
) -> Standing:
    """Return reports, then the lone positions scan by scan, each at its own moment."""
    # Lone are positions that no report takes and where no other sensor looks; bearings are none.
    # ``plots`` are at the common time, ``measured`` as they were measured.
    found = [made]
    for column, (scan, own, seen) in enumerate(zip(scans, plots, measured, strict=True)):
        if own.is_bearing:
            continue
        is_free = ~_watched(own, [other for other in plots if other is not own])
        taken = made.taken[:, column]
        is_free[taken[taken > 0] - 1] = False
        left = np.flatnonzero(is_free)
        row = np.zeros((left.shape[0], len(scans)), dtype=np.int64)
        row[:, column] = left + 1
        moments = np.full(len(scan), scan.time) if scan.moments is None else scan.moments
        spread = np.asarray(seen.covariance)[left]
        found.append(Standing(row, seen.value[left], spread, moments[left]))
    return Standing(*(np.concatenate(each) for each in zip(*found, strict=True)))


def _watched(plots: SensorPlots, others: Sequence[SensorPlots]) -> NDArray[np.bool_]:
    """Return which plots lie where another sensor looks too."""
    watched = np.zeros(plots.value.shape[0], dtype=np.bool_)
    for other in others:
        if other.coverage is None:
            watched[:] = True
        else:
            view = other.coverage.coverage()
            seen = [is_covered(place[0], place[1], view) for place in plots.value]
            watched |= np.array(seen, dtype=np.bool_)
    return watched
