"""Biases undone: by hand, against numerical derivatives, and what makes no model."""

import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.fusion.bias import BiasModel

MEAN = np.array([[3000.0, 4000.0, 100.0, -50.0], [-2000.0, 500.0, -20.0, 80.0]])
MEAN_3D = np.array([[3000.0, 4000.0, 900.0, 100.0, -50.0, 5.0]])
ALL = {
    2: np.array([100.0, -30.0, 0.05, 20.0, 0.02, 0.7]),
    3: np.array([100.0, -30.0, 15.0, 0.05, 20.0, 0.02, 0.7]),
}


def moving(**biases: float) -> np.ndarray:
    names = BiasModel().names(2)
    return np.array([biases.get(name, 0.0) for name in names])


def test_no_bias_changes_nothing() -> None:
    assert BiasModel().corrected(MEAN, moving()) == pytest.approx(MEAN)


def test_a_translation_is_taken_off() -> None:
    back = BiasModel().corrected(MEAN, moving(translation_x=100.0, translation_y=-30.0))
    assert back[0] == pytest.approx([2900.0, 4030.0, 100.0, -50.0])


@pytest.mark.parametrize("name", ["rotation", "azimuth"])
def test_a_clockwise_turn_about_the_sensor_is_turned_back(name: str) -> None:
    model = BiasModel((name,), position=(1000.0, 0.0))
    # What was north of the sensor was reported east of it.
    back = model.corrected(np.array([[3000.0, 0.0, 5.0, 0.0]]), moving(**{name: np.pi / 2}))
    assert back[0] == pytest.approx([1000.0, 2000.0, 0.0, 5.0])


def test_a_range_that_is_too_long_is_shortened_along_the_line_of_sight() -> None:
    back = BiasModel(("range",)).corrected(MEAN[:1], moving(range=500.0))
    assert back[0, :2] == pytest.approx([2700.0, 3600.0])


def test_a_clock_that_is_ahead_reports_states_of_too_long_ago() -> None:
    back = BiasModel().corrected(MEAN, moving(clock=2.0))
    assert back[0] == pytest.approx([3200.0, 3900.0, 100.0, -50.0])


@pytest.mark.parametrize("mean", [MEAN, MEAN_3D])
def test_derivatives_are_those_of_small_steps(mean: np.ndarray) -> None:
    dim = mean.shape[1] // 2
    model = BiasModel(("translation", "range", "azimuth", "clock"), position=(500.0, -200.0))
    bias = ALL[dim]
    gradient = model.gradient(mean, bias)
    assert gradient.mean == pytest.approx(model.corrected(mean, bias))
    for place in range(2 * dim):
        step = np.zeros(2 * dim)
        step[place] = 1e-2
        slope = (model.corrected(mean + step, bias) - model.corrected(mean - step, bias)) / 2e-2
        # How a velocity depends on the position, by way of a range bias, is left out.
        rows = slice(dim) if place < dim else slice(2 * dim)
        assert gradient.by_state[:, rows, place] == pytest.approx(slope[:, rows], abs=2e-3)
    for place, is_free in enumerate(model.is_estimated(dim)):
        step = np.zeros(bias.shape)
        step[place] = 1e-4
        slope = (model.corrected(mean, bias + step) - model.corrected(mean, bias - step)) / 2e-4
        wanted = slope if is_free else np.zeros_like(slope)
        assert gradient.by_bias[:, :, place] == pytest.approx(wanted, rel=1e-4, abs=1e-3)


def test_every_row_may_have_its_own_bias() -> None:
    biases = np.stack([ALL[2], 2.0 * ALL[2]])
    model = BiasModel(("translation", "rotation"))
    apart = [model.corrected(MEAN[[row]], biases[row])[0] for row in range(2)]
    assert model.corrected(MEAN, biases) == pytest.approx(np.stack(apart))


def test_names_follow_one_order_whatever_is_asked_for() -> None:
    model = BiasModel(("clock", "translation"))
    assert model.estimate == ("translation", "clock")
    assert model.names(3)[:4] == ("translation_x", "translation_y", "translation_z", "rotation")
    assert model.is_estimated(2).tolist() == [True, True, False, False, False, True]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"estimate": ("shift",)}, "estimate: .*expected some of translation, rotation"),
        ({"estimate": ()}, "expected some of translation"),
        ({"estimate": ("clock", "clock")}, "each once"),
        (
            {"estimate": ("rotation", "azimuth")},
            "rotation and azimuth, which cannot be told apart",
        ),
        ({"position": (0.0,)}, r"position: .*expected x, y\[, z\]"),
        ({"position": (0.0, np.nan)}, "each entry a finite number"),
        ({"prior": {"range": 5.0}}, "prior: 'range'; expected names of what is estimated"),
        ({"prior": {"clock": 0.0}}, r"prior, clock: 0.0; expected a number > 0 \[s\]"),
    ],
)
def test_refuses_what_is_no_model(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        BiasModel(**arguments)  # type: ignore[arg-type]
