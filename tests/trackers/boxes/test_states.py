"""The filter of a box's parts, against one with matrices."""

import numpy as np
import pytest

from trackweave.trackers.boxes import states

PARTS = np.array([[10.0, 20.0, 3.0, 4.0]])
FACTOR = np.ones((1, 4))


def one_track() -> states.Tracks:
    one = np.ones(1)
    names = ("visible", "hidden", "hits", "evidence", "score_sum", "last_seen", "score")
    others = dict.fromkeys(names, one) | dict.fromkeys(("kind", "name", "row"), one.astype(int))
    return states.born(PARTS, FACTOR, {**others, "data": np.full(1, None, dtype=object)})


def test_prediction_and_update_are_the_kalman_filters(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(states, "ODD", 1e-12)
    tracks, wait = one_track(), 0.3
    scale = states.mean_extents(PARTS)[0]
    mean = np.array([10.0, 0.0])
    spread = np.diag([(states.ERROR[0] * scale) ** 2, (states.RATE[0] * scale) ** 2])
    move = np.array([[1.0, wait], [0.0, 1.0]])
    noise = (states.CHANGE[0] * scale) ** 2 * np.array(
        [[wait**3 / 3, wait**2 / 2], [wait**2 / 2, wait]]
    )
    states.predict(tracks, FACTOR, wait)
    mean, spread = move @ mean, move @ spread @ move.T + noise
    error = states.columns(states.ERROR, tracks.mean) ** 2
    states.update(tracks, np.array([[1.5, 0.0, 0.0, 0.0]]), error)
    gain = spread[:, 0] / (spread[0, 0] + error[0, 0])
    mean, spread = mean + gain * 1.5, spread - np.outer(gain, spread[0])
    found = [tracks.variance[0, 0], tracks.mixed[0, 0], tracks.rate_variance[0, 0]]
    assert np.allclose(found, [spread[0, 0], spread[0, 1], spread[1, 1]])
    assert np.allclose([tracks.mean[0, 0], tracks.rate[0, 0]], mean)


def test_an_odd_box_moves_a_track_less_than_its_distance_asks() -> None:
    moved = []
    for away in (1.0, 40.0):
        tracks = one_track()
        error = states.columns(states.ERROR, tracks.mean) ** 2
        states.update(tracks, np.array([[away, 0.0, 0.0, 0.0]]), error)
        moved.append((tracks.mean[0, 0] - 10.0) / away)
    assert moved[1] < moved[0] / 3.0


def test_rates_are_forgotten_slowly() -> None:
    tracks = one_track()
    tracks.rate = np.ones((1, 4))
    states.predict(tracks, FACTOR, states.STEADY)
    assert np.allclose(tracks.rate, np.exp(-1.0))
    assert np.allclose(tracks.mean, PARTS + states.STEADY)
