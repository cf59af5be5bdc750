"""A satellite that passes now and then, and two sensors that hardly see the same."""

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from estimation.test_estimate import table
from trackweave.estimation.disagreement import disagreements
from trackweave.metrics import assignment_quality


@pytest.mark.slow
def test_scans_hours_apart_at_any_time_are_followed_from_one_to_the_next():
    rng = np.random.default_rng(6)
    passes = np.cumsum(3600.0 * rng.choice([2.3, 5.0, 8.9, 14.2, 21.7], 60))
    place, way = rng.uniform(-2e5, 2e5, (25, 2)), rng.normal(0, 0.08, (25, 2))
    rows, whose = [], []
    for time in passes:
        seen = np.flatnonzero(rng.uniform(size=25) < 0.8)
        there = (place + time * way)[seen] + rng.normal(0, 300, (seen.size, 2))
        false = rng.uniform(-2e5, 2e5, (rng.poisson(3), 2))
        rows += [(time, x, y) for x, y in (*there, *false)]
        whose += [*map(str, seen), *([""] * len(false))]
    reports = pl.DataFrame(rows, schema=["time", "x", "y"], orient="row")
    result = tw.track(reports)
    track = result.assignments["track"].fill_null(-1).to_numpy()
    assert assignment_quality(whose, track).idf1 > 0.9
    used = result.run["configuration"]["sensors"]["default"]
    assert used["scan_period"] == pytest.approx(np.median(np.diff(passes)), rel=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_who_sees_side_by_side_is_compared_where_both_see(seed):
    # One object stands at either side of a border, where one sensor's view ends and the other's
    # begins, and one moves.
    rng = np.random.default_rng(seed)
    number, time, place = [], [], []
    for moment in np.arange(0.0, 60.0, 0.25):
        there = np.concatenate(
            [[(-3.0, 3.0), (3.0, 3.0)], rng.uniform((-30, 0), (30, 20), (1, 2))]
        )
        for index, is_seen in enumerate((there[:, 0] < 0.5, there[:, 0] > -0.5)):
            place += there[is_seen].tolist()
            number += [index] * int(is_seen.sum())
            time += [moment + 0.01 * index] * int(is_seen.sum())
    every = np.array(place) + rng.normal(0, 0.2, (len(place), 2))
    reports = replace(table(np.array(time), every), sensor=np.array(number), sensors=("A", "B"))
    assert disagreements(reports, 1.0) == {}
