"""Small recordings, as somebody who tries it makes them first: how many are tracked right.

Each row is a kind of recording with 5 m of noise: objects at rest, slow, that circle at 150 m or
go straight, a look each second or first so and then every ten, and tags that report themselves
every ten seconds at their own phases, or whenever they like with such a mean; without false alarms
or with a share of them over all the place. Right is an IDF1 of reports of 0.9 and more.
"""

import argparse
import time
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import polars as pl
from text_tables import command, heading, table

from trackweave import track
from trackweave.metrics import assignment_quality

SIGMA, PAUSE, RIGHT, RADIUS = 5.0, 10.0, 0.9, 150.0
HEAD = ["recording", "told", "right", "least IDF1", "most tracks", "CPU s each"]


class Kind(NamedTuple):
    """What a recording holds."""

    name: str
    count: int  # Objects
    looks: int  # Of one that looks each second; 0 for tags
    speed: float  # [m/s]
    loose: float = 0.0  # By how much of a pause each report of a tag is early or late at most
    has_names: bool = False
    told: Mapping[str, Any] = {}
    turn: float = 0.0  # By how much it circles from look to look [rad]
    pause: float = 1.0  # Between looks of the second half [s]
    is_free: bool = False  # Whether a tag reports whenever it likes
    false: float = 0.0  # Which share of all reports is of nobody


KINDS = (
    *(Kind(f"one at rest, {n} reports", 1, n, 0.0) for n in (8, 20, 60)),
    Kind("one at rest, 40 reports", 1, 40, 0.0, told={"sigma": 0.5 * SIGMA}),
    Kind("one at 1.1 m/s, 30 reports", 1, 30, 1.1),
    *(Kind(f"{n} tags, ± 10 %", n, 0, 2.0, 0.1) for n in (2, 3, 6)),
    Kind("2 tags, ± 10 %", 2, 0, 2.0, 0.1, told={"scans": False}),
    *(Kind(f"{n} tags, exact", n, 0, 2.0) for n in (2, 3, 6)),
    *(Kind(f"one circles, {turn} rad a look", 1, 100, 0.0, turn=turn) for turn in (0.3, 0.7, 1.1)),
    Kind("3 circle, 0.7 rad a look", 3, 100, 0.0, turn=0.7),
    Kind("3 straight, 10 s apart later", 3, 80, 10.0, pause=10.0),
    *(
        Kind("3 straight, 60 reports", 3, 60, 10.0, told={"sigma": factor * SIGMA})
        for factor in (0.01, 0.05, 0.2)
    ),
    *(
        Kind(f"6 tags{at}, whenever they like", 6, 0, speed, is_free=True)
        for at, speed in (("", 2.0), (" at rest", 0.0))
    ),
    Kind("6 tags, ± 10 %, a tenth false", 6, 0, 2.0, 0.1, false=0.1),
    Kind("6 tags, whenever they like, a fifth false", 6, 0, 2.0, is_free=True, false=0.2),
    *(Kind(f"{n} with names, ± 10 %", n, 0, 8.0, 0.1, has_names=True) for n in (2, 5)),
)


def reports_of(kind: Kind, rng: np.random.Generator) -> pl.DataFrame:
    """Return a recording's reports, with the object of each."""
    rows = []
    for each in range(kind.count):
        moments = np.arange(float(kind.looks))
        moments += (kind.pause - 1.0) * np.maximum(moments - kind.looks // 2, 0.0)
        if kind.is_free:
            moments = np.round(np.cumsum(rng.exponential(PAUSE, 40)), 3)
        elif not kind.looks:
            moments = np.arange(rng.uniform(0.0, PAUSE), 40 * PAUSE, PAUSE)
            moments = moments + PAUSE * rng.uniform(-kind.loose, kind.loose, moments.size)
            moments = np.round(moments[rng.random(moments.size) < 0.95], 3)
        way = rng.uniform(0.0, 2.0 * np.pi)
        velocity = kind.speed * np.array([np.cos(way), np.sin(way)])
        place = rng.uniform(-1000.0, 1000.0, 2) + np.outer(moments, velocity)
        if kind.turn:
            place += RADIUS * np.stack([np.cos(kind.turn * moments + way),
                                        np.sin(kind.turn * moments + way)], axis=1)  # fmt: skip
        place += rng.normal(0.0, SIGMA, place.shape)
        rows += [(now, *at, str(each)) for now, at in zip(moments, place, strict=True)]
    if kind.false:
        low, high = (edge([row[:3] for row in rows], axis=0) for edge in (np.min, np.max))
        count = round(kind.false / (1.0 - kind.false) * len(rows))
        rows += [(*np.round(rng.uniform(low, high), 3).tolist(), None) for _ in range(count)]
    frame = pl.DataFrame(
        rows, {"time": pl.Float64, "x": pl.Float64, "y": pl.Float64, "target": pl.String},
        orient="row",
    ).sort("time")  # fmt: skip
    return frame.with_columns(identity=pl.col("target")) if kind.has_names else frame


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--only", default="", help="part of the rows' names")
    options = parser.parse_args()
    rows = []
    for kind in (each for each in KINDS if options.only in each.name):
        told = {"sensors": {"default": dict(kind.told)}} if kind.told else {}
        found, n_tracks, before = [], [], time.process_time()
        for seed in range(options.first, options.first + options.seeds):
            reports = reports_of(kind, np.random.default_rng(seed))
            result = track(reports.drop("target"), told)
            number = result.reports["track"].to_list()
            found.append(assignment_quality(reports["target"].to_list(), number).idf1 or 0.0)
            n_tracks.append(len(set(number) - {None}))
        spent = (time.process_time() - before) / options.seeds
        said = ", ".join(f"{key} {value}" for key, value in kind.told.items()) or "nothing"
        right = sum(idf1 >= RIGHT for idf1 in found)
        rows.append([kind.name, said, f"{right} of {options.seeds}", f"{min(found):.2f}",
                     f"{max(n_tracks)}", f"{spent:.1f}"])  # fmt: skip
    print(heading(command("first_files.py")))
    print()
    print(table(HEAD, rows))


if __name__ == "__main__":
    main()
