"""Reports of a turning beam, each with its own time, become turns."""

from collections.abc import Mapping

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.models.rotation import Rotation

__all__ = ["turn_ends", "with_turns"]

# Of so many sectors the one with the fewest reports is where turns begin.
N_SECTORS = 36


def turn_ends(time: FloatArray, rotation: Rotation) -> tuple[IntArray, FloatArray]:
    """Return each report's turn, and when turns end.

    A turn begins where the sensor sees least: an object there may be seen twice in a turn or not
    at all, because it moves and because no clock is exact.

    Parameters
    ----------
    time
        Time of each report [s].
    rotation
        How the beam turns.

    Returns
    -------
    The number of each report's turn, and the end of that turn [s], none before the report; each
    of shape (reports,).
    """
    turned = time / rotation.period
    sector = np.minimum((N_SECTORS * (turned % 1.0)).astype(np.int64), N_SECTORS - 1)
    crowd = np.bincount(sector, minlength=N_SECTORS).astype(float)
    # A sector counts with half of its neighbours, which tells gaps from chance; of equally empty
    # ones the one in the midst of the widest gap is taken.
    near = crowd + (np.roll(crowd, 1) + np.roll(crowd, -1)) / 2
    reach = N_SECTORS // 4
    far = sum(
        (np.roll(crowd, step) + np.roll(crowd, -step)) * (1 - step / reach)
        for step in range(1, reach)
    )
    quietest = np.argmin(near + far / (1e3 * max(time.size, 1)))
    begin = (float(quietest) + 0.5) / N_SECTORS
    number = np.floor(turned - begin).astype(np.int64)
    ends = (number + 1 + begin) * rotation.period
    return number, np.maximum(ends, time)


def with_turns(reports: ReportTable, rotations: Mapping[str, Rotation]) -> IntArray | None:
    """Return scan numbers for a table in which turns are scans.

    Parameters
    ----------
    reports
        Reports without scan numbers.
    rotations
        How beams turn, by sensor; a sensor left out has a scan at each time.

    Returns
    -------
    A number per report, unique within its sensor; those of the table where it has any.
    """
    if reports.scan is not None or not rotations:
        return reports.scan
    _, scan = np.unique(reports.time, return_inverse=True)
    scan = scan.reshape(-1).astype(np.int64)
    for index, name in enumerate(reports.sensors):
        if name in rotations:
            rows = reports.sensor == index
            scan[rows], _ = turn_ends(reports.time[rows], rotations[name])
    return scan
