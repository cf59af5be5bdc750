"""Small recordings, as somebody who tries it makes them first: nothing told, hardly any noise."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.metrics import assignment_quality

STEP = 10.0


def quality(frame: pl.DataFrame, told: Mapping[str, Any] | None = None) -> float:
    """Return the IDF1 of tracks of a table whose last column is the target."""
    target = frame["target"].to_list()
    result = tw.track(frame.drop("target"), told)
    found = assignment_quality(target, result.reports["track"].to_list()).idf1
    return 0.0 if found is None else found


def tags(count: int, seed: int, *, loose: float, lost: float = 0.05) -> pl.DataFrame:
    """Return tags that report themselves every ten seconds, each at its own phase."""
    rng, rows = np.random.default_rng(seed), []
    for tag in range(count):
        time = np.arange(rng.uniform(0.0, STEP), 400.0, STEP)
        time = time + rng.uniform(-loose, loose, time.size) * STEP
        time = np.round(time[rng.random(time.size) >= lost], 3)
        way = rng.uniform(0.0, 2.0 * np.pi)
        place = rng.uniform(-1000.0, 1000.0, 2) + np.outer(
            time, 2.0 * np.array([np.cos(way), 0.6])
        )
        place += rng.normal(0.0, 5.0, place.shape)
        rows += [(now, *at, str(tag)) for now, at in zip(time, place, strict=True)]
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row").sort("time")


@pytest.mark.slow
@pytest.mark.parametrize("loose", [0.0, 0.1])
@pytest.mark.parametrize("count", [2, 3, 6])
@pytest.mark.parametrize("seed", [11, 12])
def test_tags_without_names_keep_theirs(count: int, loose: float, seed: int) -> None:
    assert quality(tags(count, seed, loose=loose)) > 0.75


@pytest.mark.parametrize("seed", [11, 12, 13])
def test_two_tags_are_followed_whether_it_is_told_that_nobody_looks(seed: int) -> None:
    told = {"sensors": {"default": {"scans": False}}}
    assert quality(tags(2, seed, loose=0.1), told) > 0.95


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 5])
@pytest.mark.parametrize("seed", [21, 23])
def test_who_has_a_name_keeps_it_at_any_phase(count: int, seed: int) -> None:
    frame = tags(count, seed, loose=0.1)
    frame = frame.with_columns(identity=pl.col("target")).select(
        "time", "x", "y", "identity", "target"
    )
    assert quality(frame) > 0.7


@pytest.mark.parametrize("speed", [0.0, 1.1, 2.0, 11.0])
@pytest.mark.parametrize("seed", range(4))
def test_one_object_alone_is_one_track_however_slow(speed: float, seed: int) -> None:
    rng, time = np.random.default_rng(seed), np.arange(30.0)
    place = np.outer(time, [speed, 0.5 * speed]) + rng.normal(0.0, 5.0, (30, 2))
    frame = pl.DataFrame({"time": time, "x": place[:, 0], "y": place[:, 1], "target": ["1"] * 30})
    assert quality(frame) > 0.9


def test_slices_of_a_pass_are_one_scan() -> None:
    # A satellite passes some hours apart; each slice of 100 km along its way has its own time.
    rng, rows, time = np.random.default_rng(5), [], 0.0
    start, speed = rng.uniform(0.0, 3e5, (25, 2)), rng.normal(0.0, 0.1, (25, 2))
    for _ in range(40):
        time += rng.uniform(8.0, 40.0) * 3600.0
        for number, place in enumerate(start + speed * time):
            if rng.random() < 0.9:
                stamp = time + 25.0 * np.floor(place[1] / 1e5)
                rows.append((stamp, *(place + rng.normal(0.0, 100.0, 2)), str(number)))
    frame = pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row").sort("time")
    result = tw.track(frame.drop("target"))
    assert any("slice by slice" in note for note in result.run["notes"])
    assert quality(frame) > 0.95
