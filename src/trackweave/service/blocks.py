"""Reports of one sensor on their way into a scan, as columns."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan
from trackweave.run.held import HeldPlaces
from trackweave.run.pieces import first_pieces, mean_of

__all__ = [
    "Block",
    "blocks_of",
    "joined",
    "keys_of",
    "scan_of",
    "without_copies",
    "without_held",
    "without_pieces",
]


class Block(NamedTuple):
    """Reports of one sensor; row k of each column belongs to the same report."""

    time: FloatArray
    measurement: FloatArray
    sigma: FloatArray
    number: IntArray
    platform: FloatArray
    """NaN where the report does not say, shape (reports, 6)."""
    identity: IntArray
    """-1 where it says none."""
    strength: FloatArray
    height: FloatArray
    """Beside a measurement of two dimensions, NaN where the report does not say [m]."""
    context: FloatArray
    scan: IntArray
    """The scan's number where the reports say it, else no number at all, shape (0,)."""

    def at(self, rows: IntArray) -> "Block":
        """Return some rows."""
        columns: Any = [c[rows] if len(c) == len(self.time) else c for c in self]
        return Block(*columns)


def blocks_of(reports: ReportTable, numbers: IntArray, names: dict[str, int]) -> dict[str, Block]:
    """Return a table's reports by sensor.

    Parameters
    ----------
    reports
        The table.
    numbers
        What each report is called, shape (reports,).
    names
        Numbers of identities, to which new ones are added.

    Returns
    -------
    The blocks by the sensors' names, each in the order of the table.
    """
    count = len(reports)
    codes = [names.setdefault(name, len(names)) for name in reports.identities]
    identity = np.full(count, -1, dtype=np.int64)
    if reports.identity is not None:
        identity = np.r_[np.asarray(codes, dtype=np.int64), -1][reports.identity]
    platform, strength = reports.platform, reports.strength
    height = reports.height if reports.dim == 2 else None
    every = Block(
        reports.time,
        reports.measurement,
        reports.sigma,
        numbers,
        np.full((count, 6), np.nan) if platform is None else platform,
        identity,
        np.full(count, np.nan) if strength is None else strength,
        np.full(count, np.nan) if height is None else height,
        np.empty((count, 0)) if reports.context is None else reports.context,
        np.empty(0, dtype=np.int64) if reports.scan is None else reports.scan,
    )
    found = {}
    for index, name in enumerate(reports.sensors):
        size = min(reports.kind_of(index).n_components(reports.dim), every.measurement.shape[1])
        own = every.at(np.flatnonzero(reports.sensor == index))
        found[name] = own._replace(
            measurement=np.ascontiguousarray(own.measurement[:, :size]),
            sigma=np.ascontiguousarray(own.sigma[:, :size]),
        )
    return found


def joined(blocks: Sequence[Block]) -> Block:
    """Return several blocks of one sensor as one, in order of time."""
    if len(blocks) == 1:
        whole = blocks[0]
    else:
        whole = Block(*(np.concatenate(columns) for columns in zip(*blocks, strict=True)))
    order = np.argsort(whole.time, kind="stable")
    return whole if np.all(np.diff(order) == 1) else whole.at(order)


def without_copies(block: Block, *, at_any_time: bool) -> Block:
    """Return a scan's reports, of equal ones the first alone; see ``trackweave.run.doubles``."""
    if len(block.time) < 2:
        return block
    keys = keys_of(block)
    seen: set[object] = set()
    kept = []
    for row, (time, key) in enumerate(zip(block.time.tolist(), keys, strict=True)):
        what = key if at_any_time else (time, key)
        if what not in seen:
            seen.add(what)
            kept.append(row)
    return block if len(kept) == len(keys) else block.at(np.asarray(kept, dtype=np.int64))


def without_pieces(block: Block, kind: MeasurementKind | ForeignKind, extent: float) -> Block:
    """Return a scan's reports, of pieces of one object their middle; see ``run.pieces``."""
    if not extent or len(block.time) < 2 or isinstance(kind, ForeignKind):
        return block
    first = first_pieces(kind, block.measurement, block.identity, extent, block.strength)
    heads, place = np.unique(first, return_inverse=True)
    if heads.size == first.size:
        return block
    return block.at(heads)._replace(measurement=mean_of(kind, block.measurement, place))


def keys_of(block: Block) -> list[bytes]:
    """Return of each report what a copy of it repeats: all but its time."""
    columns = (block.measurement, block.sigma, block.platform, block.context)
    single = (block.strength, block.height, block.identity)
    numbers = np.concatenate([*columns, *(each[:, np.newaxis] for each in single)], axis=1)
    return [row.tobytes() for row in np.ascontiguousarray(numbers)]


def scan_of(block: Block, sensor: str, end: float, *, own_times: bool) -> Scan:
    """Return the scan that a block is; see ``ReportTable.scan_of``."""
    has_platform = not np.isnan(block.platform[:, 0]).any()
    return Scan(
        time=end,
        sensor=sensor,
        measurement=block.measurement,
        sigma=block.sigma,
        report=block.number,
        moments=block.time if own_times else None,
        platform=np.nan_to_num(block.platform) if has_platform else None,
        identity=block.identity if np.any(block.identity >= 0) else None,
        strength=None if np.isnan(block.strength).all() else block.strength,
        height=None if np.isnan(block.height).all() else block.height,
        context=block.context if block.context.shape[1] else None,
    )


def without_held(block: Block, held: HeldPlaces | None, time: float) -> Block:
    """Return a look's reports without places that are said on of what has moved on."""
    if held is None:
        return block
    again = held.take(time, block.measurement[:, :2])
    return block.at(np.flatnonzero(~np.array(again, dtype=np.bool_)))
