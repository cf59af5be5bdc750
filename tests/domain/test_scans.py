"""Tests of one sensor's reports at one time."""

import numpy as np
import pytest

from trackweave.domain.scans import Scan
from trackweave.errors import InvalidInputError


@pytest.mark.parametrize("nothing", [[], (), np.empty(0), np.empty((0, 0))])
def test_an_empty_list_is_an_empty_scan(nothing) -> None:
    scan = Scan(1.0, "radar", nothing, sigma=[], report=[])
    assert len(scan) == 0
    assert scan.measurement.shape == scan.sigma.shape == (0, 0)
    assert scan.report.shape == (0,)


def test_an_empty_scan_may_say_its_dimensions() -> None:
    scan = Scan(1.0, "radar", np.empty((0, 3)))
    assert scan.measurement.shape == scan.sigma.shape == (0, 3)


def test_the_sensors_number_and_its_text_are_one_name() -> None:
    assert Scan(1.0, 0, []).sensor == Scan(1.0, np.int64(0), []).sensor == "0"
    with pytest.raises(InvalidInputError, match=r"sensor: None; expected a text"):
        Scan(1.0, None, [])


@pytest.mark.parametrize("time", [np.nan, np.inf, "noon", None, True, np.datetime64("2020-01-01")])
def test_refuses_a_time_that_is_no_finite_number(time) -> None:
    with pytest.raises(InvalidInputError, match=r"time: .*; expected a finite number"):
        Scan(time, "radar", [[1.0, 2.0]])


@pytest.mark.parametrize(
    "values",
    [
        {"measurement": [[1.0, 2.0], [3.0]]},
        {"measurement": [1.0, 2.0]},
        {"measurement": [[1.0, np.nan]]},
        {"sigma": [[1.0, 1.0], [1.0]]},
        {"sigma": [[0.0, 1.0]]},
        {"report": [[1], [1, 2]]},
        {"report": [1, 2]},
        {"height": [1.0, 2.0]},
        {"height": [np.inf]},
        {"height": [-1e9]},
    ],
)
def test_refuses_columns_that_do_not_fit(values) -> None:
    with pytest.raises(InvalidInputError, match=next(iter(values))):
        Scan(**({"time": 1.0, "sensor": "radar", "measurement": [[1.0, 2.0]]} | values))
