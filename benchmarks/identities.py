"""Reports that say whose they are: identities hidden, right, and one in twenty another's.

IDF1 of the reports against who sent them, switches, tracks and how many senders there are.
"""

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from bench_data import BESIDE, add_arguments
from eight_scenes import made
from invented_scenes import collars
from never_worse import _radars
from text_tables import command, heading, table

from trackweave import track
from trackweave.metrics import assignment_quality

WRONG = 0.05
HEAD = ["recording", "identities", "IDF1", "switches", "tracks", "senders", "identity_error"]


def recordings(bench: Path) -> Iterator[tuple[str, pl.DataFrame, Mapping[str, Any]]]:
    """Yield reports with a ``target``, and what is told."""
    for seed in (1, 2, 3):
        herd = collars(np.random.default_rng(seed)).drop("identity")
        yield f"25 collars of a herd, seed {seed}", herd, {}
    for seed in (11, 12, 13):
        options = ["--ships", "80", "--seed", str(seed)]
        folder = made(bench, "gen_ais.py", f"ships-80-{seed}", options)
        yield f"80 ships, seed {seed}", _read(folder / "reports.csv"), {}
    sky = pl.read_csv(BESIDE / "data" / "opensky" / "OpenSky_Plane_States.csv")
    yield "OpenSky", sky.select("time", "lat", "lon", target="icao24"), {}
    options = ["--aircraft", "150", "--radars", "4", "--seed", "61"]
    folder = made(bench, "gen_sky.py", "sky-150-4-61", options)
    yield "sky 150/4, seed 61", _read(folder / "reports.csv"), _radars(folder, whole=False)


def named(reports: pl.DataFrame, wrong: float, rng: np.random.Generator) -> pl.DataFrame:
    """Return reports with their identities, a share of which are exchanged."""
    names = reports["target"].fill_null("").to_numpy().astype(object)
    is_wrong = rng.random(names.size) < wrong
    names[is_wrong] = rng.permutation(names[is_wrong])
    identity = pl.Series([name or None for name in names], dtype=pl.String)
    return reports.drop("target").with_columns(identity=identity)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser)
    parser.add_argument("--only", nargs="+", default=[""], help="whose name holds one of these")
    arguments = parser.parse_args()
    lines = []
    for name, reports, told in recordings(arguments.bench):
        if not any(part in name for part in arguments.only):
            continue
        whose = reports["target"].fill_null("").to_list()
        for how, seen in (
            ("hidden", reports.drop("target")),
            ("right", named(reports, 0.0, np.random.default_rng(0))),
            ("5 % wrong", named(reports, WRONG, np.random.default_rng(0))),
        ):
            result = track(seen, told)
            found = result.assignments["track"].fill_null(-1).to_numpy()
            scored = assignment_quality(whose, found)
            errors = [
                sensor["identity_error"]
                for sensor in result.run["configuration"]["sensors"].values()
            ]
            lines.append([
                name, how, f"{scored.idf1:.4f}", scored.switches,
                np.unique(found[found >= 0]).size, len({*whose} - {""}),
                "" if how == "hidden" else f"{max(errors):.2g}",
            ])  # fmt: skip
            print(*lines[-1], sep="  ", flush=True)
    print(heading(command("identities.py")), end="\n\n")
    print(table(HEAD, lines))


def _read(path: Path) -> pl.DataFrame:
    return pl.read_csv(path, schema_overrides={"target": pl.String})


if __name__ == "__main__":
    main()
