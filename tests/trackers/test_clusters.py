"""Clusters of a tracker's window: what they cost adds up to the answer, inactive ones too."""

import numpy as np
import pytest

from oracles.scenes import tracker
from trackers.test_inactive_clusters import ALL_INACTIVE, NONE_INACTIVE, quarters, scans
from trackweave.association import inactive


@pytest.mark.parametrize("little", [ALL_INACTIVE, NONE_INACTIVE])
@pytest.mark.parametrize("seed", [1, 2])
def test_cost_what_the_answer_does_and_have_each_report_once(monkeypatch, little, seed):
    monkeypatch.setattr(inactive, "LITTLE", little)
    target, seen = tracker(*quarters(), window=4), 0
    for scan in scans(seed):
        hypothesis = target.step(scan)
        clusters = target.clusters()
        assert clusters.cost.sum() == pytest.approx(hypothesis.certificate.cost)
        pairs = np.unique(np.stack([clusters.report, clusters.owner]), axis=1)
        assert np.unique(pairs[0]).size == pairs.shape[1]
        told = target.pending()
        taken = told.report[told.track >= 0]
        assert np.isin(taken, pairs[0]).all()
        without = np.setdiff1d(np.arange(clusters.cost.size), clusters.owner)
        assert np.isfinite(clusters.place[without]).all()
        seen = max(seen, clusters.cost.size)
    assert seen > 5


def test_are_none_before_the_first_scan():
    assert tracker(*quarters()).clusters().cost.size == 0
