"""Noise that is larger along one axis is told by axis, and does not seem to be motion."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw

pytestmark = pytest.mark.slow

TRUE_PROCESS = 2.0


def camera(seed, noise):
    """Return twelve seconds of fifteen objects that a stereo camera sees thirty times a second."""
    rng = np.random.default_rng(seed)
    step, rows = 1 / 30, []
    for target in range(15):
        place, speed = rng.uniform(-20, 20, 3), rng.normal(0, 2, 3)
        for frame in range(360):
            speed = speed + rng.normal(0, np.sqrt(TRUE_PROCESS * step), 3)
            place = place + step * speed
            if rng.random() < 0.9:
                rows.append((frame * step, *(place + rng.normal(0, noise)), str(target)))
    rows += [(f * step, *rng.uniform(-30, 30, 3), None) for f in rng.integers(0, 360, 400)]
    return pl.DataFrame(rows, schema=["time", "x", "y", "z", "target"], orient="row").sort("time")


def test_noise_along_a_line_of_sight_is_told_by_axis():
    noise = (0.08, 0.5, 0.08)
    result = tw.track(camera(1, noise))
    told = result.run["configuration"]
    sigma = told["sensors"]["default"]["sigma"]
    assert [sigma[axis] for axis in "xyz"] == pytest.approx(noise, rel=0.15)
    assert told["motion"]["process_noise"] < 10.0 * TRUE_PROCESS
    assert tw.evaluate(assignments=result.assignments).report_idf1 > 0.97


def test_noise_that_is_alike_is_one_number():
    told = tw.track(camera(2, (0.2, 0.2, 0.2))).run["configuration"]
    assert told["sensors"]["default"]["sigma"] == pytest.approx(0.2, rel=0.15)


def test_a_sensor_beside_another_that_sees_other_objects_is_told_too():
    is_rights = pl.col("target").is_in(["0", "1"]).fill_null(value=False)
    table = camera(3, (0.08, 0.5, 0.08)).with_columns(
        sensor=pl.when(is_rights).then(pl.lit("right")).otherwise(pl.lit("left"))
    )
    sigma = tw.track(table).run["configuration"]["sensors"]["left"]["sigma"]
    assert sigma["y"] > 3.0 * sigma["x"]
