"""The noise of heights, and by how much sensors differ in them, against how they were made."""

from dataclasses import replace

import numpy as np
import pytest

from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimate import estimate
from trackweave.estimation.estimates import Estimates
from trackweave.estimation.levels import with_levels
from trackweave.models.sensors import HEIGHT_NOISE


def stacks(
    noise: float = 0.0,
    sensors: dict[str, tuple[float, float]] | None = None,
    *,
    behind: float | None = None,
    climb: float = 0.0,
) -> ReportTable:
    """Return aircraft that circle one above the other, and false alarms at any height.

    Each sensor's heights are off by a distance, and in a unit [m]. Each aircraft flies an angle
    ``behind`` the last [rad], or anywhere, and all climb so fast [m/s].
    """
    rng, rows, n = np.random.default_rng(5), [], 8
    begin = rng.uniform(0.0, 2.0 * np.pi, n) if behind is None else behind * np.arange(n)
    for index, (offset, unit) in enumerate((sensors or {"A": (0.0, 1.0)}).values()):
        for turn in range(60):
            time = 4.0 * turn + 1.7 * index
            seen = np.flatnonzero(rng.random(n) < 0.9)
            angle = begin[seen] + 0.022 * time
            place = 5000.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
            height = 2000.0 + 300.0 * seen + climb * time + rng.normal(0.0, noise, seen.size)
            height = 30.48 * np.round(height / 30.48)
            false = np.column_stack([rng.uniform(-1e4, 1e4, (3, 2)), rng.uniform(1e3, 6e3, 3)])
            own = np.column_stack([place + rng.normal(0.0, 250.0, place.shape), height])
            of_turn = np.vstack([own, false])
            of_turn[:, 2] = (of_turn[:, 2] + offset) / unit
            rows += [(time, index, *row) for row in of_turn]
    time, sensor, east, north, height = np.array(sorted(rows)).T
    names = tuple(sensors or {"A": None})
    place = np.stack([east, north], axis=1)
    return ReportTable(
        time,
        sensor.astype(int),
        names,
        place,
        np.full(place.shape, np.nan),
        report=np.arange(time.size),
        height=height,
    )


def found(reports: ReportTable) -> Estimates:
    return with_levels(estimate(reports), reports)


@pytest.mark.parametrize("noise", [60.0, 150.0, 300.0])
def test_finds_the_noise_of_heights(noise: float) -> None:
    # Neighbours in a stack make it seem wider, as they are near oftener than any two.
    assert 0.8 * noise < found(stacks(noise)).sensors["A"].sigma_height < 1.7 * noise


def test_heights_in_steps_are_as_exact_as_usual() -> None:
    sensor = found(stacks()).sensors["A"]
    assert sensor.sigma_height is None
    assert sensor.height_offset == 0.0
    assert 30.48 / np.sqrt(12.0) < HEIGHT_NOISE


@pytest.mark.parametrize("offset", [-450.0, 190.0, 1000.0])
def test_finds_by_how_much_two_sensors_differ(offset: float) -> None:
    estimates = found(stacks(sensors={"A": (0.0, 1.0), "B": (offset, 1.0)}))
    between = estimates.sensors["B"].height_offset - estimates.sensors["A"].height_offset
    assert between == pytest.approx(offset, abs=20.0)
    assert estimates.notes == ()


def test_sensors_that_agree_are_left_as_they_are() -> None:
    estimates = found(stacks(sensors={"A": (0.0, 1.0), "B": (60.0, 1.0)}))
    assert {each.height_offset for each in estimates.sensors.values()} == {0.0}


def test_a_climb_is_no_noise() -> None:
    # 240 m from look to look would be a noise of 170 m.
    assert (found(stacks(climb=60.0)).sensors["A"].sigma_height or HEIGHT_NOISE) < 140.0


@pytest.mark.parametrize("behind", [0.02, 0.1])
@pytest.mark.parametrize("offset", [0.0, 300.0])
def test_who_flies_behind_another_is_at_no_other_sensors_height(behind, offset) -> None:
    estimates = found(stacks(sensors={"A": (0.0, 1.0), "B": (offset, 1.0)}, behind=behind))
    between = estimates.sensors["B"].height_offset - estimates.sensors["A"].height_offset
    assert between == pytest.approx(offset, abs=20.0)
    assert estimates.notes == ()


@pytest.mark.parametrize("unit", [0.3048, 1.0 / 0.3048])
def test_feet_beside_metres_are_named_and_not_used(unit: float) -> None:
    estimates = found(stacks(sensors={"A": (0.0, 1.0), "B": (0.0, unit)}))
    (note,) = estimates.notes
    assert "in feet; expected metres of both" in note
    assert max(each.sigma_height or 0.0 for each in estimates.sensors.values()) == 1e5


def test_without_heights_nothing_is_said_of_them() -> None:
    reports = stacks()
    for none in (None, np.full(len(reports), np.nan)):
        without = replace(reports, height=none)
        estimates = estimate(without)
        assert with_levels(estimates, without).sensors == estimates.sensors
