"""What sets one sensor apart from all others: its clock, its place, its axes, its units."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.measurements import MeasurementKind
from trackweave.run.diagnostics.case import Case, Finding
from trackweave.run.diagnostics.pairs import Sample, best_clock, best_shift, sample_of
from trackweave.run.diagnostics.senses import sense_of, senses_of

__all__ = ["disagreeing_sensors", "other_senses"]

# A cause is named where it explains so many reports, and so many times more than without it or
# by chance; and of so many tracks.
FITTING_SHARE, FITTING_TIMES, FEWEST_FITTING, FEWEST_TRACKS = 0.15, 2.5, 15, 3
# A sensor of which so many times fewer fit than of the best one is the one that is wrong.
ODD_ONE = 0.6
# Simpler causes come first where they explain nearly as many.
NEARLY = 0.85
MOST_SENSORS = 8
WEIGHT = 100.0
EXPECTED = "degrees clockwise from north"


@dataclass(frozen=True, slots=True)
class _Cause:
    """A hypothesis, what share of reports fits with it, and the words for it."""

    word: str
    share: float
    tracks: int
    what: str
    change: str
    seen: float | None = None


def other_senses(case: Case) -> Iterator[Finding]:
    """Yield which sensors' bearings fit the others' positions better in another sense."""
    for index in case.examined:
        name = case.reports.sensors[index]
        if case.reports.kind_of(index) is not MeasurementKind.BEARING:
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


def disagreeing_sensors(case: Case) -> Iterator[Finding]:
    """Yield sensors whose reports fit the others' tracks under a simple transformation only."""
    telling = [index for index in case.examined if case.tells_place(index)]
    if len(telling) < 2 or case.settings.period is not None:
        return
    samples = [sample for i in telling if (sample := sample_of(case, i)) is not None]
    fitting = [sample.hits(sample.there(), sample.place)[0] for sample in samples]
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
        yield Finding(
            found.word,
            name,
            f"sensor {name}: {found.what} ({found.share:.0%} of its reports then lie on {others} "
            f"tracks, {fitting[k]:.0%} as they are); {found.change}",
            weight=WEIGHT + found.share,
            told=fitting[k],
            seen=found.seen if found.seen is not None else found.share,
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
        if cause.share >= least
        and (cause.share - before) * sample.time.size >= FEWEST_FITTING
        and cause.tracks >= min(FEWEST_TRACKS, len(sample.paths))
    ]
    best = max((cause.share for cause in clear), default=0.0)
    return next((cause for cause in clear if cause.share >= NEARLY * best), None)


def _of_units(sample: Sample, case: Case) -> Iterator[_Cause]:
    """Yield kilometres taken for metres, and the other way round."""
    pairs = sample.there()
    is_polar = case.reports.kind_of(sample.index).has_range
    what = "ranges" if is_polar else "positions"
    base = sample.platform if is_polar else 0.0
    for factor, unit in ((1e3, "kilometres"), (1e-3, "millimetres")):
        share, tracks = sample.hits(pairs, base + factor * (sample.place - base))
        yield _Cause(
            "kilometres" if factor > 1 else "millimetres",
            share,
            tracks,
            f"its {what} seem to be in {unit}",
            "give them in metres",
            factor,
        )


def _of_clock(sample: Sample) -> Iterator[_Cause]:
    """Yield a clock that is ahead of or behind the others'."""
    ahead = best_clock(sample)
    if ahead == 0.0:
        return
    share, tracks = sample.hits(sample.there(ahead), sample.place)
    shown = f"{abs(ahead):.3g} s"
    if abs(ahead) >= 120:
        shown = f"{abs(ahead):.0f} s ({abs(ahead) / 3600:.3g} h)"
    way = "ahead of" if ahead > 0 else "behind"
    yield _Cause(
        "clock",
        share,
        tracks,
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
        share, tracks = sample.hits(pairs, sample.platform + place)
        what = f"its azimuths fit the others when {_counted(sense)}"
        word = "radians" if sense == "radians" else "sense"
        yield _Cause(word, share, tracks, what, f"expected {EXPECTED}")


def _of_axes(sample: Sample) -> Iterator[_Cause]:
    """Yield axes that are exchanged or mirrored, about the origin or elsewhere."""
    pairs, change = sample.there(), "give x east and y north"
    for word, (turned, what) in _AXES.items():
        place = turned(sample.place)
        share, tracks = sample.hits(pairs, place)
        yield _Cause(word, share, tracks, what, change)
        share, tracks = sample.hits(pairs, place + best_shift(sample, pairs, place))
        # Half of all moved anywhere may fit by chance; a mirror that is told must fit better.
        yield _Cause(word, NEARLY * share, tracks, f"{what}, and moved", change)


def _of_place(sample: Sample, is_polar: bool) -> Iterator[_Cause]:
    """Yield reports that all lie as far off in one direction."""
    pairs = sample.there()
    shift = best_shift(sample, pairs, sample.place)
    far = float(np.linalg.norm(shift))
    if far > 2 * sample.near:
        share, tracks = sample.hits(pairs, sample.place + shift)
        what = f"its reports seem to lie {far:.3g} m {_direction(-shift)} of where they should"
        change = "correct its position" if is_polar else "correct its x and y"
        yield _Cause("offset", share, tracks, what, change, far)


def _direction(step: FloatArray) -> str:
    words = ["north", "north-east", "east", "south-east",
             "south", "south-west", "west", "north-west"]  # fmt: skip
    turn = np.arctan2(step[0], step[1]) / (np.pi / 4)
    return words[round(float(turn)) % 8]
