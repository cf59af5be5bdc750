"""Histories of tracks whose reports are no positions."""

from dataclasses import replace

import numpy as np
import pytest

from trackweave.config import load_configuration
from trackweave.config.fill import Settings
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.models.motion import (
    ConstantAcceleration,
    ConstantVelocity,
    CoordinatedTurn,
    Imm,
    Motion,
)
from trackweave.models.rotation import Rotation
from trackweave.models.sensors import Sensor
from trackweave.run import settings_for
from trackweave.run.history import smoothed_history
from trackweave.run.scans import scan_ends

TIMES = np.arange(0.0, 40.0, 2.0)
TRUTH = np.stack([2000.0 + 30.0 * TIMES, 3000.0 - 20.0 * TIMES], axis=1)
VELOCITY = np.array([30.0, -20.0])
STRAIGHT = ConstantVelocity(0.1, 60.0)
MIXED = Imm((STRAIGHT, CoordinatedTurn(0.1, 1e-5, 60.0, 0.05)), (60.0, 10.0))
RADAR = Sensor(
    "radar", (15.0, 0.005, 0.5), measurement=Kind.RANGE_AZIMUTH_RATE, position=(100.0, -50.0)
)
CAMERAS = (
    Sensor("left", 0.004, measurement=Kind.BEARING, position=(-1000.0, 0.0)),
    Sensor("right", 0.004, measurement=Kind.BEARING, position=(5000.0, 0.0)),
)


def table_of(sensors: tuple[Sensor, ...], seed: int = 1) -> ReportTable:
    """Return one report at each time, of the sensors in turn."""
    rng = np.random.default_rng(seed)
    width = max(sensor.measurement.n_components(2) for sensor in sensors)
    rows = np.full((TIMES.size, width), np.nan)
    for k, place in enumerate(TRUTH):
        sensor = sensors[k % len(sensors)]
        apart = place - sensor.platform[:2]
        distance = np.hypot(*apart)
        azimuth = np.arctan2(apart[0], apart[1]) % (2 * np.pi)
        exact = {
            Kind.BEARING: [azimuth],
            Kind.RANGE_AZIMUTH: [distance, azimuth],
            Kind.RANGE_AZIMUTH_RATE: [distance, azimuth, apart @ VELOCITY / distance],
        }[sensor.measurement]
        rows[k, : len(exact)] = exact + rng.normal(size=len(exact)) * sensor.sigmas(2)
    return ReportTable(
        time=TIMES,
        sensor=np.arange(TIMES.size) % len(sensors),
        sensors=tuple(sensor.name for sensor in sensors),
        measurement=rows,
        sigma=np.full_like(rows, np.nan),
        report=np.arange(TIMES.size).astype(str).astype(object),
        kinds=tuple(sensor.measurement for sensor in sensors),
        space=2,
    )


def settings(sensors: tuple[Sensor, ...], motion: Motion) -> Settings:
    """Return those of any run, with the sensors and the motion."""
    positions = ReportTable(
        time=TIMES, sensor=np.zeros(TIMES.size, np.int64), sensors=("A",), measurement=TRUTH,
        sigma=np.full_like(TRUTH, 5.0), report=np.arange(TIMES.size).astype(str).astype(object),
    )  # fmt: skip
    config = {
        "motion": {"process_noise": 0.1, "max_speed": 60.0},
        "sensors": {"default": {"sigma": 5.0, "clutter_density": 1e-6, "scan_period": 2.0}},
    }
    usual = settings_for(positions, load_configuration(config))
    return replace(usual, sensors=sensors, motion=motion)


def known(time: float, place: np.ndarray) -> TrackTable:
    """Return what a tracker knew of the track first."""
    return TrackTable(
        time=np.array([time]), track=np.array([7]), status=np.array([CONFIRMED]),
        mean=np.r_[place, 0.0, 0.0][None], covariance=np.diag([900.0, 900.0, 400.0, 400.0])[None],
        score=np.zeros(1), hits=np.ones(1, np.int64), last_update=np.array([time]),
    )  # fmt: skip


def history(sensors: tuple[Sensor, ...], motion: Motion, tracks: TrackTable) -> TrackTable:
    table = table_of(sensors)
    return smoothed_history(
        table, dict.fromkeys(range(len(table)), 7), tracks, settings(sensors, motion)
    )


@pytest.mark.parametrize("motion", [STRAIGHT, MIXED, ConstantAcceleration(0.001, 60.0, 1.0)])
def test_ranges_and_azimuths_are_smoothed_onto_the_path(motion):
    found = history((RADAR,), motion, TrackTable.empty(2))
    assert found.time.tolist() == TIMES.tolist()
    assert np.sqrt(np.mean((found.mean[:, :2] - TRUTH) ** 2)) < 8.0
    assert np.abs(found.mean[:, 2:] - VELOCITY).max() < 4.0
    error = found.mean - np.hstack([TRUTH, np.tile(VELOCITY, (TIMES.size, 1))])
    nees = np.einsum("ti,tij,tj->t", error, np.linalg.inv(found.covariance), error)
    assert nees.mean() < 10.0


def test_a_first_report_s_range_rate_counts_too():
    without = replace(RADAR, sigma=(15.0, 0.005), measurement=Kind.RANGE_AZIMUTH)
    first = [
        history((sensor,), STRAIGHT, TrackTable.empty(2)).covariance[0] for sensor in
        (RADAR, without)
    ]  # fmt: skip
    assert first[0][2, 2] + first[0][3, 3] < first[1][2, 2] + first[1][3, 3]


@pytest.mark.parametrize("motion", [STRAIGHT, MIXED])
def test_bearings_that_cross_are_smoothed_from_the_first_on(motion):
    found = history(CAMERAS, motion, known(2.0, TRUTH[1] + 40.0))
    assert found.time.tolist() == TIMES.tolist()
    assert np.sqrt(np.mean((found.mean[:, :2] - TRUTH) ** 2)) < 25.0


def test_a_bearing_before_a_range_begins_where_the_range_puts_the_object():
    found = history((CAMERAS[0], RADAR), STRAIGHT, TrackTable.empty(2))
    assert np.sqrt(np.mean((found.mean[:, :2] - TRUTH) ** 2)) < 15.0


def test_bearings_without_any_place_stay_uncertain_but_finite():
    found = history((CAMERAS[0],), STRAIGHT, TrackTable.empty(2))
    assert np.all(np.isfinite(found.mean))
    assert found.covariance[0, 0, 0] > 1e5


def test_accelerations_are_told_where_the_motion_knows_them():
    found = history((RADAR,), ConstantAcceleration(0.001, 60.0, 1.0), TrackTable.empty(2))
    assert found.acceleration.shape == (TIMES.size, 2)
    assert np.abs(found.acceleration).max() < 0.5
    assert history((RADAR,), STRAIGHT, TrackTable.empty(2)).acceleration.shape[1] == 0


def test_reports_of_a_turning_sensor_count_at_their_own_time_and_show_at_their_scan_s_end():
    radar = replace(RADAR, rotation=Rotation(4.0), scan_period=4.0)
    table = replace(table_of((radar,)), scan=np.repeat(np.arange(10), 2))
    ends = scan_ends(table, {"radar": Rotation(4.0)})
    # Of each turn the track has the first report; of the fourth none.
    rows = np.array([row for row in range(0, 20, 2) if row != 6])
    found = smoothed_history(
        table, dict.fromkeys(rows.tolist(), 7), TrackTable.empty(2), settings((radar,), STRAIGHT)
    )
    last = ends[rows[-1]]
    assert found.time.tolist() == np.unique(ends[ends <= last]).tolist()
    newest = [TIMES[rows[TIMES[rows] <= time]].max() for time in found.time]
    assert found.last_update.tolist() == newest
    assert np.any(found.last_update < found.time)
    moved = TRUTH[0] + found.time[:, None] * VELOCITY
    assert np.sqrt(np.mean((found.mean[:, :2] - moved) ** 2)) < 12.0
