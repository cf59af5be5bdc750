"""Differences between tracks told apart from wrong pairs, and from what they cannot tell."""

import numpy as np
import pytest

from oracles.biased_scenes import Scene, Truth, scene
from trackweave.fusion.bias import BiasModel
from trackweave.fusion.bias_fit import NotObservableError, differences, fit_bias
from trackweave.fusion.learning import learned

TRUTH = Truth()
NOTHING = np.zeros(6)


def facts(made: Scene) -> tuple[object, object]:
    return (
        learned(made.reference, TRUTH.process_noise),
        learned(made.other, TRUTH.process_noise),
    )


def squared_error(bias: np.ndarray, covariance: np.ndarray, truth: np.ndarray) -> float:
    known = np.diagonal(covariance) > 0
    error = (bias - truth)[known]
    return float(error @ np.linalg.solve(covariance[np.ix_(known, known)], error))


def test_rows_are_the_times_at_which_both_tracks_of_a_pair_are_there() -> None:
    made = scene(TRUTH, np.random.default_rng(1))
    mine, yours = facts(made)
    rows = differences(mine, yours, made.pairs[:2], np.array([1.0, 0.5]))
    assert rows.pair.tolist() == [0] * TRUTH.n_times + [1] * TRUTH.n_times
    assert rows.trust[[0, -1]].tolist() == [1.0, 0.5]
    row = np.flatnonzero(mine.track == made.pairs[1, 0])[3]
    assert rows.reference[TRUTH.n_times + 3] == pytest.approx(mine.mean[row])


def test_wrong_pairs_do_not_disturb_the_bias() -> None:
    for seed in range(5):
        made = scene(TRUTH, np.random.default_rng(seed))
        wrong = made.pairs.copy()
        wrong[:3, 1] = np.roll(wrong[:3, 1], 1)
        rows = differences(*facts(made), wrong, np.ones(10))
        fit = fit_bias(rows, BiasModel(), NOTHING, check=True)
        assert fit.used[:3].max() < 0.2
        assert fit.used[3:].min() > 0.9
        assert squared_error(fit.bias, fit.covariance, TRUTH.numbers()) < 20.0


def test_a_prior_moves_what_the_tracks_leave_open() -> None:
    made = scene(Truth(headings=0.0, n_objects=4), np.random.default_rng(3))
    rows = differences(*facts(made), made.pairs, np.ones(4))
    fit = fit_bias(
        rows, BiasModel(("translation",), prior={"translation": 1e-3}), NOTHING, check=True
    )
    assert np.abs(fit.bias).max() < 0.1


def test_errors_that_are_greater_than_stated_widen_the_answer() -> None:
    made = scene(TRUTH, np.random.default_rng(4))
    rows = differences(*facts(made), made.pairs, np.ones(10))
    boasting = rows._replace(
        reference_information=9 * rows.reference_information,
        other_information=9 * rows.other_information,
    )
    honest, wide = (fit_bias(some, BiasModel(), NOTHING, check=True) for some in (rows, boasting))
    assert wide.scale == pytest.approx(9 * honest.scale, rel=0.3)
    assert np.diagonal(wide.covariance) == pytest.approx(np.diagonal(honest.covariance), rel=0.5)


def test_refuses_what_no_difference_tells() -> None:
    made = scene(TRUTH, np.random.default_rng(5))
    rows = differences(*facts(made), made.pairs, np.zeros(10))
    with pytest.raises(NotObservableError, match="the tracks leave it as uncertain as it was"):
        fit_bias(rows, BiasModel(), NOTHING, check=True)
