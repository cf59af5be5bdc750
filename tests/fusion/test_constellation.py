"""The pattern of tracks tells a great bias, and says no where there is none."""

import numpy as np
import pytest

from oracles.biased_scenes import Truth, scene
from trackweave.fusion.bias import BiasModel
from trackweave.fusion.constellation import guess_bias


@pytest.mark.parametrize("n_objects", [3, 12, 40])
def test_guesses_within_what_it_says_of_its_errors(n_objects: int) -> None:
    for seed in range(3):
        truth = Truth(n_objects=n_objects, translation=(4000.0, -3000.0), angle=0.1, late=2.0)
        made = scene(truth, np.random.default_rng(seed))
        guess = guess_bias(made.reference[-1], made.other[-1], BiasModel())
        assert guess is not None
        error = guess.bias - truth.numbers()
        known = BiasModel().is_estimated(2)
        spread = guess.covariance[np.ix_(known, known)]
        assert error[known] @ np.linalg.solve(spread, error[known]) < 25.0


def test_finds_no_pattern_where_there_is_none() -> None:
    for seed in range(5):
        mine, others = (scene(Truth(), np.random.default_rng(seed + start)) for start in (0, 100))
        assert guess_bias(mine.reference[-1], others.other[-1], BiasModel()) is None


def test_two_tracks_make_no_pattern() -> None:
    made = scene(Truth(n_objects=2), np.random.default_rng(1))
    assert guess_bias(made.reference[-1], made.other[-1], BiasModel()) is None
