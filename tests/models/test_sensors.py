import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.models.sensors import Sensor

GOOD = {
    "name": "radar",
    "sigma": 10.0,
    "detection_probability": 0.9,
    "clutter_density": 1e-5,
    "scan_period": 1.0,
}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("sigma", 0.0),
        ("sigma", (10.0, -1.0)),
        ("sigma", np.nan),
        ("sigma", np.inf),
        ("detection_probability", 0.0),
        ("detection_probability", 1.0),
        ("detection_probability", np.nan),
        ("clutter_density", 0.0),
        ("clutter_density", np.inf),
        ("clutter_density", np.nan),
        ("scan_period", 0.0),
        ("scan_period", -4.0),
        ("scan_period", np.nan),
    ],
)
def test_refuses_what_no_sensor_can_have(name, value):
    with pytest.raises(InvalidInputError, match=name):
        Sensor(**(GOOD | {name: value}))


def test_one_sigma_serves_all_axes():
    np.testing.assert_array_equal(Sensor(**GOOD).sigmas(3), [10.0, 10.0, 10.0])


def test_sigmas_may_differ_by_axis():
    sensor = Sensor(**(GOOD | {"sigma": (10.0, 20.0)}))
    np.testing.assert_array_equal(sensor.sigmas(2), [10.0, 20.0])
    with pytest.raises(InvalidInputError, match="sigma for 2 axes; expected 1 or 3"):
        sensor.sigmas(3)


def test_a_sensor_need_not_scan():
    assert Sensor(**(GOOD | {"scan_period": None})).scan_period is None
