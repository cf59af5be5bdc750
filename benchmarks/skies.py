"""Skies of turning radars with all that real ones have, of which places and periods are told."""

import argparse
import time

import numpy as np
import polars as pl
from bench_data import add_arguments, repeats
from eight_scenes import made
from never_worse import _radars
from text_tables import command, heading, table

from trackweave import track
from trackweave.metrics import assignment_quality

SIZES = ((150, 4), (300, 6))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser)
    parser.set_defaults(first=11)
    parser.add_argument("--sizes", nargs="+", type=int, default=[0, 1], help="150/4, 300/6")
    parser.add_argument("--whole", action="store_true", help="tell sigma of each radar as well")
    arguments = parser.parse_args()
    lines = []
    for aircraft, radars in (SIZES[size] for size in arguments.sizes):
        for seed in repeats(arguments):
            given = ["--aircraft", aircraft, "--radars", radars, "--seed", seed]
            name = f"sky-{aircraft}-{radars}-{seed}"
            folder = made(arguments.bench, "gen_sky.py", name, [str(each) for each in given])
            reports = pl.read_csv(folder / "reports.csv", schema_overrides={"target": pl.String})
            lines.append(
                [
                    f"{aircraft}/{radars}",
                    seed,
                    *_judged(reports, _radars(folder, whole=arguments.whole)),
                ]
            )
            print(*lines[-1], sep="  ", flush=True)
    print(heading(command("skies.py")), end="\n\n")
    head = [
        "aircraft/radars",
        "seed",
        "IDF1",
        "switches",
        "false reports in tracks",
        "on no track",
    ]
    print(table([*head, "CPU s"], lines))


def _judged(reports: pl.DataFrame, told: dict) -> list[str]:
    begun = time.process_time()
    result = track(reports.drop("target"), told, rng=np.random.default_rng(0))
    spent = time.process_time() - begun
    true = reports["target"].fill_null("").to_list()
    found = result.assignments["track"].fill_null(-1).to_numpy()
    is_false = np.array([whose == "" for whose in true])
    last: dict[str, int] = {}
    switches = 0
    for whose, number in zip(true, found.tolist(), strict=True):
        if whose and number >= 0:
            switches += last.get(whose, number) != number
            last[whose] = number
    return [
        f"{assignment_quality(true, found).idf1 or 0.0:.3f}",
        str(switches),
        f"{int((is_false & (found >= 0)).sum())} of {int(is_false.sum())}",
        f"{int((~is_false & (found < 0)).sum())} of {int((~is_false).sum())}",
        f"{spent:.0f}",
    ]


if __name__ == "__main__":
    main()
