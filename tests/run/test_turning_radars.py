"""Turning radars are learned at their reports' own times, on the ground."""

import numpy as np
import polars as pl
import pytest

from trackweave.config import load_configuration
from trackweave.run.tracking import report_table, settings_for

pytestmark = pytest.mark.slow

RADARS = {"near": ((0.0, 0.0), 5.0), "far": ((60e3, 10e3), 8.0)}
SIGMA = {"range_m": 50.0, "azimuth_deg": 0.06}


def sky(seed=3, minutes=4.0):
    """Sixteen aircraft high above two radars, which see each four times in five."""
    rng = np.random.default_rng(seed)
    start, heading = rng.uniform(-4e4, 8e4, (16, 2)), rng.uniform(0, 2 * np.pi, 16)
    velocity = 200.0 * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    height = rng.uniform(5e3, 11e3, 16)
    parts = []
    for name, (place, period) in RADARS.items():
        turn = np.repeat(np.arange(int(60 * minutes / period)), 16)
        who = np.tile(np.arange(16), turn.size // 16)
        time = (turn + 0.5) * period
        for _ in range(4):
            away = start[who] + velocity[who] * time[:, None] - place
            azimuth = np.degrees(np.arctan2(*away.T)) % 360
            time = (turn + azimuth / 360) * period
        slant = np.hypot(np.hypot(*away.T), height[who]) + rng.normal(0, 50.0, who.size)
        azimuth = (azimuth + rng.normal(0, SIGMA["azimuth_deg"], who.size)) % 360
        columns = {"time": time, "range_m": slant, "azimuth_deg": azimuth, "height_m": height[who]}
        seen = rng.random(who.size) < 0.8
        parts.append(pl.DataFrame(columns).filter(seen).with_columns(sensor=pl.lit(name)))
    return pl.concat(parts).sort("time")


def test_their_noise_and_detection_probability_come_out_right():
    keys = {n: {"position": list(at), "scan_period": s} for n, (at, s) in RADARS.items()}
    configuration = load_configuration({"sensors": keys})
    table, _ = report_table(sky(), configuration)
    for sensor in settings_for(table, configuration).sensors:
        distance, azimuth = sensor.sigmas(2)
        assert distance == pytest.approx(SIGMA["range_m"], rel=0.5)
        assert np.degrees(azimuth) == pytest.approx(SIGMA["azimuth_deg"], rel=0.5)
        assert sensor.detection_probability == pytest.approx(0.8, abs=0.06)
        assert sensor.echoes == ()
