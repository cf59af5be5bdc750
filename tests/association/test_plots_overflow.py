"""Tests of what is done about more tuples than there may be, and of plots that tell little."""

import math
import time
from dataclasses import replace

import numpy as np
import pytest

from trackweave.association.plots_rule import PlotsRule, SensorPlots
from trackweave.association.scan_plots import plots_of
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.scans import Scan
from trackweave.errors import InvalidInputError
from trackweave.models.sensors import Sensor


def cell(n_sensors=3, n_plots=30, dim=2, side=10.0, seed=0):
    rng = np.random.default_rng(seed)
    return [
        SensorPlots(rng.uniform(0.0, side, size=(n_plots, dim)), 10.0, 1e6, 5.0)
        for _ in range(n_sensors)
    ]


def cameras(n_sensors=3, n_plots=30, seed=0):
    rng = np.random.default_rng(seed)
    angles = np.arange(n_sensors) * 2.0 * math.pi / n_sensors
    return [
        SensorPlots(
            rng.uniform(0.0, 2.0 * math.pi, size=n_plots), 0.01, 6.28, 5.0,
            place=9e3 * np.array([math.sin(angle), math.cos(angle)]),
        )
        for angle in angles
    ]  # fmt: skip


def rows_of(scored):
    return dict(zip(map(tuple, scored.tuples.tolist()), scored.costs, strict=True))


@pytest.mark.parametrize("sensors", [cell(), cell(dim=3), cameras(), [*cell(2), *cameras(1)]])
@pytest.mark.parametrize("max_tuples", [200, 500, 5000])
def test_thinned_tuples_are_some_of_all_at_the_same_price(sensors, max_tuples):
    rule = PlotsRule(1e-6)
    every = rows_of(rule(sensors))
    assert len(every) > max_tuples or max_tuples == 5000
    thin = replace(rule, overflow="thin", max_tuples=max_tuples)
    scored = thin(sensors)
    few = rows_of(scored)
    assert len(few) == len(scored) <= max_tuples
    assert len(few) > max_tuples / 40
    assert scored.is_complete == (len(every) <= max_tuples)
    assert set(few) <= set(every)
    np.testing.assert_allclose(list(few.values()), [every[row] for row in few], atol=1e-4)
    assert thin(sensors).tuples.tobytes() == scored.tuples.tobytes()


def test_what_fits_is_complete_and_the_same_as_when_it_is_refused():
    sensors = cell(n_plots=8)
    refuse, thin = PlotsRule(1e-6), PlotsRule(1e-6, overflow="thin")
    one, two = refuse(sensors), thin(sensors)
    assert one.is_complete
    assert two.is_complete
    assert one.costs.tobytes() == two.costs.tobytes()


def test_each_set_is_joined_by_the_nearest_of_each_further_sensor():
    rng = np.random.default_rng(3)
    first, second = rng.uniform(0.0, 30.0, size=(2, 40, 2))
    sensors = [SensorPlots(value, 10.0, 1e6, 1.0) for value in (first, second)]
    # So few that each of the first may have three at most, but four are too many: 2 remain.
    scored = PlotsRule(1e-6, overflow="thin", max_tuples=159)(sensors)
    away = np.linalg.norm(first[:, None] - second[None], axis=2)
    nearest = np.argsort(away, axis=1)[:, :2] + 1
    want = {(row + 1, int(number)) for row in range(40) for number in nearest[row]}
    assert set(rows_of(scored)) == want


def test_at_last_a_set_is_not_grown_without_its_nearest():
    sensors = cell(n_sensors=6, n_plots=10)
    scored = PlotsRule(1e-6, overflow="thin", max_tuples=200)(sensors)
    assert not scored.is_complete
    # Of each plot of the first one by one further sensor, of the second one less, and so on.
    assert len(scored) == 10 * (5 + 4 + 3 + 2 + 1)
    # There is nothing more to leave out then but plots.
    assert len(PlotsRule(1e-6, overflow="thin", max_tuples=20)(sensors)) == 20


@pytest.mark.slow
def test_a_thousand_plots_of_each_in_one_cell_end_soon():
    sensors = cell(n_plots=1000)
    rule = PlotsRule(1e-6, overflow="thin", max_tuples=2_000_000)
    rule(cell(n_plots=2))
    before = time.process_time()
    scored = rule(sensors)
    # Two seconds and a half on a machine that is busy with other things; compiled beforehand.
    assert time.process_time() - before < 10.0
    assert not scored.is_complete
    assert 200_000 < len(scored) <= 2_000_000
    assert len(np.unique(scored.tuples[:, 0])) == 1001


def test_thinning_keeps_objects_that_stand_out():
    rng = np.random.default_rng(1)
    truth = rng.uniform(0.0, 2000.0, size=(60, 2))
    values = truth + rng.normal(size=(5, *truth.shape)) * 10.0
    dense = [
        SensorPlots(np.concatenate([value, rng.uniform(0.0, 60.0, (60, 2))]), 10.0, 4e6, 5.0)
        for value in values
    ]
    scored = PlotsRule(1e-6, overflow="thin", max_tuples=50_000)(dense)
    assert not scored.is_complete
    rows = rows_of(scored)
    alone = np.all(truth > 120.0, axis=1)
    kept = [tuple([number + 1] * 5) in rows for number in np.flatnonzero(alone)]
    assert len(kept) > 40
    assert np.mean(kept) > 0.9


def test_sensors_of_bearings_at_one_place_need_a_third_elsewhere():
    # Their bearings never cross: without another sensor they make no tuple.
    place = (0.0, 0.0)
    two = [SensorPlots([0.0], 0.01, 6.28, 1.0, place=place) for _ in range(2)]
    assert len(PlotsRule(1e-6)(two)) == 0
    aside = SensorPlots([math.atan2(-1000.0, 0.0)], 0.01, 6.28, 1.0, place=(1000.0, 1000.0))
    for overflow in ("refuse", "thin"):
        rows = rows_of(PlotsRule(1e-6, overflow=overflow)([*two, aside]))
        assert set(rows) == {(1, 1, 1), (1, 0, 1), (0, 1, 1)}


@pytest.mark.parametrize("overflow", ["refuse", "thin"])
def test_bearings_that_are_all_parallel_make_no_tuple(overflow):
    places = [(0.0, 0.0), (500.0, 0.0), (1000.0, 100.0), (-700.0, 900.0)]
    sensors = [SensorPlots([0.5, 0.5], 0.01, 6.28, 1.0, place=place) for place in places]
    assert len(PlotsRule(1e-6, overflow=overflow)(sensors)) == 0


def test_a_bearing_through_another_sensor_says_nothing_with_that_ones_bearing():
    # They cross at the second sensor itself, from where every direction is as likely.
    north = SensorPlots([0.0], 0.01, 6.28, 1.0, place=(0.0, 0.0))
    there = SensorPlots([1.0], 0.01, 6.28, 1.0, place=(0.0, 1000.0))
    assert len(PlotsRule(1e-6)([north, there])) == 0
    seen = SensorPlots([[0.0, 1000.0]], 10.0, 1e6, 1.0)
    assert set(rows_of(PlotsRule(1e-6)([north, seen]))) == {(1, 1)}
    assert len(PlotsRule(1e-6)([there, seen])) == 0


@pytest.mark.parametrize("overflow", ["refuse", "thin"])
@pytest.mark.parametrize("cost", ["evidence", "equation-1"])
def test_sensors_without_plots_make_no_tuple_and_do_not_hinder_others(overflow, cost):
    rule = PlotsRule(1e-6, cost=cost, overflow=overflow)
    empty = SensorPlots(np.empty((0, 2)), 10.0, 1e6, 1.0)
    blind = SensorPlots(np.empty(0), 0.01, 6.28, 1.0, place=(0.0, 0.0))
    assert len(rule([empty, blind, empty])) == 0
    some = SensorPlots([[0.0, 0.0]], 10.0, 1e6, 1.0)
    assert set(rows_of(rule([empty, some, blind, some]))) == {(0, 1, 0, 1)}


def test_a_plot_without_a_range_stands_at_its_sensor():
    sensor = Sensor("A", (30.0, 0.01), measurement=MeasurementKind.RANGE_AZIMUTH)
    at_zero = plots_of(Scan(time=0.0, sensor="A", measurement=[[0.0, 2.0]]), sensor, 2)
    np.testing.assert_array_equal(at_zero.value, [[0.0, 0.0]])
    other = SensorPlots([[0.0, 0.0]], 10.0, 1e6, 1.0)
    scored = PlotsRule(1e-6)([at_zero, other])
    assert np.all(np.isfinite(scored.costs))
    assert set(rows_of(scored)) == {(1, 1)}


def test_refuses_a_word_that_it_does_not_know():
    with pytest.raises(InvalidInputError, match="overflow: 'drop'; expected one of refuse, thin"):
        PlotsRule(1e-6, overflow="drop")
