"""The noise of what walks at random is not told by how far it is beside straight ways."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw

TOLD = {
    "motion": {"model": "random-walk", "process_noise": 1.2, "max_speed": 6.0},
    "sensors": {"default": {"sigma": 0.3, "detection_probability": 0.95, "scan_period": 1.0}},
}


def walkers() -> pl.DataFrame:
    rng, rows = np.random.default_rng(4), []
    for walker in range(20):
        place = rng.uniform(0.0, 500.0, 2)
        for scan in range(60):
            place = place + rng.normal(0.0, np.sqrt(1.2), 2)
            if rng.random() < 0.95:
                rows.append((float(scan), *(place + rng.normal(0.0, 0.3, 2)), str(walker)))
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row").sort("time")


def test_a_sigma_that_is_told_rightly_is_kept_in_silence() -> None:
    run = tw.track(walkers(), TOLD).run
    assert run["configuration"]["sensors"]["default"]["sigma"] == pytest.approx(0.3)
    assert not [note for note in run["notes"] if "sigma" in note]
