"""Rows become reports as the tracker takes them."""

import numpy as np
import polars as pl

from trackweave.domain.measurements import MeasurementKind
from trackweave.models.sensors import Sensor
from trackweave.service.sorting_in import sorted_in
from trackweave.service.spec import Spec


def test_what_is_wrong_with_a_sensor_is_taken_out_of_what_comes_in():
    radar = Sensor("radar", sigma=(30.0, 0.001), measurement=MeasurementKind.RANGE_AZIMUTH)
    biases = {"range_bias_m": 100.0, "azimuth_bias_deg": 1.0, "clock_offset": 0.5}
    columns = {"time": [10.0], "sensor": ["radar"], "range_m": [5100.0], "azimuth_deg": [46.0]}
    spec = Spec({"sensors": {"radar": biases}})
    reports = sorted_in(pl.DataFrame(columns), spec, {"radar": radar}).reports
    assert reports is not None
    assert reports.time.tolist() == [9.5]
    np.testing.assert_allclose(reports.measurement[0, :2], [5000.0, np.radians(45.0)])


def test_positions_of_a_sensor_that_measures_ranges_are_such():
    radar = Sensor("radar", sigma=(30.0, 0.001), measurement=MeasurementKind.RANGE_AZIMUTH)
    told = {"measurement": "range-azimuth", "position": [100.0, 200.0]}
    columns = {"time": [10.0], "sensor": ["radar"], "x": [400.0], "y": [600.0]}
    found = sorted_in(pl.DataFrame(columns), Spec({"sensors": {"radar": told}}), {"radar": radar})
    assert found.reports is not None
    assert found.unfit == {}
    np.testing.assert_allclose(found.reports.measurement[0], [500.0, np.arctan2(300, 400)])
