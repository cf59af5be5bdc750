"""What a run left in its directory, read back."""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.frames import LocalFrame, Projection
from trackweave.domain.tracks import TrackTable
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.io.checks import Range, RowChecks
from trackweave.io.columns import text_array
from trackweave.io.output import RECORD
from trackweave.io.positions import TRACK_COVARIANCE, TRACK_PLACE, TRACK_SPEED, require_origin
from trackweave.io.priors import covariance_names, state_names
from trackweave.io.tables import load_table
from trackweave.io.truth import read_status

__all__ = ["AssignedReports", "RunFiles", "read_run"]

COMMANDS = ("track", "demo")
TABLES = ("tracks.csv", "history.csv", "assignments.csv")
_TRACK = Range(0.0, 2.0**53, expected="a whole number")


@dataclass(frozen=True, slots=True, eq=False)
class AssignedReports:
    """When each report came, from whom, and whether it has a track.

    Parameters
    ----------
    report
        Identifier of each report as text, shape (reports,).
    time
        Time of each report [s].
    sensor
        Name of its sensor.
    track
        Its track, -1 for a false alarm.
    """

    report: np.ndarray[Any, Any]
    time: FloatArray
    sensor: np.ndarray[Any, Any]
    track: IntArray

    def __len__(self) -> int:
        return len(self.time)


@dataclass(frozen=True, slots=True, eq=False)
class RunFiles:
    """A run as its files tell it.

    Parameters
    ----------
    path
        Its directory.
    record
        Content of run.json.
    tracks
        What was known after each scan; of the covariances only what belongs to positions.
    history
        The same, amended and smoothed after the fact.
    assignments
        Which report belongs to which track.
    frame
        The plane on which latitudes and longitudes were laid, None for plane coordinates.
    iso_time
        Whether times came as ISO 8601.
    """

    path: Path
    record: dict[str, Any]
    tracks: TrackTable
    history: TrackTable
    assignments: AssignedReports
    frame: LocalFrame | None
    iso_time: bool

    def scans(self, *keys: str) -> list[FloatArray]:
        """Return what run.json says of each scan under some keys, NaN for null.

        Parameters
        ----------
        keys
            Such as ``gap``.

        Returns
        -------
        One array for each key, shape (scans,).

        Raises
        ------
        DataFormatError
            If a key is missing or holds no numbers.
        """
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
        """Return where the configuration says that sensors stand.

        Returns
        -------
        Places [m] by the sensors' names, without those of which nothing is said.

        Raises
        ------
        DataFormatError
            If the record says something else than two or three numbers.
        """
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
    """Read the files that ``trackweave track`` or ``demo`` wrote.

    Parameters
    ----------
    directory
        The run's ``--out``.

    Returns
    -------
    What they hold.

    Raises
    ------
    DataFormatError
        If this is no directory of such a run, or a file of it is missing or damaged.
    """
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
    names = state_names(dim)
    n = 2 * dim
    for name in ("time", "track", "status", *names):
        checks.require(name, "a tracks table")
    time, iso = checks.times("time")
    track = checks.whole_numbers("track", _TRACK)
    status = read_status(checks)
    mean = np.stack(
        [
            checks.numbers(name, TRACK_SPEED if name.startswith("v") else TRACK_PLACE)
            for name in names
        ],
        -1,
    )
    covariance = np.zeros((len(checks), n, n))
    for name in covariance_names(dim):
        first, second = (names.index(axis) for axis in name.split("_")[1:])
        if first < dim and second < dim and name in checks.names:
            values = checks.numbers(name, TRACK_COVARIANCE)
            covariance[:, first, second] = covariance[:, second, first] = values
    checks.finish("fail")
    nothing = np.zeros(len(checks))
    codes = track.astype(np.int64)
    table = TrackTable(
        time, codes, status, mean, covariance, nothing, nothing.astype(np.int64), time
    )
    return table, iso


def _assignments(path: Path) -> AssignedReports:
    checks = RowChecks(load_table(path, may_be_empty=True))
    for name in ("report", "time", "sensor", "track"):
        checks.require(name, "an assignments table")
    report = text_array(checks.text("report", "an identifier"))
    time, _ = checks.times("time")
    sensor = text_array(checks.text("sensor"))
    track = checks.numbers("track", _TRACK, optional=True)
    checks.finish("fail")
    codes = np.where(np.isnan(track), -1, track).astype(np.int64)
    return AssignedReports(report, time, sensor, codes)
