"""The parts of the study of three radars, each a table of numbers."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.studies.wiranto_plots import (
    DOCUMENT,
    METHODS,
    Instant,
    Sorted,
    instants_of_sky,
    judged,
    sort_plots,
)
from trackweave.studies.wiranto_scenes import STRAIGHT, TURNING, RadarSky, SkyShape, draw_sky
from trackweave.studies.wiranto_tracks import (
    IMM,
    LEGS,
    PRESET,
    TRACKERS,
    Offsets,
    leg_of,
    offsets_from,
    offsets_of_plots,
    run_tracker,
)
from trackweave.studies.writing import Table

__all__ = [
    "NOISES",
    "PLOTS",
    "SELECTED",
    "SKIES",
    "SMOOTHED",
    "by_noise",
    "sort_sky",
    "sorting",
    "spread_of",
    "summary",
    "tracking",
]

SKIES = {
    "as chosen": SkyShape(),
    "dense clutter": SkyShape(false_alarms=20.0),
    "dense clutter, formations": SkyShape(false_alarms=20.0, abreast=3),
}
NOISES = (1.0, 3.0, 10.0, 30.0, 100.0)
PLOTS, SELECTED, SMOOTHED = "plots", "selected, fused", "default, imm, history"
OFF = ("RMSE [m]", "scatter [m]", "to the right [m]", "ahead [m]")
Step = Callable[[], None]


def sort_sky(sky: RadarSky, methods: Sequence[str], rng: np.random.Generator) -> dict[str, Sorted]:
    """Return a sky's plots as each of some methods sorts them.

    Parameters
    ----------
    sky
        The sky.
    methods
        Names of ``METHODS``.
    rng
        Source of randomness.

    Returns
    -------
    The plots by groups, by method.
    """
    posed: dict[str, tuple[Instant, ...]] = {}
    found = {}
    for name in methods:
        cost, solver = METHODS[name]
        if cost not in posed:
            posed[cost] = instants_of_sky(sky, cost)
        found[name] = sort_plots(sky, posed[cost], solver(), rng)
    return found


def sorting(rng: np.random.Generator, n_skies: Mapping[str, int], step: Step) -> Table:
    """Return how rightly each method sorts the plots of some skies.

    Parameters
    ----------
    rng
        Source of randomness.
    n_skies
        How many of each of the ``SKIES``.
    step
        Called after each sky.

    Returns
    -------
    One row per sky and method.
    """
    head: tuple[str, ...] = ()
    rows: list[tuple[object, ...]] = []
    for kind, count in n_skies.items():
        for number, own in enumerate(rng.spawn(count)):
            sky = draw_sky(SKIES[kind], own)
            least: dict[str, Sorted] = {}
            for name, found in sort_sky(sky, list(METHODS), own).items():
                exact = least.setdefault(METHODS[name][0], found)
                measures = judged(sky, found, exact.costs)
                head = ("sky", "method", "draw", *measures)
                rows.append((kind, name, number, *measures.values()))
            step()
    return Table(head, tuple(rows))


def tracking(rng: np.random.Generator, n_skies: int, step: Step) -> tuple[Table, Table]:
    """Return how well whole trackers follow, and how far off the courses they are.

    Parameters
    ----------
    rng
        Source of randomness.
    n_skies
        How many skies.
    step
        Called after each sky.

    Returns
    -------
    One row per sky and tracker, and one per sky, leg and what lies off the course.
    """
    head: tuple[str, ...] = ()
    rows: list[tuple[object, ...]] = []
    legs: list[tuple[object, ...]] = []
    for number, own in enumerate(rng.spawn(n_skies)):
        sky = draw_sky(SkyShape(), own)
        chosen = sort_sky(sky, [DOCUMENT], own)[DOCUMENT]
        aircraft = (*STRAIGHT, TURNING)
        off = {
            PLOTS: {name: offsets_of_plots(sky, name) for name in aircraft},
            SELECTED: {
                name: offsets_from(sky, name, chosen.time, chosen.place) for name in aircraft
            },
        }
        for tracker in TRACKERS:
            found = run_tracker(sky, tracker, own)
            off[tracker] = found.offsets
            if tracker == IMM:
                off[SMOOTHED] = found.smoothed
            head = ("tracker", "draw", *found.measures)
            rows.append((tracker, number, *found.measures.values()))
        for what, offsets in off.items():
            legs += [(what, leg, number, *_off(leg_of(offsets, leg))) for leg in LEGS]
        step()
    return Table(head, tuple(rows)), Table(("what", "leg", "draw", *OFF), tuple(legs))


def by_noise(rng: np.random.Generator, noises: Sequence[float], n_skies: int, step: Step) -> Table:
    """Return how far off the courses two trackers are, by the process noise that they assume.

    Parameters
    ----------
    rng
        Source of randomness.
    noises
        Power spectral densities [m²/s³].
    n_skies
        How many skies.
    step
        Called after each sky.

    Returns
    -------
    One row per sky, tracker, process noise and leg.
    """
    rows: list[tuple[object, ...]] = []
    for number, own in enumerate(rng.spawn(n_skies)):
        sky = draw_sky(SkyShape(), own)
        for tracker in (PRESET, IMM):
            for noise in noises:
                found = run_tracker(sky, tracker, own, noise)
                for leg in LEGS[:2]:
                    off = _off(leg_of(found.offsets, leg))
                    rows.append((tracker, noise, leg, number, *off, found.measures["switches"]))
        step()
    return Table(("tracker", "noise [m²/s³]", "leg", "draw", *OFF, "switches"), tuple(rows))


def _off(found: Offsets) -> tuple[float, float, float, float]:
    return found.rmse, found.scatter, float(found.right.mean()), float(found.ahead.mean())


def spread_of(values: FloatArray) -> str:
    """Return mean, standard deviation and range of some numbers, in words.

    Parameters
    ----------
    values
        At least one.

    Returns
    -------
    The words, with two digits of the standard deviation that count, and three decimals at most.
    """
    deviation = float(values.std())
    digits = 2 if deviation == 0.0 else int(np.clip(1 - np.floor(np.log10(deviation)), 0, 3))
    mean, spread, low, high = (
        f"{value:.{digits}f}".replace("-", "−")
        for value in (values.mean(), deviation, values.min(), values.max())
    )
    return f"{mean} ± {spread} ({low} to {high})"


def summary(table: Table, by: Sequence[str], names: Sequence[str]) -> Table:
    """Return means, standard deviations and ranges over draws.

    Parameters
    ----------
    table
        Numbers of each draw.
    by
        Columns whose values are kept apart.
    names
        Columns that are summed up.

    Returns
    -------
    One row for each combination of values.
    """
    places = [table.head.index(name) for name in by]
    rows: list[tuple[object, ...]] = []
    for key in dict.fromkeys(tuple(row[place] for place in places) for row in table.rows):
        where = dict(zip(by, key, strict=True))
        rows.append((*key, *(spread_of(table.column(name, **where)) for name in names)))
    return Table((*by, *names), tuple(rows))
