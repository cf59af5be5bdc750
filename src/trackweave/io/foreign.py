"""What rows measure whose sensors' kinds are from outside the package."""

from collections.abc import Mapping

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
    own = text_array(sensors).astype(str)
    names = {str(name): kinds.get(str(name), kinds.get("default")) for name in np.unique(own)}
    foreign = {name: kind for name, kind in names.items() if kind is not None}
    if not foreign:
        return read_measured(checks, sensors, frame)
    rows = np.isin(own, list(foreign))
    ours = None if rows.all() else read_measured(checks, sensors, frame, rows)
    space = max(kind.dim or 2 for kind in foreign.values()) if ours is None else ours.space
    for kind in foreign.values():
        if kind.dim not in (None, space):
            raise DataFormatError(
                f"{checks.name}: measurement {kind.word} is for {kind.dim} dimensions; expected "
                f"{space}, as the other sensors' reports have"
            )
    count = len(checks)
    width = max(len(kind.columns(space)) for kind in foreign.values())
    deep = max(len(kind.context) for kind in foreign.values())
    values, sigma = np.full(
        (2, count, max(width, 0 if ours is None else ours.values.shape[1])), np.nan
    )
    context, columns = np.full((count, deep), np.nan), list[str]()
    number = np.zeros(count, dtype=np.int64)
    if ours is not None:
        values[:, : ours.values.shape[1]], sigma[:, : ours.sigma.shape[1]] = (
            ours.values,
            ours.sigma,
        )
        columns += ours.columns
        number = number if ours.kind is None else ours.kind
    for name, kind in foreign.items():
        among = own == name
        of = kind.columns(space)
        values[among, : len(of)] = _numbers(checks, of, among, kind)[among]
        sigma[among, : len(of)] = _sigma(checks, of, among)[among]
        context[among, : len(kind.context)] = _context(checks, kind, among)[among]
        columns += [*of, *(f"sigma_{column}" for column in of), *kind.context]
    return Measured(
        values, sigma, number, space, tuple(dict.fromkeys(columns)),
        frame if ours is None else ours.frame, () if ours is None else ours.notes,
        context, foreign,
    )  # fmt: skip


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
