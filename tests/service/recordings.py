"""Recordings with complete configurations, for what has to be equal however it is tracked."""

from typing import Any

import numpy as np
import polars as pl

from trackweave.simulation import demo_scenario, simulate


def positions(seed: int = 3) -> tuple[pl.DataFrame, dict[str, Any]]:
    """Return what three radars of positions see of nine boats."""
    reports = simulate(demo_scenario(), np.random.default_rng(seed)).reports
    frame = pl.DataFrame(
        {
            "time": reports.time,
            "sensor": [reports.sensors[index] for index in reports.sensor],
            "x": reports.measurement[:, 0],
            "y": reports.measurement[:, 1],
        }
    )
    sensor = {
        "measurement": "position", "sigma": 8.0, "detection_probability": 0.86,
        "clutter_density": 3e-6, "scan_period": 6.0,
    }  # fmt: skip
    configuration = {
        "seed": 1,
        "motion": {"process_noise": 0.5, "max_speed": 20.0},
        "lifecycle": {"new_target_density": 1e-6},
        "sensors": {name: dict(sensor) for name in reports.sensors},
    }
    return frame, configuration


def lone_reports(
    seed: int = 5, n_ships: int = 5, *, named: bool = False
) -> tuple[pl.DataFrame, dict[str, Any]]:
    """Return what a receiver hears of ships that report themselves, some of it twice."""
    rng, rows = np.random.default_rng(seed), []
    for ship in range(n_ships):
        time, place, velocity = rng.uniform(0, 8), rng.uniform(-3e3, 3e3, 2), rng.normal(0, 6, 2)
        while time < 300.0:
            x, y = place + velocity * time + rng.normal(0, 5, 2)
            rows.append((round(time, 3), "ais", x, y, f"S{ship}"))
            if rng.random() < 0.05:
                rows.append((round(time, 3) + 1.0, "ais", x, y, f"S{ship}"))
            time += rng.choice([6.0, 10.0])
    names = ["time", "sensor", "x", "y", "identity"]
    frame = pl.DataFrame(sorted(rows), schema=names, orient="row")
    frame = frame if named else frame.drop("identity")
    sensor = {
        "measurement": "position", "sigma": 5.0, "detection_probability": 0.95,
        "clutter_density": 1e-9, "scans": False,
    }  # fmt: skip
    return frame, {
        "seed": 1,
        "motion": {"process_noise": 0.05, "max_speed": 20.0},
        "lifecycle": {"new_target_density": 1e-8},
        "sensors": {"ais": sensor},
    }


def named_reports(seed: int = 8) -> tuple[pl.DataFrame, dict[str, Any]]:
    """Return what it hears of more ships that say who they are, but for some."""
    frame, configuration = lone_reports(seed, n_ships=12, named=True)
    unnamed = (pl.int_range(pl.len()) % 17 == 3) & pl.col("x").is_unique()
    return frame.with_columns(
        identity=pl.when(unnamed).then(None).otherwise(pl.col("identity"))
    ), configuration


def named_beside_radar(seed: int = 9) -> tuple[pl.DataFrame, dict[str, Any]]:
    """Return the same beside a radar that turns."""
    named, told = named_reports(seed)
    seen, configuration = turning_radar(seed)
    square = {"polygon": [[-1e5, -1e5], [1e5, -1e5], [1e5, 1e5], [-1e5, 1e5]]}
    every = {**configuration["sensors"], **told["sensors"]}
    sensors = {name: {**own, "field_of_view": square} for name, own in every.items()}
    # Nobody sees the ships but themselves, which what is told of the radar does not say.
    sensors["tower"]["trust"] = ["detection_probability"]
    named = named.filter(pl.col("time") < seen["time"].max())
    both = pl.concat([seen, named], how="diagonal").sort("time", maintain_order=True)
    return both, {**configuration, "sensors": sensors}


def paused(seed: int = 4) -> tuple[pl.DataFrame, dict[str, Any]]:
    """Return the same boats; one radar pauses early and all of them later."""
    frame, configuration = positions(seed)
    own = (pl.col("sensor") == "pier") & pl.col("time").is_between(30.0, 60.0)
    return frame.filter(~(own | pl.col("time").is_between(75.0, 95.0))), configuration


def paused_turns(seed: int = 7) -> tuple[pl.DataFrame, dict[str, Any]]:
    """Return what a radar sees of many aircraft that turns on after pauses of turns."""
    return turning_radar(seed, n_aircraft=14)


def held_places(seed: int = 12) -> tuple[pl.DataFrame, dict[str, Any]]:
    """Return state vectors of aircraft every ten seconds; some places are said on for minutes."""
    rng, rows = np.random.default_rng(seed), []
    for aircraft in range(12):
        course = rng.uniform(0.0, 2.0 * np.pi)
        velocity = rng.uniform(60.0, 200.0) * np.array([np.cos(course), np.sin(course)])
        place = rng.uniform(-3e4, 3e4, 2)
        for look in range(60):
            heard = 20 if aircraft % 3 == 0 and 20 <= look < 40 else look
            if heard == look:
                said = place + velocity * 10.0 * look + rng.normal(0.0, 40.0, 2)
            if rng.random() < 0.9:
                rows.append((10.0 * look, *(np.array([51.0, 0.0]) + said[::-1] / 111e3)))
    frame = pl.DataFrame(sorted(rows), ["time", "lat", "lon"], orient="row")
    return frame, {
        "seed": 1,
        "frame": {"origin": [51.0, 0.0]},
        "motion": {"process_noise": 1.0, "max_speed": 400.0},
        "lifecycle": {"new_target_density": 1e-10},
        "sensors": {
            "default": {
                "sigma": 60.0,
                "detection_probability": 0.9,
                "clutter_density": 1e-12,
                "scan_period": 10.0,
            }
        },
    }


def turns_heard_twice(seed: int = 6) -> tuple[pl.DataFrame, dict[str, Any]]:
    """Return what two networks bring of the same radar, some of it up to half a second later."""
    frame, configuration = turning_radar(seed)
    later = np.random.default_rng(seed).uniform(0.001, 0.5, frame.height)
    again = frame.with_columns(pl.col("time") + later).gather_every(3)
    return pl.concat([frame, again]).sort("time", maintain_order=True), configuration


def turning_radar(seed: int = 6, n_aircraft: int = 6) -> tuple[pl.DataFrame, dict[str, Any]]:
    """Return what a radar whose beam turns sees of aircraft; two turns are empty."""
    rng, rows, period, phase = np.random.default_rng(seed), [], 4.0, 1.0
    when = lambda turn, azimuth: (turn + ((azimuth - phase) % (2 * np.pi)) / (2 * np.pi)) * period  # noqa: E731
    for _ in range(n_aircraft):
        place, velocity = rng.uniform(-3e4, 3e4, 2), rng.normal(0, 150, 2)
        for turn in range(40):
            time = turn * period
            for _ in range(4):
                x, y = place + velocity * time
                azimuth = np.arctan2(x, y) % (2 * np.pi)
                time = when(turn, azimuth)
            if rng.random() < 0.9 and turn not in (20, 21):
                noisy = np.degrees(azimuth) + rng.normal(0, 0.08)
                rows.append((round(time, 4), "tower", np.hypot(x, y) + rng.normal(0, 50), noisy))
    names = ["time", "sensor", "range_m", "azimuth_deg"]
    frame = pl.DataFrame(sorted(rows), schema=names, orient="row")
    sensor = {
        "measurement": "range-azimuth", "position": [0.0, 0.0],
        "sigma": {"range_m": 50.0, "azimuth_deg": 0.08}, "detection_probability": 0.9,
        "clutter_density": 1e-5, "scan_period": period, "rotation": "clockwise",
        "phase_deg": float(np.degrees(phase)),
    }  # fmt: skip
    return frame.with_columns(pl.col("azimuth_deg") % 360.0), {
        "seed": 1,
        "motion": {"process_noise": 1.0, "max_speed": 400.0},
        "lifecycle": {"new_target_density": 1e-10},
        "sensors": {"tower": sensor},
    }


ALL = {
    "positions": positions, "paused": paused, "lone reports": lone_reports,
    "named reports": named_reports, "named beside a radar": named_beside_radar,
    "turning radar": turning_radar, "paused turns": paused_turns,
    "turns heard twice": turns_heard_twice,
}  # fmt: skip
