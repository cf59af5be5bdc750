"""What is told of a sensor's biases is taken out of its reports."""

import numpy as np
import polars as pl
import pytest

from trackweave.config import load_configuration
from trackweave.errors import InvalidInputError
from trackweave.run.biases import as_key, told_biases, unbiased
from trackweave.run.tracking import report_table

POLAR = pl.DataFrame(
    {
        "time": [0.0, 0.4, 1.0],
        "sensor": ["b", "a", "b"],
        "range_m": [1100.0, 900.0, 1200.0],
        "azimuth_deg": [0.5, 90.0, 180.0],
        "remark": ["x", "y", "z"],
    }
)


def mended(frame, **keys):
    configuration = load_configuration({"sensors": keys})
    table, _ = report_table(frame, configuration)
    return unbiased(table, told_biases(table, configuration.sensor))


def test_ranges_and_azimuths_are_those_without():
    table = mended(POLAR, b={"range_bias_m": 100.0, "range_scale": 2.0, "azimuth_bias_deg": 1.0})
    np.testing.assert_allclose(table.measurement[:, 0], [500.0, 900.0, 550.0])
    np.testing.assert_allclose(np.degrees(table.measurement[:, 1]), [359.5, 90.0, 179.0])


def test_a_clock_that_is_ahead_changes_the_order_and_nothing_gets_lost():
    table = mended(POLAR, b={"clock_offset": 0.5})
    np.testing.assert_allclose(table.time, [-0.5, 0.4, 0.5])
    table = mended(POLAR, a={"clock_offset": 0.5})
    np.testing.assert_allclose(table.time, [-0.1, 0.0, 1.0])
    assert table.row.tolist() == [2, 1, 3]
    assert list(table.carried["remark"]) == ["y", "x", "z"]


def test_positions_are_shifted_back():
    frame = pl.DataFrame({"time": [0.0], "x": [10.0], "y": [20.0]})
    table = mended(frame, default={"translation": [3.0, -4.0]})
    assert table.measurement.tolist() == [[7.0, 24.0]]


def test_without_any_the_table_is_the_same():
    table, _ = report_table(POLAR, load_configuration(None))
    assert unbiased(table, np.zeros((2, 4))) is table


def test_a_bias_that_a_sensor_cannot_have_is_refused_with_those_that_it_can():
    with pytest.raises(InvalidInputError, match=r"sensors\.b\.translation: .*range_bias_m"):
        mended(POLAR, b={"translation": [1.0, 2.0]})


def test_keys_say_what_they_were_told():
    bias = np.array([5.0, 0.001, np.radians(0.3), 0.5])
    assert as_key("range_scale", bias) == pytest.approx(1.001)
    assert as_key("azimuth_bias_deg", bias) == pytest.approx(0.3)
    assert as_key("range_scale", bias, is_sigma=True) == pytest.approx(0.001)
