"""What ``serve --demo`` feeds itself: three radars, and boats that come and go."""

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from trackweave.domain.frames import LocalFrame
from trackweave.io.columns import datetime_column
from trackweave.randomness import generator_of
from trackweave.simulation import Area, RandomTargets, Scenario, demo_scenario, simulate

__all__ = ["demonstration"]

DURATION, SPEED = 900.0, 2.0
"""Seconds of traffic, and how many times as fast as it was they pass; then they pass again."""
AHEAD = 12.0
"""Seconds of it that come at once: so the first picture has tracks."""
HARBOUR = LocalFrame(54.50, 10.25)
"""The Kiel Fjord's mouth."""
PERIOD = 3.0


def demonstration(folder: Path, seed: int) -> tuple[str, dict[str, Any]]:
    """Write a recording, and return what replays it and the configuration to track it with.

    Parameters
    ----------
    folder
        Where the recording goes.
    seed
        The same seed gives the same traffic.

    Returns
    -------
    A URL for ``--listen``, and the tables of a tracker.toml.
    """
    scenario = _scenario()
    scene = simulate(scenario, generator_of(seed))
    reports = scene.reports
    now = datetime.now(UTC).timestamp()
    latitude, longitude, _ = HARBOUR.to_geodetic(reports.measurement[:, :2])
    table = pl.DataFrame(
        {
            "time": datetime_column("time", reports.time + round(now)),
            "sensor": [reports.sensors[index] for index in reports.sensor.tolist()],
            "lat": latitude,
            "lon": longitude,
        }
    )
    path = folder / "demo.parquet"
    table.write_parquet(path)
    return f"replay:{path}?speed={SPEED:g}&ahead={AHEAD:g}&loop=1", _configuration(scenario, seed)


def _scenario() -> Scenario:
    sensors = tuple(
        replace(sensor, scan_period=PERIOD, start_offset=place, clutter_per_scan=4.0)
        for place, sensor in enumerate(demo_scenario().sensors)
    )
    return Scenario(
        area=Area((0.0, 0.0), (2000.0, 1400.0)),
        duration=DURATION,
        sensors=sensors,
        random=RandomTargets(
            count=14, speed=(4.0, 12.0), birth_rate=0.13, survival=0.999, stay_inside=False
        ),
        process_noise=0.02,
    )


def _configuration(scenario: Scenario, seed: int) -> dict[str, Any]:
    area = scenario.area
    size = float(np.prod(np.subtract(area.high, area.low)))
    sensors = {
        sensor.name: {
            "measurement": "position",
            "sigma": sensor.sigmas(2)[0],
            "detection_probability": sensor.detection_probability,
            "clutter_density": sensor.clutter_per_scan / size,
            "scan_period": sensor.scan_period,
            "position": list(sensor.position or (0.0, 0.0)),
        }
        for sensor in scenario.sensors
    }
    return {
        "seed": seed,
        "frame": {"origin": [HARBOUR.latitude_deg, HARBOUR.longitude_deg]},
        "motion": {"process_noise": 0.1, "max_speed": 15.0},
        "lifecycle": {"new_target_density": 1e-8},
        "sensors": sensors,
    }
