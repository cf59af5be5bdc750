"""Where objects keep together, their distance is no noise: tracks that are likelier say so."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.config import load_configuration
from trackweave.estimation.estimate import estimate
from trackweave.metrics import assignment_quality
from trackweave.run.kept import Kept
from trackweave.run.likelier import likelier


def tags(spacing: float, minutes: float = 2.0) -> pl.DataFrame:
    """Return five tags side by side on a winding way, each a report about every second [3 m]."""
    rng, rows = np.random.default_rng(0), []
    for tag in range(5):
        time = rng.uniform(0.0, 1.0)
        while time < 60.0 * minutes:
            place = np.array([spacing * tag + 15.0 * time, 200.0 * np.sin(time / 60.0)])
            rows.append((round(time, 3), *(place + rng.normal(0.0, 3.0, 2)), f"tag {tag}"))
            time += 1.0 + rng.normal(0.0, 0.1)
    return pl.DataFrame(rows, schema=["time", "x", "y", "target"], orient="row").sort("time")


def test_tags_that_keep_together_are_told_apart() -> None:
    frame = tags(20.0)
    result = tw.track(frame.drop("target"))
    quality = assignment_quality(frame["target"].to_list(), result.reports["track"].to_list())
    assert quality.idf1 > 0.95
    sensor = result.run["configuration"]["sensors"]["default"]
    assert sensor["sigma"] == pytest.approx(3.0, rel=0.3)


def test_what_is_as_likely_is_left_as_it_was() -> None:
    reports = tw.read_reports(tags(500.0).drop("target"))
    estimates = estimate(reports)
    assert likelier(estimates, reports, load_configuration(None), Kept()) is estimates


def test_attempts_of_a_run_take_what_the_first_one_found() -> None:
    reports, kept = tw.read_reports(tags(20.0).drop("target")), Kept()
    configuration = load_configuration(None)
    found = likelier(estimate(reports), reports, configuration, kept)
    assert likelier(estimate(reports), reports, configuration, kept) is found
    again = likelier(estimate(reports), reports, configuration, Kept())
    assert again == found
