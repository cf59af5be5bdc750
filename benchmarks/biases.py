"""Skies in which two radars are biased: what is found of it, and whether aircraft keep names.

Each scene is tracked as it is, with the biases, and with the biases but nothing looked for. With
``--places`` one radar stands elsewhere than told instead, by as much in each of three ways.
"""

import argparse
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from bench_data import add_arguments, repeats
from eight_scenes import made
from names_kept import HIDDEN, names_of
from never_worse import _radars
from text_tables import command, heading, table

from trackweave import track
from trackweave.config import load_configuration
from trackweave.run.registering import registration_of
from trackweave.run.tracking import report_table

BIASED = ("radar0", "radar1")
RANGE_M, AZIMUTH_DEG, CLOCK_S = 100.0, 0.3, 0.5
TRUE = {"range_bias_m": RANGE_M, "azimuth_bias_deg": AZIMUTH_DEG, "clock_offset": CLOCK_S}
# By how much the place that is told of a radar is wrong, east and north [m].
PLACES = ((150.0, -80.0), (-1200.0, 900.0), (3000.0, 2500.0))
KEPT = {"range_bias_m": 0.0, "range_scale": 1.0, "azimuth_bias_deg": 0.0, "clock_offset": 0.0}


def with_biases(reports: pl.DataFrame, sensors: Sequence[str] = BIASED) -> pl.DataFrame:
    """Return reports of which some sensors' are biased."""
    off = pl.col("sensor").is_in(sensors).cast(pl.Float64)
    return reports.with_columns(
        time=pl.col("time") + CLOCK_S * off,
        range_m=pl.col("range_m") + RANGE_M * off,
        azimuth_deg=(pl.col("azimuth_deg") + AZIMUTH_DEG * off) % 360.0,
    ).sort("time")


def kept(told: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is told with the word that there are no biases."""
    sensors = {
        name: {**own, **KEPT, "trust": [*KEPT, "position"]}
        for name, own in told["sensors"].items()
    }
    return {**told, "sensors": sensors}


def tracked(reports: pl.DataFrame, told: Mapping[str, Any]) -> tuple[list[str], dict[str, Any]]:
    """Return IDF1, switches and CPU time in words, and what the run says of biases."""
    begun = time.process_time()
    result = track(reports.drop(HIDDEN, strict=False), told, rng=np.random.default_rng(0))
    spent = time.process_time() - begun
    quality, switches, _ = names_of(result, reports)
    return [f"{quality:.3f}", str(switches), f"{spent:.0f}"], result.run["registration"] or {}


def found_in(reports: pl.DataFrame, told: Mapping[str, Any]) -> tuple[dict[str, Any], float]:
    """Return what is found of biases alone, and the CPU time [s]."""
    configuration = load_configuration(told)
    rows, _ = report_table(reports.drop(HIDDEN, strict=False), configuration)
    begun = time.process_time()
    found = registration_of(rows, configuration).as_record() or {}
    return found, time.process_time() - begun


def worst(found: Mapping[str, Any]) -> list[str]:
    """Return how far each number of the biased is off at most, and what else is taken out."""
    sensors = found.get("sensors", {})
    off = {
        key: max(abs(sensors[name][key]["used"] / true - 1.0) for name in BIASED)
        for key, true in TRUE.items()
    }
    besides = sum(
        sensors[name][key]["used"] != KEPT[key]
        for name in sensors
        for key in KEPT
        if name not in BIASED or key == "range_scale"
    )
    return [*(f"{100 * share:.1f}" for share in off.values()), str(besides)]


def untrue(found: Mapping[str, Any]) -> int:
    """Return how many biases are taken out where there are none."""
    sensors = found.get("sensors", {})
    return sum(own[key]["used"] != KEPT[key] for own in sensors.values() for key in KEPT)


def errors(found: Mapping[str, Any], *, biased: bool) -> list[float]:
    """Return how many of its standard deviations each number that is told is off."""
    numbers = []
    for name, own in found.get("sensors", {}).items():
        for key, usual in KEPT.items():
            true = TRUE.get(key, usual) if biased and name in BIASED else usual
            if own[key]["sigma"] is not None:
                numbers.append((own[key]["learned"] - true) / own[key]["sigma"])
    return numbers


def displaced(told: Mapping[str, Any], shift: tuple[float, float]) -> dict[str, Any]:
    """Return what is told with the first radar told to stand elsewhere."""
    own = told["sensors"][BIASED[0]]
    place = [*np.add(own["position"][:2], shift).tolist(), *own["position"][2:]]
    sensors = {**told["sensors"], BIASED[0]: {**own, "position": place}}
    return {**told, "sensors": sensors}


def places(arguments: argparse.Namespace) -> None:
    """Print how well places are found that are told wrongly, and what that is worth."""
    lines = []
    for seed in repeats(arguments):
        reports, told = _scene(arguments.bench, arguments.aircraft, arguments.radars, seed)
        true = told["sensors"][BIASED[0]]["position"]
        for shift in PLACES:
            wrong = displaced(told, shift)
            mended, said = tracked(reports, wrong)
            left, _ = tracked(reports, kept(wrong))
            at = said["sensors"][BIASED[0]]["position"]["used"]
            off = float(np.hypot(*np.subtract(at[:2], true[:2])))
            besides = untrue(said)
            lines.append([seed, f"{np.hypot(*shift):.0f}", f"{off:.1f}", besides, *mended, *left])
            print(*lines[-1], sep="  ", flush=True)
    head = ["seed", "m wrong", "m off when found", "biases besides"]
    head += [
        f"{run}{what}"
        for run in ("", "nothing looked for: ")
        for what in ("IDF1", "switches", "CPU s")
    ]
    print(heading(command("biases.py")), end="\n\n")
    print(table(head, lines))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser)
    parser.set_defaults(first=21)
    parser.add_argument("--aircraft", type=int, default=150)
    parser.add_argument("--radars", type=int, default=4)
    parser.add_argument("--only", action="store_true", help="find biases, and track nothing")
    parser.add_argument("--places", action="store_true", help="a wrong place in place of biases")
    arguments = parser.parse_args()
    if arguments.places:
        places(arguments)
        return
    lines, sigmas = [], dict[bool, list[float]]({False: [], True: []})
    for seed in repeats(arguments):
        reports, told = _scene(arguments.bench, arguments.aircraft, arguments.radars, seed)
        biased = with_biases(reports)
        if arguments.only:
            (right, spent), (wrong, more) = found_in(reports, told), found_in(biased, told)
            lines.append([seed, untrue(right), *worst(wrong), f"{spent:.1f}", f"{more:.1f}"])
        else:
            plain, right = tracked(reports, told)
            mended, wrong = tracked(biased, told)
            left, _ = tracked(biased, kept(told))
            lines.append([seed, untrue(right), *worst(wrong), *plain, *mended, *left])
        for is_biased, found in ((False, right), (True, wrong)):
            sigmas[is_biased] += errors(found, biased=is_biased)
        print(*lines[-1], sep="  ", flush=True)
    print(heading(command("biases.py")), end="\n\n")
    print(table(_head(only=arguments.only), lines), end="\n\n")
    for is_biased, numbers in sigmas.items():
        scene = "with biases" if is_biased else "without"
        spread = float(np.sqrt(np.mean(np.square(numbers))))
        print(f"{scene}: errors ÷ σ, root mean square {spread:.2f}, {len(numbers)} numbers")


def _head(*, only: bool) -> list[str]:
    head = ["seed", "taken out where none", "range % off", "azimuth % off", "clock % off"]
    head.append("besides")
    if only:
        return [*head, "CPU s without", "CPU s with"]
    runs = ("without biases", "with", "with, nothing looked for")
    return [*head, *(f"{run}: {what}" for run in runs for what in ("IDF1", "switches", "CPU s"))]


def _scene(
    bench: Path, aircraft: int, radars: int, seed: int
) -> tuple[pl.DataFrame, Mapping[str, Any]]:
    given = ["--aircraft", aircraft, "--radars", radars, "--seed", seed]
    name = f"sky-{aircraft}-{radars}-{seed}"
    folder = made(bench, "gen_sky.py", name, [str(each) for each in given])
    reports = pl.read_csv(folder / "reports.csv", schema_overrides={"target": pl.String})
    return reports, _radars(folder, whole=False)


if __name__ == "__main__":
    main()
