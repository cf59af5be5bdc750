import math

import numpy as np
import pytest
from scipy.stats import chi2

from trackweave.association.window_rule import (
    GATE_PROBABILITY,
    Context,
    scan_input,
    window_rule,
)
from trackweave.domain.scans import Scan
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor

MOTION = ConstantVelocity(0.1, 30.0)
CONTEXT = Context(MOTION, 2)
SENSOR = Sensor("radar", 10.0, 0.9, 1e-5, 1.0)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_gate_lets_its_share_of_own_reports_through(dim):
    rule = window_rule(MOTION, (0.999, 7.0, 5.0, 50.0, 50.0), dim)
    nothing = Scan(0.0, "radar", np.empty((0, dim)))
    data, _ = scan_input(nothing, SENSOR, 0.0, Context(MOTION, dim))
    assert chi2.cdf(data.gate, dim) == pytest.approx(GATE_PROBABILITY)
    assert rule.end_cost == pytest.approx(-math.log(0.001))


def test_sorts_reports_along_x_and_says_how():
    scan = Scan(3.0, "radar", np.array([[5.0, 0.0], [1.0, 1.0], [3.0, 2.0]]))
    data, order = scan_input(scan, SENSOR, 0.5, CONTEXT)
    assert order.tolist() == [1, 2, 0]
    np.testing.assert_array_equal(data.position, scan.measurement[order])
    assert data.slot.tolist() == [0, 1, 2]
    assert data.survival_cost == 0.5
    assert data.log_clutter == pytest.approx(math.log(1e-5))


def test_a_reports_own_noise_goes_before_the_sensors():
    sigma = np.array([[np.nan, np.nan], [3.0, np.nan]])
    scan = Scan(0.0, "radar", np.array([[2.0, 0.0], [1.0, 0.0]]), sigma)
    data, _ = scan_input(scan, SENSOR, 0.0, CONTEXT)
    noise = data.noise[data.setting]
    np.testing.assert_allclose(noise, [np.diag([9.0, 100.0]), np.diag([100.0, 100.0])])


def test_leaves_the_scan_as_it_is():
    measurement = np.array([[5.0, 0.0], [1.0, 1.0]])
    scan_input(Scan(0.0, "radar", measurement), SENSOR, 0.0, CONTEXT)
    np.testing.assert_array_equal(measurement, [[5.0, 0.0], [1.0, 1.0]])
