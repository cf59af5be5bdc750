"""Objects that keep together and report themselves without names, each told apart by its reports.

Each row is a pack on a winding way: how many, how far apart, how fast, how often each reports, and
how noisy that is. With nothing told, with the noise, and with that wrong by a factor.
"""

import argparse
import time
from typing import NamedTuple

import numpy as np
import polars as pl
from text_tables import command, heading, table

from trackweave import track
from trackweave.metrics import assignment_quality

HEAD = ["objects", "apart m", "m/s", "every s", "sigma m", "told sigma", "IDF1", "tracks", "CPU s"]


class Pack(NamedTuple):
    """How objects keep together."""

    count: int
    apart: float  # From one to the next [m]
    speed: float  # [m/s]
    every: tuple[float, float]  # Least and greatest time from one's report to its next [s]
    sigma: float  # [m]
    minutes: float


PACKS = (
    Pack(1, 0.0, 8.0, (4.0, 4.0), 4.0, 20.0),
    Pack(8, 15.0, 8.0, (4.0, 12.0), 4.0, 15.0),
    Pack(8, 30.0, 8.0, (4.0, 12.0), 4.0, 15.0),
    Pack(8, 60.0, 15.0, (4.0, 12.0), 4.0, 15.0),
    Pack(5, 20.0, 5.0, (8.0, 8.0), 3.0, 15.0),
    Pack(5, 20.0, 1.2, (20.0, 40.0), 3.0, 40.0),
    Pack(5, 50.0, 15.0, (10.0, 10.0), 3.0, 20.0),
)
TOLD = (None, 1.0, 0.5)


def reports_of(pack: Pack, rng: np.random.Generator) -> pl.DataFrame:
    """Return reports of objects one behind the other, each in its own rhythm and never alike."""
    rows, end = [], 60.0 * pack.minutes
    for each in range(pack.count):
        own = rng.uniform(*pack.every)
        moments = np.arange(rng.uniform(0.0, own), end, own)
        moments = moments + rng.normal(0.0, 0.02 * own, moments.size)
        way = pack.speed * moments - pack.apart * each
        place = np.column_stack([way, 40.0 * np.sin(way / 300.0)])
        place += rng.normal(0.0, pack.sigma, place.shape)
        rows += [(now, *at, str(each)) for now, at in zip(moments, place, strict=True)]
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row").sort("time")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rows = []
    for each in PACKS:
        reports = reports_of(each, np.random.default_rng(options.seed))
        for times in TOLD:
            sigma = None if times is None else times * each.sigma
            told = {} if sigma is None else {"sensors": {"default": {"sigma": sigma}}}
            before = time.process_time()
            result = track(reports.drop("target"), told)
            spent = time.process_time() - before
            number = result.reports["track"].fill_null(-1).to_numpy()
            found = assignment_quality(reports["target"].to_list(), number)
            how = f"{each.every[0]:g} to {each.every[1]:g}", f"{each.sigma:g}"
            said = "nothing" if sigma is None else f"{sigma:g}"
            n_tracks = f"{np.unique(number[number >= 0]).size}"
            rows.append([f"{each.count}", f"{each.apart:g}", f"{each.speed:g}", *how, said,
                         f"{found.idf1:.3f}", n_tracks, f"{spent:.0f}"])  # fmt: skip
    print(heading(command("packs.py")))
    print()
    print(table(HEAD, rows))


if __name__ == "__main__":
    main()
