"""Reports of a turning beam, each with its own time, become turns."""

from collections.abc import Mapping

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.models.rotation import FollowedRotation, Rotation

__all__ = ["N_SECTORS", "Sectors", "turn_ends", "with_turns"]

# Into so many sectors a turn is cut; an object crosses few borders, and reports come in time.
N_SECTORS = 8
# A cut is moved by up to this share of a sector, to where there are no reports.
MOST_MOVED = 0.25
# Of so many directions the one with the fewest reports is where turns begin.
N_DIRECTIONS = 36


class Sectors:
    """The sectors of a beam's turns, and in which of them reports are.

    Where a beam that wanders is known to some thousandths of a turn only, an object at the border
    of two sectors would be looked for in one and reported in the other. Each turn is cut anew
    there, in the widest gap between reports.
    """

    def __init__(self, rotation: Rotation, time: FloatArray) -> None:
        self._rotation = rotation
        self._moved: dict[int, float] = {}
        swept = rotation.turned(time) * N_SECTORS
        self.number: IntArray = np.floor(swept).astype(np.int64)
        if isinstance(rotation, FollowedRotation):
            borders, cuts = _cuts(swept)
            self._moved = dict(zip(borders.tolist(), cuts.tolist(), strict=True))
            nearest = np.round(swept)
            place = np.searchsorted(borders, nearest).clip(max=max(borders.size - 1, 0))
            if borders.size:
                moved = borders[place] == nearest
                after = nearest - (swept < cuts[place])
                self.number = np.where(moved, after, self.number).astype(np.int64)

    def end(self, number: int) -> float:
        """Return when a sector ends [s]."""
        return float(self._rotation.when(self._moved.get(number + 1, number + 1) / N_SECTORS))

    def ends(self, number: IntArray) -> FloatArray:
        """Return when sectors end [s]."""
        moved = [self._moved.get(each + 1, each + 1) for each in number.tolist()]
        return self._rotation.when(np.asarray(moved, dtype=np.float64) * (1.0 / N_SECTORS))


def _cuts(swept: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the borders near which there are reports, and where to cut instead [sectors]."""
    border = np.round(swept)
    near = np.abs(swept - border) < MOST_MOVED
    borders = np.unique(border[near])
    if borders.size == 0:
        return borders, borders
    edges = np.concatenate([borders - MOST_MOVED, borders + MOST_MOVED])
    point = np.sort(np.concatenate([swept[near], edges]))
    owner = np.round(point)
    gap = np.where(owner[1:] == owner[:-1], np.diff(point), -1.0)
    middle = (point[1:] + point[:-1]) / 2
    widest = np.lexsort((gap, owner[:-1]))
    last = np.searchsorted(owner[:-1][widest], borders, side="right") - 1
    return borders, middle[widest[last]]


def turn_ends(time: FloatArray, rotation: Rotation) -> tuple[IntArray, FloatArray]:
    """Return the number of each report's turn, and when it ends [s], none before the report."""
    # A turn begins where the sensor sees least: an object there may be seen twice in a turn or not
    # at all, because it moves and because no clock is exact.
    turned = rotation.turned(time)
    place = np.minimum((N_DIRECTIONS * (turned % 1.0)).astype(np.int64), N_DIRECTIONS - 1)
    crowd = np.bincount(place, minlength=N_DIRECTIONS).astype(float)
    # A direction counts with half of its neighbours, which tells gaps from chance; of equally
    # empty ones the one in the midst of the widest gap is taken.
    near = crowd + (np.roll(crowd, 1) + np.roll(crowd, -1)) / 2
    reach = N_DIRECTIONS // 4
    far = sum(
        (np.roll(crowd, step) + np.roll(crowd, -step)) * (1 - step / reach)
        for step in range(1, reach)
    )
    quietest = np.argmin(near + far / (1e3 * max(time.size, 1)))
    begin = (float(quietest) + 0.5) / N_DIRECTIONS
    number = np.floor(turned - begin).astype(np.int64)
    ends = rotation.when(np.asarray(number + 1 + begin, dtype=np.float64))
    return number, np.maximum(ends, time)


def with_turns(reports: ReportTable, rotations: Mapping[str, Rotation]) -> IntArray | None:
    """Return scan numbers, unique within a sensor, for a table in which turns are scans."""
    # Those of the table are kept where it has any; a sensor that does not turn has a scan at each
    # time.
    if reports.scan is not None or not rotations:
        return reports.scan
    _, scan = np.unique(reports.time, return_inverse=True)
    scan = scan.reshape(-1).astype(np.int64)
    for index, name in enumerate(reports.sensors):
        if name in rotations:
            rows = reports.sensor == index
            scan[rows], _ = turn_ends(reports.time[rows], rotations[name])
    return scan
