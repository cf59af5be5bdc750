"""Sensors that report nothing but where they stand themselves."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.estimation.estimate import estimate
from trackweave.estimation.receivers import as_one, receivers_in
from trackweave.metrics import assignment_quality

STATIONS = np.array([[0.0, 0.0], [500.0, 0.0], [0.0, 500.0], [500.0, 500.0]])


def heard(*, named: bool = True) -> pl.DataFrame:
    """Return an hour of six tags, each heard at the stations within 400 m of it."""
    rng, rows = np.random.default_rng(1), []
    for tag in range(6):
        place, velocity, time = rng.uniform(0, 500, 2), rng.normal(0, 0.4, 2), rng.uniform(0, 60)
        while time < 3600:
            wait = rng.uniform(30, 60)
            velocity = 0.8 * velocity + rng.normal(0, 0.2, 2)
            place, time = np.clip(place + wait * velocity, -50, 550), time + wait
            for one in np.flatnonzero(np.hypot(*(STATIONS - place).T) < 400):
                rows.append((np.floor(time), f"r{one}", *STATIONS[one], f"t{tag}"))
    table = pl.DataFrame(rows, ["time", "sensor", "x", "y", "identity"], orient="row").sort("time")
    return table if named else table.drop("identity")


def test_tags_heard_at_stations_are_tracked_by_name() -> None:
    table = heard()
    result = tw.track(table)
    whose = table["identity"].to_list()
    quality = assignment_quality(whose, result.assignments["track"].to_list())
    assert quality.idf1 > 0.98
    (note,) = (each for each in result.run["notes"] if "report one place each" in each)
    assert note.startswith("sensors r")
    assert len(result.run["notes"]) == 1


def test_noise_is_as_stations_are_apart_and_each_hears_its_share() -> None:
    reports = tw.read_reports(heard())
    found = estimate(reports)
    (sigma,) = {each.plane_sigma for each in found.sensors.values()}
    assert sigma == pytest.approx(250.0, rel=0.1)
    # Chances of a second in which each hears an object, together that of all.
    silent = [np.log1p(-each.detection_probability) for each in found.sensors.values()]
    counts = [
        np.count_nonzero(reports.sensor == reports.sensors.index(name)) for name in found.sensors
    ]
    np.testing.assert_allclose(silent / np.sum(silent), counts / np.sum(counts), rtol=1e-3)


def test_who_is_not_named_who_moves_and_two_alone_are_no_receivers() -> None:
    assert receivers_in(tw.read_reports(heard(named=False))) == []
    table = heard()
    assert receivers_in(tw.read_reports(table.filter(pl.col("sensor") < "r2"))) == []
    moved = table.with_columns(x=pl.when(pl.col("sensor") == "r0").then("time").otherwise("x"))
    assert receivers_in(tw.read_reports(moved)) == ["r1", "r2", "r3"]
    assert receivers_in(tw.read_reports(table), ["r1"]) == ["r0", "r2", "r3"]


def test_as_one_gives_all_to_the_first() -> None:
    reports = tw.read_reports(heard())
    one = as_one(reports, ["r1", "r3"])
    assert np.array_equal(one.sensor == 1, np.isin(reports.sensor, [1, 3]))
    assert as_one(reports, []) is reports
