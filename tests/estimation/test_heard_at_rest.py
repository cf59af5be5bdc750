"""Where objects that report themselves stay."""

import numpy as np
import polars as pl
import pytest

from trackweave.config import load_configuration
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimate import estimate
from trackweave.estimation.estimates import Estimates, SensorEstimate
from trackweave.estimation.heard_at_rest import heard_at_rest
from trackweave.estimation.standing import with_seldom
from trackweave.run.tracking import report_table

RADAR = SensorEstimate(3.0, 14.0, 0.9, 1e-7, 1e8, 4.0, scans=True)
AIS = SensorEstimate(None, 5.0, 0.1, 1e-8, 1e8, 4.0, scans=False)
GUESS = Estimates({"ais": AIS, "radar": RADAR}, 0.1, 20.0, 1e-9, 1e-8)
BERTH = np.array([500.0, -300.0])


def harbour(*, berthed: bool) -> ReportTable:
    """Return a radar that sees a berth at times, and AIS of who lies there or passes."""
    rng = np.random.default_rng(3)
    looks = 3.0 * np.arange(200)
    seen = looks[rng.random(looks.size) < 0.3]
    moored = np.arange(20.0, 600.0, 180.0) if berthed else np.empty(0)
    passing = np.arange(0.0, 600.0, 6.0)
    way = np.stack([passing * 5.0 - 1000.0, np.full(passing.size, -260.0)], axis=1)
    time = np.concatenate([moored, passing, seen])
    place = np.concatenate([np.tile(BERTH, (moored.size, 1)), way, np.tile(BERTH, (seen.size, 1))])
    sensor = np.repeat([0, 0, 1], [moored.size, passing.size, seen.size])
    noise = np.where(sensor == 0, 5.0, 14.0)[:, None]
    place = place + noise * rng.normal(size=place.shape)
    return table(time, sensor, place)


def table(time: np.ndarray, sensor: np.ndarray, place: np.ndarray) -> ReportTable:
    names = np.array(["ais", "radar"])[sensor]
    rows = pl.DataFrame({"time": time, "sensor": names, "x": place[:, 0], "y": place[:, 1]})
    return report_table(rows.sort("time"), load_configuration({}))[0]


def test_a_ship_at_its_berth_is_heard_there_and_a_passing_one_is_not() -> None:
    (found,) = heard_at_rest(GUESS, harbour(berthed=True))
    assert found == pytest.approx(BERTH, abs=10.0)
    assert heard_at_rest(GUESS, harbour(berthed=False)).shape == (0, 2)


@pytest.mark.parametrize("berthed", [True, False])
def test_what_a_radar_sees_of_it_is_no_false_alarm_that_comes_again(berthed: bool) -> None:
    reports = harbour(berthed=berthed)
    looks = {"ais": np.empty(0), "radar": 3.0 * np.arange(200)}
    found = with_seldom(GUESS, reports, looks, reports).sensors["radar"].echoes
    assert len(found) == (0 if berthed else 1)


def test_one_that_hears_a_single_object_beside_another_sensor_is_estimated() -> None:
    rng = np.random.default_rng(1)
    heard, looks = np.arange(0.0, 600.0, 40.0), np.arange(0.0, 600.0, 3.0)
    way = np.stack([5.0 * looks - 1000.0, np.full(looks.size, -260.0)], axis=1)
    place = np.concatenate([np.tile(BERTH, (heard.size, 1)), way])
    sensor = np.repeat([0, 1], [heard.size, looks.size])
    place = place + 5.0 * rng.normal(size=place.shape)
    # Its rows are not the first of all.
    reports = table(np.concatenate([heard + 1.0, looks]), sensor, place)
    found = estimate(reports, {}, {"ais": False})
    assert found.sensors["ais"].plane_sigma == pytest.approx(5.0, rel=0.4)
