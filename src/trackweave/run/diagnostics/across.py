"""What sets one sensor apart from all others: its clock, its place, its axes, its units."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.estimates import digits
from trackweave.run.diagnostics.case import Case, Finding, Path
from trackweave.run.diagnostics.units import sense_of, senses_of

__all__ = [
    "Fit",
    "Sample",
    "best_clock",
    "best_shift",
    "disagreeing_sensors",
    "other_senses",
    "sample_of",
]

# So many reports of a sensor are compared with so many tracks of others.
MOST_REPORTS, MOST_TRACKS = 240, 80
OWN_SHARE, FEWEST_OF_OTHERS = 0.3, 4
# A report is near a track within so many standard deviations, as noise may be told wrongly in no
# less and no more than these shares of the space.
NEAR_SIGMAS, NEAREST, FARTHEST = 3.0, 0.004, 0.02
# And so many times less far off is close to it: what is not the cause may be near.
CLOSE = 0.25
# Reports moved by so much of the space, in so many directions, are near a track by chance.
AWAY, DIRECTIONS = (0.13, 0.21, 0.29), 5
# Nobody follows with a clock what moves less than so many times what is near.
LEAST_MOVED = 8.0
MOST_STATES = 4000


class Fit(NamedTuple):
    """How well reports fit with tracks."""

    share: float  # Of the reports, near a track
    close: float  # Of the reports, close to one
    tracks: int  # Near how many some reports are


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """Some reports of a sensor, and the tracks that others made."""

    index: int
    time: FloatArray  # [s], shape (reports,)
    place: FloatArray  # Where the reports put their objects [m], shape (reports, 2)
    platform: FloatArray  # Where their sensor was [m], shape (reports, 2)
    paths: Sequence[Path]
    near: float  # How far from a track a report of its object may be [m]
    extent: float  # Diagonal of the space in which the tracks are [m]

    def there(
        self, later: float = 0.0, scale: float = 1.0
    ) -> tuple[IntArray, IntArray, FloatArray]:
        """Return pairs of a report and a track alive then: both numbers, and the track's place."""
        # What is later by so many seconds was made that much earlier; times are in a unit of
        # so many seconds.
        report, track, place = [], [], []
        for number, path in enumerate(self.paths):
            at = path.at(scale * self.time - later)
            alive = np.flatnonzero(~np.isnan(at[:, 0]))
            report.append(alive)
            track.append(np.full(alive.size, number))
            place.append(at[alive])
        return np.concatenate(report), np.concatenate(track), np.concatenate(place)

    def fit(self, pairs: tuple[IntArray, IntArray, FloatArray], place: FloatArray) -> Fit:
        """Return how well reports fit that are taken to be at some places [m]."""
        report, track, there = pairs
        off = there - place[report]
        away = np.einsum("ij,ij->i", off, off)
        is_near, is_close = away <= self.near**2, away <= (CLOSE * self.near) ** 2
        near_one = np.unique(track[is_near], return_counts=True)[1]
        share, close = (
            np.unique(report[some]).size / max(self.time.size, 1) for some in (is_near, is_close)
        )
        return Fit(share, close, int(np.count_nonzero(near_one >= 3)))

    def chance(self, pairs: tuple[IntArray, IntArray, FloatArray], place: FloatArray) -> float:
        """Return the share of reports that are near a track wherever they are."""
        angle = 0.7 + 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
        steps = self.extent * np.stack([np.sin(angle), np.cos(angle)], axis=1)
        return max(self.fit(pairs, place + away * step).share for away in AWAY for step in steps)


def sample_of(case: Case, index: int) -> Sample | None:
    """Return some of a sensor's reports beside the others' tracks, None where there are none."""
    of, rows = case.reports.sensor, case.rows[index]
    paths = []
    for path in case.paths:
        others = int(np.count_nonzero(of[path.rows] != index))
        if others >= max(FEWEST_OF_OTHERS, OWN_SHARE * path.rows.size):
            paths.append(path)
    rows = rows[~np.isnan(case.position[rows, 0])]
    if not paths or rows.size == 0:
        return None
    rows = rows[:: -(-rows.size // MOST_REPORTS)]
    known = np.concatenate([path.place for path in paths[:MOST_TRACKS]])
    extent = max(float(np.linalg.norm(np.ptp(known, axis=0))), 1e-9)
    near = np.clip(NEAR_SIGMAS * case.plane_sigma(index), NEAREST * extent, FARTHEST * extent)
    return Sample(
        index,
        case.reports.time[rows],
        case.position[rows],
        case.platform[rows],
        paths[:MOST_TRACKS],
        float(near),
        extent,
    )


def best_shift(
    sample: Sample, pairs: tuple[IntArray, IntArray, FloatArray], place: FloatArray
) -> FloatArray:
    """Return by how much, east and north [m], to move reports so that most are near a track."""
    # ``pairs`` are reports and tracks alive at their times; ``place`` is where the reports are
    # taken to be [m].
    off = pairs[2] - place[pairs[0]]
    if off.shape[0] == 0:
        return np.zeros(2)
    low = off.min(axis=0)
    cell = np.floor((off - low) / sample.near).astype(np.int64)
    width = int(cell[:, 1].max()) + 3
    # Whatever lies about a corner is near in one of four cells; a square of them counts.
    key = (cell[:, 0] + 1) * width + cell[:, 1] + 1
    square = np.concatenate([key, key - 1, key - width, key - width - 1])
    found, count = np.unique(square, return_counts=True)
    corner = np.array(divmod(int(found[np.argmax(count)]), width), dtype=float)
    middle = low + corner * sample.near
    for _ in range(3):
        close = np.linalg.norm(off - middle, axis=1) <= 1.5 * sample.near
        middle = np.median(off[close], axis=0) if close.any() else middle
    return np.asarray(middle)


def best_clock(sample: Sample) -> float:
    """Return by how much a sensor's clock is ahead of the others' if it is [s]."""
    # Reports are compared with places where tracks were at any time: the times between vote. It is
    # 0 where nothing moves, so that nobody can tell.
    moved = [
        path
        for path in sample.paths
        if np.linalg.norm(np.ptp(path.place, axis=0)) > LEAST_MOVED * sample.near
    ]
    if not moved:
        return 0.0
    time = np.concatenate([path.time for path in moved])
    place = np.concatenate([path.place for path in moved])
    speed = float(np.median(np.concatenate([path.speed for path in moved])))
    some = slice(None, None, -(-time.size // MOST_STATES))
    report, state = _beside(sample.place, place[some], 1.5 * sample.near)
    if report.size == 0 or speed <= 0:
        return 0.0
    width = sample.near / speed
    steps = np.round((sample.time[report] - time[some][state]) / width)
    # Of each report, each moment counts once, however many states are near.
    votes = np.unique(np.stack([report, steps]), axis=1)[1]
    found, count = np.unique(np.concatenate([votes, votes + 1]), return_counts=True)
    around = (float(found[np.argmax(count)]) - 0.5) * width
    tried = around + width * np.linspace(-1.5, 1.5, 7)
    shares = [sample.fit(sample.there(later), sample.place).share for later in tried]
    best = np.flatnonzero(np.array(shares) >= 0.98 * max(shares))
    return float(tried[best].mean())


def _beside(one: FloatArray, other: FloatArray, radius: float) -> tuple[IntArray, IntArray]:
    """Return the pairs of rows of two tables of points that are this near."""
    # SciPy's trees take longer to import than all of this.
    low = np.minimum(one.min(axis=0), other.min(axis=0)) - 2 * radius
    cells = [np.floor((points - low) / radius).astype(np.int64) for points in (one, other)]
    width = int(max(cells[0][:, 1].max(), cells[1][:, 1].max())) + 2
    keys = [cell[:, 0] * width + cell[:, 1] for cell in cells]
    order = np.argsort(keys[1], kind="stable")
    ordered = keys[1][order]
    first, second = [], []
    for step in (-width, 0, width):
        # Three cells of a column follow one another.
        begin = np.searchsorted(ordered, keys[0] + step - 1, "left")
        count = np.searchsorted(ordered, keys[0] + step + 1, "right") - begin
        first.append(np.repeat(np.arange(len(one)), count))
        within = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        second.append(order[np.repeat(begin, count) + within])
    rows, others = np.concatenate(first), np.concatenate(second)
    is_near = np.linalg.norm(one[rows] - other[others], axis=1) <= radius
    return rows[is_near], others[is_near]


# A cause is named where it explains so many reports, and so many times more than without it or
# by chance; and of so many tracks.
FITTING_SHARE, FITTING_TIMES, FEWEST_FITTING, FEWEST_TRACKS = 0.15, 2.5, 15, 3
# A sensor of which so many times fewer fit than of the best one is the one that is wrong.
ODD_ONE = 0.6
# In another unit reports are so many times as far apart as what counts as near.
GATHERED = 4.0
# Simpler causes come first where they explain nearly as many.
NEARLY = 0.85
MOST_SENSORS = 8
WEIGHT = 100.0
# Units that are taken for metres [m] and for seconds [s].
LENGTHS = {"kilometres": 1e3, "nautical miles": 1852.0, "feet": 0.3048, "millimetres": 1e-3}
TIMES = {"milliseconds": 1e-3, "minutes": 60.0}
OTHERWISE = {"millimetres": "in kilometres"} | dict.fromkeys(("offset", "clock"), "the other way")
EXPECTED = "degrees clockwise from north"


@dataclass(frozen=True, slots=True)
class _Cause:
    """A hypothesis, what share of reports fits with it, and the words for it."""

    word: str
    fit: Fit
    what: str
    change: str
    seen: float | None = None


def other_senses(case: Case) -> Iterator[Finding]:
    """Yield which sensors' bearings fit the others' positions better in another sense."""
    for index in case.examined:
        name = case.reports.sensors[index]
        if not case.reports.kind_of(index).is_bearing_only:
            continue
        found = sense_of(case, index)
        if found is None:
            continue
        best, share, right = found
        yield Finding(
            "radians" if best == "radians" else "sense",
            name,
            f"sensor {name}: its bearings fit the other sensors' positions when "
            f"{_counted(best)} ({share:.0%} of them, {right:.0%} as they are); expected "
            f"{EXPECTED}",
            weight=WEIGHT + share,
            told=right,
            seen=share,
        )


def _counted(sense: str) -> str:
    return "taken for radians" if sense == "radians" else f"counted {sense}"


def _is_coarse(case: Case) -> bool:
    """Tell whether rows of tracks are farther apart than scans, so that paths are too coarse."""
    period = case.settings.period
    scans = [each.scan_period for each in case.sensors if each.scan_period is not None]
    return period is not None and period > min(scans, default=0.0)


def disagreeing_sensors(case: Case) -> Iterator[Finding]:
    """Yield sensors whose reports fit the others' tracks under a simple transformation only."""
    telling = [index for index in case.examined if case.tells_place(index)]
    if len(telling) < 2 or _is_coarse(case):
        return
    samples = [sample for i in telling if (sample := sample_of(case, i)) is not None]
    fitting = [sample.fit(sample.there(), sample.place).share for sample in samples]
    if not samples:
        return
    odd = [k for k in np.argsort(fitting) if fitting[k] <= ODD_ONE * max(*fitting, 0.2)]
    said = 0
    for k in odd[:MOST_SENSORS]:
        found = _cause(samples[k], fitting[k], case)
        if found is None or (said and len(telling) == 2):
            continue
        said += 1
        name = case.reports.sensors[samples[k].index]
        others = "the others'"
        if len(telling) == 2:
            other = next(i for i in telling if i != samples[k].index)
            others = f"sensor {case.reports.sensors[other]}'s"
            if found.word in OTHERWISE:
                # Of two that differ either may be the one that is wrong.
                either = f"{found.what}, or {others} {OTHERWISE[found.word]}"
                found = replace(found, what=either)
        yield Finding(
            found.word,
            name,
            f"sensor {name}: {found.what} ({found.fit.share:.0%} of its reports then lie on "
            f"{others} tracks, {fitting[k]:.0%} as they are); {found.change}",
            weight=WEIGHT + found.fit.share,
            told=fitting[k],
            seen=found.seen if found.seen is not None else found.fit.share,
        )


def _cause(sample: Sample, before: float, case: Case) -> _Cause | None:
    """Return the simplest of the causes that explain clearly more than nothing does."""
    is_polar = case.reports.kind_of(sample.index).has_range
    axes = _of_senses(sample, case) if is_polar else _of_axes(sample)
    causes = [
        *_of_units(sample, case), *_of_clock(sample), *axes, *_of_place(sample, is_polar)
    ]  # fmt: skip
    pairs = sample.there()
    chance = sample.chance(pairs, sample.place) if pairs[0].size else 0.0
    least = max(FITTING_SHARE, FITTING_TIMES * max(before, chance))
    clear = [
        cause
        for cause in causes
        if cause.fit.share >= least
        and (cause.fit.share - before) * sample.time.size >= FEWEST_FITTING
        and cause.fit.tracks >= min(FEWEST_TRACKS, len(sample.paths))
    ]
    # Where most fly one way, a wrong clock brings near what a wrong place brings close.
    best = max((cause.fit.close for cause in clear), default=0.0)
    return next((cause for cause in clear if cause.fit.close >= NEARLY * best), None)


def _of_units(sample: Sample, case: Case) -> Iterator[_Cause]:
    """Yield other units of places and of times."""
    pairs = sample.there()
    is_polar = case.reports.kind_of(sample.index).has_range
    what = "ranges" if is_polar else "positions"
    base = sample.platform if is_polar else 0.0
    spread = float(np.linalg.norm(np.std(sample.place - base, axis=0)))
    for unit, metres in LENGTHS.items():
        # All in one place they fit whatever is there.
        if metres * spread > GATHERED * sample.near:
            fit = sample.fit(pairs, base + metres * (sample.place - base))
            said = f"its {what} seem to be in {unit}"
            yield _Cause(unit, fit, said, "give them in metres", metres)
    for unit, seconds in TIMES.items():
        fit = sample.fit(sample.there(scale=seconds), sample.place)
        what = f"its times seem to be in {unit}"
        yield _Cause(unit, fit, what, "give them in seconds", seconds)


def _of_clock(sample: Sample) -> Iterator[_Cause]:
    """Yield a clock that is ahead of or behind the others'."""
    ahead = best_clock(sample)
    if ahead == 0.0:
        return
    shown = f"{abs(ahead):.3g} s"
    if abs(ahead) >= 120:
        shown = f"{abs(ahead):.0f} s ({abs(ahead) / 3600:.3g} h)"
    way = "ahead of" if ahead > 0 else "behind"
    yield _Cause(
        "clock",
        sample.fit(sample.there(ahead), sample.place),
        f"its clock seems to be {way} the others' by {shown}",
        "correct its times",
        ahead,
    )


_AXES: Mapping[str, tuple[Callable[[FloatArray], FloatArray], str]] = {
    "swap": (lambda p: p[:, ::-1], "its x and y seem to be exchanged"),
    "mirror x": (lambda p: p * [-1, 1], "its east and west seem to be exchanged (x mirrored)"),
    "mirror y": (lambda p: p * [1, -1], "its north and south seem to be exchanged (y mirrored)"),
    "turned": (lambda p: -p, "its axes seem to be turned by half a turn"),
}


def _of_senses(sample: Sample, case: Case) -> Iterator[_Cause]:
    """Yield azimuths that are counted otherwise."""
    pairs, relative = sample.there(), sample.place - sample.platform
    distance, angle = np.hypot(*relative.T), np.arctan2(*relative.T)
    for sense, turned in senses_of(angle).items():
        place = distance[:, None] * np.stack([np.sin(turned), np.cos(turned)], axis=1)
        fit = sample.fit(pairs, sample.platform + place)
        what = f"its azimuths fit the others when {_counted(sense)}"
        word = "radians" if sense == "radians" else "sense"
        yield _Cause(word, fit, what, f"expected {EXPECTED}")


def _of_axes(sample: Sample) -> Iterator[_Cause]:
    """Yield axes that are exchanged or mirrored, about the origin or elsewhere."""
    pairs, change = sample.there(), "give x east and y north"
    for word, (turned, what) in _AXES.items():
        place = turned(sample.place)
        yield _Cause(word, sample.fit(pairs, place), what, change)
        moved = sample.fit(pairs, place + best_shift(sample, pairs, place))
        # Half of all moved anywhere may fit by chance; a mirror that is told must fit better.
        fit = Fit(NEARLY * moved.share, NEARLY * moved.close, moved.tracks)
        yield _Cause(word, fit, f"{what}, and moved", change)


def _of_place(sample: Sample, is_polar: bool) -> Iterator[_Cause]:
    """Yield reports that all lie as far off in one direction."""
    pairs = sample.there()
    shift = best_shift(sample, pairs, sample.place)
    far = float(np.linalg.norm(shift))
    if far > sample.near:
        fit = sample.fit(pairs, sample.place + shift)
        where = f"{digits(far, 3):g} m {_direction(-shift)}"
        what = f"its reports seem to lie {where} of where they should"
        change = "correct its position" if is_polar else "correct its x and y"
        yield _Cause("offset", fit, what, change, far)


def _direction(step: FloatArray) -> str:
    words = ("north", "north-east", "east", "south-east",
             "south", "south-west", "west", "north-west")  # fmt: skip
    return words[round(float(np.arctan2(step[0], step[1]) / (np.pi / 4))) % 8]
