"""What looks wrong with reports, although each row is fine."""

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.models.sensors import Sensor
from trackweave.run.placing import placed, platforms_of

__all__ = ["doubts_on"]

FEWEST_REPEATS, REPEATED_SHARE = 3, 0.05
FEWEST_AT_ONCE = 10
# So many directions are compared, with so many positions nearest in time.
MOST_COMPARED, MOST_BESIDE, FEWEST_COMPARED = 300, 40, 20
LONGEST_APART_S = 5.0
CLOSE_SIGMAS, LEAST_SIGMA = 3.0, np.radians(0.5)
# A sense is wrong where another explains so many directions, and so many times more.
FITTING_SHARE, FITTING_TIMES = 0.3, 2.5
OTHER_SENSES: Mapping[str, Callable[[float], float]] = {
    "counter-clockwise from north": lambda angle: -angle,
    "counter-clockwise from east": lambda angle: np.pi / 2 - angle,
    "clockwise from south": lambda angle: angle + np.pi,
}


def doubts_on(reports: ReportTable, sensors: Sequence[Sensor]) -> list[str]:
    """Return sentences on what looks wrong with reports.

    Parameters
    ----------
    reports
        Reports of any kind, on the plane.
    sensors
        The sensors, in the table's order.

    Returns
    -------
    Nothing where all looks well. Nothing is changed.
    """
    return [*_repeats(reports), *_single_times(reports), *_senses(reports, sensors)]


def _repeats(reports: ReportTable) -> Iterator[str]:
    """Yield which sensors' reports come twice, as from two copies of one feed."""
    filled = np.nan_to_num(reports.measurement, nan=-1.0)
    rows = np.column_stack([reports.sensor, reports.time, filled])
    _, first = np.unique(rows, axis=0, return_index=True)
    again = np.ones(len(reports), dtype=bool)
    again[first] = False
    for index, name in enumerate(reports.sensors):
        own = reports.sensor == index
        count, total = int(np.sum(again & own)), int(own.sum())
        if count >= max(FEWEST_REPEATS, REPEATED_SHARE * total):
            yield (
                f"sensor {name}: {count} of {total} reports are equal to another of the same "
                "time; each counts as a report of its own, and no object has two in a scan"
            )


def _single_times(reports: ReportTable) -> Iterator[str]:
    """Yield which sensors report at one time only, although more than a scan holds."""
    for index, name in enumerate(reports.sensors):
        time = reports.time[reports.sensor == index]
        if time.size >= FEWEST_AT_ONCE and np.ptp(time) == 0.0 and reports.scan is None:
            yield (
                f"sensor {name}: all {time.size} reports have the time {time[0]:.15g} s, so that "
                "they are one scan"
            )


def _senses(reports: ReportTable, sensors: Sequence[Sensor]) -> Iterator[str]:
    """Yield which sensors' directions fit the others' positions better in another sense."""
    places = {sensor.name: sensor.position for sensor in sensors if sensor.position is not None}
    positions = placed(reports, places)
    platform = platforms_of(reports, places)
    for index, kind in enumerate(reports.kinds):
        if kind is MeasurementKind.POSITION:
            continue
        others = np.array([name != reports.sensors[index] for name in positions.sensors])
        beside = np.flatnonzero(others[positions.sensor]) if len(positions) else np.empty(0, int)
        rows = np.flatnonzero(reports.sensor == index)
        rows = rows[:: max(1, rows.size // MOST_COMPARED)]
        if beside.size == 0 or rows.size < FEWEST_COMPARED:
            continue
        at = 1 if kind.has_range else 0
        sigma = max(float(sensors[index].sigmas(reports.dim)[at]), LEAST_SIGMA)
        seen = reports.measurement[rows, at], reports.time[rows], platform[rows]
        known = positions.measurement[beside], positions.time[beside]
        right, shares = _shares(seen, known, CLOSE_SIGMAS * sigma)
        best = max(shares, key=lambda sense: shares[sense])
        if shares[best] > max(FITTING_SHARE, FITTING_TIMES * right):
            word = "azimuths" if kind.has_range else "bearings"
            yield (
                f"sensor {reports.sensors[index]}: its {word} fit the other sensors' positions "
                f"when counted {best} ({shares[best]:.0%} of them, {right:.0%} as they are); "
                "expected clockwise from north"
            )


def _shares(
    seen: tuple[FloatArray, FloatArray, FloatArray],
    known: tuple[FloatArray, FloatArray],
    close: float,
) -> tuple[float, dict[str, float]]:
    """Return the share of directions that point to a position, as they are and in each sense."""
    hits = np.zeros(1 + len(OTHER_SENSES))
    count = 0
    for angle, time, platform in zip(*seen, strict=True):
        middle = int(np.searchsorted(known[1], time))
        near = slice(max(0, middle - MOST_BESIDE // 2), middle + MOST_BESIDE // 2)
        when = np.abs(known[1][near] - time) <= LONGEST_APART_S
        offset = known[0][near][when][:, :2] - platform[:2]
        if offset.shape[0] == 0:
            continue
        count += 1
        towards = np.arctan2(offset[:, 0], offset[:, 1])
        turned = [angle, *(sense(angle) for sense in OTHER_SENSES.values())]
        for place, direction in enumerate(turned):
            apart = np.abs((towards - direction + np.pi) % (2 * np.pi) - np.pi)
            hits[place] += float(apart.min() <= close)
    share = hits / max(count, 1) if count >= FEWEST_COMPARED else np.zeros_like(hits)
    return float(share[0]), dict(zip(OTHER_SENSES, share[1:].tolist(), strict=True))
