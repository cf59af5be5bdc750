"""What each row of a table of reports measures: a position, a range and angles, or a bearing."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.frames import LocalFrame
from trackweave.domain.measurements import MeasurementKind
from trackweave.errors import DataFormatError
from trackweave.io.checks import Range, RowChecks
from trackweave.io.columns import BoolArray, text_array
from trackweave.io.polar import (
    AZIMUTH,
    POLAR_COLUMNS,
    choose_components,
    read_heading,
    read_polar,
    read_sigma,
)
from trackweave.io.positions import has_height, has_positions, not_available, read_positions

__all__ = ["Measured", "read_all_measured", "read_measured"]

_SIGMA_COLUMNS = ("sigma_x", "sigma_y", "sigma_z")
_POSITION, _RANGE, _BEARING, _NOTHING, _UNKNOWN, _ELSEWHERE = range(6)


class Measured(NamedTuple):
    """What rows measure."""

    # The numbers, shape (rows, width), NaN to the right of what a row has, any in bad rows.
    values: FloatArray
    sigma: FloatArray  # Their standard deviations, of the same shape; NaN where a row has none
    # Each row's ``MeasurementKind``, shape (rows,); None where all are positions.
    kind: IntArray | None
    space: int  # Number of dimensions of the tracking space
    columns: tuple[str, ...]  # Names of the columns that were read
    # The plane on which latitudes and longitudes were laid, None for plane coordinates.
    frame: LocalFrame | None
    notes: tuple[str, ...] = ()  # What was not used
    # Further numbers of rows of kinds from outside, NaN where there is none.
    context: FloatArray | None = None
    # Those kinds, by the names of their sensors.
    foreign: Mapping[str, ForeignKind] = MappingProxyType({})


def read_measured(
    checks: RowChecks,
    sensors: pl.Series,
    frame: LocalFrame | None,
    elsewhere: BoolArray | None = None,
) -> Measured:
    """Return what each row measures but those that are read ``elsewhere``."""
    # A row is a position where it has one, otherwise a range with its azimuth, otherwise a
    # bearing; one whose position is the code for "not available" is set aside. All rows of a
    # sensor are of one kind. An elevation or a range rate counts where all rows of its sensor have
    # one. The tracking space has three dimensions where every sensor of positions has heights and
    # every sensor of ranges elevations. Otherwise heights are left out, and ranges with elevations
    # become distances on the ground.
    group = _groups(checks)
    if elsewhere is not None:
        group[elsewhere] = _ELSEWHERE
    unknown = (group == _POSITION) & not_available(checks, frame)
    checks.set_aside(unknown)
    if not np.isin(group, (_RANGE, _BEARING)).any():
        among = ~unknown & (group != _ELSEWHERE)
        positions = read_positions(checks, frame, None if among.all() else among)
        dim = positions.values.shape[1]
        columns = (*positions.columns, *_SIGMA_COLUMNS[:dim])
        sigma = _position_sigma(checks, dim)
        is_flat = "x" in columns and checks.filled("z") and not has_height(checks)
        notes = ("z is 0 in every row: tracking is in two dimensions",) * is_flat
        return Measured(positions.values, sigma, None, dim, columns, positions.frame, notes)
    column = "range_m" if (group == _RANGE).any() else "bearing_deg"
    checks.refuse(column, group == _NOTHING, "a measurement: a position, a range or a bearing")
    names, sensor = np.unique(text_array(sensors).astype(str), return_inverse=True)
    _refuse_two_kinds(checks, group, (names, sensor))
    group[unknown] = _UNKNOWN
    return _mixed(checks, group, (names, sensor), frame)


def _groups(checks: RowChecks) -> IntArray:
    """Return what each row's filled cells make it."""
    names = set(checks.names)
    group = np.full(len(checks), _NOTHING)
    group[checks.filled_cells("bearing_deg")] = _BEARING
    in_range = checks.filled_cells("range_m")
    if in_range.any() and not has_positions(names):
        checks.require("azimuth_deg", "an azimuth [degrees] beside range_m")
    if {"range_m", "azimuth_deg"} <= names:
        group[in_range | checks.filled_cells("azimuth_deg")] = _RANGE
    elif "bearing_deg" not in names and "azimuth_deg" in names and not has_positions(names):
        checks.require("range_m", "a range [m] beside azimuth_deg, or bearing_deg for one alone")
    if has_positions(names):
        for name in ("x", "y", "lat", "lon"):
            group[checks.filled_cells(name)] = _POSITION
    return group


def _refuse_two_kinds(
    checks: RowChecks, group: IntArray, sensors: tuple[np.ndarray, IntArray]
) -> None:
    """Complain of rows that measure another thing than the first of their sensor."""
    position = "x" if "x" in checks.names else "lat"
    columns = {_POSITION: position, _RANGE: "range_m", _BEARING: "bearing_deg"}
    words = {_POSITION: "a position", _RANGE: "a range", _BEARING: "a bearing"}
    names, sensor = sensors
    for number, name in enumerate(names):
        rows = np.flatnonzero(checks.good & (sensor == number) & (group != _ELSEWHERE))
        if rows.size == 0:
            continue
        first = group[rows[0]]
        for other in np.unique(group[rows]):
            if other != first:
                where = (sensor == number) & (group == other)
                expected = f"{words[first]}, as in the rows of sensor {name} before"
                checks.refuse(columns[other], where, expected)


def _mixed(
    checks: RowChecks,
    group: IntArray,
    sensors: tuple[np.ndarray, IntArray],
    frame: LocalFrame | None,
) -> Measured:
    """Return what rows of several kinds measure."""
    heading = _checked_heading(checks, group, sensors)
    at_position, at_bearing = group == _POSITION, group == _BEARING
    width, columns, notes = 0, list[str](), list[str]()
    positions = None
    if at_position.any():
        positions = read_positions(checks, frame, at_position)
        frame, width = positions.frame, positions.values.shape[1]
        columns += positions.columns
    polar = None
    if (group == _RANGE).any():
        polar = read_polar(checks, group == _RANGE, heading, sensors[1])
        columns += POLAR_COLUMNS
    solid = polar is None or (width != 2 and bool(polar.complete[0].all()))
    space = 3 if solid and (polar or width == 3) else 2
    kind = np.full(len(checks), int(MeasurementKind.POSITION))
    values, sigma = np.full((2, len(checks), 4), np.nan)
    if positions is not None:
        if width > space:
            notes.append("heights of positions are not used: not every sensor tells them")
        values[at_position, :space] = positions.values[at_position, :space]
        noise = _position_sigma(checks, space, at_position)
        sigma[at_position, :space] = noise[at_position]
        columns += _SIGMA_COLUMNS[:width]
    if polar is not None:
        notes += choose_components(polar, sensors, space, (values, sigma, kind))
    if at_bearing.any():
        kind[at_bearing] = MeasurementKind.BEARING
        bearing = np.radians(checks.numbers("bearing_deg", AZIMUTH, among=at_bearing)) + heading
        values[at_bearing, 0] = bearing[at_bearing] % (2 * np.pi)
        sigma[at_bearing, 0] = read_sigma(checks, "sigma_bearing_deg", at_bearing)[at_bearing]
        columns += ["bearing_deg", "sigma_bearing_deg"]
        if np.any(at_bearing & checks.filled_cells("elevation_deg")):
            notes.append(
                "elevations beside bearings are not used, as these are tracked on a plane"
            )
    used = max(MeasurementKind(k).n_components(space) for k in np.unique(kind))
    return Measured(
        np.ascontiguousarray(values[:, :used]),
        np.ascontiguousarray(sigma[:, :used]),
        kind, space, tuple(columns), frame, tuple(notes),
    )  # fmt: skip


def _checked_heading(
    checks: RowChecks, group: IntArray, sensors: tuple[np.ndarray, IntArray]
) -> FloatArray:
    """Return each row's heading; a sensor tells it in all of its rows or in none."""
    heading = read_heading(checks)
    said = checks.filled_cells("sensor_heading_deg")
    if said.any():
        names, sensor = sensors
        turned = np.unique(sensor[said])
        angular = np.isin(group, (_RANGE, _BEARING))
        for number in turned:
            where = angular & ~said & (sensor == number)
            expected = f"a number, as in other rows of sensor {names[number]}"
            checks.refuse("sensor_heading_deg", where, expected)
    return heading


def _position_sigma(checks: RowChecks, dim: int, among: BoolArray | None = None) -> FloatArray:
    """Return each position's noise, which a row has along both horizontal axes or neither."""
    for name, other in (("sigma_x", "sigma_y"), ("sigma_y", "sigma_x")):
        if checks.filled(name) and other not in checks.names:
            said = checks.filled_cells(name)
            if said.all():
                raise DataFormatError(
                    f"{checks.name}, column {name}: there is no {other}; expected {other} too"
                )
            checks.refuse(name, said, f"a number in {other} beside it")
    sigma = np.stack([read_sigma(checks, name, among) for name in _SIGMA_COLUMNS[:dim]], axis=-1)
    blank = np.isnan(sigma[:, :2])
    for axis, name in enumerate(_SIGMA_COLUMNS[:2]):
        half = blank[:, axis] & ~blank[:, 1 - axis]
        checks.refuse(name, half, f"a positive number beside {_SIGMA_COLUMNS[1 - axis]}")
    return sigma


_NUMBER = Range(-1e15, 1e15, expected="a number")
_POSITIVE = Range(0.0, 1e15, positive=True)


def read_all_measured(
    checks: RowChecks,
    sensors: pl.Series,
    frame: LocalFrame | None,
    kinds: Mapping[str, ForeignKind | None],
) -> Measured:
    """Return what each row measures; ``kinds`` from outside by sensor, "default" for the rest."""
    own = text_array(sensors).astype(str) if kinds else np.empty(0, dtype=str)
    names = {str(name): kinds.get(str(name), kinds.get("default")) for name in np.unique(own)}
    foreign = {name: kind for name, kind in names.items() if kind is not None}
    if not foreign:
        return read_measured(checks, sensors, frame)
    rows, count = np.isin(own, list(foreign)), len(checks)
    nothing, dim = np.empty((count, 0)), max(kind.dim or 2 for kind in foreign.values())
    ours = Measured(nothing, nothing, None, dim, (), frame)
    if not rows.all():
        ours = read_measured(checks, sensors, frame, rows)
    _refuse_other_spaces(checks, foreign.values(), ours.space)
    columns, taken = list(ours.columns), ours.values.shape[1]
    width = max(taken, *(len(kind.columns(ours.space)) for kind in foreign.values()))
    values, sigma = np.full((2, count, width), np.nan)
    values[:, :taken], sigma[:, :taken] = ours.values, ours.sigma
    context = np.full((count, max(len(kind.context) for kind in foreign.values())), np.nan)
    for name, kind in foreign.items():
        among, of = own == name, kind.columns(ours.space)
        values[among, : len(of)] = _numbers(checks, of, among, kind)[among]
        sigma[among, : len(of)] = _sigma(checks, of, among)[among]
        context[among, : len(kind.context)] = _context(checks, kind, among)[among]
        columns += [*of, *(f"sigma_{column}" for column in of), *kind.context]
    return ours._replace(
        values=values,
        sigma=sigma,
        kind=np.zeros(count, dtype=np.int64) if ours.kind is None else ours.kind,
        columns=tuple(dict.fromkeys(columns)),
        context=context,
        foreign=foreign,
    )


def _refuse_other_spaces(checks: RowChecks, kinds: Iterable[ForeignKind], space: int) -> None:
    for kind in kinds:
        if kind.dim not in (None, space):
            raise DataFormatError(
                f"{checks.name}: measurement {kind.word} is for {kind.dim} dimensions; expected "
                f"{space}, as the other sensors' reports have"
            )


def _numbers(
    checks: RowChecks, columns: tuple[str, ...], among: BoolArray, kind: ForeignKind
) -> FloatArray:
    for column in columns:
        checks.require(column, f"numbers of measurement {kind.word}")
    return np.stack([checks.numbers(each, _NUMBER, among=among) for each in columns], axis=-1)


def _sigma(checks: RowChecks, columns: tuple[str, ...], among: BoolArray) -> FloatArray:
    read = [checks.optional_numbers(f"sigma_{each}", _POSITIVE, among) for each in columns]
    return np.stack(read, axis=-1)


def _context(checks: RowChecks, kind: ForeignKind, among: BoolArray) -> FloatArray:
    for column in kind.context:
        checks.require(column, f"what measurement {kind.word} needs of each report")
    read = [checks.numbers(each, _NUMBER, optional=True, among=among) for each in kind.context]
    return np.stack(read, axis=-1) if read else np.empty((len(checks), 0))
