"""What stays at one place all the time is an object, or where that is told an echo."""

import numpy as np
import polars as pl
import pytest

from trackweave import track
from trackweave.metrics import assignment_quality

SITE = np.array([0.0, -50.0])


@pytest.fixture(scope="module")
def walkers() -> pl.DataFrame:
    """Six who walk among a dozen fixed places that are seen more and less often."""
    rng, rows = np.random.default_rng(4), []
    places, share = rng.uniform(0.0, 400.0, (12, 2)), rng.uniform(0.45, 0.9, 12)
    at, heading = rng.uniform(50.0, 350.0, (6, 2)), rng.uniform(0.0, 2.0 * np.pi, 6)
    for scan in range(80):
        heading += rng.normal(0.0, 0.1, 6)
        at += 3.0 * np.stack([np.sin(heading), np.cos(heading)], axis=1)
        seen = [("", each) for each in places[rng.random(12) < share]]
        seen += [(str(k), at[k]) for k in np.flatnonzero(rng.random(6) < 0.92)]
        for whose, place in seen:
            x, y = place + rng.normal(0.0, 1.5, 2)
            rows.append((2.5 * scan, x, y, whose))
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row")


def as_ranges(walkers: pl.DataFrame) -> pl.DataFrame:
    """Return the same as a radar tells it."""
    away = walkers.select("x", "y").to_numpy() - SITE
    azimuth = np.degrees(np.arctan2(*away.T)) % 360.0
    return pl.DataFrame(
        {"time": walkers["time"], "range_m": np.hypot(*away.T), "azimuth_deg": azimuth}
    )


@pytest.mark.slow
@pytest.mark.parametrize("ranges", [False, True])
def test_echoes_that_are_seen_nearly_as_often_as_objects_are_none_where_that_is_told(
    walkers: pl.DataFrame, ranges: bool
) -> None:
    reports = as_ranges(walkers) if ranges else walkers.drop("target")
    told = {"sensors": {"default": {"position": [*SITE]}}} if ranges else {}
    plain = track(reports, told)
    (note,) = [each for each in plain.run["notes"] if "at_rest" in each]
    assert "tracks stay at one place" in note
    result = track(reports, {**told, "lifecycle": {"at_rest": "echoes"}})
    whose = walkers["target"].to_list()
    first, second = (
        assignment_quality(whose, each.assignments["track"].fill_null(-1).to_list()).idf1
        for each in (plain, result)
    )
    assert second > max(0.95, first + 0.2)
    assert not [each for each in result.run["notes"] if "at_rest" in each or "only" in each]


def test_objects_that_rest_beside_others_that_are_seen_as_often_are_not_asked_about() -> None:
    rng, rows = np.random.default_rng(5), []
    places = rng.uniform(0.0, 400.0, (8, 2))
    for scan in range(60):
        moved = [*places[:6], places[6] + 4.0 * scan, places[7] - 4.0 * scan]
        for place in moved:
            if rng.random() < 0.9:
                rows.append((2.5 * scan, *(place + rng.normal(0.0, 1.5, 2))))
    run = track(pl.DataFrame(rows, ["time", "x", "y"], orient="row")).run
    assert not [each for each in run["notes"] if "at_rest" in each]
