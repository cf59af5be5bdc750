"""The small scenes of gen_cases.py with what an engineer tells, and one key of it told wrongly.

Told is what the generator's text says of each scene; the table shows what each wrong key costs.
Of scenes that take long there are fewer seeds.
"""

import argparse
import copy
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from bench_data import BESIDE
from eight_scenes import SIGMA, followed, made
from text_tables import command, heading, table

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

SLOW = ("side_by_side", "drifting_turn", "short_reach")
SHIPS = 80


Spoil = Callable[[Told], None]


def losses(folders: Sequence[Path], well: Told, ways: Sequence[Spoil]) -> list[str]:
    """Return the mean IDF1 of what is told well, and what each wrong way loses, also at worst."""
    right = [followed(folder, well)[0] for folder in folders]
    cells = [f"{sum(right) / len(right):.3f}"]
    for spoil in ways:
        told = copy.deepcopy(well)
        spoil(told)
        lost = [
            best - followed(folder, told)[0] for folder, best in zip(folders, right, strict=True)
        ]
        mean = sum(lost) / len(lost)
        cell = f"{mean:.3f}" + (f" ({max(lost):.3f})" if len(lost) > 1 else "")
        cells.append(f"**{cell}**" if mean > LOSS else cell)
    return cells


def rows(arguments: argparse.Namespace) -> Iterator[list[str]]:
    """Yield a row for each scene, and one for the ships, of which sigma alone is told."""
    bench = arguments.bench
    for scene in arguments.only:
        seeds = arguments.slow_seeds if scene in SLOW else arguments.seeds
        folders = [made(bench, "gen_cases.py", f"s{s}", ["--seed", str(s)]) / scene for s in seeds]
        cells = losses(folders, ENGINEER[scene], list(WRONG.values()))
        yield [f"`{scene}`", str(len(seeds)), *cells]
    if arguments.ships == "yes":
        seed = str(arguments.slow_seeds[0])
        options = ["--ships", str(SHIPS), "--minutes", "60", "--seed", seed]
        folder = made(bench, "gen_ais.py", f"ais-{SHIPS}-{seed}", options)
        ways = [spoil for name, spoil in WRONG.items() if name.startswith("σ")]
        cells = losses([folder], SIGMA, ways)
        yield [f"{SHIPS} ships, σ told", "1", *cells, *["–"] * (len(WRONG) - len(ways))]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bench", type=Path, default=BESIDE / "bench")
    parser.add_argument("--seeds", type=int, nargs="+", default=[11, 12])
    parser.add_argument("--slow-seeds", type=int, nargs="+", default=[11])
    parser.add_argument("--only", nargs="*", choices=list(ENGINEER), default=list(ENGINEER))
    parser.add_argument("--ships", choices=["yes", "no"], default="yes")
    arguments = parser.parse_args()
    if not (arguments.bench / "gen_cases.py").exists():
        print(f"Skipped: {arguments.bench} is not there; name a folder with --bench")
        return
    print(heading(command("told_wrongly.py")), end="\n\n")
    print(table(["scene", "seeds", "IDF1 told well", *WRONG], list(rows(arguments))))
    print(f"\nMean losses of IDF1, and the worst of several seeds; bold: more than {LOSS}.")


if __name__ == "__main__":
    main()
