"""Tests of one sensor's plots."""

import math

import numpy as np
import pytest

from trackweave.association.sensor_plots import SensorPlots
from trackweave.errors import InvalidInputError


def test_one_sigma_serves_every_plot_and_axis():
    plots = SensorPlots([[0, 1], [2, 3]], 5, volume=1.0, false_alarms=1.0)
    assert plots.value.dtype == np.float64
    np.testing.assert_array_equal(plots.sigma, np.full((2, 2), 5.0))
    plots = SensorPlots([[0, 1], [2, 3]], (5, 6), volume=1.0, false_alarms=1.0)
    np.testing.assert_array_equal(plots.sigma, [[5.0, 6.0], [5.0, 6.0]])
    assert not plots.is_bearing


def test_bearings_are_brought_to_one_turn():
    plots = SensorPlots([-0.5, 7.0], 0.1, volume=1.0, false_alarms=1.0, place=(0, 0))
    np.testing.assert_allclose(plots.value, [2 * math.pi - 0.5, 7.0 - 2 * math.pi])
    assert plots.is_bearing


@pytest.mark.parametrize(
    ("value", "changes", "words"),
    [
        ([[0.0, math.nan]], {}, r"value\[0, 1\]: nan"),
        ([[0.0]], {}, "value: .* expected shape"),
        ([[[0.0]]], {}, "value: .* expected shape"),
        (5.0, {}, "value: .* expected shape"),
        ([[0.0, 0.0]], {"sigma": 0.0}, "sigma: 0.0; expected finite numbers > 0"),
        ([[0.0, 0.0]], {"sigma": [1.0, 2.0, 3.0]}, r"sigma: .* shape \(1, 2\)"),
        ([[0.0, 0.0]], {"sigma": "wide"}, "sigma: 'wide'"),
        ([[0.0, 0.0]], {"sigma": 1e-40}, "sigma: 1e-40"),
        ([[0.0, 1e40]], {}, r"value: .* expected numbers within ±1e\+30"),
        ([[0.0, 0.0]], {"volume": -1.0}, "volume: -1.0"),
        ([[0.0, 0.0]], {"false_alarms": 0.0}, "false_alarms: 0.0"),
        ([[0.0, 0.0]], {"detection_probability": 1.0}, "detection_probability: 1.0"),
        ([[0.0, 0.0]], {"place": (0.0,)}, "place: .* expected shape"),
        ([0.0], {}, "place: None; expected where the sensor"),
        ([math.inf], {"place": (0.0, 0.0)}, r"value\[0\]: inf"),
    ],
)
def test_refuses_plots_that_cannot_be(value, changes, words):
    with pytest.raises(InvalidInputError, match=words):
        SensorPlots(value, **{"sigma": 10.0, "volume": 1e6, "false_alarms": 2.0} | changes)


def test_refuses_plots_in_rows_of_different_length():
    with pytest.raises(InvalidInputError, match="expected rows of one length"):
        SensorPlots([[0.0, 1.0], [2.0]], 1.0, 1.0, 1.0)
