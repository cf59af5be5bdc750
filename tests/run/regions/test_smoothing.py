"""Histories in shares are those of one process."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.engine import Outcome
from trackweave.run import tracking
from trackweave.run.history import smoothed_history
from trackweave.run.regions.smoothing import smoothed_on


class Here:
    """Workers that are this process, of which some are lost."""

    def __init__(self, lost: int = -1) -> None:
        self.tasks, self.lost = [], lost

    def submit(self, work, *share):
        self.tasks.append((work, share))

    def gather(self):
        for number, (work, share) in enumerate(self.tasks):
            if number == self.lost:
                yield Outcome(number, error="killed", is_lost=True)
            else:
                yield Outcome(number, work(*share))


@pytest.fixture(scope="module")
def run() -> tuple[ReportTable, dict[int, int], tw.TrackTable, Settings]:
    """What a run smooths: nine objects, two sensors."""
    rng = np.random.default_rng(4)
    rows = [
        (float(scan), "ab"[scan % 2], 500.0 * each + 9.0 * scan + x, y)
        for scan in range(12)
        for each, (x, y) in enumerate(rng.normal(0.0, 2.0, (9, 2)))
        if rng.random() < 0.9
    ]
    given = []

    def kept(*arguments):
        given.append(arguments)
        return smoothed_history(*arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tracking, "smoothed_history", kept)
        tw.track(pl.DataFrame(rows, ["time", "sensor", "x", "y"], orient="row"))
    return given[0][:4]


@pytest.mark.parametrize(("count", "lost"), [(1, -1), (2, -1), (5, 1), (40, 0)])
def test_any_number_of_shares_gives_the_same_history(run, count, lost):
    reports, assignment, tracks, settings = run
    alone = smoothed_history(*run)
    shared, cpu = smoothed_on(Here(lost), count, (reports, assignment, tracks), settings)
    assert 1 <= len(cpu) <= count
    assert len(alone) > 50
    for name in ("time", "track", "status", "mean", "covariance", "score", "hits", "last_update"):
        np.testing.assert_array_equal(getattr(alone, name), getattr(shared, name))
