"""The small scenes of gen_cases.py with what an engineer tells, and one key of it told wrongly.

    python benchmarks/told_wrongly.py SCENES … [--only short_reach side_by_side]

SCENES are folders that ``gen_cases.py OUT --seed N`` made; the table shows means over them.
"""

import argparse
import copy
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from text_tables import command, heading, table

from trackweave import track
from trackweave.metrics import assignment_quality

Told = dict[str, Any]
LOSS = 0.03


def _told(
    sigma: Any, detection: float, false: float, process: float, speed: float, **more: Any
) -> Told:
    sensor = {
        "sigma": sigma,
        "detection_probability": detection,
        "clutter_density": false,
        **more,
    }
    return {
        "motion": {"process_noise": process, "max_speed": speed},
        "sensors": {"default": sensor},
    }


def _radars() -> Told:
    told = _told({"range_m": 50.0, "azimuth_deg": 0.06}, 0.97, 1e-8, 0.1, 300.0, scan_period=4.0)
    sites = ((60e3, 60e3), (140e3, 70e3), (100e3, 140e3))
    told["sensors"] |= {f"r{number}": {"position": list(at)} for number, at in enumerate(sites)}
    return told


# What the generator's text says of each scene. Clutter per m² (per m·rad of ranges and azimuths)
# is a guess of one false alarm in a hundred scans where a scene has none.
ENGINEER: dict[str, Told] = {
    "side_by_side": _told(
        {"range_m": 6.0, "azimuth_deg": 0.03}, 0.9, 1e-8, 1.0, 350.0, scan_period=4.0
    ),
    "shared_stamps": _told(5.0, 0.9, 1e-10, 0.01, 10.0),
    "whole_seconds": _told(6.0, 0.9, 1e-10, 0.01, 15.0),
    "drifting_turn": _told(4.0, 0.92, 2.0 / 3.6e7, 0.1, 25.0, scan_period=1.0),
    "interleaved": _told(2.0, 0.7, 1e-8, 0.1, 20.0),
    "fast_minority": _told(0.3, 0.9, 1e-7, 0.01, 40.0, scan_period=0.1),
    "short_reach": _radars(),
    "silent_minute": _told(40.0, 0.97, 1e-12, 0.1, 300.0, scan_period=4.0),
}


def _scaled(value: Any, factor: float) -> Any:
    if isinstance(value, dict):
        return {key: factor * number for key, number in value.items()}
    return factor * value


def _sensor(key: str, change: Callable[[Any], Any]) -> Callable[[Told], None]:
    def applied(told: Told) -> None:
        told["sensors"]["default"][key] = change(told["sensors"]["default"][key])

    return applied


def _motion(key: str, factor: float) -> Callable[[Told], None]:
    def applied(told: Told) -> None:
        told["motion"][key] *= factor

    return applied


WRONG: dict[str, Callable[[Told], None]] = {
    "σ × 2": _sensor("sigma", lambda value: _scaled(value, 2.0)),
    "σ ÷ 2": _sensor("sigma", lambda value: _scaled(value, 0.5)),
    "1 − P_D × 2": _sensor("detection_probability", lambda value: 1 - 2 * (1 - value)),
    "1 − P_D ÷ 2": _sensor("detection_probability", lambda value: 1 - (1 - value) / 2),
    "clutter × 2": _sensor("clutter_density", lambda value: 2 * value),
    "clutter ÷ 2": _sensor("clutter_density", lambda value: value / 2),
    "process × 4": _motion("process_noise", 4.0),
    "process ÷ 4": _motion("process_noise", 0.25),
    "max_speed × 2": _motion("max_speed", 2.0),
}


def identified(folder: Path, told: Told | None) -> float:
    """Return IDF1 of a scene's reports, its identities hidden."""
    reports = pl.read_csv(folder / "reports.csv", schema_overrides={"target": pl.String})
    result = track(reports.drop("target"), told, rng=np.random.default_rng(0))
    found = result.assignments["track"].fill_null(-1).to_numpy()
    return assignment_quality(reports["target"].fill_null("").to_list(), found).idf1 or 0.0


def rows(folders: list[Path], scene: str) -> Iterator[float]:
    """Yield the means: nothing told, told well, and each key told wrongly."""
    ways: list[Told | None] = [None, ENGINEER[scene]]
    for spoil in WRONG.values():
        told = copy.deepcopy(ENGINEER[scene])
        spoil(told)
        ways.append(told)
    # Nobody can know where radars stand but who put them there.
    if scene == "short_reach":
        sites = {n: s for n, s in ENGINEER[scene]["sensors"].items() if n != "default"}
        ways[0] = {"sensors": sites}
    for told in ways:
        yield float(np.mean([identified(folder / scene, told) for folder in folders]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", type=Path, nargs="+")
    parser.add_argument("--only", nargs="+", choices=list(ENGINEER), default=list(ENGINEER))
    arguments = parser.parse_args()
    print(heading(command("told_wrongly.py")))
    lines = []
    for scene in arguments.only:
        nothing, well, *wrong = rows(arguments.scenes, scene)
        shown = [f"{value:.3f}" + ("!" if value < well - LOSS else "") for value in wrong]
        lines.append([f"`{scene}`", f"{nothing:.3f}", f"{well:.3f}", *shown])
    print(table(["scene", "nothing told", "told well", *WRONG], lines))
    print(f"\n! more than {LOSS} below what is told well")


if __name__ == "__main__":
    main()
