"""What no sensor and no object can have is not believed."""

from dataclasses import replace

import numpy as np

from estimation.test_estimate import scene, table
from trackweave.domain.reports import ReportTable
from trackweave.estimation.covering import covered_by
from trackweave.estimation.estimate import estimate
from trackweave.estimation.estimates import Estimates
from trackweave.estimation.frames import scan_period
from trackweave.estimation.plausibility import believable, without_stale


def believed(reports: ReportTable, *, speed: float = 0.0, sigma: float = 0.0) -> Estimates:
    found = estimate(reports)
    sensor = found.sensors["A"]
    sensor = replace(sensor, sigma=sigma or sensor.sigma)
    found = replace(found, sensors={"A": sensor}, max_speed=speed or found.max_speed)
    return believable(found, reports, in_metres=True)


def moored(n_ships: int = 20) -> ReportTable:
    rng = np.random.default_rng(1)
    berth = rng.uniform(0, 20_000, (n_ships, 2))
    place = np.concatenate([berth + rng.normal(0, 3, berth.shape) for _ in range(30)])
    return table(np.repeat(np.arange(30.0), n_ships), place)


def test_what_can_be_is_left_alone() -> None:
    found = estimate(scene())
    assert believable(found, scene(), in_metres=True) == found


def test_no_object_moves_at_thousands_of_kilometres_a_second() -> None:
    found = believed(scene(), speed=3.4e6)
    assert 0 < found.max_speed <= 50
    (note,) = found.notes
    assert note.startswith("motion.max_speed: 3.4e+06 m/s ")


def test_noise_beyond_what_lies_together_is_not_believed() -> None:
    found = believed(moored(), sigma=620.0)
    assert 0.5 < found.sensors["A"].sigma < 50
    assert found.notes[0].startswith("sensor A: a sigma of 620 m ")
    assert believed(moored(), sigma=5.0).sensors["A"].sigma == 5.0


def test_what_tracks_told_since_is_not_said_to_stand_in() -> None:
    first = believed(moored(), sigma=620.0, speed=3.4e6)
    noise, speed = first.notes
    assert without_stale(first, first) == first
    told = replace(first, sensors={"A": replace(first.sensors["A"], sigma=3.0)})
    assert without_stale(first, told).notes == (speed,)
    faster = replace(first, max_speed=12.0, notes=(*first.notes, "motion.max_speed: another"))
    assert without_stale(first, faster).notes == (noise, "motion.max_speed: another")


def test_the_grain_of_a_clock_is_no_scan_period() -> None:
    rng = np.random.default_rng(1)
    start = np.sort(rng.integers(0, 600, 60)).astype(float)
    time = (start[:, None] + 1e-4 * np.arange(8)).reshape(-1)
    assert scan_period(np.unique(time)) is None
    assert scan_period(np.arange(2000) * 1e-4) is not None
    found = believed(table(time, rng.uniform(0, 1e4, (time.size, 2))))
    assert "taken for no scan period" in found.notes[0]


def test_an_area_of_reports_on_a_line_is_said_to_stand_in() -> None:
    line = np.stack([np.arange(30.0), 2 * np.arange(30.0)], axis=1)
    assert covered_by(line, 0.1) > 0
    (note,) = estimate(table(np.arange(30.0), line)).notes
    assert note.startswith("sensor A: its reports lie on a line or at one place")


def test_a_speed_that_is_told_is_not_held_against_the_estimate() -> None:
    found = replace(estimate(scene()), max_speed=3.4e6)
    assert not believable(found, scene(), in_metres=True, is_speed_told=True).notes


def test_above_the_air_objects_move_as_in_orbit() -> None:
    flat = scene()
    flat = replace(flat, measurement=100.0 * flat.measurement)
    place = np.column_stack([flat.measurement, np.full(len(flat), 6e5)])
    orbiting = replace(estimate(flat), max_speed=7_600.0)
    high = replace(flat, measurement=place)
    assert believable(orbiting, high, in_metres=True).max_speed == 7_600.0
    assert believable(replace(orbiting, max_speed=2e4), high, in_metres=True).max_speed == 8_000.0
    assert believable(orbiting, flat, in_metres=True).max_speed <= 50.0
