"""A radar over the sea: false alarms that last for a scan or two are no objects."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.metrics import assignment_quality

pytestmark = pytest.mark.slow

SIGMA, SIDE, N_SCANS = 10.0, 3000.0, 70


def sea(seed, chance=0.4):
    """Return reports of ships, buoys and the sea, and whose each is."""
    rng = np.random.default_rng(seed)
    place = rng.uniform(0.2 * SIDE, 0.8 * SIDE, (6, 2))
    velocity = np.where(np.arange(6)[:, None] < 3, rng.normal(0, 8, (6, 2)), 0.0)
    rows, whose, live = [], [], []
    for scan in range(N_SCANS):
        live = [each for each in live if rng.uniform() < chance]
        live += [*rng.uniform(0, SIDE, (18, 2))]
        seen = np.flatnonzero(rng.uniform(size=6) < 0.9)
        at = [*(place + 2.0 * scan * velocity)[seen], *live]
        for where in at:
            rows.append((2.0 * scan, *rng.normal(where, SIGMA)))
        whose += [*map(str, seen), *([""] * len(live))]
    return pl.DataFrame(rows, schema=["time", "x", "y"], orient="row"), np.array(whose)


def judged(result, whose):
    """Return the IDF1, and how many tracks are mostly of false alarms."""
    track = result.assignments["track"].fill_null(-1).to_numpy()
    false = sum(np.mean(whose[track == each] == "") > 0.5 for each in np.unique(track[track >= 0]))
    return float(assignment_quality([*whose], track).idf1), false


def test_what_comes_again_is_learned_and_proven_against():
    reports, whose = sea(1)
    result = tw.track(reports)
    learned = result.run["configuration"]["sensors"]["default"]["clutter_persistence"]
    assert 0.25 <= learned <= 0.55
    assert any("come again at their place" in note for note in result.run["notes"])
    assert not any("reports are in tracks" in note for note in result.run["notes"])
    quality, false = judged(result, whose)
    off = tw.track(reports, {"sensors": {"default": {"clutter_persistence": 0.0}}})
    worse, more = judged(off, whose)
    assert quality > 0.9
    assert false <= 1
    assert quality > worse
    assert more > false + 5


def test_nothing_is_learned_where_each_is_for_itself():
    reports, whose = sea(2, chance=0.0)
    result = tw.track(reports)
    assert result.run["configuration"]["sensors"]["default"]["clutter_persistence"] == 0.0
    assert judged(result, whose)[0] > 0.9
