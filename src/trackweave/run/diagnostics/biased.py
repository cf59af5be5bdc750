"""Whether sensors put objects beside where others see them, where biases were not looked for."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.estimates import digits
from trackweave.estimation.receivers import receivers_in
from trackweave.run.diagnostics.case import Case, Finding

__all__ = ["biased_sensors"]

# Of a sensor so many tracks are looked at, and one tells with so many reports.
MOST_TRACKS, FEWEST_REPORTS = 30, 4
# What is farther off than so many standard deviations is another object, and so is what moves
# about by more than so many.
FARTHEST, STEADY = 40.0, 3.0
# So many tracks have to agree, as a share of those that tell; and their median has to be so many
# times what they scatter by, and as much of the sensor's noise.
FEWEST_TRACKS, LEAST_SHARE, CLEAR, LEAST = 6, 0.5, 2.0, 0.5
LEAST_SPREAD = 0.05
PLACE, CLOCK, LINE = slice(0, 2), 2, slice(3, 5)
"""What may be off: places, east and north; time; of ranging sensors range and azimuth."""
# Velocities are of so many pauses between reports to both sides, and not below so much [m/s].
LONG_STEP, SLOWEST = 2.0, 0.1
OF_MEDIAN = 1.4826
# As far apart as so many of their usual pauses nobody knows where an object was between reports.
LONGEST_PAUSE = 4.0
# Nothing on the ground is faster [m/s].
FASTEST_ON_GROUND = 60.0
WEIGHT, MOST_WEIGHT = 60.0, 20.0
DEGREES = 180.0 / np.pi


class _Way(NamedTuple):
    """Reports of a track by one sensor, or by all others."""

    time: FloatArray  # [s], ascending
    place: FloatArray  # On the plane [m]
    row: IntArray
    group: int  # Number of the track among the case's groups


def biased_sensors(case: Case) -> Iterator[Finding]:
    """Yield the sensor that agrees the clearest with others but for how far they are apart."""
    # Those that it is compared with seem to be off, too, each its own way and less clearly.
    receivers = receivers_in(case.reports)
    examined = [index for index in case.examined if case.reports.sensors[index] not in receivers]
    found = [finding for index in examined if (finding := _finding(case, index)) is not None]
    yield from sorted(found, key=lambda finding: -finding.weight)[:1]


def _finding(case: Case, index: int) -> Finding | None:
    """Return what is said of a sensor, the heavier the less what is off scatters over tracks."""
    name = case.reports.sensors[index]
    why = case.unregistered.get(name)
    if why is None or not case.tells_place(index):
        return None
    off = _beside_others(case, index)
    if off.shape[0] < FEWEST_TRACKS:
        return None
    # In standard deviations of what this sensor measures.
    middle = np.median(off, axis=0)
    spread = OF_MEDIAN * np.median(np.abs(off - middle), axis=0)
    ratio = np.abs(middle) / np.maximum(spread, LEAST_SPREAD)
    ratio[np.abs(middle) < LEAST] = 0.0
    if _may_be_high(case, index):
        ratio[LINE.start] = 0.0
    part = int(np.argmax(ratio))
    if ratio[part] < CLEAR:
        return None
    sigma = _sigma(case, index)
    either = "which of them is right nothing tells; " if part <= CLOCK else ""
    seen, error = middle * sigma, 1.25 / math.sqrt(off.shape[0]) * spread * sigma
    words = _words(case, index, part, (seen, error))
    return Finding(
        "bias",
        name,
        f"sensor {name}: {words} than where other sensors see the same objects, by "
        f"{off.shape[0]} tracks; {either}nothing is taken out, as {why}: mend the sensor, or give "
        f"what is wrong in [sensors.{name}]",
        weight=WEIGHT + min(float(ratio[part]), MOST_WEIGHT),
        told=0.0,
        seen=float(seen[part]),
    )


def _words(case: Case, index: int, part: int, off: tuple[FloatArray, FloatArray]) -> str:
    """Return what is off by how much [m, rad, s], and how sure that is."""
    value, error = (float(each[part]) for each in off)
    size = digits(abs(value), 3)
    if part == CLOCK:
        way_of_clock = "later" if value > 0 else "earlier"
        return f"its times are {size:g} ± {error:.1g} s {way_of_clock}"
    if part < CLOCK:
        way = (("farther west", "farther east"), ("farther south", "farther north"))
        return f"its positions are {size:g} ± {error:.1g} m {way[part][int(value > 0)]}"
    if part == LINE.start:
        way_of_range = "greater" if value > 0 else "smaller"
        return f"its ranges are {size:g} ± {error:.1g} m {way_of_range}"
    way_of_azimuth = "greater" if value > 0 else "smaller"
    turned, unsure = abs(value) * DEGREES, error * DEGREES
    return f"its azimuths are {turned:.3g} ± {unsure:.1g}° {way_of_azimuth}"


def _may_be_high(case: Case, index: int) -> bool:
    """Tell whether ranges end above the ground, nobody knows where."""
    kind, rows = case.reports.kind_of(index), case.rows[index]
    if not kind.has_range or kind.has_elevation:
        return False
    if case.reports.height is not None and np.isfinite(case.reports.height[rows]).mean() > 0.5:
        return False
    return case.usual_speed > FASTEST_ON_GROUND


def _sigma(case: Case, index: int) -> FloatArray:
    """Return the noise of a sensor in all that may be off [m, m, s, m, rad]."""
    noise, own = case.plane_sigma(index), case.sensors[index].sigmas(case.reports.dim)[:2]
    # And the time in which objects usually come as far as its places are off.
    late = noise / max(case.usual_speed, SLOWEST)
    if case.reports.kind_of(index).has_range:
        return np.array([noise, noise, late, *own])
    return np.array([*own, late])


def _beside_others(case: Case, index: int) -> FloatArray:
    """Return how far a sensor's tracks lie beside others', in its noise, shape (tracks, parts)."""
    own, others = _ways(case, index, is_own=True), _ways(case, index, is_own=False)
    nothing = np.empty((0, 0))
    if not own or not others:
        return nothing
    own = own[:: -(-len(own) // MOST_TRACKS)]
    middle = np.array([way.time[way.time.size // 2] for way in own])
    there = np.array([way.place[way.time.size // 2] for way in own])
    gate = FARTHEST * case.plane_sigma(index)
    sigma = _sigma(case, index)
    # What both see under one name is one object, whoever else keeps beside it: posts all stand.
    same = {other.group: other for other in others}
    near: list[list[_Way]] = [[same[way.group]] if way.group in same else [] for way in own]
    for other in others:
        for number in np.flatnonzero(np.linalg.norm(_at(other, middle) - there, axis=1) < gate):
            if own[number].group not in same:
                near[number].append(other)
    told, found = 0, []
    for way, beside in zip(own, near, strict=True):
        steady = [off for other in beside if (off := _apart(case, way, other, sigma)) is not None]
        told += bool(beside)
        if steady:
            # Whoever flies the same way at the same time is rarer than the object itself.
            found.append(min(steady, key=lambda off: float(np.linalg.norm(off[PLACE]))))
    return np.array(found) if len(found) > LEAST_SHARE * told else nothing


def _ways(case: Case, index: int, *, is_own: bool) -> list[_Way]:
    """Return the reports of each track that are a sensor's own, or those of all others."""
    telling = np.array([case.tells_place(each) for each in range(len(case.reports.sensors))])
    of = case.reports.sensor
    ways = []
    for number, group in enumerate(case.groups):
        rows = group[(of[group] == index) == is_own]
        rows = rows[telling[of[rows]]]
        rows = rows[np.isfinite(case.position[rows, 0])]
        if rows.size >= FEWEST_REPORTS:
            ways.append(_Way(case.reports.time[rows], case.position[rows], rows, number))
    return ways


def _at(way: _Way, time: FloatArray) -> FloatArray:
    """Return where the reports of a way lead at some times [m], NaN where they do not tell."""
    place = np.stack([np.interp(time, way.time, axis, np.nan, np.nan) for axis in way.place.T], 1)
    pauses = np.diff(way.time)
    after = np.clip(np.searchsorted(way.time, time), 1, pauses.size) - 1
    place[pauses[after] > LONGEST_PAUSE * np.median(pauses)] = np.nan
    return place


def _apart(case: Case, own: _Way, other: _Way, sigma: FloatArray) -> FloatArray | None:
    """Return how far a way lies beside another, in noise; None where that is not steady."""
    step = LONG_STEP * float(np.median(np.diff(other.time)))
    before, expected, after = (_at(other, own.time + late) for late in (-step, 0.0, step))
    known = np.isfinite(before[:, 0] + expected[:, 0] + after[:, 0])
    if np.count_nonzero(known) < FEWEST_REPORTS or step <= 0.0:
        return None
    expected, velocity = expected[known], (after - before)[known] / (2.0 * step)
    off = own.place[known] - expected
    # What is stamped later by a second lies a second's way behind.
    late = -np.sum(off * velocity, axis=1) / np.maximum(np.sum(velocity**2, axis=1), SLOWEST**2)
    parts = [off, late]
    if sigma.size > LINE.start:
        # Along the line of sight and across it, clockwise.
        line = expected - case.platform[own.row[known]]
        distance = np.maximum(np.linalg.norm(line, axis=1), 1e-9)
        east, north = (line / distance[:, None]).T
        along = off[:, 0] * east + off[:, 1] * north
        across = (off[:, 0] * north - off[:, 1] * east) / distance
        parts += [along, across]
    scaled = np.column_stack(parts) / sigma
    middle: FloatArray = np.median(scaled, axis=0)
    scatter = OF_MEDIAN * np.median(np.abs(scaled - middle), axis=0)
    is_steady = scatter <= STEADY
    told = (PLACE, CLOCK, LINE) if sigma.size > LINE.start else (PLACE, CLOCK)
    return middle if any(np.all(is_steady[part]) for part in told) else None
