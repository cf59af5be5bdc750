"""Directions that are counted otherwise are told."""

import numpy as np
import pytest

from run.diagnostics.scenes import case_of, with_sensors
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.reports import ReportTable
from trackweave.run.diagnostics.across import other_senses
from trackweave.run.diagnostics.units import azimuths_in_radians

CAMERA = {"sigma": {"bearing_deg": 1.0}, "position": [50.0, -20.0]}


def watched(turned) -> ReportTable:
    """Two walkers seen by a lidar, and their bearings from a camera."""
    time = np.repeat(np.arange(40.0), 2)
    east = np.where(np.arange(80) % 2, 100.0 + 2 * time, 30.0 - time)
    north = np.where(np.arange(80) % 2, 40.0, 90.0 - 3 * time)
    bearing = np.arctan2(east - 50.0, north + 20.0)
    bearing += np.random.default_rng(1).normal(0, np.radians(1.0), 80)
    measurement = np.stack([east, north], axis=-1)
    seen = np.stack([turned(bearing) % (2 * np.pi), np.full(80, np.nan)], axis=-1)
    order = np.lexsort((np.repeat([1, 0], 80), np.tile(time, 2)))
    return ReportTable(
        time=np.tile(time, 2)[order],
        sensor=np.repeat([1, 0], 80)[order],
        sensors=("camera", "lidar"),
        measurement=np.concatenate([measurement, seen])[order],
        sigma=np.full((160, 2), np.nan),
        report=np.arange(160).astype(str).astype(object),
        kinds=(Kind.BEARING, Kind.POSITION),
        space=2,
    )


def test_bearings_in_the_right_sense_are_beyond_doubt() -> None:
    assert list(other_senses(case_of(watched(lambda angle: angle), camera=CAMERA))) == []


@pytest.mark.parametrize(
    ("turned", "sense"),
    [
        (lambda angle: -angle, "counted counter-clockwise from north"),
        (lambda angle: np.pi / 2 - angle, "counted counter-clockwise from east"),
        (lambda angle: angle + np.pi, "counted clockwise from south"),
        (np.radians, "taken for radians"),
    ],
)
def test_bearings_in_another_sense_are_told(turned, sense) -> None:
    (found,) = other_senses(case_of(watched(turned), camera=CAMERA))
    assert found.sentence.startswith("sensor camera: its bearings fit the other sensors' posit")
    assert f"when {sense} (" in found.sentence


def all_round(low: float, high: float) -> ReportTable:
    angle = np.random.default_rng(1).uniform(low, high, 400)
    measurement = np.stack([np.full(400, 1e3), np.radians(angle) % (2 * np.pi)], axis=1)
    return ReportTable(
        time=np.arange(400.0), sensor=np.zeros(400, np.int64), sensors=("radar",),
        measurement=measurement, sigma=np.full((400, 2), np.nan),
        report=np.arange(400).astype(str).astype(object), kinds=(Kind.RANGE_AZIMUTH,), space=2,
    )  # fmt: skip


@pytest.mark.parametrize("sector", [(0.0, 6.2832), (-3.1416, 3.1416)])
def test_azimuths_that_fill_what_radians_can_be_are_told(sector) -> None:
    (found,) = azimuths_in_radians(radar(all_round(*sector)))
    assert found.cause == "radians"


@pytest.mark.parametrize("sector", [(0.0, 360.0), (2.0, 6.0), (0.0, 5.5), (350.0, 356.0)])
def test_a_narrow_or_full_view_is_no_radians(sector) -> None:
    assert list(azimuths_in_radians(radar(all_round(*sector)))) == []


def radar(reports: ReportTable):
    told = {"sigma": {"range_m": 10.0, "azimuth_deg": 0.1}, "rotation": "none"}
    return with_sensors(case_of(reports, radar=told))
