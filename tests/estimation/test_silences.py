"""Pauses, and what they tell of hiding."""

import numpy as np
import pytest

from trackweave.estimation.silences import USUAL_SHARE, USUAL_SILENCE, long_pauses, silences
from trackweave.trackers.lifecycle import Lifecycle


def test_misses_one_by_one_are_no_long_pauses() -> None:
    rng = np.random.default_rng(1)
    for detection in (0.5, 0.8, 0.97):
        pauses = rng.geometric(detection, 2000) - 1
        assert long_pauses(pauses, int(pauses.sum()) + pauses.size).sum() <= 1


def test_pauses_longer_than_chance_are_long() -> None:
    pauses = np.random.default_rng(3).geometric(0.9, 500) - 1
    pauses[[7, 100, 400]] = [30, 25, 40]
    assert np.flatnonzero(long_pauses(pauses, int(pauses.sum()) + 500)).tolist() == [7, 100, 400]


def test_long_pauses_do_not_hide_one_another() -> None:
    """A radar that never sees two tracks of five: their pauses seem to be its usual misses."""
    seen = np.random.default_rng(4).geometric(0.8, 200) - 1
    pauses = np.concatenate([seen, np.full(20, 17)])
    chances = int(pauses.sum()) + seen.size
    assert not long_pauses(pauses, chances).any()
    found = long_pauses(pauses, chances, are_most=True)
    assert np.flatnonzero(found).tolist() == list(range(200, 220))


def test_where_none_is_long_that_many_might_be_changes_nothing() -> None:
    rng = np.random.default_rng(1)
    for detection in (0.5, 0.8, 0.97):
        pauses = rng.geometric(detection, 2000) - 1
        chances = int(pauses.sum()) + pauses.size
        assert long_pauses(pauses, chances, are_most=True).sum() <= 1


def test_rates_are_those_of_the_chain_that_made_the_pauses() -> None:
    rng = np.random.default_rng(3)
    gaps = []
    for _ in range(50):
        pauses = rng.geometric(0.9, 200) - 1
        pauses[rng.integers(0, 200, 4)] = 20 + rng.integers(-2, 3, 4)
        gaps.append((pauses + 1.0, pauses))
    share, silence = silences(gaps)
    hidden = sum(time[pause > 15].sum() for time, pause in gaps)
    assert share == pytest.approx(hidden / sum(time.sum() for time, _ in gaps), rel=0.1)
    assert silence == pytest.approx(20.0, rel=0.1)


def test_one_short_silence_tells_little_of_how_long_they_last() -> None:
    pauses = np.zeros(3000, dtype=np.int64)
    pauses[100] = 4
    _, silence = silences([(4.0 * (pauses + 1.0), pauses)])
    assert 25.0 < silence < 40.0  # Between its 16 s and the usual 60 s.


def test_without_silences_what_is_usual_stands() -> None:
    assert silences([]) == (USUAL_SHARE, USUAL_SILENCE)
    usual = Lifecycle()
    assert (usual.hidden_share, usual.mean_silence) == (USUAL_SHARE, USUAL_SILENCE)
    share, silence = silences([(np.ones(50), np.zeros(50, dtype=np.int64))])
    assert silence == USUAL_SILENCE
    assert 0.003 <= share <= USUAL_SHARE
