"""Names through long silences: tracks joined once a run is over, beside the same run without.

A join is right where most reports of the name before the silence are of the object of most of
those after it.
"""

import argparse
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from bench_data import BESIDE, add_arguments
from eight_scenes import made
from names_kept import HIDDEN
from never_worse import _radars
from text_tables import command, heading, table

from trackweave import track
from trackweave.metrics import assignment_quality

HEAD = ["recording", "joins", "right", "IDF1 without", "with", "switches without", "with"]
Recording = tuple[str, pl.DataFrame, Mapping[str, Any]]


def recordings(bench: Path) -> Iterator[Recording]:
    """Yield reports with their truth, and what is told."""
    for ships, seeds in ((80, range(11, 16)), (300, (11, 21))):
        for seed in seeds:
            options = ["--ships", str(ships), "--seed", str(seed)]
            folder = made(bench, "gen_ais.py", f"ships-{ships}-{seed}", options)
            yield f"{ships} ships, seed {seed}", _read(folder / "reports.csv"), {}
    options = ["--aircraft", "150", "--radars", "4", "--seed", "16"]
    folder = made(bench, "gen_sky.py", "sky-150-4-16", options)
    yield "sky 150/4, seed 16", _read(folder / "reports.csv"), _radars(folder, whole=False)
    sky = pl.read_csv(BESIDE / "data" / "opensky" / "OpenSky_Plane_States.csv")
    yield "OpenSky", sky.select("time", "lat", "lon", target="icao24"), {}
    radar = pl.read_csv(BESIDE / "data" / "radar_bcn" / "radar_bcn_20_24h.csv")
    yield "radar_bcn, four hours", radar, {}


def _read(path: Path) -> pl.DataFrame:
    return pl.read_csv(path, schema_overrides={"target": pl.String})


def followed(reports: pl.DataFrame, told: Mapping[str, Any], *, join: bool) -> tuple[Any, ...]:
    """Return a run's record, the tracks found, IDF1, and switches."""
    lifecycle = {"lifecycle": {"join": join}}
    result = track(reports.drop(HIDDEN, strict=False), {**told, **lifecycle})
    found = result.assignments["track"].fill_null(-1).to_numpy()
    true = reports["target"].fill_null("").to_list()
    last: dict[str, int] = {}
    switches = 0
    for whose, number in zip(true, found.tolist(), strict=True):
        if whose and number >= 0:
            switches += last.get(whose, number) != number
            last[whose] = number
    return result.run, found, assignment_quality(true, found).idf1 or 0.0, switches


def right_ones(run: Mapping[str, Any], found: np.ndarray, reports: pl.DataFrame) -> int:
    """Return how many joins are right."""
    when, true = reports["time"].to_numpy(), np.array(reports["target"].fill_null("").to_list())
    count = 0
    for join in (run["joins"] or {"list": []})["list"]:
        own = found == join["into"]
        early = Counter(true[own & (when < join["time"])].tolist()).most_common(1)
        late = Counter(true[own & (when >= join["time"])].tolist()).most_common(1)
        count += bool(early and late and early[0][0] and early[0][0] == late[0][0])
    return count


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser)
    parser.add_argument("--only", nargs="+", default=[""], help="whose name holds one of these")
    arguments = parser.parse_args()
    lines = []
    for name, reports, told in recordings(arguments.bench):
        if not any(part in name for part in arguments.only):
            continue
        begun = time.process_time()
        _, _, before, switched = followed(reports, told, join=False)
        run, found, after, switches = followed(reports, told, join=True)
        n_joins = len(run["joins"]["list"]) if run["joins"] else 0
        right = right_ones(run, found, reports)
        lines.append(
            [name, n_joins, right, f"{before:.4f}", f"{after:.4f}", switched, switches]
        )  # fmt: skip
        print(*lines[-1], f"{time.process_time() - begun:.0f} s", sep="  ", flush=True)
    print(heading(command("joins.py")), end="\n\n")
    print(table(HEAD, lines))


if __name__ == "__main__":
    main()
