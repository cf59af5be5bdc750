"""Tests of one sensor's reports at one time."""

from dataclasses import fields

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


def test_a_part_has_its_rows_of_every_column() -> None:
    n = 5
    columns = {
        "measurement": np.arange(2.0 * n).reshape(n, 2), "report": np.arange(n) + 7,
        "moments": np.linspace(0.0, 1.0, n), "platform": np.arange(6.0 * n).reshape(n, 6),
        "identity": np.arange(n), "strength": np.arange(n) / n, "height": np.arange(n) * 10.0,
        "covariance": np.eye(2) * np.arange(1.0, n + 1)[:, None, None],
        "context": np.arange(3.0 * n).reshape(n, 3),
    }  # fmt: skip
    scan = Scan(1.0, "radar", **columns, tells_silence=True)
    for rows in ([3, 1], np.array([True, False, True, False, False]), np.array([], dtype=int)):
        part = scan.part(rows, tells_silence=False)
        for each in fields(Scan):
            own, whole = getattr(part, each.name), getattr(scan, each.name)
            if each.name in ("time", "sensor"):
                assert own == whole
            elif each.name == "tells_silence":
                assert own is False
            else:
                np.testing.assert_array_equal(own, whole[rows])
    assert scan.tells_silence is True
    assert Scan(1.0, "radar", [[1.0, 2.0]], platform=np.arange(6.0)).part([]).platform.size == 6
