"""What a run left in its directory, read back."""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any, get_args

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.frames import LocalFrame, Projection
from trackweave.domain.tracks import TrackTable
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.io.checks import RowChecks
from trackweave.io.columns import text_array
from trackweave.io.output import RECORD
from trackweave.io.positions import TRACK_COVARIANCE, require_origin
from trackweave.io.tables import load_table
from trackweave.io.tracks_in import TRACK, read_states, track_table

__all__ = ["AssignedReports", "RunFiles", "read_run", "reports_file"]

COMMANDS = ("track", "demo")
TABLES = ("tracks.csv", "history.csv", "assignments.csv")


@dataclass(frozen=True, slots=True, eq=False)
class AssignedReports:
    """When each report came, from whom, and whether it has a track."""

    report: np.ndarray[Any, Any]  # Identifier of each report as text, shape (reports,)
    time: FloatArray  # Time of each report [s]
    sensor: np.ndarray[Any, Any]  # Name of its sensor
    track: IntArray  # Its track, -1 for a false alarm

    def __len__(self) -> int:
        return len(self.time)


@dataclass(frozen=True, slots=True, eq=False)
class RunFiles:
    """A run as its files tell it."""

    path: Path  # Its directory
    record: dict[str, Any]  # Content of run.json
    # What was known after each scan; of the covariances only what belongs to positions.
    tracks: TrackTable
    history: TrackTable  # The same, amended and smoothed after the fact
    assignments: AssignedReports  # Which report belongs to which track
    # The plane on which latitudes and longitudes were laid, None for plane coordinates.
    frame: LocalFrame | None
    iso_time: bool  # Whether times came as ISO 8601

    def scans(self, *keys: str) -> list[FloatArray]:
        """Return what run.json says of each scan under some keys, NaN for null."""
        return [_column(self.path, self.record, ("scans",), key) for key in keys]

    def cpu_ms(self) -> FloatArray | None:
        """Return the CPU milliseconds of each scan; None where the record has no timing."""
        if not isinstance(self.record.get("timing"), dict):
            return None
        spent = _column(self.path, self.record, ("timing", "scans"), "cpu_ms")
        if spent.size != len(self.record["scans"]):
            raise DataFormatError(_strange(self.path, self.record, "timing"))
        return spent

    def sensor_positions(self) -> dict[str, tuple[float, ...]]:
        """Return where the configuration says that sensors stand [m], by their names."""
        configuration = self.record.get("configuration")
        sensors = configuration.get("sensors") if isinstance(configuration, dict) else None
        found: dict[str, tuple[float, ...]] = {}
        for name, values in sensors.items() if isinstance(sensors, dict) else ():
            place = values.get("position") if isinstance(values, dict) else None
            if place is None:
                continue
            if not (isinstance(place, list) and len(place) in (2, 3) and _all_numbers(place)):
                raise DataFormatError(
                    f"{self.path / RECORD}, key configuration.sensors.{name}.position: "
                    f"{place!r:.60}; expected two or three numbers"
                )
            found[name] = tuple(float(number) for number in place)
        return found


def read_run(directory: Path) -> RunFiles:
    """Read the files that ``trackweave track`` or ``demo`` wrote; complain of what is damaged."""
    record = _record(directory)
    for name in TABLES:
        if not (directory / name).exists():
            raise DataFormatError(
                f"{directory / name}: missing; expected all files of a run: {', '.join(TABLES)}"
            )
    dim, frame = _get(directory, record, "input", "dimensions"), _frame(directory, record)
    if isinstance(dim, bool) or dim not in (2, 3):
        raise DataFormatError(f"{directory / RECORD}, key dimensions: {dim}; expected 2 or 3")
    tracks, iso_time = _tracks(directory / "tracks.csv", dim)
    history, _ = _tracks(directory / "history.csv", dim)
    assignments = _assignments(directory / "assignments.csv")
    run = RunFiles(directory, record, tracks, history, assignments, frame, iso_time)
    time, reports, _ = run.scans("time", "reports", "gap")
    for key, values in (("time", time), ("reports", reports)):
        if not np.isfinite(values).all():
            raise DataFormatError(_strange(directory, record, key))
    copies = record.get("doubles", [])
    is_list = isinstance(copies, list) and all(isinstance(each, dict) for each in copies)
    if not is_list or any("report" not in each for each in copies):
        raise DataFormatError(_strange(directory, record, "doubles"))
    return run


def reports_file(run: RunFiles) -> Path | None:
    """Return the file of the reports that a run tracked, None where it is not to be found."""
    own = run.path / "reports.csv"
    if own.is_file():
        return own
    named = run.record["input"].get("file")
    if not isinstance(named, str) or not named:
        return None
    # As it was given, which a move of the run's directory together with its reports survives.
    beside = run.path.absolute().parent
    places = (Path(named), beside / named, beside / Path(named).name)
    return next((place for place in places if place.is_file()), None)


def _record(directory: Path) -> dict[str, Any]:
    expected = "expected the directory of a run of `trackweave track`"
    if not directory.is_dir():
        found = "a file" if directory.exists() else "no such directory"
        raise DataFormatError(f"{directory}: {found}; {expected}")
    path = directory / RECORD
    if not path.exists():
        raise DataFormatError(f"{directory}: no {RECORD} in it; {expected}")
    try:
        record = json.loads(path.read_bytes())
    except (ValueError, RecursionError) as err:
        raise DataFormatError(f"{path}: not JSON ({err}); {expected}") from err
    except OSError as err:
        raise DataFormatError(f"{path}: cannot be read ({err.strerror or err})") from err
    if not isinstance(record, dict) or "trackweave" not in record:
        raise DataFormatError(f"{path}: not the record of a run of trackweave; {expected}")
    command = record.get("command", "track")
    if command not in COMMANDS:
        raise DataFormatError(f"{directory}: holds a run of `trackweave {command}`; {expected}")
    return record


def _get(directory: Path, record: dict[str, Any], *keys: str) -> Any:
    """Return an entry of the record, or say which version wrote a record without it."""
    found: Any = record
    for key in keys:
        if not isinstance(found, dict) or key not in found:
            raise DataFormatError(_strange(directory, record, key))
        found = found[key]
    return found


def _strange(directory: Path, record: dict[str, Any], key: str) -> str:
    from importlib.metadata import version

    return (
        f"{directory / RECORD}, key {key}: not as expected; written by trackweave "
        f"{record['trackweave']}, this is {version('trackweave')}"
    )


def _column(
    directory: Path, record: dict[str, Any], keys: tuple[str, ...], key: str
) -> FloatArray:
    rows = _get(directory, record, *keys)
    is_table = isinstance(rows, list) and all(isinstance(row, dict) and key in row for row in rows)
    values = [row[key] for row in rows] if is_table else []
    if not is_table or not _all_numbers(value for value in values if value is not None):
        raise DataFormatError(_strange(directory, record, key))
    return np.array(values, dtype=np.float64)  # null becomes NaN


def _all_numbers(values: Iterable[Any]) -> bool:
    """Tell whether values are plain numbers that NumPy has room for."""
    return all(
        isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300
        for value in values
    )


def _frame(directory: Path, record: dict[str, Any]) -> LocalFrame | None:
    origin = _get(directory, record, "input").get("frame_origin")
    projection: Projection = record["input"].get("frame_projection") or "tangent"
    if projection not in get_args(Projection):
        raise DataFormatError(_strange(directory, record, "frame_projection"))
    if origin is None:
        return None
    try:
        return require_origin(origin, projection)
    except InvalidInputError as err:
        raise DataFormatError(f"{directory / RECORD}, key frame_origin: {err}") from err


def _tracks(path: Path, dim: int) -> tuple[TrackTable, bool]:
    checks = RowChecks(load_table(path, may_be_empty=True))
    states = read_states(checks, dim, ("status",), "a tracks table")
    covariance = np.zeros((len(checks), 2 * dim, 2 * dim))
    for row, column in combinations_with_replacement(range(dim), 2):
        name = f"p_{'xyz'[row]}_{'xyz'[column]}"
        if name in checks.names:
            values = checks.numbers(name, TRACK_COVARIANCE)
            covariance[:, row, column] = covariance[:, column, row] = values
    checks.finish("fail")
    return track_table(states, covariance, np.arange(len(checks))), states.iso_time


def _assignments(path: Path) -> AssignedReports:
    checks = RowChecks(load_table(path, may_be_empty=True))
    for name in ("report", "time", "sensor", "track"):
        checks.require(name, "an assignments table")
    report = text_array(checks.text("report", "an identifier"))
    time, _ = checks.times("time")
    sensor = text_array(checks.text("sensor"))
    track = checks.numbers("track", TRACK, optional=True)
    checks.finish("fail")
    codes = np.where(np.isnan(track), -1, track).astype(np.int64)
    return AssignedReports(report, time, sensor, codes)
