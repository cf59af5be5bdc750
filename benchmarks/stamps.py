"""The same reports in other units and under other stamps, which ought to be tracked alike.

Twelve walkers before a camera, and 25 aircraft before a turning radar, 4 s a turn; each row says
what was done to their times and places. Nothing is told.
"""

import argparse
import time
from collections.abc import Callable, Iterator

import numpy as np
import polars as pl
from text_tables import command, heading, table

from trackweave import track
from trackweave.metrics import assignment_quality

HEAD = ["reports", "times and places", "IDF1", "tracks", "CPU s"]
FRAME, TURN, FAR = 0.4, 4.0, 120e3
Stamps = Callable[[np.ndarray, np.random.Generator], np.ndarray]
STAMPS: dict[str, dict[str, Stamps]] = {
    "camera": {
        "one stamp a frame": lambda told, rng: told,
        "stamps within 10 ms": lambda told, rng: told + rng.uniform(0, 0.01, told.size),
        "within 100 ms": lambda told, rng: told + rng.uniform(0, 0.1, told.size),
        "late by 20 ms, exponentially": lambda told, rng: told + rng.exponential(0.02, told.size),
    },
    "radar": {
        "each its time": lambda told, rng: told,
        "to 0.1 s": lambda told, rng: np.round(told, 1),
        "off by 0.2 s": lambda told, rng: told + rng.normal(0, 0.2, told.size),
        "late by 0.3 s, exponentially": lambda told, rng: told + rng.exponential(0.3, told.size),
        "to whole seconds": lambda told, rng: np.floor(told),
        "to 32 sectors a turn": lambda told, rng: np.ceil(told * 32 / TURN) * TURN / 32,
        "to turns": lambda told, rng: np.ceil(told / TURN) * TURN,
    },
}
UNITS = {
    "micrometres": (1e6, 1.0),
    "millimetres, minutes": (1e3, 1 / 60),
    "days": (1.0, 1 / 86_400),
}


def camera(rng: np.random.Generator) -> pl.DataFrame:
    """Return a minute of frames, with misses and three false alarms each."""
    place, speed = rng.uniform(0, 200, (12, 2)), rng.normal(0, 3, (12, 2))
    rows = []
    for frame in range(150):
        speed = speed + rng.normal(0, 0.35, speed.shape)
        place = place + FRAME * speed
        rows += [
            (FRAME * frame, *(place[each] + rng.normal(0, 0.5, 2)), str(each))
            for each in np.flatnonzero(rng.random(12) < 0.9)
        ]
        rows += [(FRAME * frame, *rng.uniform(-100, 300, 2), "") for _ in range(rng.poisson(3))]
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row")


def radar(rng: np.random.Generator) -> pl.DataFrame:
    """Return ten minutes of aircraft that fly straight on, and eight false alarms a turn."""
    heading, rows = rng.uniform(0, 2 * np.pi, 25), []
    begin = rng.uniform(-80e3, 80e3, (25, 2))
    way = rng.uniform(80, 250, (25, 1)) * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    for turn in range(150):
        for each in np.flatnonzero(rng.random(25) < 0.93):
            now = TURN * turn
            for _ in range(3):
                place = begin[each] + now * way[each]
                azimuth = np.arctan2(*place) % (2 * np.pi)
                now = TURN * (turn + azimuth / (2 * np.pi))
            told = np.degrees(azimuth) + rng.normal(0, 0.12)
            rows.append((now, np.hypot(*place) + rng.normal(0, 60), told % 360, str(each)))
        for share in rng.random(rng.poisson(8)):
            away = FAR * np.sqrt(rng.random())
            rows.append((TURN * (turn + share), away, 360 * share, ""))
    names = ["time", "range_m", "azimuth_deg", "target"]
    return pl.DataFrame(rows, names, orient="row").filter(pl.col("range_m") < FAR)


def cases(seed: int) -> Iterator[tuple[str, str, pl.DataFrame]]:
    """Yield what sees, what was done, and the reports."""
    for name, scene in (("camera", camera), ("radar", radar)):
        reports = scene(np.random.default_rng(seed))
        for done, stamp in STAMPS[name].items():
            told = stamp(reports["time"].to_numpy(), np.random.default_rng(seed + 1000))
            yield name, done, reports.with_columns(time=pl.Series(told)).sort("time")
    away, angle = pl.col("range_m"), pl.col("azimuth_deg") * np.pi / 180
    utm = {"x": 400e3 + away * angle.sin(), "y": 5200e3 + away * angle.cos()}
    yield "radar", "x, y in UTM, its place not told", reports.select("time", "target", **utm)
    reports = camera(np.random.default_rng(seed))
    for done, (length, moment) in UNITS.items():
        columns = pl.col("x", "y") * length, pl.col("time") * moment
        yield "camera", done, reports.with_columns(*columns)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rows = []
    for name, done, reports in cases(options.seed):
        before = time.process_time()
        result = track(reports.drop("target"))
        spent = time.process_time() - before
        number = result.reports["track"].fill_null(-1).to_numpy()
        found = assignment_quality(reports["target"].to_list(), number)
        rows.append([name, done, f"{found.idf1:.3f}", str(np.unique(number[number >= 0]).size),
                     f"{spent:.0f}"])  # fmt: skip
    print(heading(command("stamps.py")))
    print()
    print(table(HEAD, rows))


if __name__ == "__main__":
    main()
