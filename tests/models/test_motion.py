import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.models.motion import ConstantVelocity


@pytest.mark.parametrize("dim", [2, 3])
def test_a_new_velocity_has_the_variance_of_a_uniform_ball(dim):
    rng = np.random.default_rng(1)
    points = rng.uniform(-30.0, 30.0, size=(400_000, dim))
    inside = points[np.sum(points**2, axis=1) <= 900.0]
    expected = ConstantVelocity(0.1, 30.0).velocity_variance(dim)
    assert inside.var(axis=0) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("process_noise", [-1.0, np.nan, np.inf])
def test_refuses_a_process_noise_that_is_none(process_noise):
    with pytest.raises(InvalidInputError, match=r"process_noise: .*m²/s³"):
        ConstantVelocity(process_noise, 30.0)


@pytest.mark.parametrize("max_speed", [0.0, -1.0, np.nan, np.inf])
def test_refuses_a_speed_that_is_none(max_speed):
    with pytest.raises(InvalidInputError, match=r"max_speed: .*m/s"):
        ConstantVelocity(0.1, max_speed)


def test_takes_an_object_that_never_turns():
    assert ConstantVelocity(0.0, 30.0).process_noise == 0.0
