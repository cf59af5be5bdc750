"""A beam whose speed wanders, followed from turn to turn.

How far the beam has turned and how fast are a state of two numbers; the rate is a random walk. It
is corrected by the middle of what some reports lie off, about a turn of them at a time, so that
false alarms and objects near the sensor pull it little, and smoothed backwards [1]_.

.. [1] H. E. Rauch, F. Tung, C. T. Striebel, Maximum likelihood estimates of linear dynamic
   systems, AIAA Journal 3, 1965.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.models.rotation import FollowedRotation

__all__ = [
    "QUIET",
    "RESTLESS",
    "Beam",
    "Gait",
    "beam_after",
    "corrected",
    "first_beam",
    "followed_rotation",
    "off_beam",
]

# By so much the angle itself wanders in a turn [turns].
ANGLE_NOISE = 0.0005
# Reports this far off [turns] are of the beam at least, and past this the angle is sought anew.
NEAR, LOST = 0.06, 0.25
# Of so many reports the middle is taken, where they come within so many turns.
FEWEST, MOST_TURNS = 5, 6.0
# A report alone is no better than this [turns].
COARSE = 0.004
FEWEST_KNOTS = 4


class Gait(NamedTuple):
    """How a beam is followed: how much it may wander, and how often it is looked at."""

    rate_noise: float
    """By so much of itself the rate wanders in a turn."""
    part: float
    """Of so much of a turn the reports are taken together [turns]."""
    angle_at_first: float
    """How far the angle may be off at first [turns]."""
    rate_at_first: float
    """And the rate, as a share of itself."""


QUIET = Gait(0.003, 1.0, 0.03, 0.005)
"""Of a motor that wanders."""
RESTLESS = Gait(0.1, 0.25, 0.1, 0.05)
"""Of an antenna in the wind, whose turns differ by some hundredths."""


class Beam(NamedTuple):
    """Where a beam is: what it has turned by a time, how fast it is, and how sure that is.

    ``time`` [s], ``turned`` [turns], ``rate`` [turns/s]; variances of both, and what they share.
    """

    time: float
    turned: float
    rate: float
    angle_variance: float
    shared: float
    rate_variance: float


def first_beam(time: float, turned: float, rate: float, gait: Gait = QUIET) -> Beam:
    """Return a beam that has roughly turned so far [turns] at a time [s], at a rate [turns/s]."""
    doubt = gait.angle_at_first**2, 0.0, (gait.rate_at_first * rate) ** 2
    return Beam(time, turned, rate, *doubt)


def beam_after(beam: Beam, time: float, gait: Gait = QUIET) -> Beam:
    """Return where a beam is expected at a time [s] that is not before its own."""
    step = time - beam.time
    turns = step * beam.rate
    noise = gait.rate_noise**2 * turns
    return Beam(
        time,
        beam.turned + turns,
        beam.rate,
        beam.angle_variance
        + 2.0 * step * beam.shared
        + step**2 * beam.rate_variance
        + noise * turns**2 / 3.0
        + ANGLE_NOISE**2 * turns,
        beam.shared + step * beam.rate_variance + noise * turns * beam.rate / 2.0,
        beam.rate_variance + noise * beam.rate**2,
    )


def corrected(beam: Beam, off: float, variance: float) -> Beam:
    """Return a beam after a measurement of its angle, ahead by so much, and its variance."""
    # The beam is as expected at the measurement's time; it is ahead by ``off`` [turns], and the
    # variance is that of this [turns²].
    gain = beam.angle_variance / (beam.angle_variance + variance)
    gain_rate = beam.shared / (beam.angle_variance + variance)
    return Beam(
        beam.time,
        beam.turned + gain * off,
        beam.rate + gain_rate * off,
        (1.0 - gain) * beam.angle_variance,
        (1.0 - gain) * beam.shared,
        beam.rate_variance - gain_rate * beam.shared,
    )


def off_beam(
    beam: Beam, time: FloatArray, angle: FloatArray, gait: Gait = QUIET
) -> tuple[Beam, float, float] | None:
    """Return what some reports say of where a beam is; None where they do not agree."""
    # They tell the beam as expected in their midst, how far it is ahead of that [turns], and the
    # variance of that. Angles are in turns in the beam's sense, whole turns being nothing.
    off = _wrapped(angle - beam.turned - beam.rate * (time - beam.time))
    expected = beam_after(beam, max(beam.time, float(time.mean())), gait)
    reach = max(NEAR, 3.0 * float(np.sqrt(expected.angle_variance)))
    middle = 0.0
    if reach > LOST:
        # Nothing is known of the angle any more: it is where most reports are.
        reach = 2.0 * NEAR
        for width in (0.5, 2.0 * reach):
            pull = np.abs(_wrapped(off - middle)) <= width
            middle = float(np.angle(np.exp(2j * np.pi * off[pull]).sum()) / (2.0 * np.pi))
    near = _wrapped(off - middle)
    near = near[np.abs(near) <= reach]
    if near.size < max(1, off.size / 2):
        return None
    centre = float(np.median(near))
    spread = 1.48 * float(np.median(np.abs(near - centre))) if near.size >= FEWEST else 0.0
    return expected, middle + centre, max(spread, COARSE) ** 2 * 1.57 / near.size


def followed_rotation(
    time: FloatArray, azimuth: FloatArray, rate: float, phase: float, gait: Gait = QUIET
) -> FollowedRotation | None:
    """Return the turn of a beam that wanders, from roughly how it turns at first."""
    # Azimuths are clockwise from north [rad], times ascending [s]. The rate is that at first
    # [rad/s], negative counter-clockwise, the phase where the beam is at the first report [rad].
    # It is None where there are too few reports for that.
    direction = 1 if rate > 0 else -1
    turn = direction * 2.0 * np.pi
    expected, known = [], []
    beam = first_beam(float(time[0]), phase / turn, rate / turn, gait)
    angle = azimuth / turn
    for begin, end in _turn_by_turn(time, beam.rate, gait.part):
        found = off_beam(beam, time[begin:end], angle[begin:end], gait)
        if found is not None:
            expected.append(found[0])
            beam = corrected(*found)
            known.append(beam)
    if len(known) < FEWEST_KNOTS:
        return None
    smoothed = np.array(list(_smoothed(expected, known)))
    return _rotation(smoothed, (float(time[0]), float(time[-1])), direction)


def _turn_by_turn(time: FloatArray, rate: float, part: float) -> Iterator[tuple[int, int]]:
    """Yield the first and the last but one of successive reports, about a part at a time."""
    begin = 0
    while begin < time.size:
        turn, longest = np.searchsorted(time, time[begin] + np.array([part, MOST_TURNS]) / rate)
        end = max(int(turn), min(begin + FEWEST, int(longest)), begin + 1)
        yield begin, end
        begin = end


def _smoothed(expected: list[Beam], known: list[Beam]) -> Iterator[tuple[float, float, float]]:
    """Yield time, angle and rate as later reports tell them too, the last first."""
    angle, rate = known[-1].turned, known[-1].rate
    yield known[-1].time, angle, rate
    for now, after in zip(known[-2::-1], expected[:0:-1], strict=True):
        step = after.time - now.time
        ahead = np.array(
            [
                [now.angle_variance + step * now.shared, now.shared],
                [now.shared + step * now.rate_variance, now.rate_variance],
            ]
        )
        a, b, c = after.angle_variance, after.shared, after.rate_variance
        inverse = np.array([[c, -b], [-b, a]]) / (a * c - b * b)
        more = ahead.T @ inverse @ np.array([angle - after.turned, rate - after.rate])
        angle, rate = now.turned + float(more[0]), now.rate + float(more[1])
        yield now.time, angle, rate


def _rotation(
    smoothed: FloatArray, bounds: tuple[float, float], direction: int
) -> FollowedRotation | None:
    """Return a turn that goes through what was found, from the first report to the last."""
    time, angle, rate = smoothed[::-1].T
    first, last = bounds
    ends = angle[0] - rate[0] * (time[0] - first), angle[-1] + rate[-1] * (last - time[-1])
    knots, turns = np.r_[first, time, last], np.r_[ends[0], angle, ends[1]]
    if last <= first or ends[1] <= ends[0]:
        return None
    # A beam never turns back.
    most = np.maximum.accumulate(np.r_[-np.inf, turns[:-1]])
    later = (np.diff(knots, prepend=-np.inf) > 0) & (turns > most)
    knots, turns = knots[later], turns[later]
    period = float(np.median(1.0 / rate))
    return FollowedRotation(period, 0.0, direction, knots, turns)


def _wrapped(turns: FloatArray) -> FloatArray:
    return np.asarray(turns - np.round(turns))
