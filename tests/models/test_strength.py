import numpy as np
import pytest
from scipy.stats import norm

from trackweave.errors import InvalidInputError
from trackweave.models.strength import StrengthModel

LOUD = StrengthModel(target_mean=12.0, target_sigma=4.0, clutter_mean=6.0, clutter_sigma=3.0)


def test_evidence_is_the_logarithm_of_the_ratio_of_densities():
    strength = np.linspace(0.0, 16.0, 33)
    ratio = norm.logpdf(strength, 12.0, 4.0) - norm.logpdf(strength, 6.0, 3.0)
    assert np.abs(ratio).max() < 8.0
    np.testing.assert_allclose(LOUD.evidence(strength), ratio, atol=1e-12)


def test_tails_are_trusted_only_so_far():
    assert LOUD.evidence(np.array([1e6, 40.0])).tolist() == [8.0, 8.0]
    quiet = StrengthModel(12.0, 1.0, 6.0, 3.0)
    assert quiet.evidence(np.array([-100.0])).tolist() == [-8.0]


def test_a_report_without_strength_says_nothing():
    np.testing.assert_array_equal(LOUD.evidence(np.array([np.nan, np.nan])), [0.0, 0.0])


def test_objects_as_loud_as_false_alarms_say_nothing():
    same = StrengthModel(6.0, 3.0, 6.0, 3.0)
    np.testing.assert_allclose(same.evidence(np.linspace(-9.0, 20.0, 9)), 0.0, atol=1e-12)


@pytest.mark.parametrize("name", ["target_mean", "target_sigma", "clutter_mean", "clutter_sigma"])
@pytest.mark.parametrize("value", [np.nan, np.inf, 0.0, -1.0])
def test_refuses_what_is_no_curve(name, value):
    if np.isfinite(value) and name.endswith("mean"):
        value = np.nan
    good = {"target_mean": 1.0, "target_sigma": 1.0, "clutter_mean": 0.0, "clutter_sigma": 1.0}
    with pytest.raises(InvalidInputError, match=name):
        StrengthModel(**(good | {name: value}))


def test_objects_small_and_large_are_as_likely_within_their_spread():
    model = StrengthModel(20.0, 3.0, 10.0, 3.0, target_spread=6.0)
    alike = StrengthModel(20.0, 3.0, 10.0, 3.0)
    strength = np.array([14.0, 17.0, 20.0, 26.0])
    clutter = (strength - 10.0) ** 2 / (2 * 3.0**2)
    np.testing.assert_allclose(model.evidence(strength), np.minimum(clutter, 8.0))
    # Beyond it the curve is that of one object.
    beyond = model.evidence(np.array([11.0])) - alike.evidence(np.array([17.0]))
    np.testing.assert_allclose(beyond, (1.0 - 7.0**2) / (2 * 3.0**2))
    with pytest.raises(InvalidInputError, match="target_spread"):
        StrengthModel(1.0, 1.0, 0.0, 1.0, target_spread=-1.0)
