import numpy as np
import pytest

from trackweave.domain.measurements import MeasurementKind as Kind
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
        ("identity_error", 0.0),
        ("identity_error", 1.0),
        ("identity_error", np.nan),
        ("tail_share", 0.6),
        ("tail_share", np.nan),
        ("tail_persistence", 1.0),
        ("tail_persistence", -0.1),
        ("tail_scale", 0.5),
        ("measurement", Kind.RANGE_RATE),
        ("trust", "sigma"),
        ("trust", ("colour",)),
        ("position", (1.0,)),
        ("position", (1.0, 2.0, 3.0, 4.0)),
        ("position", (1.0, np.nan)),
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


@pytest.mark.parametrize(
    ("kind", "dim", "count"),
    [(Kind.RANGE_AZIMUTH, 2, 2), (Kind.RANGE_AZIMUTH_ELEVATION_RATE, 3, 4), (Kind.BEARING, 3, 1)],
)
def test_sigmas_are_of_what_the_sensor_measures(kind, dim, count):
    own = tuple(float(number) for number in range(1, count + 1))
    sensor = Sensor(**(GOOD | {"sigma": own, "measurement": kind}))
    np.testing.assert_array_equal(sensor.sigmas(dim), own)
    wrong = Sensor(**(GOOD | {"sigma": (*own, 1.0), "measurement": kind}))
    with pytest.raises(InvalidInputError, match=f"sigma for {count + 1} axes; expected 1 or"):
        wrong.sigmas(dim)


@pytest.mark.parametrize("position", [None, (7.0, 8.0), (7.0, 8.0, 9.0)])
def test_a_sensor_that_stands_is_a_platform_that_does_not_move(position):
    platform = Sensor(**(GOOD | {"position": position})).platform
    known = position or ()
    assert platform.tolist() == [*known, *[0.0] * (6 - len(known))]


def test_echoes_make_false_alarms_denser_where_they_are():
    echo = (1000.0, 0.0, 50.0, 0.4)
    sensor = Sensor("A", clutter_density=1e-6, echoes=(echo,))
    place = np.array([[1000.0, 0.0], [1050.0, 0.0], [9000.0, 0.0]])
    peak = 0.4 / (2 * np.pi * 50.0**2) / 1e-6
    expected = [1 + peak, 1 + peak * np.exp(-0.5), 1.0]
    np.testing.assert_allclose(sensor.false_alarms(place, np.ones(3)), expected)
    # A unit of range and azimuth is as many square metres as the range has metres.
    np.testing.assert_allclose(sensor.false_alarms(place[:1], np.array([1e3])), 1 + 1e3 * peak)
