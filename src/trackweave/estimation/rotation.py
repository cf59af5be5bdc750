"""How a sensor's beam turns, from when reports came and from where."""

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.estimation.following import QUIET, RESTLESS, Gait, followed_rotation
from trackweave.estimation.steady_turn import (
    COARSELY,
    FEWEST_REPORTS,
    LEAST_REPORTS_PER_TURN,
    LEAST_SHARE,
    LOOSELY,
    NEAR,
    PERIOD_ERROR,
    REPORTS_PER_TURN,
    likeliest_rate,
    possible_rates,
    settled_rate,
    steady_turn,
)
from trackweave.models.rotation import FollowedRotation, Rotation

__all__ = ["follows", "loose_rotation_of", "off_turn", "rotation_of", "wander_of", "wanders"]

# Of a beam that wanders only so few follow a steady turn.
FIRST_STRETCHES = (240, 120, 60)
LEAST_TURNS_FOLLOWED = 8.0
# A turn is followed where so many reports together are off by more than this [rad]: at sectors'
# borders an object is looked for on one side and reported on the other.
REPORTS_PER_GROUP, FEWEST_GROUPS, UNSTEADY = 12, 6, 0.005
# What lies off a turn that is followed by more than this is off within it [rad].
RESTLESSLY = 0.02
# A part in which a beam keeps its speed has so many reports at least, of which so few successive
# ones tell where it ends; of so many less than this share follow a turn that they do not keep.
OF_PART, SOME, LEFT = 60, 24, 0.75
# Turns of parts differ by such a share at least, and more reports follow them by such a one.
OTHER, MORE = 0.03, 0.03
# Where so many beginnings lead nowhere it is no beam.
MOST_MISSED = 12


def rotation_of(
    time: FloatArray,
    azimuth: FloatArray,
    *,
    period: float | None = None,
    direction: int | None = None,
) -> Rotation | None:
    """Return the turn that says at each report's time where the report came from."""
    # A steady one where that fits to the edge of a sector; else one that is followed from turn to
    # turn. Times are ascending [s], azimuths clockwise from north, seen from the sensor [rad].
    # ``period`` is about how long a turn takes [s], if known; ``direction`` is 1 for clockwise, -1
    # for counter-clockwise. It is None where fewer than seven reports in ten follow a turn, where
    # all come from one direction or at one moment of the turn so that none could be told, and for
    # too few reports.
    if time.size < FEWEST_REPORTS:
        return None
    steady = steady_turn(time, azimuth, period, direction)
    if steady is not None and not wanders(time, azimuth, steady):
        found: Rotation | None = steady
    else:
        found = _wandering(time, azimuth, period, direction) or steady
    if found is None or _is_left(time, azimuth, found):
        changing = _changing(time, azimuth, period, direction)
        if changing is not None and (
            found is None or _near(time, azimuth, changing) > _near(time, azimuth, found) + MORE
        ):
            return changing
    return found


def loose_rotation_of(
    time: FloatArray, azimuth: FloatArray, *, period: float | None = None
) -> Rotation | None:
    """Return the steady turn that reports follow whose stamps are off by up to a tenth of it."""
    # As of ``rotation_of``; stamps may be of when reports were received, or of whole seconds, two
    # and more to a turn.
    if time.size < FEWEST_REPORTS:
        return None
    found = steady_turn(time, azimuth, period, None, LOOSELY)
    found = found or steady_turn(time, azimuth, period, None, COARSELY)
    if found is None:
        return None
    turns = float(time[-1] - time[0]) / found.period
    return found if time.size >= REPORTS_PER_TURN * turns else None


def _wandering(
    time: FloatArray, azimuth: FloatArray, period: float | None, direction: int | None
) -> Rotation | None:
    """Return the turn of a beam whose speed wanders, begun where it is steady for long enough."""
    elapsed = time - time[0]
    for count in sorted({min(count, time.size) for count in FIRST_STRETCHES}, reverse=True):
        most = count / LEAST_REPORTS_PER_TURN
        rates = possible_rates(float(elapsed[count - 1]), most, period, direction)
        rate = likeliest_rate(elapsed[:count], azimuth[:count], rates)
        if rate is None:
            continue
        followed = settled_rate(elapsed[:count], azimuth[:count], rate, count)
        if followed is None:
            continue
        rate, phase = followed
        if rate == 0 or (direction or rate) * rate < 0:
            continue
        begun = rate, phase
        found = _followed(time, azimuth, begun, QUIET)
        if found is None or wander_of(time, azimuth, found) > RESTLESSLY:
            found = _followed(time, azimuth, begun, RESTLESS) or found
        if found is not None:
            return found
    return None


def _followed(
    time: FloatArray, azimuth: FloatArray, begun: tuple[float, float], gait: Gait
) -> Rotation | None:
    """Return the turn of a beam that is followed so from its beginning, if reports follow it."""
    found = followed_rotation(time, azimuth, *begun, gait)
    if found is None or found.turned(time[-1]) - found.turned(time[0]) < LEAST_TURNS_FOLLOWED:
        return None
    return found if follows(time, azimuth, found) else None


def _is_left(time: FloatArray, azimuth: FloatArray, rotation: Rotation) -> bool:
    """Tell whether for a while hardly any report follows a turn."""
    if time.size < 3 * OF_PART:
        return False
    near = np.abs(off_turn(time, azimuth, rotation)) < NEAR
    return bool(_rolling(near, OF_PART).min() < LEFT)


def _rolling(near: NDArray[np.bool_], size: int) -> FloatArray:
    """Return the share of so many successive reports that are near a beam, one after another."""
    return np.asarray(np.convolve(near, np.full(size, 1.0 / size), "valid"))


def _changing(
    time: FloatArray, azimuth: FloatArray, period: float | None, direction: int | None
) -> FollowedRotation | None:
    """Return the turn of a beam whose speed is changed now and then, as with the range shown."""
    parts: list[tuple[int, int, Rotation]] = []
    begin, missed = 0, 0
    while begin < time.size - OF_PART and missed < MOST_MISSED:
        found = None
        for count in FIRST_STRETCHES:
            own = slice(begin, begin + count)
            # What is told is of one of the parts at most.
            found = steady_turn(time[own], azimuth[own], None, direction)
            if found is not None:
                break
        end = begin if found is None else _followed_to(time, azimuth, begin, found)
        if found is None or end - begin < OF_PART:
            begin, missed = begin + OF_PART // 4, missed + 1
            continue
        own = slice(begin, end)
        found = steady_turn(time[own], azimuth[own], None, found.direction) or found
        parts.append((begin, end, found))
        begin = end
    followed = sum(end - begin for begin, end, _ in parts)
    periods = [each.period for *_, each in parts]
    if (
        len(parts) < 2
        or followed < LEAST_SHARE * time.size
        or len({each.direction for *_, each in parts}) > 1
        or max(periods) < (1.0 + OTHER) * min(periods)
        or not (period is None or any(abs(p - period) < PERIOD_ERROR * period for p in periods))
    ):
        return None
    return _joined(time, parts)


def _followed_to(time: FloatArray, azimuth: FloatArray, begin: int, rotation: Rotation) -> int:
    """Return up to where reports from one on follow a turn, whose period is made out meanwhile."""
    end = begin + OF_PART
    while True:
        ahead = slice(begin, min(begin + 2 * (end - begin), time.size))
        near = np.abs(off_turn(time[ahead], azimuth[ahead], rotation)) < NEAR
        left = np.flatnonzero(_rolling(near, SOME) < 0.5)
        if left.size:
            # The last that follows is in the middle of those of which half do.
            return begin + int(left[0]) + SOME // 2
        end = ahead.stop
        if end == time.size:
            return end
        found = steady_turn(
            time[begin:end], azimuth[begin:end], rotation.period, rotation.direction
        )
        rotation = rotation if found is None else found


def _joined(time: FloatArray, parts: list[tuple[int, int, Rotation]]) -> FollowedRotation:
    """Return the turn that goes from part to part; between two it takes less than a turn more."""
    knots: list[float] = []
    turns: list[float] = []
    direction = parts[0][2].direction
    for begin, end, own in parts:
        ends = time[[begin, end - 1]]
        angle = own.turned(ends) + own.phase / (direction * 2.0 * np.pi)
        if turns:
            angle += np.ceil(turns[-1] - angle[0])
        knots += ends.tolist()
        turns += angle.tolist()
    lengths = np.repeat(
        [own.period for *_, own in parts],
        [round((time[end - 1] - time[begin]) / own.period) + 1 for begin, end, own in parts],
    )
    return FollowedRotation(
        float(np.median(lengths)), 0.0, direction, np.array(knots), np.array(turns)
    )


def follows(time: FloatArray, azimuth: FloatArray, rotation: Rotation) -> bool:
    """Tell whether reports came from where a beam was that turns so."""
    return _near(time, azimuth, rotation) >= LEAST_SHARE


def _near(time: FloatArray, azimuth: FloatArray, rotation: Rotation) -> float:
    """Return the share of reports that came from where a beam was that turns so."""
    return float(np.mean(np.abs(off_turn(time, azimuth, rotation)) < NEAR))


def wanders(time: FloatArray, azimuth: FloatArray, rotation: Rotation) -> bool:
    """Tell whether a beam is off a turn by more than the edge of a sector may be."""
    return wander_of(time, azimuth, rotation) > UNSTEADY


def wander_of(time: FloatArray, azimuth: FloatArray, rotation: Rotation) -> float:
    """Return by how much more than chance successive reports together lie off a turn [rad]."""
    off = off_turn(time, azimuth, rotation)
    near = off[np.abs(off) < 2 * NEAR]
    n_groups = near.size // REPORTS_PER_GROUP
    if n_groups < FEWEST_GROUPS:
        return 0.0
    groups = near[: n_groups * REPORTS_PER_GROUP].reshape(n_groups, REPORTS_PER_GROUP)
    chance = groups.var(axis=1, ddof=1).mean() / REPORTS_PER_GROUP
    return float(np.sqrt(max(groups.mean(axis=1).var(ddof=1) - chance, 0.0)))


def off_turn(time: FloatArray, azimuth: FloatArray, rotation: Rotation) -> FloatArray:
    """Return how far reports came from where the beam was, ahead of it [rad]."""
    beam = rotation.phase + rotation.direction * 2 * np.pi * rotation.turned(time)
    return np.asarray(np.angle(np.exp(1j * rotation.direction * (azimuth - beam))))
