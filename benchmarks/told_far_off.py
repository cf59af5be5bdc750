"""Scenes with all told as an engineer would, and one key of it far off at a time.

    python benchmarks/told_far_off.py --first 1301 --seeds 2

Twenty boats on a square that a sensor of positions sees among false alarms, seven times in ten;
and twenty aircraft that turn now and then before two turning radars. IDF1 of the reports.
"""

import argparse
import copy
from collections.abc import Iterator
from typing import Any

import numpy as np
import polars as pl
from text_tables import command, heading, table

from trackweave import track
from trackweave.metrics import assignment_quality

Told = dict[str, Any]
SIDE, BOATS, FALSE = 2500.0, 20, 12
RADARS = {
    "A": ((0.0, 0.0), 4.0, 60e3, (40.0, 0.07), 0.9, 8),
    "B": ((22e3, -14e3), 10.0, 90e3, (120.0, 0.2), 0.8, 15),
}
"""Place [m], turn [s], reach [m], noise [m, degrees], detection, false alarms a turn."""


def ways(rng: np.random.Generator, count: int, told: tuple[float, ...]) -> np.ndarray:
    """Return where objects are each second, shape (objects, seconds, 2)."""
    seconds, side, slow, fast, sharp = told
    found = np.empty((count, int(seconds), 2))
    for way in found:
        place, heading = rng.uniform(-side / 2, side / 2, 2), rng.uniform(0, 2 * np.pi)
        speed, rate, wait = rng.uniform(slow, fast), 0.0, 0.0
        for second in range(len(way)):
            if wait <= 0.0:
                rate = (
                    0.0 if rate else np.radians(rng.choice([-1, 1]) * rng.uniform(0.5, 1) * sharp)
                )
                wait = rng.uniform(20, 60) if rate else rng.uniform(40, 160)
            wait, heading = wait - 1.0, heading + rate
            place = place + speed * np.array([np.sin(heading), np.cos(heading)])
            way[second] = place
    return found


def boats(seed: int) -> tuple[pl.DataFrame, Told]:
    """Return what a sensor of positions reports of boats and of nobody; and what is told."""
    rng = np.random.default_rng(seed)
    rows = []
    there = ways(rng, BOATS, (420, SIDE, 2.0, 12.0, 3.0)) + SIDE / 2
    for time in range(0, 420, 3):
        for one in np.flatnonzero(rng.random(BOATS) < 0.7):
            x, y = there[one, time] + rng.normal(0, 8, 2)
            if 0 < x < SIDE and 0 < y < SIDE:
                rows.append((float(time), x, y, f"b{one}"))
        rows += [(float(time), x, y, "") for x, y in rng.uniform(0, SIDE, (rng.poisson(FALSE), 2))]
    sensor = {
        "sigma": 8.0, "detection_probability": 0.7, "clutter_per_scan": FALSE,
        "scan_period": 3.0, "field_of_view": square(0.0),
    }  # fmt: skip
    motion = {"process_noise": 1.0, "max_speed": 14.0}
    reports = pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row")
    return reports, {"motion": motion, "sensors": {"default": sensor}}


def square(edge: float) -> dict[str, Any]:
    """Return the square without an edge [m]."""
    low, high = edge, SIDE - edge
    return {"polygon": [[low, low], [high, low], [high, high], [low, high]]}


def radars(seed: int) -> tuple[pl.DataFrame, Told]:
    """Return what two turning radars report of aircraft and of nobody; and what is told."""
    rng = np.random.default_rng(seed)
    rows, sensors = [], {}
    there = ways(rng, BOATS, (500, 1e5, 110.0, 230.0, 3.0))
    for name, (place, turn, reach, noise, detection, n_false) in RADARS.items():
        sensors[name] = {
            "sigma": {"range_m": noise[0], "azimuth_deg": noise[1]}, "clutter_per_scan": n_false,
            "detection_probability": detection, "scan_period": turn, "rotation": "clockwise",
            "position": list(place), "field_of_view": {"max_range_m": reach},
        }  # fmt: skip
        for begin in np.arange(0.0, 490.0 - turn, turn):
            seen = [(f"a{one}", *_met(there[one] - place, begin, turn)) for one in range(BOATS)]
            far, around = reach * np.sqrt(rng.random(n_false)), rng.uniform(0, 360, n_false)
            false = zip(far, around, strict=True)
            seen += [("", begin + turn * azimuth / 360, away, azimuth) for away, azimuth in false]
            for target, time, away, azimuth in seen:
                if away < reach and (not target or rng.random() < detection):
                    off = rng.normal(0, noise[0]), rng.normal(0, noise[1])
                    told = away + off[0], (azimuth + off[1]) % 360
                    rows.append((round(time, 3), name, *told, target))
    names = ["time", "sensor", "range_m", "azimuth_deg", "target"]
    reports = pl.DataFrame(sorted(rows), names, orient="row")
    return reports, {"motion": {"process_noise": 20.0, "max_speed": 260.0}, "sensors": sensors}


def _met(way: np.ndarray, begin: float, turn: float) -> tuple[float, float, float]:
    """Return when a beam that is at north at a time meets an object, how far off and where."""
    time = begin
    for _ in range(4):
        east, north = (np.interp(time, np.arange(len(way)), axis) for axis in way.T)
        azimuth = float(np.degrees(np.arctan2(east, north))) % 360
        time = begin + turn * azimuth / 360
    return time, float(np.hypot(east, north)), azimuth


def scaled(told: Told, key: str, factor: float) -> None:
    """Tell so many times as much of something."""
    owners = [told["motion"]] if key in told["motion"] else told["sensors"].values()
    for owner in owners:
        owner[key] *= factor


def far_off(told: Told) -> Iterator[tuple[str, Told]]:
    """Yield what is told wrongly, by a name each."""
    for name, key, factor in (
        ("max_speed ÷ 3", "max_speed", 1 / 3),
        ("process noise ÷ 100", "process_noise", 0.01),
        ("clutter ÷ 10", "clutter_per_scan", 0.1),
        ("clutter × 10", "clutter_per_scan", 10),
    ):
        wrong = copy.deepcopy(told)
        scaled(wrong, key, factor)
        yield name, wrong
    wrong = copy.deepcopy(told)
    for sensor in wrong["sensors"].values():
        sensor["detection_probability"] = 0.98
    yield "P_D = 0.98", wrong
    wrong = copy.deepcopy(told)
    for sensor in wrong["sensors"].values():
        view = sensor["field_of_view"]
        narrow = "polygon" not in view
        sensor["field_of_view"] = (
            {"max_range_m": 0.6 * view["max_range_m"]} if narrow else square(400.0)
        )
    yield "field of view too small", wrong


def quality(reports: pl.DataFrame, told: Told) -> float:
    """Return the IDF1 of a run's reports."""
    found = track(reports.drop("target"), told, rng=1).reports
    tracks = found["track"].cast(pl.String).fill_null("")
    return assignment_quality(reports["target"].to_list(), tracks.to_list()).idf1


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--first", type=int, default=1301)
    parser.add_argument("--seeds", type=int, default=2)
    arguments = parser.parse_args()
    rows: dict[str, list[Any]] = {}
    columns = [""]
    for scene in (boats, radars):
        for seed in range(arguments.first, arguments.first + arguments.seeds):
            reports, told = scene(seed)
            sensors = told["sensors"]
            places = {
                name: {"position": sensors[name]["position"]} for name in RADARS if name in sensors
            }
            columns.append(f"{scene.__name__}, {seed}")
            for name, config in (
                ("all told rightly", told),
                ("nothing told but places", {"sensors": places} if places else {}),
                *far_off(told),
            ):
                rows.setdefault(name, [name]).append(f"{quality(reports, config):.3f}")
    print(heading(command("told_far_off.py")), end="\n\n")
    print(table(columns, list(rows.values())))


if __name__ == "__main__":
    main()
