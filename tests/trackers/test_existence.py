"""How probable it is that an object is there, and in sight."""

import numpy as np
import pytest

from oracles.scenes import MOTION, run, scan, sensor
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker

SEEN, SILENT = 12, 8


def rows_of(tracker):
    """Return each scan's row of one object that is seen for a while, and then not."""
    nobody = np.empty((0, 2))
    scans = [
        scan(
            float(time),
            np.array([[20.0 * time, 0.0]]) if time < SEEN else nobody,
            "a",
            [time] * (time < SEEN),
        )
        for time in range(SEEN + SILENT)
    ]
    return [hypothesis.tracks for hypothesis in run(tracker, scans)]


def test_silence_first_says_out_of_sight_and_then_gone():
    tracker = MultiHypothesisTracker(
        motion=MOTION, sensors=[sensor("a")], window=3, lifecycle=Lifecycle(hidden_share=0.05)
    )
    rows = rows_of(tracker)
    assert rows[SEEN - 1].existence[0] > 0.99
    silent = [each for each in rows[SEEN:] if len(each)]
    visible = [rows[SEEN - 1].visible[0], *(each.visible[0] for each in silent)]
    existence = [each.existence[0] for each in silent]
    assert len(silent) >= 2
    assert np.all(np.diff(visible) < 0)
    assert np.all(np.diff(existence) < 0)
    # Rows end with the probability that the object is there and in sight.
    assert all(each.visible[0] * each.existence[0] >= 0.5 for each in silent)
    assert len(rows[-1]) == 0


@pytest.mark.parametrize("name", ["existence", "visible"])
def test_a_method_without_beliefs_tells_neither(name):
    rows = rows_of(NearestNeighbourTracker(motion=MOTION, sensors=[sensor("a")]))
    assert np.isnan(getattr(rows[SEEN - 1], name)).all()
