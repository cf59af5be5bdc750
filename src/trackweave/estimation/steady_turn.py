"""The turn of constant period that reports follow, and how fast a beam turns at first."""

from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.models.rotation import Rotation

__all__ = [
    "COARSELY",
    "FEWEST_REPORTS",
    "LEAST_REPORTS_PER_TURN",
    "LEAST_SHARE",
    "LOOSELY",
    "NEAR",
    "PERIOD_ERROR",
    "REPORTS_PER_TURN",
    "Fit",
    "likeliest_rate",
    "possible_rates",
    "settled_rate",
    "steady_turn",
]

FEWEST_REPORTS = 12
"""Fewer tell no turn."""
# From so many successive reports the turn is found; then it is followed through the others.
FIRST_REPORTS = 240
NEAR = 0.25
"""A report this near the beam fits [rad]."""
LEAST_SHARE = 0.7
"""So many have to."""
LEAST_TURNS = 2.0
SELDOM = 10.0  # A told period may be so many times as short as reports alone can tell
LEAST_TURNS_AT_FIRST = 0.1
# Where there are many, the first of every so many are looked at next.
THINNED = 8
PERIOD_ERROR = 0.1
"""A period that is given may be wrong by this share."""
LEAST_REPORTS_PER_TURN = 1.5
"""Reports per turn are more than this, or no turn could be told from another."""
STEPS_PER_TURN = 12
# Of the steps of a clock, in which times are this exact, one that looks at each of them is heard
# at more than this share.
# It is of coarse stamps where it is heard at more than the lesser.
IN_STEP, MOST_STEPS, SOME_STEPS = 0.01, 0.7, 0.3
# Frames come so near to the usual time after the last one [share], most of them, and those that
# are so much later near to several times as long; of a beam that is so of few reports to a turn.
NEARLY_ALIKE, MOSTLY, LONGER_STEP, NEAR_STEP, FEW_OF_TURN = 0.35, 0.75, 1.7, 0.2, 3.0
# A fit is told from another by so much of the share.
CLEARLY = 0.85
LOOSELY_NEAR = 0.75
# Where a beam turns so far between two stamps of a coarse clock that reports which fit may be
# farther off, half of all fit by chance: more have to.
MOST_NEAR, LEAST_COARSELY, HALF, HALF_TOLD = 1.8, 0.9, 0.85, 1.01
REPORTS_PER_TURN = 6.0
"""Where stamps are loose a turn has so many reports."""
# Those near the beam are no farther off than that [rad], and it fills between two stamps, within a
# factor, what it turns by.
FILLED = 2.5
# Where most come from one direction, at least so many do not, and so many times as many as do not
# follow the turn.
MOST_ALIKE, ELSEWHERE = 0.1, 2.5


@dataclass(frozen=True, slots=True)
class Fit:
    """How exactly reports follow a beam."""

    near: float  # So far off it they are at most [rad]
    least: float = LEAST_SHARE  # This share of them
    is_loose: bool = False  # Whether stamps are not of when the beam was there
    # Whether it turns on between two stamps of a clock, by half of which they are farther off.
    is_coarse: bool = False

    def within(self, elapsed: FloatArray, rates: FloatArray) -> FloatArray:
        """Return how far off a beam of each rate of turn [rad/s] reports are at most [rad]."""
        if not self.is_coarse:
            return np.full(rates.shape, self.near)
        half = np.abs(rates) * _gaps(elapsed).min() / 2.0
        return np.asarray(np.clip(NEAR + half, self.near, MOST_NEAR))


EXACTLY = Fit(NEAR)
LOOSELY = Fit(LOOSELY_NEAR, is_loose=True)
COARSELY = Fit(LOOSELY_NEAR, LEAST_COARSELY, is_loose=True, is_coarse=True)


def steady_turn(
    time: FloatArray,
    azimuth: FloatArray,
    period: float | None,
    direction: int | None,
    fit: Fit = EXACTLY,
) -> Rotation | None:
    """Return the turn of constant period that the reports follow from the first to the last."""
    origin = float(time[0])
    elapsed = time - origin
    # Where thousands come in a turn, the first of all are of a small part of one.
    for thin in (1, THINNED) if elapsed.size >= THINNED * FIRST_REPORTS else (1,):
        first = slice(0, thin * FIRST_REPORTS, thin)
        rate = _first_rate(elapsed[first], azimuth[first], (period, direction), fit)
        count = min(thin * FIRST_REPORTS, elapsed.size)
        followed = None if rate is None else settled_rate(elapsed, azimuth, rate, count)
        if followed is None:
            continue
        rate, phase = followed
        is_long = abs(rate) * elapsed[-1] >= LEAST_TURNS * 2 * np.pi
        if is_long and _share(elapsed, azimuth, np.array([rate]), fit)[0] >= fit.least:
            turn, sense = 2 * np.pi / abs(rate), 1 if rate > 0 else -1
            return Rotation(turn, float((phase - rate * origin) % (2 * np.pi)), sense)
    return None


def _first_rate(
    elapsed: FloatArray,
    azimuth: FloatArray,
    told: tuple[float | None, int | None],
    fit: Fit,
) -> float | None:
    """Return the rate of turn [rad/s] that the first reports follow, given what is told of it."""
    # They may come more seldom than all do.
    fewest = REPORTS_PER_TURN / 1.5 if fit.is_loose else LEAST_REPORTS_PER_TURN
    rates = possible_rates(float(elapsed[-1]), elapsed.size / fewest, *told)
    if fit.is_coarse and rates.size:
        # Half a turn between two stamps might be one the other way, and fits from many places.
        half = HALF_TOLD if told[0] is not None else HALF
        rates = rates[np.abs(rates) * _gaps(elapsed).min() < half * np.pi]
    return likeliest_rate(elapsed, azimuth, rates, fit)


def possible_rates(
    span: float, most: float, period: float | None, direction: int | None
) -> FloatArray:
    """Return rates of at most so many turns [rad/s], ascending; none where no time went by."""
    if span <= 0:
        return np.empty(0)
    least = LEAST_TURNS_AT_FIRST
    if period is not None:
        turns = span / period
        if turns > SELDOM * most:
            # A beam that is met once in many turns is met by chance.
            return np.empty(0)
        least, most = turns * (1 - PERIOD_ERROR), turns * (1 + PERIOD_ERROR) + 1 / STEPS_PER_TURN
    rates = 2 * np.pi / span * np.arange(least, most, 1 / STEPS_PER_TURN)
    parts = [sense * rates for sense in (-1, 1) if direction in (None, sense)]
    return np.sort(np.concatenate(parts))


def likeliest_rate(
    elapsed: FloatArray, azimuth: FloatArray, rates: FloatArray, fit: Fit = EXACTLY
) -> float | None:
    """Return the rate of turn [rad/s] that most reports follow, None where none is clear."""
    gaps = _gaps(elapsed)
    if rates.size == 0 or gaps.size == 0:
        return None
    # Where reports come in step with a clock, any number of turns may lie between them; but those
    # of a beam whose times are rounded leave many of its steps out.
    counts = gaps / gaps.min()
    is_clocked = bool(np.all(np.abs(counts - np.round(counts)) < IN_STEP))
    is_coarse = is_clocked and gaps.size > SOME_STEPS * float(counts.sum())
    if fit.is_coarse and not is_coarse:
        return None
    share = _share(elapsed, azimuth, rates, fit)
    best = float(share.max())
    still = _share(elapsed, azimuth, np.zeros(1), fit)[0]
    # Of a crowd in one direction, those elsewhere tell of a turn.
    is_told = fit.is_loose and 1.0 - still >= max(ELSEWHERE * (1.0 - best), MOST_ALIKE)
    if best < fit.least or (still > CLEARLY * best and not is_told):
        return None
    # Of rates that fit as well the slowest: others are that and whole turns between reports. Two
    # stamps to a turn do not tell its sense, which is clockwise nearly everywhere.
    span = float(elapsed[-1])
    fitting = rates[share >= max(fit.least, 0.95 * best)]
    fitting = fitting[np.abs(fitting) < np.abs(fitting).min() + np.pi / span]
    rate = float(fitting[fitting > 0 if fitting[-1] > 0 else fitting < 0].mean())
    step = float(np.median(gaps))
    if is_clocked and gaps.size < MOST_STEPS * float(counts.sum()):
        step = float(gaps.mean())
    if fit.is_loose and (is_coarse or gaps.size < elapsed.size / 2):
        return rate if _fills(elapsed, azimuth, rate, float(gaps.min())) else None
    if _is_of_frames(gaps, 2 * np.pi / max(abs(rate), 1e-300)):
        return None
    if _share(elapsed, azimuth, np.array([rate + 2 * np.pi / step]), fit)[0] > CLEARLY * best:
        return None
    return rate


def _gaps(elapsed: FloatArray) -> FloatArray:
    """Return the pauses between successive reports of different times [s]."""
    gaps = np.diff(elapsed)
    return np.asarray(gaps[gaps > 1e-9 * elapsed[-1]])


def _is_of_frames(gaps: FloatArray, turn: float) -> bool:
    """Tell whether nearly each report comes a usual time after the last, several to a turn [s]."""
    # Of a beam that is so of objects that stand evenly around it; of one that circles, always.
    usual = float(np.median(gaps))
    steps = gaps / usual
    missed = steps[steps > LONGER_STEP]
    if missed.size and np.median(np.abs(missed - np.round(missed))) > NEAR_STEP:
        return False
    alike = np.mean(np.abs(steps - 1.0) < NEARLY_ALIKE)
    return bool(alike > MOSTLY and turn > FEW_OF_TURN * usual)


def _fills(elapsed: FloatArray, azimuth: FloatArray, rate: float, step: float) -> bool:
    """Tell whether reports of one stamp come from as wide a sector as a beam turns by."""
    # Of several turns between two stamps, or of one object that circles, they do not.
    off = np.exp(1j * (azimuth - rate * elapsed))
    off = np.angle(off * np.conj(_middle(off)))
    sector = abs(rate) * step
    filled = np.sqrt(12.0) * off[np.abs(off) < 2 * LOOSELY_NEAR].std()
    return bool(sector / FILLED < filled < sector * FILLED)


def _share(elapsed: FloatArray, azimuth: FloatArray, rates: FloatArray, fit: Fit) -> FloatArray:
    """Return for each rate of turn the share of reports that come from where the beam is."""
    near = fit.within(elapsed, rates)[:, np.newaxis]
    off = np.exp(1j * (azimuth - rates[:, None] * elapsed))
    middle = off.mean(axis=1, keepdims=True)
    # The middle of those that are near is no longer drawn by the others.
    for _ in range(2):
        pulls = _along(off, middle) > np.cos(np.minimum(2 * near, np.pi))
        middle = np.sum(off * pulls, axis=1, keepdims=True) + 1e-12 * middle
    return np.asarray(np.mean(_along(off, middle) > np.cos(near), axis=1))


def _along(off: np.ndarray, middle: np.ndarray) -> FloatArray:
    """Return the cosine of how far unit vectors point beside their row's middle."""
    # Angles themselves would be most of the time that a search of rates takes.
    return np.asarray((off * np.conj(middle / np.maximum(np.abs(middle), 1e-300))).real)


def settled_rate(
    elapsed: FloatArray, azimuth: FloatArray, rate: float, count: int
) -> tuple[float, float] | None:
    """Return rate [rad/s] and phase at the beginning [rad], refined over more and more reports."""
    # None where too few agree: a clock that was set meanwhile puts the middle where nobody is.
    phase = 0.0
    while True:
        time, off = elapsed[:count], np.exp(1j * (azimuth[:count] - rate * elapsed[:count]))
        middle = np.angle(_middle(off))
        residual = np.angle(off * np.exp(-1j * middle))
        near = np.abs(residual) < 3 * NEAR
        for _ in range(3):
            if np.count_nonzero(near) < FEWEST_REPORTS:
                return None
            slope, level = np.polyfit(time[near], residual[near], 1)
            rest = residual - level - slope * time
            near = np.abs(rest) < max(3 * float(np.median(np.abs(rest))), 1e-6)
        rate, phase = rate + float(slope), float(middle + level)
        if count == elapsed.size:
            return rate, phase
        count = min(2 * count, elapsed.size)


def _middle(off: np.ndarray) -> complex:
    middle = complex(off.mean())
    for _ in range(2):
        near = np.abs(np.angle(off * np.conj(middle))) < 2 * NEAR
        middle = complex(np.sum(off * near)) + 1e-12 * middle
    return middle
