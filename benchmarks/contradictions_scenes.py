"""Scenes of a few radars in which something that is told, or sent, is wrong."""

import copy
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import polars as pl

from trackweave.simulation import Scenario, simulate
from trackweave.simulation.scenario import Area, RandomTargets, SimulatedSensor

PLACES = {"east": (2900.0, 200.0), "north": (1500.0, 1900.0), "west": (100.0, 300.0)}
WRONG = "north"


@dataclass
class Scene:
    """Reports with ``target``, and what is true of their sensors as a configuration tells it."""

    reports: pl.DataFrame
    told: dict[str, Any]
    truth: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Contradiction:
    """A way to spoil a scene, the words that name it, and whether anything has to be told."""

    spoil: Callable[[Scene], Scene]
    causes: tuple[str, ...]
    polar: bool = False
    told: bool = True


def scene(seed: int, *, polar: bool = False, n_sensors: int = 3) -> Scene:
    """Return a scene of its own for each seed."""
    rng = np.random.default_rng([seed, 77])
    truth = {
        "sigma": float(rng.uniform(6, 14)),
        "detection": float(rng.uniform(0.8, 0.95)),
        "clutter": float(rng.uniform(3, 9)),
        "period": float(rng.uniform(3, 6)),
        "process": float(rng.uniform(0.3, 1.0)),
    }
    names = list(PLACES)[-n_sensors:]
    sensors = tuple(
        SimulatedSensor(
            name=name,
            sigma=truth["sigma"],
            scan_period=truth["period"],
            detection_probability=truth["detection"],
            clutter_per_scan=truth["clutter"],
            start_offset=truth["period"] * turn / n_sensors,
            position=PLACES[name],
        )
        for turn, name in enumerate(names)
    )
    made = simulate(
        Scenario(
            area=Area((0.0, 0.0), (3000.0, 2000.0)),
            duration=28 * truth["period"],
            sensors=sensors,
            random=RandomTargets(int(rng.integers(8, 12)), (6.0, 18.0)),
            process_noise=truth["process"],
        ),
        rng,
    )
    table = pl.DataFrame(
        {
            "time": made.reports.time,
            "sensor": np.array(made.reports.sensors)[made.reports.sensor],
            "x": made.reports.measurement[:, 0],
            "y": made.reports.measurement[:, 1],
            "target": list(made.reports.carried["target"]),
        }
    )
    told: dict[str, Any] = {
        "motion": {"process_noise": truth["process"], "max_speed": 40.0},
        "sensors": {
            name: {
                "sigma": truth["sigma"],
                "detection_probability": truth["detection"],
                "clutter_per_scan": truth["clutter"],
                "scan_period": truth["period"],
                "position": list(PLACES[name]),
            }
            for name in names
        },
    }
    return as_polar(Scene(table, told, truth)) if polar else Scene(table, told, truth)


def as_polar(one: Scene) -> Scene:
    """Return a scene whose radars tell ranges and azimuths."""
    place = np.array([PLACES[name] for name in one.reports["sensor"]])
    off = one.reports.select("x", "y").to_numpy() - place
    table = one.reports.drop("x", "y").with_columns(
        range_m=np.hypot(*off.T), azimuth_deg=np.degrees(np.arctan2(*off.T)) % 360.0
    )
    told = copy.deepcopy(one.told)
    usual = float(np.median(table["range_m"].to_numpy()))
    for sensor in told["sensors"].values():
        sigma = sensor["sigma"]
        sensor["sigma"] = {"range_m": sigma, "azimuth_deg": float(np.degrees(sigma / usual))}
    return Scene(table, told, one.truth)


def sent(sensor: str | None, **columns: pl.Expr) -> Callable[[Scene], Scene]:
    """Return what changes columns of one sensor's reports, or of all."""

    def spoil(one: Scene) -> Scene:
        where = pl.lit(True) if sensor is None else pl.col("sensor") == sensor
        changed = [
            pl.when(where).then(value).otherwise(pl.col(name)).alias(name)
            for name, value in columns.items()
        ]
        return Scene(one.reports.with_columns(changed).sort("time"), one.told, one.truth)

    return spoil


def copied(one: Scene) -> Scene:
    """Return a scene in which one radar's reports come as another's too."""
    again = one.reports.filter(pl.col("sensor") == WRONG).with_columns(sensor=pl.lit("copy"))
    told = copy.deepcopy(one.told)
    told["sensors"]["copy"] = told["sensors"][WRONG]
    return Scene(pl.concat([one.reports, again]).sort("time"), told, one.truth)


def said(key: str, change: Callable[[float], Any]) -> Callable[[Scene], Scene]:
    """Return what tells another value of every sensor, or of motion."""

    def spoil(one: Scene) -> Scene:
        told = copy.deepcopy(one.told)
        tables = [told["motion"]] if key in told["motion"] else list(told["sensors"].values())
        for table in tables:
            value = table.get(key)
            if isinstance(value, dict):
                table[key] = {name: change(number) for name, number in value.items()}
            else:
                table[key] = change(value if value is not None else 0.0)
        return Scene(one.reports, told, one.truth)

    return spoil


X, Y, T = pl.col("x"), pl.col("y"), pl.col("time")
CONTRADICTIONS: dict[str, Contradiction] = {
    "one clock 10 s ahead": Contradiction(sent(WRONG, time=T + 10.0), ("clock",), told=False),
    "one clock an hour ahead": Contradiction(sent(WRONG, time=T + 3600.0), ("clock",), told=False),
    "one clock two hours behind": Contradiction(sent(WRONG, time=T - 7200.0), ("clock",)),
    "one radar 500 m off": Contradiction(
        sent(WRONG, x=X + 400.0, y=Y - 300.0), ("offset",), told=False
    ),
    "one radar mirrored": Contradiction(sent(WRONG, x=-X), ("mirror x",), told=False),
    "one radar mirrored about its middle": Contradiction(
        sent(WRONG, y=2000.0 - Y), ("mirror y",), told=False
    ),
    "one radar's x and y exchanged": Contradiction(sent(WRONG, x=Y, y=X), ("swap",), told=False),
    "one radar in kilometres": Contradiction(sent(WRONG, x=X / 1e3, y=Y / 1e3), ("kilometres",)),
    "all in kilometres": Contradiction(sent(None, x=X / 1e3, y=Y / 1e3), ("kilometres",)),
    "one radar's ranges in kilometres": Contradiction(
        sent(WRONG, range_m=pl.col("range_m") / 1e3), ("kilometres",), polar=True
    ),
    "all ranges in kilometres": Contradiction(
        sent(None, range_m=pl.col("range_m") / 1e3), ("kilometres",), polar=True
    ),
    "one radar's azimuths in radians": Contradiction(
        sent(WRONG, azimuth_deg=pl.col("azimuth_deg").radians()), ("radians",), polar=True
    ),
    "all azimuths in radians": Contradiction(
        sent(None, azimuth_deg=pl.col("azimuth_deg").radians()), ("radians",), polar=True
    ),
    "one radar's azimuths counter-clockwise": Contradiction(
        sent(WRONG, azimuth_deg=(360.0 - pl.col("azimuth_deg"))), ("sense",), polar=True
    ),
    "one radar's reports copied": Contradiction(copied, ("copies",), told=False),
    "sigma ÷ 100": Contradiction(said("sigma", lambda v: v / 100), ("sigma",)),
    "sigma ÷ 10": Contradiction(said("sigma", lambda v: v / 10), ("sigma",)),
    "sigma × 10": Contradiction(said("sigma", lambda v: v * 10), ("sigma",)),
    "1 − P_D × 5": Contradiction(
        said("detection_probability", lambda v: max(1 - 5 * (1 - v), 0.1)),
        ("detection_probability",),
    ),
    "1 − P_D ÷ 10": Contradiction(
        said("detection_probability", lambda v: 1 - (1 - v) / 10), ("detection_probability",)
    ),
    "P_D ÷ 10": Contradiction(
        said("detection_probability", lambda v: v / 10), ("detection_probability",)
    ),
    "clutter × 1000": Contradiction(said("clutter_per_scan", lambda v: v * 1e3), ("clutter",)),
    "clutter ÷ 1000": Contradiction(said("clutter_per_scan", lambda v: v / 1e3), ("clutter",)),
    "clutter × 10": Contradiction(said("clutter_per_scan", lambda v: v * 10), ("clutter",)),
    "clutter ÷ 10": Contradiction(said("clutter_per_scan", lambda v: v / 10), ("clutter",)),
    "max_speed ÷ 10": Contradiction(said("max_speed", lambda v: v / 10), ("max_speed",)),
    "max_speed × 30": Contradiction(said("max_speed", lambda v: v * 30), ("max_speed",)),
    "process noise ÷ 30": Contradiction(
        said("process_noise", lambda v: v / 30), ("process_noise",)
    ),
    "process noise × 30": Contradiction(
        said("process_noise", lambda v: v * 30), ("process_noise",)
    ),
    "a field of view too short": Contradiction(
        said("field_of_view", lambda _: {"max_range_m": 300.0}), ("field of view",)
    ),
}
