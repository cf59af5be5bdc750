"""What rows measure whose sensors' kinds are from outside the package."""

from collections.abc import Iterable, Mapping

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.frames import LocalFrame
from trackweave.errors import DataFormatError
from trackweave.io.checks import Range, RowChecks
from trackweave.io.columns import BoolArray, text_array
from trackweave.io.measured import Measured, read_measured

__all__ = ["read_all_measured"]

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
