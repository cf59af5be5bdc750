"""Two sensors that do not look, of which one is late: places differ by little, not by a sky."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw

pytestmark = pytest.mark.slow

N, SIDE, END = 9, 40e3, 240.0


def sky(seed: int) -> pl.DataFrame:
    """Return aircraft that report themselves every second, and what others make of it later."""
    rng, rows = np.random.default_rng(seed), []
    at, heading = rng.uniform(-SIDE, SIDE, (N, 2)), rng.uniform(0.0, 2.0 * np.pi, N)
    velocity = rng.uniform(150.0, 250.0, (N, 1)) * np.stack([np.cos(heading), np.sin(heading)], 1)
    for name, pause, late, sigma in (("own", 1.0, 0.2, 10.0), ("others", 3.0, 1.5, 60.0)):
        for number in range(N):
            time = rng.uniform(0.0, pause)
            while time < END:
                place = at[number] + velocity[number] * time + rng.normal(0.0, sigma, 2)
                rows.append((time + late * rng.uniform(0.5, 1.5), *place, name, f"a{number}"))
                time += pause * rng.uniform(0.8, 1.3)
    names = ["time", "x", "y", "sensor", "target"]
    return pl.DataFrame(rows, schema=names, orient="row").sort("time")


@pytest.mark.parametrize("seed", [3])
def test_noise_of_sensors_that_do_not_look_is_none_of_their_objects_distance(seed: int) -> None:
    reports = sky(seed)
    named = reports.rename({"target": "identity"})
    result = tw.track(named, rng=0)
    sensors = result.run["configuration"]["sensors"]
    # Their pairs at one time are 33 km apart.
    assert max(each["sigma"] for each in sensors.values()) < 200.0
