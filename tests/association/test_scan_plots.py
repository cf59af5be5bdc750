"""Tests of the plots that are made of scans, whatever the sensor measures."""

import math

import numpy as np
import pytest

from trackweave.association.plots_rule import PlotsRule
from trackweave.association.scan_plots import plots_of
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.scans import Scan
from trackweave.errors import InvalidInputError
from trackweave.models._kernels import is_covered
from trackweave.models.coverage import FieldOfView
from trackweave.models.rotation import Rotation
from trackweave.models.sensors import Sensor

POLAR_SIGMA = (40.0, 0.004)
HERE = (300.0, -200.0)


def scan(measurement, **more):
    return Scan(time=10.0, sensor="A", measurement=np.atleast_2d(measurement), **more)


def polar_sensor(**changes):
    given = {"sigma": POLAR_SIGMA, "measurement": Kind.RANGE_AZIMUTH, "position": HERE}
    return Sensor("A", **given | {"clutter_density": 1e-3} | changes)


def polar(points, here=HERE):
    away = np.asarray(points) - np.asarray(here)
    return np.stack([np.hypot(*away.T), np.arctan2(away[:, 0], away[:, 1])], axis=1)


def numeric_steps(to_place, measurement, size):
    """Return how a place moves with what is measured, by small differences."""
    columns = []
    for axis in range(size):
        step = np.zeros(size)
        step[axis] = 1e-6 * max(1.0, abs(measurement[axis]))
        ahead, behind = to_place(measurement + step), to_place(measurement - step)
        columns.append((ahead - behind) / (2 * step[axis]))
    return np.stack(columns, axis=1)


def flat_place(measurement):
    distance, azimuth = measurement[:2]
    return np.array(HERE) + distance * np.array([math.sin(azimuth), math.cos(azimuth)])


def high_place(measurement):
    distance, azimuth, elevation = measurement[:3]
    level = distance * math.cos(elevation)
    return np.array(
        [level * math.sin(azimuth), level * math.cos(azimuth), distance * math.sin(elevation)]
    )


def test_positions_keep_their_values_and_errors():
    sensor = Sensor("A", sigma=(5.0, 7.0), clutter_density=2e-6, detection_probability=0.8)
    found = plots_of(scan([[1.0, 2.0], [3.0, 4.0]], sigma=[[np.nan] * 2, [1.0, 9.0]]), sensor, 2)
    np.testing.assert_array_equal(found.value, [[1.0, 2.0], [3.0, 4.0]])
    np.testing.assert_allclose(found.sigma, [[5.0, 7.0], [1.0, 9.0]])
    np.testing.assert_array_equal(np.broadcast_to(found.clutter_density, 2), 2e-6)
    assert found.detection_probability == 0.8
    assert found.volume is None
    assert not np.any(found.drift)


def test_a_scans_covariances_stay():
    covariance = [[[4.0, 1.0], [1.0, 2.0]]]
    found = plots_of(scan([1.0, 2.0], covariance=covariance), Sensor("A"), 2)
    np.testing.assert_allclose(found.covariance, covariance)


@pytest.mark.parametrize("kind", [Kind.RANGE_AZIMUTH, Kind.RANGE_AZIMUTH_RATE])
def test_range_and_azimuth_become_positions_with_the_errors_that_they_have_there(kind):
    row = np.array([2000.0, 0.7, 12.0])[: kind.n_components(2)]
    sigma = (*POLAR_SIGMA, 1.0)[: row.size]
    width = 80.0 if kind.has_rate else None
    sensor = polar_sensor(measurement=kind, sigma=sigma, detection_probability=0.7)
    found = plots_of(scan(row), sensor, 2, ignored_width=width)
    steps = numeric_steps(flat_place, row[:2], 2)
    np.testing.assert_allclose(found.value[0], flat_place(row), atol=0.1)
    np.testing.assert_allclose(
        found.covariance[0], steps @ np.diag(np.square(POLAR_SIGMA)) @ steps.T, rtol=1e-6
    )
    assert found.clutter_density[0] == pytest.approx(1e-3 * (width or 1.0) / 2000.0)


def test_correlated_ranges_and_azimuths_become_correlated_positions():
    row, covariance = np.array([2000.0, 0.7]), np.array([[1600.0, 0.1], [0.1, 1.6e-5]])
    found = plots_of(scan(row, covariance=covariance[None]), polar_sensor(), 2)
    steps = numeric_steps(flat_place, row, 2)
    np.testing.assert_allclose(found.covariance[0], steps @ covariance @ steps.T, rtol=1e-6)


@pytest.mark.parametrize("kind", [Kind.RANGE_AZIMUTH_ELEVATION, Kind.RANGE_AZIMUTH_ELEVATION_RATE])
def test_elevations_place_plots_in_space(kind):
    row = np.array([2000.0, 0.7, 0.5, 3.0])[: kind.n_components(3)]
    sigma = (40.0, 0.004, 0.01, 1.0)[: row.size]
    sensor = Sensor("A", sigma=sigma, measurement=kind, clutter_density=1e-3)
    width = 50.0 if kind.has_rate else None
    found = plots_of(scan(row), sensor, 3, ignored_width=width)
    steps = numeric_steps(high_place, row[:3], 3)
    np.testing.assert_allclose(found.value[0], high_place(row), atol=0.2)
    np.testing.assert_allclose(
        found.covariance[0], steps @ np.diag(np.square(sigma[:3])) @ steps.T, rtol=1e-5
    )
    unit = 2000.0**2 * math.cos(0.5)
    assert found.clutter_density[0] == pytest.approx(1e-3 * (width or 1.0) / unit)
    assert plots_of(scan(row), sensor, 3, ignored_width=width, volume=7.0).volume[0] == (
        pytest.approx(7.0 * unit)
    )


def test_bearings_come_with_the_place_of_their_sensor():
    sensor = Sensor("A", 0.02, measurement=Kind.BEARING, position=HERE, clutter_density=0.3)
    found = plots_of(scan([[0.4], [1.2]]), sensor, 2)
    assert found.is_bearing
    np.testing.assert_allclose(found.value, [0.4, 1.2])
    np.testing.assert_allclose(found.sigma, 0.02)
    np.testing.assert_allclose(found.place, HERE)
    assert found.clutter_density == 0.3
    assert found.volume == pytest.approx(2 * math.pi)


@pytest.mark.parametrize("rows", [1, 2])
def test_a_sensor_that_moves_is_where_its_scan_says(rows):
    platform = np.array([[10.0, 20.0, 0.0, 1.0, 1.0, 0.0], [30.0, 40.0, 0.0, 1.0, 1.0, 0.0]])[
        :rows
    ]
    given = platform if rows > 1 else platform[0]
    sensor = Sensor("A", 0.02, measurement=Kind.BEARING)
    seen = plots_of(scan([[0.4], [1.2]], platform=given), sensor, 2)
    np.testing.assert_allclose(
        np.broadcast_to(seen.place, (2, 2)), np.resize(platform, (2, 6))[:, :2]
    )
    polar_seen = plots_of(scan([[100.0, 0.0], [100.0, 0.0]], platform=given), polar_sensor(), 2)
    want = np.resize(platform, (2, 6))[:, :2] + [0.0, 100.0]
    np.testing.assert_allclose(polar_seen.value, want, atol=0.01)


def test_plots_of_another_time_are_less_sure():
    sensor = Sensor("A", 3.0)
    early = scan([[0.0, 0.0], [1.0, 1.0]], moments=[8.0, 10.0])
    np.testing.assert_allclose(plots_of(early, sensor, 2, speed=2.0).drift, [4.0, 0.0])
    np.testing.assert_allclose(plots_of(early, sensor, 2, speed=2.0, time=12.0).drift, [8.0, 4.0])
    assert plots_of(scan([[0.0, 0.0]]), sensor, 2, speed=2.0, time=9.0).drift == 2.0
    assert plots_of(scan([[0.0, 0.0]]), sensor, 2, speed=2.0).drift == 0.0


def test_nearest_to_the_sensor_and_to_the_zenith_errors_stay_finite():
    near = plots_of(scan([[0.0, 1.0], [-5.0, 1.0]]), polar_sensor(), 2)
    for covariance in near.covariance:
        across = np.array([math.cos(1.0), -math.sin(1.0)])
        assert across @ covariance @ across == pytest.approx((40.0 * 0.004) ** 2)
    sensor = Sensor("A", (40.0, 0.004, 0.01), measurement=Kind.RANGE_AZIMUTH_ELEVATION)
    overhead = plots_of(scan([1000.0, 1.0, math.pi / 2]), sensor, 3)
    assert np.linalg.eigvalsh(overhead.covariance[0]).min() > 1e-4
    assert np.all(np.isfinite(overhead.clutter_density))


@pytest.mark.parametrize("kind", [Kind.POSITION, Kind.RANGE_AZIMUTH, Kind.BEARING])
@pytest.mark.parametrize("dim", [2])
def test_an_empty_scan_makes_no_plots(kind, dim):
    sensor = Sensor("A", measurement=kind)
    for empty in (Scan(time=0.0, sensor="A", measurement=[]), scan(np.empty((0, 2)))):
        found = plots_of(empty, sensor, dim)
        assert len(found.value) == 0
        assert found.is_bearing == (kind is Kind.BEARING)


def test_a_field_of_view_gives_the_volume_in_what_is_measured():
    view = FieldOfView(position=HERE, max_range=5000.0, azimuth_deg=(0.0, 90.0))
    seen = scan([2000.0, 0.7])
    found = plots_of(seen, polar_sensor(field_of_view=view), 2)
    assert found.volume[0] == pytest.approx(5000.0 * math.pi / 2 * 2000.0)
    flat = Sensor("A", field_of_view=view)
    area = math.pi * 5000.0**2 / 4
    np.testing.assert_allclose(plots_of(scan([0.0, 0.0]), flat, 2).volume, area)
    turning = Sensor("A", field_of_view=view, rotation=Rotation(8.0))
    half = plots_of(scan([0.0, 0.0]), turning, 2, start=9.0)
    np.testing.assert_allclose(half.volume, area / 2)


def test_plots_know_where_their_scan_looked():
    view = FieldOfView(position=HERE, min_range=100.0, max_range=5000.0, azimuth_deg=(300.0, 30.0))
    turning = Sensor("A", field_of_view=view, position=HERE, rotation=Rotation(8.0))
    assert plots_of(scan([0.0, 0.0]), Sensor("A"), 2).coverage is None
    whole = plots_of(scan([0.0, 0.0]), turning, 2).coverage
    assert (whole.position, whole.min_range, whole.max_range) == (HERE, 100.0, 5000.0)
    np.testing.assert_allclose(whole.azimuth_deg, (300.0, 390.0))
    # From 9 to 10 s the beam goes from 45 to 90 degrees, from 8 to 10 s from 0 on.
    gone = plots_of(scan([0.0, 0.0]), turning, 2, start=9.0)
    assert gone.volume is None
    inside = np.array(HERE) + 1000.0 * np.array([math.sin(1.0), math.cos(1.0)])
    assert not is_covered(*inside, gone.coverage.coverage())
    np.testing.assert_allclose(
        plots_of(scan([0.0, 0.0]), turning, 2, start=8.0).coverage.azimuth_deg, (0.0, 30.0)
    )
    sailing = scan([0.0, 0.0], platform=[10.0, 20.0, 0.0, 0.0, 0.0, 0.0])
    assert plots_of(sailing, turning, 2).coverage.position == (10.0, 20.0)
    bay = FieldOfView(polygon=[(0.0, 0.0), (9.0, 0.0), (0.0, 9.0)])
    kept = plots_of(scan([0.0, 0.0]), Sensor("A", field_of_view=bay), 2)
    np.testing.assert_allclose(kept.coverage.polygon, bay.polygon)
    np.testing.assert_allclose(kept.volume, 40.5)


def test_the_price_of_a_plot_is_the_same_in_metres_as_in_what_is_measured():
    # Two sensors that stand apart and one point that both see: eq. 1 by hand, in m·rad.
    point, there = np.array([[1500.0, 900.0]]), (-900.0, 500.0)
    view = FieldOfView(max_range=4000.0)
    sensors = [polar_sensor(field_of_view=view), polar_sensor(field_of_view=view, position=there)]
    plots = [plots_of(scan(polar(point, sensor.position)), sensor, 2) for sensor in sensors]
    scored = PlotsRule(cost="equation-1")(plots)
    root, extent = 2 * math.pi * POLAR_SIGMA[0] * POLAR_SIGMA[1], 4000.0 * 2 * math.pi
    assert scored.costs[0] == pytest.approx(2 * math.log(root / (0.9 * extent)), abs=1e-3)


def test_the_evidence_of_ranges_and_azimuths_is_the_integral_in_what_is_measured():
    sensors = [polar_sensor(), polar_sensor(position=(-900.0, 500.0))]
    point, density = np.array([[1500.0, 900.0]]), 1e-7
    noise = np.array([[30.0, -0.003], [-20.0, 0.002]])
    rows = [
        polar(point, sensor.position) + off for sensor, off in zip(sensors, noise, strict=True)
    ]
    plots = [plots_of(scan(row), sensor, 2) for row, sensor in zip(rows, sensors, strict=True)]
    scored = PlotsRule(density)(plots)
    axis = np.linspace(-150.0, 150.0, 601)
    east, north = np.meshgrid(point[0, 0] + axis, point[0, 1] + axis)
    log = np.full(east.size, math.log(density * (axis[1] - axis[0]) ** 2))
    for row, sensor in zip(rows, sensors, strict=True):
        off = row - polar(np.stack([east.ravel(), north.ravel()], axis=1), sensor.position)
        log -= 0.5 * np.sum((off / POLAR_SIGMA) ** 2, axis=1)
        log += math.log(0.9 / 1e-3 / (2 * math.pi * POLAR_SIGMA[0] * POLAR_SIGMA[1]))
    assert scored.costs[0] == pytest.approx(-math.log(np.sum(np.exp(log))), abs=0.02)


def test_eq_1_says_what_it_misses_where_a_field_of_view_has_no_bound():
    found = plots_of(scan([2000.0, 0.7]), polar_sensor(), 2)
    with pytest.raises(InvalidInputError, match=r"sensors\[1\]: volume: None; expected the field"):
        PlotsRule(cost="equation-1")(
            [plots_of(scan([1.0, 0.7]), polar_sensor(), 2, volume=9.0), found]
        )


@pytest.mark.parametrize(
    ("rows", "kind", "changes", "words"),
    [
        ([1.0, 2.0, 3.0], Kind.POSITION, {}, "sensor A: reports of 3 numbers; expected 2 for"),
        ([1.0, 2.0, 3.0], Kind.RANGE_AZIMUTH_RATE, {}, "ignored_width: None; .* range-azimuth-ra"),
        ([1.0, 2.0, 3.0], Kind.RANGE_AZIMUTH_ELEVATION, {}, "ignored_width: None; expected"),
        ([1.0, 2.0], Kind.RANGE_AZIMUTH, {"dim": 3}, "range-azimuth in 3 dimensions; expected"),
        ([1.0], Kind.BEARING, {"dim": 3}, "sensor A: bearing in 3 dimensions; expected"),
        ([1.0, 2.0], Kind.POSITION, {"dim": 4}, "dim: 4; expected 2 or 3"),
        ([1.0, 2.0], Kind.POSITION, {"speed": -1.0}, "speed: -1.0"),
        ([1.0, 2.0], Kind.POSITION, {"speed": math.nan}, "speed: nan"),
        ([1.0, 2.0], Kind.POSITION, {"time": math.inf}, "time: inf"),
        ([1.0, 2.0], Kind.POSITION, {"volume": -1.0}, "volume"),
        ([1.0, 2.0, 3.0], Kind.RANGE_AZIMUTH_RATE, {"ignored_width": 0.0}, "ignored_width: 0.0"),
    ],
)
def test_refuses_scans_that_make_no_plots(rows, kind, changes, words):
    dim = changes.pop("dim", 2)
    with pytest.raises(InvalidInputError, match=words):
        plots_of(scan(rows), Sensor("A", measurement=kind), dim, **changes)
