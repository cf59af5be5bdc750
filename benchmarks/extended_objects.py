"""Objects that give several reports a look: each report for itself, or pieces as one object.

Each row is a kind of scene, nothing told. Beside objects of many points are objects that keep
together, of which none must be taken for another's piece.
"""

import argparse
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
import polars as pl
from text_tables import command, heading, table

from trackweave import track
from trackweave.metrics import assignment_quality

HEAD = [
    "scene", "objects", "each for itself: IDF1", "tracks", "CPU s",
    "as learned: IDF1", "tracks", "CPU s", "extent m",
]  # fmt: skip
EACH = {"sensors": {"default": {"extent": 0.0}}}
Points = Iterator[tuple[float, np.ndarray, str | None]]


class Way(NamedTuple):
    """How objects wander in a box."""

    count: int
    box: float  # Half its width [m]
    speed: float  # [m/s]
    looks: int
    period: float  # From look to look [s]
    turning: float  # Deviation of a change of velocity [m/s]


def walk(rng: np.random.Generator, way: Way) -> Iterator[tuple[float, np.ndarray, np.ndarray]]:
    """Yield times, places and velocities of objects that wander in a box."""
    count, box, speed, looks, period, turning = way
    place, velocity = rng.uniform(-box, box, (count, 2)), rng.normal(0.0, speed, (count, 2))
    for look in range(looks):
        velocity += rng.normal(0.0, turning, (count, 2))
        place = place + period * velocity
        velocity = np.where(np.abs(place) > box, -np.sign(place) * np.abs(velocity), velocity)
        yield look * period, place, velocity


def clutter(rng: np.random.Generator, now: float, mean: float, box: float) -> Points:
    """Yield false alarms of a look."""
    for at in rng.uniform(-box, box, (rng.poisson(mean), 2)):
        yield now, at, None


def people(rng: np.random.Generator) -> Points:
    """Yield four people before a lidar, five points each on average."""
    for now, place, _ in walk(rng, Way(4, 10.0, 0.8, 150, 0.1, 0.1)):
        for each, count in enumerate(rng.poisson(5, 4)):
            yield from ((now, at, str(each)) for at in rng.normal(place[each], 0.2, (count, 2)))
        yield from clutter(rng, now, 1.0, 12.0)


def one_car(rng: np.random.Generator) -> Points:
    """Yield one car alone, one to six points on its outline."""
    place, velocity = np.zeros(2), np.array([15.0, 3.0])
    for look in range(80):
        velocity = velocity + rng.normal(0.0, 0.3, 2)
        place = place + 0.2 * velocity
        along = velocity / np.linalg.norm(velocity)
        axes = np.stack([along, [-along[1], along[0]]])
        for _ in range(rng.integers(1, 7)):
            on_it = rng.uniform([-2.3, -0.9], [2.3, 0.9]) @ axes
            yield 0.2 * look, place + on_it + rng.normal(0.0, 0.2, 2), "car"


def ships(rng: np.random.Generator) -> Points:
    """Yield six ships of 50 to 250 m, with some echoes along each."""
    length = rng.uniform(50.0, 250.0, 6)
    for now, place, velocity in walk(rng, Way(6, 4000.0, 5.0, 100, 3.0, 0.05)):
        for each in np.flatnonzero(rng.random(6) < 0.95):
            along = velocity[each] / np.linalg.norm(velocity[each])
            for _ in range(1 + rng.poisson(length[each] / 60.0)):
                at = place[each] + along * rng.uniform(-0.5, 0.5) * length[each]
                yield now, rng.normal(at, 8.0), str(each)
        yield from clutter(rng, now, 10.0, 4000.0)


def halves(rng: np.random.Generator) -> Points:
    """Yield twenty objects of which one report in four is two."""
    for now, place, _ in walk(rng, Way(20, 900.0, 8.0, 80, 1.0, 0.3)):
        for each in np.flatnonzero(rng.random(20) < 0.9):
            at, apart = rng.normal(place[each], 3.0), rng.normal(0.0, 6.0, 2)
            is_split = rng.random() < 0.25
            yield from ((now, here, str(each))
                        for here in ((at + apart, at - apart) if is_split else (at,)))  # fmt: skip
        yield from clutter(rng, now, 5.0, 900.0)


def pack(rng: np.random.Generator) -> Points:
    """Yield eight that keep together, five sigma apart."""
    aside = 5.0 * np.stack([np.arange(8) % 4, np.arange(8) // 4], axis=1)
    for now, place, _ in walk(rng, Way(1, 1e6, 3.0, 100, 1.0, 0.1)):
        aside = aside + rng.normal(0.0, 0.1, aside.shape)
        for each in np.flatnonzero(rng.random(8) < 0.9):
            yield now, rng.normal(place[0] + aside[each], 1.0), str(each)
        yield from ((now, place[0] + at, None) for _, at, _ in clutter(rng, now, 2.0, 100.0))


def couples(rng: np.random.Generator) -> Points:
    """Yield five couples that walk side by side, six sigma apart."""
    aside = rng.normal(0.0, 0.6, (5, 2))
    for now, place, _ in walk(rng, Way(5, 20.0, 1.0, 100, 0.2, 0.1)):
        aside = aside + rng.normal(0.0, 0.01, aside.shape)
        both = np.concatenate([place, place + aside])
        for each in np.flatnonzero(rng.random(10) < 0.9):
            yield now, rng.normal(both[each], 0.1), str(each)
        yield from clutter(rng, now, 2.0, 30.0)


def crowd(rng: np.random.Generator) -> Points:
    """Yield thirty people in a room."""
    for now, place, _ in walk(rng, Way(30, 10.0, 0.8, 100, 0.2, 0.1)):
        for each in np.flatnonzero(rng.random(30) < 0.9):
            yield now, rng.normal(place[each], 0.1), str(each)


SCENES: tuple[Callable[[np.random.Generator], Points], ...] = (
    people, one_car, ships, halves, pack, couples, crowd,
)  # fmt: skip


def measured(reports: pl.DataFrame, told: Any) -> tuple[float, int, float, float]:
    """Return IDF1, number of tracks, CPU [s] and extent [m] of a run."""
    begin = time.process_time()
    result = track(reports.drop("target"), told)
    cpu = time.process_time() - begin
    found = result.reports["track"].fill_null(-1).to_numpy()
    quality = assignment_quality(reports["target"].to_list(), found)
    extent = result.run["configuration"]["sensors"]["default"]["extent"]
    return quality.idf1 or 0.0, np.unique(found[found >= 0]).size, cpu, extent


def main() -> None:
    """Print the table: means over seeds, of the number of tracks the greatest."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=1, help="the first seed (default 1)")
    parser.add_argument("--seeds", type=int, default=5, help="how many (default 5)")
    arguments = parser.parse_args()

    print(heading(command("extended_objects.py")), end="\n\n")
    lines = []
    for scene in SCENES:
        found = []
        for seed in range(arguments.first, arguments.first + arguments.seeds):
            rows = [(round(t, 3), *at, who) for t, at, who in scene(np.random.default_rng(seed))]
            frame = pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row")
            objects = frame["target"].n_unique() - frame["target"].is_null().any()
            found.append((*measured(frame, EACH), *measured(frame, None)))
        figures = np.array(found)
        mean, most = figures.mean(axis=0), figures.max(axis=0)
        lines.append([
            scene.__name__.replace("_", " "), str(objects),
            f"{mean[0]:.3f}", f"{most[1]:.0f}", f"{mean[2]:.1f}",
            f"{mean[4]:.3f}", f"{most[5]:.0f}", f"{mean[6]:.1f}",
            f"{figures[:, 7].min():.3g} to {most[7]:.3g}",
        ])  # fmt: skip
        print(*lines[-1], sep="  ", flush=True)
    print()
    print(table(HEAD, lines))


if __name__ == "__main__":
    main()
