"""What is tracked where reports by themselves line up by no more than chance does."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.config import load_configuration
from trackweave.estimation.estimate import estimate
from trackweave.metrics import assignment_quality
from trackweave.run.wider_search import widely_searched

pytestmark = pytest.mark.slow

SCANS = 60


def recording(way, count: int, sigma: float, seen: float, false: float, size: float):
    """Return a look a second at objects that go their way, and what is nobody's."""
    rng = np.random.default_rng(3)
    rows = []
    for now in np.arange(float(SCANS)):
        for each in range(count):
            if rng.random() < seen:
                rows.append((now, *(way(each, now) + rng.normal(0.0, sigma, 2)), str(each)))
        rows += [(now, *rng.uniform(-size, size, 2), "") for _ in range(rng.poisson(false))]
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row")


def circling(each: int, now: float) -> np.ndarray:
    """Return a place on a circle of 30 m that takes eight looks."""
    turn = 0.83 * now + each
    return 200.0 * np.array([each, -each]) + 30.0 * np.array([np.cos(turn), np.sin(turn)])


def straight(each: int, now: float) -> np.ndarray:
    """Return a place on a straight way."""
    way = 2.4 * each
    return np.array([300.0 * each, -100.0 * each]) + 40.0 * now * np.array(
        [np.cos(way), np.sin(way)]
    )


def test_what_stands_still_at_times_hides_nothing_that_goes_as_far_as_the_next_is_off() -> None:
    # A belt goes 0.9 m from frame to frame but for two stops; parcels are 0.5 to 1.5 m apart.
    rng, rows, moved = np.random.default_rng(3), [], 0.0
    start = -np.cumsum(rng.uniform(0.5, 1.5, 220))
    for now in range(200):
        for parcel in np.flatnonzero((start + moved > 0.0) & (start + moved < 7.0)):
            if rng.random() < 0.96:
                place = (start[parcel] + moved, 0.1 + 0.5 * ((7 * parcel) % 10) / 10)
                rows.append((float(now), *(place + rng.normal(0.0, 0.02, 2)), str(parcel)))
        moved += 0.0 if now % 90 > 78 else 0.9
    table = pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row")
    result = tw.track(table.drop("target"))
    quality = assignment_quality(table["target"].to_list(), result.reports["track"].to_list())
    assert quality.idf1 > 0.8


def apart(each: int, now: float) -> np.ndarray:
    """Return a place a thousand kilometres from all others."""
    return np.array([1e6 * each + now, 0.5 * now])


@pytest.mark.parametrize(
    "told",
    [(circling, 3, 1.0, 0.95, 1.0, 500.0), (circling, 1, 1.0, 0.95, 0.0, 1.0),
     (straight, 3, 5.0, 0.5, 5.0, 3e3),
     (apart, 2, 1.0, 1.0, 0.0, 1.0)],
    ids=["circles", "a circle", "half seen", "far apart"],
)  # fmt: skip
def test_what_hardly_lines_up_is_tracked(told):
    table = recording(*told)
    result = tw.track(table.drop("target"))
    whose = [each or None for each in table["target"]]
    quality = assignment_quality(whose, result.reports["track"].to_list())
    assert quality.idf1 > 0.9


def test_what_darts_in_three_dimensions_is_tracked():
    rng, rows = np.random.default_rng(3), []
    for each in range(5):
        place, velocity = rng.uniform([-800.0, -800.0, 40.0], [800.0, 800.0, 140.0]), np.zeros(3)
        for now in range(150):
            if now % 20 == 0:
                way = rng.uniform(0.0, 2.0 * np.pi)
                wanted = 15.0 * (now % 40 == 0) * np.array([np.cos(way), np.sin(way), 0.0])
            velocity = velocity + np.clip(wanted - velocity, -5.0, 5.0)
            place = place + velocity
            if rng.random() < 0.55:
                rows.append((float(now), *(place + rng.normal(0.0, 8.0, 3)), str(each)))
    for now in range(150):
        for _ in range(rng.poisson(12)):
            rows.append((float(now), *rng.uniform([-1500, -1500, 0], [1500, 1500, 400]), None))
    table = pl.DataFrame(rows, ["time", "x", "y", "z", "target"], orient="row")
    result = tw.track(table.drop("target"))
    quality = assignment_quality(table["target"].to_list(), result.reports["track"].to_list())
    assert quality.idf1 > 0.85


def test_of_false_alarms_in_three_dimensions_nothing_is_found():
    table = recording(straight, 0, 1.0, 1.0, 30.0, 500.0).drop("target")
    high = np.random.default_rng(4).uniform(-500.0, 500.0, len(table))
    reports = tw.read_reports(table.with_columns(z=high))
    assert widely_searched(estimate(reports), reports, load_configuration({})) is None


@pytest.mark.parametrize("false", [3.0, 30.0])
def test_of_false_alarms_alone_nothing_is_found(false):
    table = recording(straight, 0, 1.0, 1.0, false, 500.0)
    reports = tw.read_reports(table.drop("target"))
    assert widely_searched(estimate(reports), reports, load_configuration({})) is None


def test_too_few_looks_tell_nothing():
    reports = tw.read_reports(recording(apart, 2, 1.0, 1.0, 0.0, 1.0).drop("target").head(8))
    assert widely_searched(estimate(reports), reports, load_configuration({})) is None
