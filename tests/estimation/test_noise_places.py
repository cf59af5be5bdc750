"""Noise that grows with the distance from a camera is told by place."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.config import load_configuration
from trackweave.metrics import assignment_quality
from trackweave.models.local_noise import local_noise
from trackweave.run.tracking import settings_for

pytestmark = pytest.mark.slow

STEP, FRAMES = 0.2, 600


def lot(growth: float, across: float = 0.002, *, bad: int = 0) -> pl.DataFrame:
    """Return people before a camera at the origin, whose noise along its sight goes with r²."""
    # Of ``bad`` of them all reports are noisier, wherever they are.
    rng = np.random.default_rng(12)
    rows = []
    for who in range(14):
        place, course = rng.uniform([-30.0, 10.0], [30.0, 80.0]), rng.uniform(0.0, 6.3)
        for frame in range(FRAMES):
            course += rng.normal(0.0, 0.05)
            if not (-35.0 < place[0] < 35.0 and 8.0 < place[1] < 85.0):
                course = np.arctan2(-place[0], 45.0 - place[1])
            place = place + 1.4 * STEP * np.array([np.sin(course), np.cos(course)])
            distance = float(np.hypot(*place))
            sight = place / distance
            along = (0.05 + growth * distance**2) * (4.0 if who < bad else 1.0)
            noise = sight * rng.normal(0.0, along)
            noise += np.array([sight[1], -sight[0]]) * rng.normal(0.0, 0.05 + across * distance)
            if rng.random() < 0.9:
                rows.append((frame * STEP, *(place + noise), str(who)))
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row").sort("time")


def told(reports: pl.DataFrame, **sensor: float) -> dict[str, object]:
    """Return what is used of the sensor, as far as it is told by keys and estimated."""
    configuration = load_configuration({"sensors": {"default": sensor}} if sensor else {})
    settings = settings_for(tw.read_reports(reports.drop("target")), configuration)
    return dict(settings.values["sensors"]["default"])


def test_noise_that_grows_with_distance_is_told_by_place() -> None:
    places = told(lot(0.0004))["sigma_at"]
    found = local_noise(places, np.array([[0.0, 15.0], [0.0, 75.0]]))  # type: ignore[arg-type]
    assert found[0, 1] < 0.5
    assert 1.2 < found[1, 1] < 3.0
    assert found[1, 0] < 0.6


def test_noise_that_is_alike_everywhere_or_of_some_objects_is_not() -> None:
    assert told(lot(0.0, 0.0))["sigma_at"] == []
    assert told(lot(0.0, 0.0, bad=3))["sigma_at"] == []


def test_a_sigma_that_is_told_holds_everywhere() -> None:
    assert told(lot(0.0004), sigma=1.0)["sigma_at"] == []


def test_a_run_with_what_was_told_by_place_is_the_same() -> None:
    reports = lot(0.0002)
    first = tw.track(reports)
    again = tw.track(reports, first.run["configuration"])
    assert again.tracks.equals(first.tracks)
    assert again.history.equals(first.history)
    found = first.assignments
    quality = assignment_quality(found["target"].to_list(), found["track"].to_list())
    assert quality.idf1 is not None
    assert quality.idf1 > 0.95
