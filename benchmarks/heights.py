"""Skies of turning radars (places and periods told) whose reports tell no heights.

Heights told, found from the ranges of several radars, and taken for none.
"""

import argparse
import time
from typing import Any
from unittest.mock import patch

import numpy as np
import polars as pl
from bench_data import add_arguments, repeats
from eight_scenes import made
from never_worse import _radars
from text_tables import command, heading, table

from trackweave import ReportTable, track
from trackweave.config import Configuration
from trackweave.metrics import assignment_quality
from trackweave.run import heights

HEAD = ["aircraft/radars", "seed", "heights", "of reports", "IDF1", "switches", "tracks", "CPU s"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add_arguments(parser)
    parser.set_defaults(first=71)
    parser.add_argument("--aircraft", type=int, default=60)
    parser.add_argument("--radars", type=int, default=3)
    arguments = parser.parse_args()
    lines = []
    size = f"{arguments.aircraft}/{arguments.radars}"
    for seed in repeats(arguments):
        given = ["--aircraft", arguments.aircraft, "--radars", arguments.radars, "--seed", seed]
        name = f"sky-{size.replace('/', '-')}-{seed}"
        folder = made(arguments.bench, "gen_sky.py", name, [str(each) for each in given])
        reports = pl.read_csv(folder / "reports.csv", schema_overrides={"target": pl.String})
        told = _radars(folder, whole=False)
        for way in ("told", "found", "none"):
            lines.append([size, seed, way, *_row(reports, told, way)])
            print(*lines[-1], sep="  ", flush=True)
    print(heading(command("heights.py")), end="\n\n")
    print(table(HEAD, lines))


def _row(reports: pl.DataFrame, told: dict[str, Any], way: str) -> list[str]:
    """Return how many reports have heights, and how well they are tracked."""
    given = reports.drop("target") if way == "told" else reports.drop("target", "height_m")
    find = heights.found_heights

    def looked_for(table: ReportTable, configuration: Configuration, *, looks: bool) -> Any:
        return find(table, configuration, looks=looks and way != "none")

    begun = time.process_time()
    with patch.object(heights, "found_heights", looked_for):
        result = track(given, told, rng=0)
    spent = time.process_time() - begun
    number = result.assignments["track"].fill_null(-1).to_numpy()
    quality = assignment_quality(reports["target"].to_list(), number)
    n_heights = {"told": int(reports["height_m"].is_not_null().sum()), "none": 0}
    found = (result.run["heights"] or {}).get("reports", 0)
    return [
        f"{n_heights.get(way, found)} of {len(reports)}",
        f"{quality.idf1:.3f}",
        str(quality.switches),
        str(np.unique(number[number >= 0]).size),
        f"{spent:.0f}",
    ]


if __name__ == "__main__":
    main()
