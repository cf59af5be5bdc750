"""How exact the heights are that reports tell beside their places, and how far off together."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import Estimates, digits
from trackweave.models.sensors import HEIGHT_NOISE

__all__ = ["with_levels"]

# An object is told of again within so long where a sensor has no period [s], and so many periods.
USUAL_LOOK, LOOKS = 10.0, 1.2
# Places agree within so many deviations.
NEAR = 3.0
# So many pairs are looked at, and of those that are near so many; fewer tell nothing.
MOST_PAIRS, MOST_NEAR, FEWEST = 1_000_000, 5_000, 100
# Differences of any two objects' heights are counted in such steps [m], at most so many.
STEP, MOST_STEPS = 50.0, 2_000
# Of each sensor's heights so many stand for all.
EVENLY = (np.arange(150) + 0.5) / 150
# The search begins from such deviations [m].
BEGINNINGS, ROUNDS = (30.0, 100.0, 300.0, 1_000.0), 40
EXACT = 10.0
# Of a crowd the best of a report's neighbours tell that heights are no noisier than so many times.
MORE, MEDIAN_OF_NORMAL = 1.5, 0.6745
# That pairs are of one object shows by so much [nats], of so many of them.
CLEAR, LEAST_SHARE = 15.0, 0.02
# Neighbours' heights differ by so many deviations.
BESIDE = 5.0
# A difference between sensors is one that explains so many times what none does.
CLEARLY = 1.2
# What is within so many times the usual noise is taken for that.
AS_USUAL = 1.5
# Two sensors' heights are compared where they are no farther apart [m].
APART = 100.0
# As heights that tell nothing count [m].
NOTHING = 1e5
UNITS = {1.0: "", 0.3048: "they are", 1.0 / 0.3048: "those are"}
"""What heights are times in another unit, and who would be in feet then."""
# Heights in the middle are as high as those of the other within this share.
NEARLY = 0.2


class _Agreement(NamedTuple):
    """How two reports of one object differ in height."""

    offset: float  # The second one's above the other's [m]
    sigma: float  # Standard deviation [m]
    gain: float = 0.0  # By how much likelier the pairs are than of any two objects [nats]


@dataclass(frozen=True, slots=True)
class _Heights:
    """The reports of one sensor that tell heights, by ascending time."""

    time: FloatArray
    place: FloatArray  # [m], shape (reports, 2)
    height: FloatArray  # [m]
    sigma: float  # Of places [m]
    look: float  # Within how long an object is told of again [s]


def with_levels(estimates: Estimates, reports: ReportTable) -> Estimates:
    """Return estimates with the noise of heights, and by how much sensors differ in them.

    Parameters
    ----------
    estimates
        Of whatever else the reports tell.
    reports
        All of them, as positions.

    Returns
    -------
    The same where heights are as exact as usual, or too few.
    """
    if reports.height is None or reports.dim != 2:
        return estimates
    heights = _heights(estimates, reports)
    sensors, notes = dict(estimates.sensors), list(estimates.notes)
    for name, own in heights.items():
        pairs = _pair(own, own, estimates.max_speed)
        found = _agreement(pairs)
        if found is None:
            continue
        later = _pair(own, own, estimates.max_speed, after=own.look)
        sigma = found.sigma * _share_of_noise(pairs, later) / np.sqrt(2.0)
        if sigma > AS_USUAL * HEIGHT_NOISE:
            sensors[name] = replace(sensors[name], sigma_height=digits(sigma, 2))
    names = sorted(heights, key=lambda name: -heights[name].time.size)
    for name in names[1:]:
        pair = _pair(heights[names[0]], heights[name], estimates.max_speed)
        unit = _unit(pair)
        found = _agreement(pair.scaled(unit))
        if found is None:
            continue
        if unit == 1.0 and abs(found.offset) > APART:
            sensors[name] = replace(sensors[name], height_offset=digits(found.offset, 3))
        elif unit != 1.0:
            sensors[name] = replace(sensors[name], sigma_height=NOTHING)
            notes.append(
                f"sensor {name}: its height_m fit those of {names[0]} only if {UNITS[unit]} in "
                "feet; expected metres of both. Its heights are not used to tell objects apart"
            )
    return replace(estimates, sensors=sensors, notes=tuple(notes))


def _heights(estimates: Estimates, reports: ReportTable) -> dict[str, _Heights]:
    """Return the heights of each sensor that tells enough of them."""
    assert reports.height is not None
    told, found = np.isfinite(reports.height), {}
    for index, name in enumerate(reports.sensors):
        rows = np.flatnonzero(told & (reports.sensor == index))
        sensor = estimates.sensors.get(name)
        if sensor is None or rows.size < FEWEST:
            continue
        look = LOOKS * (sensor.scan_period or USUAL_LOOK)
        place = reports.measurement[rows][:, :2]
        found[name] = _Heights(
            reports.time[rows], place, reports.height[rows], sensor.plane_sigma, look
        )
    return found


class _Pairs(NamedTuple):
    """Heights of two reports each, one soon after the other and near enough for one object."""

    number: IntArray  # Of the first report
    first: FloatArray  # [m]
    second: FloatArray
    any_first: FloatArray  # Heights as such, of either sensor
    any_second: FloatArray
    is_own: bool  # Whether both are one sensor's

    def scaled(self, unit: float) -> "_Pairs":
        """Return the same with the second heights in another unit."""
        return self._replace(second=unit * self.second, any_second=unit * self.any_second)


def _share_of_noise(pairs: _Pairs, later: _Pairs) -> float:
    """Return which part of the deviation between two looks is noise: a climb's doubles in two."""
    if later.first.size < FEWEST:
        return 1.0
    one, two = (_nearest(each.number, each.second - each.first) for each in (pairs, later))
    return float(np.sqrt(np.clip((4.0 - (two / one) ** 2) / 3.0, 0.0, 1.0)))


def _pair(first: _Heights, second: _Heights, fastest: float, after: float = 0.0) -> _Pairs:
    """Return the pairs of two sensors, or of one and so long after one another [s]."""
    is_own = first is second
    # Between two sensors before and after alike: who flies behind is lower or higher for good.
    since = first.time + after if is_own else first.time - second.look
    begin = np.searchsorted(second.time, since, "right" if is_own else "left")
    end = np.searchsorted(second.time, first.time + after + second.look, "right")
    step = max(int(np.ceil((end - begin).sum() / MOST_PAIRS)), 1)
    mine = np.arange(0, first.time.size, step)
    count = (end - begin)[mine]
    yours = np.repeat(begin[mine] - np.cumsum(count) + count, count) + np.arange(count.sum())
    mine = np.repeat(mine, count)
    off = np.linalg.norm(second.place[yours] - first.place[mine], axis=1)
    wait = np.abs(second.time[yours] - first.time[mine])
    near = np.flatnonzero(off < NEAR * np.hypot(first.sigma, second.sigma) + fastest * wait)
    firsts = np.unique(mine[near])[:: near.size // MOST_NEAR + 1]
    near = near[np.isin(mine[near], firsts)]
    pair = mine[near], first.height[mine[near]], second.height[yours[near]]
    return _Pairs(*pair, first.height, second.height, is_own)


def _unit(pairs: _Pairs) -> float:
    """Return how many times the first ones' the second heights' unit is, 1 for the same."""
    if pairs.first.size < FEWEST:
        return 1.0
    middle = float(np.median(pairs.first)), float(np.median(pairs.second))
    for unit in UNITS:
        if unit != 1.0 and abs(unit * middle[1] - middle[0]) < NEARLY * abs(middle[0]):
            return unit
    return 1.0


def _agreement(pairs: _Pairs) -> _Agreement | None:
    """Return how heights of one object differ, None where none are seen to be of one."""
    # Of the pairs some are of one object, and differ by little, or as two sensors do; the others
    # are of any two.
    if pairs.first.size < FEWEST:
        return None
    apart = pairs.second - pairs.first
    any_two = (np.quantile(each, EVENLY) for each in (pairs.any_first, pairs.any_second))
    by_chance = -np.subtract.outer(*any_two).reshape(-1)
    usual = _by_chance(apart, by_chance)
    # Who else is near is above as often as below: the middle is that of one object's too. Most
    # sensors do not differ.
    middles = [0.0] if pairs.is_own else [0.0, float(np.median(apart))]
    fits = [
        max(
            (_fitted(apart, usual, _Agreement(middle, each), pairs.is_own) for each in BEGINNINGS),
            key=lambda fit: fit.gain,
        )
        for middle in middles
    ]
    best = fits[-1] if fits[-1].gain > CLEARLY * fits[0].gain else fits[0]
    if best.gain < CLEAR or abs(best.offset - middles[-1]) > APART:
        return None
    return best._replace(sigma=min(best.sigma, MORE * _nearest(pairs.number, apart - best.offset)))


def _nearest(number: IntArray, apart: FloatArray) -> float:
    """Return the deviation of those that agree best with each first report."""
    least = np.full(int(number.max()) + 1, np.inf)
    np.minimum.at(least, number, np.abs(apart))
    return max(float(np.median(least[np.isfinite(least)])) / MEDIAN_OF_NORMAL, EXACT)


def _by_chance(apart: FloatArray, by_chance: FloatArray) -> FloatArray:
    """Return how dense differences like each pair's are by chance [1/m]."""
    low, high = min(apart.min(), by_chance.min()), max(apart.max(), by_chance.max())
    count = int(np.clip((high - low) / STEP + 1, 1, MOST_STEPS))
    edges = np.linspace(low, max(high, low + STEP), count + 1)
    chance = (np.histogram(by_chance, edges)[0] + 1.0) / (by_chance.size + count)
    at = np.clip(np.searchsorted(edges, apart, side="right") - 1, 0, count - 1)
    density: FloatArray = chance[at] / (edges[1] - edges[0])
    return density


def _fitted(apart: FloatArray, usual: FloatArray, begin: _Agreement, is_own: bool) -> _Agreement:
    """Return the likeliest agreement from a first one on."""
    # Neighbours are near again and again, and at heights near each other's oftener than by chance.
    offset, sigma = begin.offset, begin.sigma
    shares = np.array([0.5, 0.25, 0.25])
    for _ in range(ROUNDS):
        own, beside = (_normal(apart - offset, sigma * wide) for wide in (1.0, BESIDE))
        parts = shares[:, None] * np.stack([own, beside, usual])
        both = parts.sum(axis=0)
        weight = parts[0] / both
        total = weight.sum()
        if total < 1.0:
            return begin
        shares = np.maximum((parts / both).mean(axis=1), 1e-9)
        offset = 0.0 if is_own else float(weight @ apart / total)
        sigma = max(float(np.sqrt(weight @ (apart - offset) ** 2 / total)), EXACT)
    gain = float(np.log(both / usual).sum())
    return _Agreement(offset, sigma, gain if shares[0] > LEAST_SHARE else 0.0)


def _normal(off: FloatArray, sigma: float) -> FloatArray:
    """Return how dense a normal distribution is."""
    density: FloatArray = np.exp(-0.5 * (off / sigma) ** 2) / (sigma * np.sqrt(2.0 * np.pi))
    return density
