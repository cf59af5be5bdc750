"""Cases for the checks: reports with tracks, and without."""

import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from trackweave.config import load_configuration
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import TrackTable
from trackweave.run.diagnostics import Case
from trackweave.run.tracking import settings_for

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"


def contradictions() -> ModuleType:
    """Return the module of the benchmark's scenes."""
    sys.path.insert(0, str(BENCHMARKS))
    try:
        import contradictions_scenes
    finally:
        sys.path.remove(str(BENCHMARKS))
    return contradictions_scenes


def positions(time: list[float], place: Any, sensor: Any = None, names=("lidar",)) -> ReportTable:
    """Return a table of positions."""
    n = len(time)
    return ReportTable(
        time=np.array(time, float),
        sensor=np.zeros(n, np.int64) if sensor is None else np.array(sensor, np.int64),
        sensors=tuple(names),
        measurement=np.array(place, float),
        sigma=np.full((n, 2), np.nan),
        report=np.arange(n).astype(str).astype(object),
    )


def case_of(reports: ReportTable, **sensors: Any) -> Case:
    """Return a case in which nothing was tracked and everything is told."""
    usual = {"sigma": 1.0, "detection_probability": 0.9, "clutter_density": 1e-6}
    told = {
        "motion": {"process_noise": 1.0, "max_speed": 10.0},
        "sensors": {"default": {**usual, "scan_period": 1.0}, **sensors},
        "lifecycle": {"new_target_density": 1e-7},
    }
    settings = settings_for(reports, load_configuration(told))
    nobody = np.full(len(reports), -1)
    return Case(reports, settings, nobody, TrackTable.empty(reports.dim))


def with_sensors(case: Case, **change: Any) -> Case:
    """Return a case whose sensors are otherwise."""
    sensors = tuple(replace(sensor, **change) for sensor in case.settings.sensors)
    return replace(case, settings=replace(case.settings, sensors=sensors))
