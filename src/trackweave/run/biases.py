"""Biases of sensors as keys of a file, and reports without them."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.errors import InvalidInputError
from trackweave.estimation.sightings import AZIMUTH, CLOCK, EAST, N_BIASES, NORTH, RANGE, SCALE

__all__ = ["BIAS_KEYS", "as_key", "keys_of", "told_biases", "unbiased"]

BIAS_KEYS: dict[str, tuple[int, ...]] = {
    "range_bias_m": (RANGE,),
    "range_scale": (SCALE,),
    "azimuth_bias_deg": (AZIMUTH,),
    "translation": (EAST, NORTH),
    "clock_offset": (CLOCK,),
}
"""The keys, and which of a sensor's six numbers each tells."""
_DEGREES = math.degrees(1.0)
Kind: TypeAlias = MeasurementKind | ForeignKind


def keys_of(kind: Kind) -> tuple[str, ...]:
    """Return the keys of the biases that a sensor of a kind can have."""
    if isinstance(kind, ForeignKind):
        return ("clock_offset",)
    if kind.is_position:
        return ("translation", "clock_offset")
    angle = ("azimuth_bias_deg", "clock_offset")
    return ("range_bias_m", "range_scale", *angle) if kind.has_range else angle


def as_key(key: str, numbers: FloatArray, *, is_sigma: bool = False) -> Any:
    """Return what a key says of a sensor's six numbers, or of their standard deviations."""
    own = [float(numbers[place]) for place in BIAS_KEYS[key]]
    if key == "translation":
        return own
    if key == "range_scale":
        return own[0] if is_sigma else 1.0 + own[0]
    return own[0] * (_DEGREES if key == "azimuth_bias_deg" else 1.0)


def told_biases(reports: ReportTable, told_of: Callable[[str], Mapping[str, Any]]) -> FloatArray:
    """Return the biases that are told, 0 for none, shape (sensors, 6) as in ``Sightings``."""
    # ``told_of`` gives the keys of a sensor, by its name.
    bias = np.zeros((len(reports.sensors), N_BIASES))
    for index, name in enumerate(reports.sensors):
        said, kind = told_of(name), reports.kind_of(index)
        may = keys_of(kind)
        for key, places in BIAS_KEYS.items():
            if key not in said:
                continue
            if key not in may:
                raise InvalidInputError(
                    f"sensors.{name}.{key}: {said[key]!r:.80}, of a sensor that reports "
                    f"{kind.word}; expected {' or '.join(may)} there"
                )
            unit = _DEGREES if key == "azimuth_bias_deg" else 1.0
            numbers = np.atleast_1d(said[key]) - (1.0 if key == "range_scale" else 0.0)
            bias[index, list(places)] = numbers / unit
    return bias


def unbiased(reports: ReportTable, bias: FloatArray) -> ReportTable:
    """Return reports as they would be without biases, the same table where all are 0."""
    # They are in order of time, and what passes through goes with its row.
    if not bias.any():
        return reports
    measurement = reports.measurement.copy()
    for index in range(len(reports.sensors)):
        kind, own = reports.kind_of(index), bias[index]
        rows = reports.sensor == index
        if isinstance(kind, ForeignKind):
            continue
        if kind.is_position:
            measurement[rows, :2] -= own[list(BIAS_KEYS["translation"])]
            continue
        at = kind.azimuth
        measurement[rows, at] = (measurement[rows, at] - own[AZIMUTH]) % (2.0 * np.pi)
        if kind.has_range:
            true = (measurement[rows, 0] - own[RANGE]) / (1.0 + own[SCALE])
            measurement[rows, 0] = np.maximum(true, 0.0)
    moved = replace(reports, measurement=measurement)
    clock = bias[:, CLOCK]
    return moved.retimed(moved.time - clock[moved.sensor]) if clock.any() else moved
