"""Whoever is fast among many that are slow is seen once these are tracked."""

import numpy as np
import polars as pl
import pytest

from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimate import WIDER, estimate
from trackweave.estimation.unexplained import with_faster
from trackweave.formats.reading import read_reports


def seen(speed: float, count: int, false: float) -> ReportTable:
    """Return sixty pictures of what is so fast, and of false alarms."""
    rng, rows = np.random.default_rng(1), []
    begin, course = rng.uniform(100, 500, (count, 2)), rng.uniform(0, 2 * np.pi, count)
    way = speed * np.stack([np.sin(course), np.cos(course)], axis=1)
    for time in 10.0 * np.arange(60):
        there = begin + (time - 300.0) * way + rng.normal(0, 0.4, (count, 2))
        rows += [(time, *there[k]) for k in np.flatnonzero(rng.random(count) < 0.9)]
        rows += [(time, *at) for at in rng.uniform(0, 600, (rng.poisson(false), 2))]
    return read_reports(pl.DataFrame(rows, ["time", "x", "y"], orient="row"))


def test_the_few_that_are_left_tell_how_fast_they_are() -> None:
    slow = estimate(seen(0.01, 40, 5.0), {}, {"default": True})
    assert slow.max_speed < 0.2
    left = seen(1.3, 3, 10.0)
    found = with_faster(slow, left)
    assert found.max_speed == pytest.approx(WIDER * 1.3, rel=0.02)
    assert found.speed_of_few == pytest.approx(1.3, rel=0.02)


@pytest.mark.parametrize("left", [seen(1.0, 0, 15.0), seen(0.01, 3, 10.0)])
def test_false_alarms_and_the_slow_tell_nothing(left: ReportTable) -> None:
    slow = estimate(seen(0.01, 40, 5.0), {}, {"default": True})
    assert with_faster(slow, left) is slow
