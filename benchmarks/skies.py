"""Skies of turning radars with all that real ones have, of which places and periods are told."""

import argparse
from pathlib import Path
from typing import Any

import polars as pl
from bench_data import add_arguments, repeats
from eight_scenes import made
from names_kept import HEAD, judged
from never_worse import _radars
from text_tables import command, heading, table

SIZES = ((150, 4), (300, 6))
EFFECTS = ("coverage", "blind", "cone", "tails", "turns", "ground", "spots", "pd")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser)
    parser.set_defaults(first=11)
    parser.add_argument("--sizes", nargs="+", type=int, default=[0, 1], help="150/4, 300/6")
    parser.add_argument("--whole", action="store_true", help="tell sigma of each radar as well")
    parser.add_argument(
        "--engineer", action="store_true", help="tell sigma, reach, P_D = 0.9 and process noise 5"
    )
    parser.add_argument(
        "--only", choices=[*EFFECTS, "nothing"], help="skies with a single effect, or without any"
    )
    parser.add_argument(
        "--as-positions",
        action="store_true",
        help="plots as x and y on the plane, of which nothing is told",
    )
    arguments = parser.parse_args()
    lines = []
    for aircraft, radars in (SIZES[size] for size in arguments.sizes):
        for seed in repeats(arguments):
            given = ["--aircraft", aircraft, "--radars", radars, "--seed", seed]
            name = f"sky-{aircraft}-{radars}-{seed}"
            if arguments.only:
                left_out = ",".join(each for each in EFFECTS if each != arguments.only)
                given += ["--without", left_out]
                name += f"-only-{arguments.only}"
            folder = made(arguments.bench, "gen_sky.py", name, [str(each) for each in given])
            reports = pl.read_csv(folder / "reports.csv", schema_overrides={"target": pl.String})
            told = _told(folder, arguments)
            if arguments.as_positions:
                reports, told = _on_plane(reports, told), {}
            lines.append([f"{aircraft}/{radars}", seed, *judged(reports, told)])
            print(*lines[-1], sep="  ", flush=True)
    print(heading(command("skies.py")), end="\n\n")
    print(table(["aircraft/radars", "seed", *HEAD], lines))


def _told(folder: Path, arguments: argparse.Namespace) -> dict[str, Any]:
    told: dict[str, Any] = dict(_radars(folder, whole=arguments.whole or arguments.engineer))
    if not arguments.engineer:
        return told
    for radar in pl.read_csv(folder / "radars.csv").iter_rows(named=True):
        reach = {"max_range_m": float(radar["reach_m"])}
        told["sensors"][radar["sensor"]] |= {"detection_probability": 0.9, "field_of_view": reach}
    return {**told, "motion": {"process_noise": 5.0}}


def _on_plane(reports: pl.DataFrame, told: dict[str, Any]) -> pl.DataFrame:
    """Return plots as the positions that a radar with heights makes of them."""
    east, north = (
        pl.col("sensor").replace_strict(
            {name: said["position"][axis] for name, said in told["sensors"].items()}
        )
        for axis in (0, 1)
    )
    azimuth, height = pl.col("azimuth_deg").radians(), pl.col("height_m").fill_null(0.0)
    ground = (pl.col("range_m") ** 2 - height**2).clip(0.0).sqrt()
    return reports.select(
        "time",
        "sensor",
        "target",
        x=east + ground * azimuth.sin(),
        y=north + ground * azimuth.cos(),
    )


if __name__ == "__main__":
    main()
