"""How a sensor's beam turns, from when reports came and from where."""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.estimation.following import followed_rotation
from trackweave.models.rotation import Rotation

__all__ = [
    "follows",
    "loose_rotation_of",
    "off_turn",
    "rotation_of",
    "settled_rate",
    "wander_of",
    "wanders",
]

FEWEST_REPORTS = 12
# From so many successive reports the turn is found; then it is followed through the others.
FIRST_REPORTS = 240
# Of a beam that wanders only so few follow a steady turn.
FIRST_STRETCHES = (240, 120, 60)
LEAST_TURNS_FOLLOWED = 8.0
# A turn is followed where so many reports together are off by more than this [rad]: at sectors'
# borders an object is looked for on one side and reported on the other.
REPORTS_PER_GROUP, FEWEST_GROUPS, UNSTEADY = 12, 6, 0.005
# A report this near the beam fits [rad], and so many have to.
NEAR = 0.25
LEAST_SHARE = 0.7
LEAST_TURNS = 2.0
SELDOM = 10.0  # A told period may be so many times as short as reports alone can tell
LEAST_TURNS_AT_FIRST = 0.1
# A period that is given may be wrong by this share.
PERIOD_ERROR = 0.1
# Reports per turn are more than this, or no turn could be told from another.
LEAST_REPORTS_PER_TURN = 1.5
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
# Where stamps are loose, reports this near the beam fit [rad], if a turn has so many and the beam
# fills between two stamps, within a factor, what it turns by.
LOOSELY_NEAR, REPORTS_PER_TURN, FILLED = 0.75, 6.0, 2.5
# Where most come from one direction, at least so many do not, and so many times as many as do not
# follow the turn.
MOST_ALIKE, ELSEWHERE = 0.1, 2.5


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
    steady = _steady(time, azimuth, period, direction)
    if steady is not None and not wanders(time, azimuth, steady):
        return steady
    return _wandering(time, azimuth, period, direction) or steady


def loose_rotation_of(
    time: FloatArray, azimuth: FloatArray, *, period: float | None = None
) -> Rotation | None:
    """Return the steady turn that reports follow whose stamps are off by up to a tenth of it."""
    # As of ``rotation_of``; stamps may be of when reports were received, or of whole seconds.
    if time.size < FEWEST_REPORTS:
        return None
    found = _steady(time, azimuth, period, None, loosely=True)
    if found is None:
        return None
    turns = float(time[-1] - time[0]) / found.period
    return found if time.size >= REPORTS_PER_TURN * turns else None


def _steady(
    time: FloatArray,
    azimuth: FloatArray,
    period: float | None,
    direction: int | None,
    *,
    loosely: bool = False,
) -> Rotation | None:
    """Return the turn of constant period that the reports follow from the first to the last."""
    origin = float(time[0])
    elapsed = time - origin
    count = min(FIRST_REPORTS, elapsed.size)
    # The first reports may come more seldom than all do.
    fewest = REPORTS_PER_TURN / 1.5 if loosely else LEAST_REPORTS_PER_TURN
    rates = _possible_rates(float(elapsed[count - 1]), count / fewest, period, direction)
    rate = _likeliest_rate(elapsed[:count], azimuth[:count], rates, loosely=loosely)
    if rate is None:
        return None
    followed = settled_rate(elapsed, azimuth, rate, count)
    if followed is None:
        return None
    rate, phase = followed
    if abs(rate) * elapsed[-1] < LEAST_TURNS * 2 * np.pi:
        return None
    near = LOOSELY_NEAR if loosely else NEAR
    if _share(elapsed, azimuth, np.array([rate]), near)[0] < LEAST_SHARE:
        return None
    sense = 1 if rate > 0 else -1
    return Rotation(2 * np.pi / abs(rate), float((phase - rate * origin) % (2 * np.pi)), sense)


def _wandering(
    time: FloatArray, azimuth: FloatArray, period: float | None, direction: int | None
) -> Rotation | None:
    """Return the turn of a beam whose speed wanders, begun where it is steady for long enough."""
    elapsed = time - time[0]
    for count in sorted({min(count, time.size) for count in FIRST_STRETCHES}, reverse=True):
        most = count / LEAST_REPORTS_PER_TURN
        rates = _possible_rates(float(elapsed[count - 1]), most, period, direction)
        rate = _likeliest_rate(elapsed[:count], azimuth[:count], rates)
        if rate is None:
            continue
        followed = settled_rate(elapsed[:count], azimuth[:count], rate, count)
        if followed is None:
            continue
        rate, phase = followed
        if rate == 0 or (direction or rate) * rate < 0:
            continue
        found = followed_rotation(time, azimuth, rate, phase)
        if found is None or found.turned(time[-1]) - found.turned(time[0]) < LEAST_TURNS_FOLLOWED:
            continue
        if follows(time, azimuth, found):
            return found
    return None


def follows(time: FloatArray, azimuth: FloatArray, rotation: Rotation) -> bool:
    """Tell whether reports came from where a beam was that turns so."""
    return bool(np.mean(np.abs(off_turn(time, azimuth, rotation)) < NEAR) >= LEAST_SHARE)


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


def _possible_rates(
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


def _likeliest_rate(
    elapsed: FloatArray, azimuth: FloatArray, rates: FloatArray, *, loosely: bool = False
) -> float | None:
    """Return the rate of turn [rad/s] that most reports follow, None where none is clear."""
    if rates.size == 0:
        return None
    span, near = float(elapsed[-1]), LOOSELY_NEAR if loosely else NEAR
    share = _share(elapsed, azimuth, rates, near)
    best = float(share.max())
    still = _share(elapsed, azimuth, np.zeros(1), near)[0]
    # Of a crowd in one direction, those elsewhere tell of a turn.
    is_told = loosely and 1.0 - still >= max(ELSEWHERE * (1.0 - best), MOST_ALIKE)
    if best < LEAST_SHARE or (still > CLEARLY * best and not is_told):
        return None
    # Of rates that fit as well the slowest: others are that and whole turns between reports.
    fitting = rates[share >= max(LEAST_SHARE, 0.95 * best)]
    rate = float(fitting[np.argmin(np.abs(fitting))])
    rate = float(fitting[np.abs(fitting - rate) < np.pi / span].mean())
    gaps = np.diff(elapsed)
    gaps = gaps[gaps > 1e-9 * span]
    step = float(np.median(gaps))
    # Where reports come in step with a clock, any number of turns may lie between them; but those
    # of a beam whose times are rounded leave many of its steps out.
    counts = gaps / gaps.min()
    is_clocked = bool(np.all(np.abs(counts - np.round(counts)) < IN_STEP))
    if is_clocked and gaps.size < MOST_STEPS * float(counts.sum()):
        step = float(gaps.mean())
    is_coarse = is_clocked and gaps.size > SOME_STEPS * float(counts.sum())
    if loosely and (is_coarse or gaps.size < elapsed.size / 2):
        return rate if _fills(elapsed, azimuth, rate, float(gaps.min())) else None
    if _is_of_frames(gaps, 2 * np.pi / max(abs(rate), 1e-300)):
        return None
    if _share(elapsed, azimuth, np.array([rate + 2 * np.pi / step]), near)[0] > CLEARLY * best:
        return None
    return rate


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


def _share(
    elapsed: FloatArray, azimuth: FloatArray, rates: FloatArray, near: float = NEAR
) -> FloatArray:
    """Return for each rate of turn the share of reports that come from where the beam is."""
    off = np.exp(1j * (azimuth - rates[:, None] * elapsed))
    middle = off.mean(axis=1, keepdims=True)
    # The middle of those that are near is no longer drawn by the others.
    for _ in range(2):
        pulls = _along(off, middle) > np.cos(2 * near)
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
