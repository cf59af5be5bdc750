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
from joins_airport import PERIOD, airport
from names_kept import HIDDEN, names_of
from never_worse import _radars
from text_tables import command, heading, table

from trackweave import track

HEAD = ["recording", "joins", "right", "parted", "right"]
HEAD += ["IDF1 without", "with", "switches without", "with"]
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
    told = {"sensors": {"default": {"position": [0.0, 0.0], "scan_period": PERIOD}}}
    for seed in range(1, 7):
        landing = airport(np.random.default_rng(seed))
        yield f"airport, seed {seed}", landing, told
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
    idf1, switches, found = names_of(result, reports)
    return result.run, found, idf1, switches


def judged(
    run: Mapping[str, Any], found: np.ndarray, reports: pl.DataFrame
) -> tuple[int, int, int, int]:
    """Return how many joins there are and how many of them are right, and of parted tracks."""
    when, true = reports["time"].to_numpy(), np.array(reports["target"].fill_null("").to_list())
    told = run["joins"] or {"list": [], "parted": []}

    def whose(own: np.ndarray) -> str:
        counts = Counter(true[own].tolist()).most_common(1)
        return str(counts[0][0]) if counts else ""

    joined = [
        (whose(own & (when < join["time"])), whose(own & (when >= join["time"])))
        for join in told["list"]
        for own in [found == join["into"]]
    ]
    parted = [
        (whose((found == each["track"]) & (when < each["time"])), whose(found == each["into"]))
        for each in told["parted"]
    ]
    return (
        len(joined), sum(bool(early) and early == late for early, late in joined),
        len(parted), sum(early != late for early, late in parted),
    )  # fmt: skip


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
        counts = judged(run, found, reports)
        lines.append([name, *counts, f"{before:.4f}", f"{after:.4f}", switched, switches])
        print(*lines[-1], f"{time.process_time() - begun:.0f} s", sep="  ", flush=True)
    print(heading(command("joins.py")), end="\n\n")
    print(table(HEAD, lines))


if __name__ == "__main__":
    main()
