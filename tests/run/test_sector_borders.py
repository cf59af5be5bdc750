"""Objects at the borders of a turning beam's sectors, which another sensor knows better."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw

pytestmark = pytest.mark.slow

TURN, N_SHIPS, N_TURNS = 3.0, 16, 130
TOLD = {
    "motion": {"process_noise": 0.01, "max_speed": 20.0, "trust": True},
    "sensors": {
        "radar": {"position": [0.0, 0.0], "sigma": {"range_m": 15.0, "azimuth_deg": 0.15},
                  "detection_probability": 0.9, "trust": True},
        "ais": {"sigma": 4.0, "scans": False, "trust": ["sigma"]},
    },
}  # fmt: skip


def ships(seed: int) -> pl.DataFrame:
    """Ships that cross the eight borders slowly, as a radar and they themselves tell it."""
    rng, rows = np.random.default_rng(seed), []
    azimuth = np.radians(45.0 * (np.arange(N_SHIPS) % 8) + rng.uniform(-1.5, 1.5, N_SHIPS))
    far = rng.uniform(9e3, 16e3, N_SHIPS)
    at = far[:, None] * np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
    velocity = rng.normal(0.0, 4.0, (N_SHIPS, 2))

    def seen(time: float, distance: float, degrees: float, ship: int) -> None:
        rows.append((time, "radar", distance, degrees % 360.0, None, None, ship))

    for turn in range(N_TURNS):
        for ship in range(N_SHIPS):
            place = at[ship] + velocity[ship] * TURN * turn
            time = TURN * (turn + np.arctan2(*place) % (2 * np.pi) / (2 * np.pi))
            place = at[ship] + velocity[ship] * time
            if rng.random() < 0.9:
                distance = np.hypot(*place) + rng.normal(0.0, 15.0)
                seen(time, distance, np.degrees(np.arctan2(*place)) + rng.normal(0.0, 0.15), ship)
        degrees = rng.uniform(0.0, 360.0)
        seen(TURN * (turn + degrees / 360.0), rng.uniform(1e3, 2e4), degrees, -1)
    for ship in range(N_SHIPS):
        for time in np.arange(rng.uniform(0.0, 8.0), TURN * N_TURNS, 8.0):
            place = at[ship] + velocity[ship] * time + rng.normal(0.0, 4.0, 2)
            rows.append((time, "ais", None, None, *place.tolist(), ship))
    names = ["time", "sensor", "range_m", "azimuth_deg", "x", "y", "target"]
    table = pl.DataFrame(rows, schema=names, orient="row", infer_schema_length=None)
    return table.sort("time")


def test_ships_at_a_sectors_border_are_one_each() -> None:
    # A report lies beyond the border where the ship does not, by the radar's noise, which is far
    # greater than what is unknown of where the ship is.
    reports = ships(3)
    result = tw.track(reports.drop("target"), TOLD, rng=0)
    assert result.run["totals"]["tracks"] == N_SHIPS
    found = result.reports.with_columns(reports["target"]).filter(pl.col("target") >= 0)
    assert found["track"].null_count() <= 2
    names = found.drop_nulls("track").group_by("target").agg(pl.col("track").n_unique())
    assert names["track"].to_list() == [1] * N_SHIPS
