"""Names of boxes stay open for as long as is asked."""

import numpy as np
import pytest

import trackweave as tw
from oracles.boxes import SURE, box, followed


@pytest.mark.slow
@pytest.mark.parametrize("rejoin", [10.0, 60.0])
@pytest.mark.parametrize("window", [0, 3])
def test_a_name_is_open_for_as_long_as_is_asked(rejoin: float, window: int) -> None:
    rng = np.random.default_rng(5)
    for silence, expected in ((0.9 * rejoin, [1, 2]), (1.1 * rejoin, [2, 3])):
        tracker = tw.BoxTracker(period=0.1, rejoin=rejoin, window=window)
        frames = []
        for k in range(20 + round(silence / 0.1) + 5):
            is_away = 20 <= k < 20 + round(silence / 0.1)
            places = [(400.0, 300.0)] if is_away else [(100.0, 100.0), (400.0, 300.0)]
            boxes = np.array([box(*place) for place in places]) + rng.normal(0, 0.5, 4)
            frames.append(tracker.update(boxes, [SURE] * len(boxes)))
            assert is_away or k < 20 or frames[-1].identifiers[-1] == 2
        assert sorted(frames[-1].identifiers.tolist()) == expected
        away = [track for track in frames[-6].tracks if track.identifier == 1]
        assert [track.visible for track in away] == ([False] if expected == [1, 2] else [])


def test_what_comes_elsewhere_has_a_name_of_its_own_while_another_is_open() -> None:
    tracker = followed(20, period=0.1, rejoin=60.0)
    for k in range(300):
        frame = tracker.update([box(600.0 + k, 400.0)], [SURE])
    assert frame.identifiers.tolist() == [2]
    assert sorted(track.identifier for track in frame.tracks) == [1, 2]
