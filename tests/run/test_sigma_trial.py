"""A sigma that is told far too small or too large breaks tracks; what reports tell is used."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.metrics import assignment_quality
from trackweave.run.small_recordings import RADARS, recording_of_radars

SIGMA = 5.0


@pytest.fixture(scope="module")
def recording() -> pl.DataFrame:
    """Return eight objects that come and go, one look a second, a false alarm now and then."""
    rng = np.random.default_rng(11)
    rows = []
    for each in range(8):
        begin, place = rng.integers(0, 40), rng.uniform(-800.0, 800.0, 2)
        velocity = rng.uniform(-15.0, 15.0, 2)
        for now in range(begin, min(begin + 40, 80)):
            if rng.random() < 0.9:
                at = place + velocity * now + rng.normal(0.0, SIGMA, 2)
                rows.append((float(now), *at, str(each)))
    for now in range(80):
        for _ in range(rng.poisson(1.0)):
            rows.append((float(now), *rng.uniform(-1500.0, 1500.0, 2), ""))
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row").sort("time")


def tracked(table: pl.DataFrame, **told: object) -> tuple[tw.TrackingResult, float]:
    result = tw.track(table.drop("target"), {"sensors": {"default": told}})
    whose = [each or None for each in table["target"]]
    return result, assignment_quality(whose, result.reports["track"].to_list()).idf1


@pytest.mark.slow
@pytest.mark.parametrize("factor", [0.001, 0.01, 0.03, 0.05, 0.1, 0.2])
def test_a_sigma_that_breaks_tracks_is_overruled(recording, factor):
    result, idf1 = tracked(recording, sigma=factor * SIGMA)
    assert idf1 > 0.95
    used = result.run["configuration"]["sensors"]["default"]["sigma"]
    assert 0.7 * SIGMA < used < 1.4 * SIGMA
    assert any("sigma is told as" in note for note in result.run["notes"])


@pytest.mark.parametrize("factor", [1.0, 2.0])
def test_a_sigma_under_which_tracks_hold_is_kept(recording, factor):
    result, idf1 = tracked(recording, sigma=factor * SIGMA)
    assert idf1 > 0.95
    assert result.run["configuration"]["sensors"]["default"]["sigma"] == factor * SIGMA


def test_a_sigma_that_is_trusted_is_kept(recording):
    result, _ = tracked(recording, sigma=0.03 * SIGMA, trust=["sigma"])
    assert result.run["configuration"]["sensors"]["default"]["sigma"] == 0.03 * SIGMA


@pytest.mark.slow
def test_beside_a_sensor_of_which_nothing_is_told(recording):
    """Of two sensors one has a sigma that is far too small."""
    rng, objects = np.random.default_rng(4), recording.filter(pl.col("target") != "")
    x, y = rng.normal(0.0, SIGMA, (2, len(objects)))
    other = objects.with_columns(
        pl.col("time") + 0.5, x=objects["x"] + x, y=objects["y"] + y, sensor=pl.lit("B")
    )
    own = recording.with_columns(sensor=pl.lit("A"))
    both = pl.concat([own, other.select(own.columns)]).sort("time")
    result = tw.track(both.drop("target"), {"sensors": {"A": {"sigma": 0.02 * SIGMA}}})
    whose = [each or None for each in both["target"]]
    assert assignment_quality(whose, result.reports["track"].to_list()).idf1 > 0.9


def test_a_turning_beam_whose_positions_stand_trial_ends_in_no_error() -> None:
    # Few reports are in tracks that last with 90 m, so that what is told stands trial.
    made = recording_of_radars()
    parts = []
    for name, (east, north, _) in RADARS.items():
        angle, own = pl.col("azimuth_deg").radians(), pl.col("sensor") == name
        x, y = (pl.col("range_m") * each for each in (angle.sin(), angle.cos()))
        parts.append(made.reports.filter(own).select("time", "sensor", x=east + x, y=north + y))
    sensors = {
        name: {"sigma": 90.0, "position": [*at], "scan_period": turn, "rotation": "clockwise"}
        for name, (*at, turn) in RADARS.items()
    }
    told = {"motion": {"max_speed": 600.0}, "sensors": sensors}
    totals = tw.track(pl.concat(parts).sort("time"), told).run["totals"]
    assert totals["assigned_reports"] > 0.5 * totals["reports"]
