"""Scenes for sensors of every kind: objects on straight lines, and what sensors report of them."""

from typing import Any, NamedTuple

import numpy as np
import polars as pl

Array = np.ndarray[Any, np.dtype[Any]]
SIDE = 200e3
RADARS, PERIOD, REACH = 10, 4.0, 100e3
POLAR = ["time", "sensor", "range_m", "azimuth_deg"]


class Scene(NamedTuple):
    """Reports, which of them are of whom (-1 of nobody), and objects' places and speeds at 0."""

    reports: pl.DataFrame
    origin: Array
    start: Array
    speed: Array
    config: dict[str, Any]

    def at(self, time: float) -> Array:
        """Return where the objects are."""
        return self.start + self.speed * time


def objects(rng: np.random.Generator, count: int, side: float, speeds: tuple[float, float]) -> Any:
    """Return places well inside a square, and speeds to anywhere."""
    start = rng.uniform(0.1 * side, 0.9 * side, (count, 2))
    size, course = rng.uniform(*speeds, count), rng.uniform(0, 2 * np.pi, count)
    return start, size[:, None] * np.stack([np.sin(course), np.cos(course)], axis=1)


def azimuth(place: Array) -> Array:
    """Return the direction of places from the origin, clockwise from north [rad]."""
    return np.asarray(np.arctan2(place[..., 0], place[..., 1]) % (2 * np.pi))


def _scene(rows: list[tuple[Any, ...]], names: list[str], moving: Any, config: Any) -> Scene:
    """Return a scene of rows that end with whose report each is."""
    rows.sort(key=lambda row: row[0])
    reports = pl.DataFrame([row[:-1] for row in rows], schema=names, orient="row")
    start, speed = moving
    return Scene(reports, np.array([row[-1] for row in rows]), start, speed, config)


def rotating(seed: int, *, aircraft: int = 30, seconds: float = 120.0) -> Scene:
    """Return ten radars of nearly equal pace, one of whose reports in a hundred comes twice."""
    rng = np.random.default_rng(seed)
    moving = start, speed = objects(rng, aircraft, SIDE, (150.0, 250.0))
    places, phases = rng.uniform(0, SIDE, (RADARS, 2)), rng.uniform(0, 2 * np.pi, RADARS)
    noise, angle_noise, false = 70.0, 0.08, 1.2
    rows: list[tuple[Any, ...]] = []
    for radar in range(RADARS):
        turn = PERIOD * (1 + 0.01 * radar)
        for number in range(int(seconds / turn) + 1):
            begin = number * turn
            for target in range(aircraft):
                time = begin
                for _ in range(4):  # the beam meets it where it is by then
                    apart = start[target] + speed[target] * time - places[radar]
                    time = (
                        begin + (azimuth(apart) - phases[radar]) % (2 * np.pi) / 2 / np.pi * turn
                    )
                distance = float(np.hypot(*apart))
                if distance > REACH or time > seconds or rng.random() > 0.97:
                    continue
                for again in range(1 + (rng.random() < 0.01)):
                    measured = distance + rng.normal() * noise
                    pointed = (np.degrees(azimuth(apart)) + rng.normal() * angle_noise) % 360
                    rows.append((time + 0.02 * again, f"r{radar}", measured, pointed, target))
            for _ in range(rng.poisson(false)):
                time = begin + rng.random() * turn
                pointed = np.degrees(phases[radar] + 2 * np.pi * (time / turn % 1)) % 360
                measured = REACH * np.sqrt(rng.random())
                if time <= seconds:
                    rows.append((time, f"r{radar}", measured, pointed, -1))
    sensors: dict[str, Any] = {
        f"r{radar}": {
            "position": places[radar].tolist(), "scan_period": PERIOD * (1 + 0.01 * radar),
            "rotation": "clockwise",
        }
        for radar in range(RADARS)
    }  # fmt: skip
    sensors["default"] = {
        "sigma": {"range_m": noise, "azimuth_deg": angle_noise}, "detection_probability": 0.97,
        "clutter_per_scan": false, "field_of_view": {"max_range_m": REACH},
    }  # fmt: skip
    life = {"new_target_density": 1e-12, "initial_target_density": aircraft / SIDE**2}
    return _scene(rows, POLAR, moving, {
        "motion": {"process_noise": 1.0, "max_speed": 300.0}, "sensors": sensors,
        "lifecycle": life, "window": {"depth": 5},
    })  # fmt: skip


def turns(scene: Scene) -> Scene:
    """Return a scene of radars whose turns are numbered and of whose beams nobody knows."""
    sensors = {
        name: {key: value for key, value in section.items() if key != "rotation"}
        for name, section in scene.config["sensors"].items()
    }
    radar = scene.reports["sensor"].str.slice(1).cast(pl.Int64).to_numpy()
    number = np.floor(scene.reports["time"].to_numpy() / (PERIOD * (1 + 0.01 * radar)))
    reports = scene.reports.with_columns(scan=pl.Series(number.astype(int) * RADARS + radar))
    return scene._replace(reports=reports, config={**scene.config, "sensors": sensors})


def platform(seed: int, *, targets: int = 6, seconds: float = 160.0) -> Scene:
    """Return a slow coarse radar and an aircraft that only sees in which direction objects are."""
    rng = np.random.default_rng(seed)
    side, noise, angle_noise, gaze, false = 40e3, 60.0, 0.6, 0.15, 1.0
    moving = start, speed = objects(rng, targets, side, (60.0, 120.0))
    fly, own_speed = np.array([-2e3, -6e3]), np.array([40.0, 220.0])
    rows: list[tuple[Any, ...]] = []
    for time in np.arange(0.0, seconds, 1.0):
        own = fly + own_speed * time
        carried = (*own, *own_speed)
        for target in range(targets):
            true = start[target] + speed[target] * time
            if time % PERIOD == 0 and rng.random() < 0.8:
                distance = float(np.hypot(*true)) + rng.normal() * noise
                pointed = (np.degrees(azimuth(true)) + rng.normal() * angle_noise) % 360
                rows.append((time, "radar", distance, pointed, None, *[None] * 4, target))
            if rng.random() < 0.8:
                bearing = (np.degrees(azimuth(true - own)) + rng.normal() * gaze) % 360
                rows.append((time, "aircraft", None, None, bearing, *carried, target))
        if time % PERIOD == 0:
            for _ in range(rng.poisson(10.0)):
                polar = 60e3 * float(np.sqrt(rng.random())), rng.uniform(0, 90)
                rows.append((time, "radar", *polar, None, *[None] * 4, -1))
        for _ in range(rng.poisson(false)):
            rows.append((time, "aircraft", None, None, rng.uniform(0, 360), *carried, -1))
    names = [*POLAR, "bearing_deg", "sensor_x", "sensor_y", "sensor_vx", "sensor_vy"]
    return _scene(rows, names, moving, {
        "motion": {"process_noise": 0.5, "max_speed": 150.0},
        "sensors": {
            "radar": {
                "sigma": {"range_m": noise, "azimuth_deg": angle_noise}, "position": [0.0, 0.0],
                "detection_probability": 0.8, "clutter_per_scan": 10.0, "scan_period": PERIOD,
                "field_of_view": {"max_range_m": 60e3, "azimuth_deg": [0, 90]},
            },
            "aircraft": {
                "sigma": {"bearing_deg": gaze}, "detection_probability": 0.8,
                "clutter_density": false / (2 * np.pi), "scan_period": 1.0,
                "field_of_view": {"max_range_m": 60e3},
            },
        },
        "lifecycle": {"new_target_density": 1e-11, "initial_target_density": targets / side**2},
        "window": {"depth": 4, "max_scans": 20},
    })  # fmt: skip


def fading(seed: int, *, targets: int = 10, seconds: int = 120, later: float = 0.4) -> Scene:
    """Return positions of a sensor that sees nine in ten at first, then fewer."""
    rng = np.random.default_rng(seed)
    side, noise, false = 2000.0, 10.0, 10.0
    moving = start, speed = objects(rng, targets, side, (2.0, 8.0))
    rows: list[tuple[Any, ...]] = []
    for time in range(seconds):
        seen = rng.random(targets) < (0.9 if time < seconds // 2 else later)
        for target in np.flatnonzero(seen):
            place = start[target] + speed[target] * time + rng.normal(0, noise, 2)
            rows.append((float(time), *place, target))
        for _ in range(rng.poisson(false)):
            rows.append((float(time), *rng.uniform(0, side, 2), -1))
    return _scene(rows, ["time", "x", "y"], moving, {
        "motion": {"process_noise": 0.02, "max_speed": 15.0},
        "sensors": {"default": {
            "sigma": noise, "detection_probability": 0.9, "scan_period": 1.0,
            "clutter_density": false / side**2,
        }},
        "lifecycle": {"initial_target_density": targets / side**2},
    })  # fmt: skip


def bearings(
    seed: int, *, targets: int, seconds: float = 60.0, sigma: float = 2e-3, share: float = 0.2
) -> Scene:
    """Return four sensors around a square, each of which sees directions alone.

    ``sigma`` is of a bearing [rad], ``share`` how many false alarms a scan has for each target.
    """
    rng = np.random.default_rng(seed)
    side, count = 10e3, 4
    gaze, false = float(np.degrees(sigma)), share * targets
    around = 2 * np.pi * np.arange(count) / count
    places = side / 2 + 9e3 * np.stack([np.sin(around), np.cos(around)], axis=1)
    moving = start, speed = objects(rng, targets, side, (5.0, 30.0))
    rows: list[tuple[Any, ...]] = []
    for time in np.arange(0.0, seconds, 1.0):
        for sensor, place in enumerate(places):
            true = np.degrees(azimuth(start + speed * time - place))
            for target in np.flatnonzero(rng.random(targets) < 0.9):
                bearing = (true[target] + rng.normal() * gaze) % 360
                rows.append((time, f"s{sensor}", bearing, *place, target))
            centre = float(np.degrees(azimuth(side / 2 - place)))
            for _ in range(rng.poisson(false)):
                rows.append(
                    (time, f"s{sensor}", (centre + rng.uniform(-35, 35)) % 360, *place, -1)
                )
    return _scene(rows, ["time", "sensor", "bearing_deg", "sensor_x", "sensor_y"], moving, {
        "motion": {"process_noise": 0.1, "max_speed": 40.0},
        "sensors": {"default": {
            "sigma": {"bearing_deg": gaze}, "detection_probability": 0.9,
            "clutter_density": false / np.radians(70), "scan_period": 1.0,
            "field_of_view": {"max_range_m": 16e3},
        }},
        "lifecycle": {
            "new_target_density": 1e-8, "initial_target_density": targets / side**2,
            "survival": 0.99,
        },
        "window": {"depth": 6, "max_scans": 24},
    })  # fmt: skip
