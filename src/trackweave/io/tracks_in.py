"""Tables of tracks: where each track was, how fast and how surely, row by row."""

from dataclasses import dataclass, replace
from itertools import combinations_with_replacement
from typing import NamedTuple, Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.frames import LocalFrame
from trackweave.domain.tracks import CONFIRMED, STATUSES, TrackTable
from trackweave.errors import DataFormatError
from trackweave.io.checks import Range, RowChecks, checks_of
from trackweave.io.columns import BoolArray, text_array
from trackweave.io.positions import LATITUDE, LONGITUDE, TRACK_COVARIANCE, TRACK_PLACE, TRACK_SPEED
from trackweave.io.tables import TableSource
from trackweave.summaries import summary

__all__ = [
    "TRACK",
    "LocalTracks",
    "States",
    "covariance_names",
    "read_local_tracks",
    "read_priors",
    "read_states",
    "read_status",
    "state_names",
    "track_table",
]

TRACK = Range(0.0, 2.0**53, expected="a whole number")
_SCORE = Range(-1e300, 1e300)
# How far two planes may lay one position apart and still be called the same [m].
_SAME_PLACE_M = 1.0
_WHAT = "a tracks table with velocities and covariances"


class States(NamedTuple):
    """What each row says, in the table's order; meaningless in bad rows."""

    time: FloatArray
    iso_time: bool
    track: FloatArray
    status: IntArray
    mean: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class LocalTracks:
    """All that one sensor's tracker said, one row per track and time.

    Parameters
    ----------
    name
        What messages call the table.
    tracks
        Its rows, sorted by time, then track; their scores and hits are 0.
    latitude, longitude
        Where each row is [degrees], None where the table does not say.
    iso_time
        Whether times came as ISO 8601; they are seconds from 1970 UTC then.
    kind
        Library that the table came from: "polars" (also for files), "pandas" or "pyarrow".
    n_left_out
        Number of tentative rows that do not take part.
    is_tentative
        Whether all rows are tentative ones, there being no others.

    Examples
    --------
    >>> import polars as pl
    >>> import trackweave as tw
    >>> reports = pl.DataFrame({"t": range(9), "x": range(0, 90, 10), "y": [1, 0, 1] * 3})
    >>> local = tw.read_local_tracks(tw.track(reports).tracks)
    >>> local.tracks.track[-1], local.tracks.time[-1]
    (np.int64(1), np.float64(8.0))
    """

    name: str
    tracks: TrackTable
    latitude: FloatArray | None = None
    longitude: FloatArray | None = None
    iso_time: bool = False
    kind: str = "polars"
    n_left_out: int = 0
    is_tentative: bool = False

    __repr__ = summary

    def __len__(self) -> int:
        return len(self.tracks)

    def with_states(self, mean: FloatArray, covariance: FloatArray) -> Self:
        """Return the same rows with other states, such as on another plane."""
        return replace(self, tracks=replace(self.tracks, mean=mean, covariance=covariance))


def state_names(dim: int) -> tuple[str, ...]:
    """Return the names of a state's components in 2 or 3 dimensions, such as x, y, vx, vy."""
    axes = ("x", "y", "z")[:dim]
    return (*axes, *(f"v{axis}" for axis in axes))


def covariance_names(dim: int) -> tuple[str, ...]:
    """Return the names of the upper triangle of a state's covariance: p_x_x, p_x_y, p_x_vx, …."""
    pairs = combinations_with_replacement(state_names(dim), 2)
    return tuple(f"p_{first}_{second}" for first, second in pairs)


def read_local_tracks(source: TableSource) -> LocalTracks:
    """Read the tracks of one sensor: confirmed and coasting rows, all where there is no status.

    Needed are ``time,track,x,y[,z],vx,vy[,vz]`` and the upper triangle of the covariance,
    ``p_x_x,p_x_y,p_x_vx,…``; ``lat,lon`` are kept where they are. Where all rows are tentative
    they are taken.

    Parameters
    ----------
    source
        A path that ends in .csv, .csv.gz or .parquet, or a pandas, polars or Arrow table; it may
        have no rows.

    Returns
    -------
    The rows.

    Raises
    ------
    DataFormatError
        If the table is not one of tracks with covariances, a row is bad, or a track has two rows
        at one time.

    Examples
    --------
    >>> import polars as pl
    >>> import trackweave as tw
    >>> reports = pl.DataFrame({"t": range(9), "x": range(0, 90, 10), "y": [1, 0, 1] * 3})
    >>> tw.read_local_tracks(tw.track(reports).tracks).tracks.dim
    2
    """
    checks = checks_of(source, may_be_empty=True)
    states, covariance = _whole_states(checks)
    latitude = longitude = None
    if checks.filled("lat") and checks.filled("lon"):
        latitude, longitude = checks.numbers("lat", LATITUDE), checks.numbers("lon", LONGITUDE)
    takes_part = states.status >= CONFIRMED
    is_tentative = bool(len(checks)) and not takes_part.any()
    takes_part |= is_tentative
    _refuse_doubles(checks, states, takes_part)
    checks.finish("fail")
    order = np.lexsort((states.track, states.time))
    order = order[takes_part[order]]
    return LocalTracks(
        checks.name,
        track_table(states, covariance, order),
        None if latitude is None else latitude[order],
        None if longitude is None else longitude[order],
        states.iso_time, checks.kind, int(len(checks) - order.size), is_tentative,
    )  # fmt: skip


def read_priors(source: TableSource, frame: LocalFrame | None = None) -> TrackTable:
    """Return the last row of each track that lives at the end of a tracks table, by track."""
    # A track whose last row is older than the table's newest by its usual time between rows, the
    # median over all tracks, or by more has ended and does not come back. Where no track has two
    # rows, as in a table made by hand, all are taken. Tentative tracks are left out unless there
    # are no others. Where they are missing, ``status`` is confirmed, ``score`` and ``hits`` are 0
    # and ``last_update`` is the row's time. Where the table has ``lat,lon`` too, they must lie on
    # the reports' plane at ``x,y``: tracks of another plane are refused.
    checks = checks_of(source, may_be_empty=True)
    states, covariance = _whole_states(checks)
    if frame is not None:
        _require_same_plane(checks, frame, states.mean)
    score = np.nan_to_num(checks.optional_numbers("score", _SCORE))
    hits = np.nan_to_num(checks.optional_numbers("hits", TRACK))
    time = last_update = states.time
    if checks.filled("last_update"):
        updates, _ = checks.times("last_update", optional=True)
        last_update = np.where(np.isnan(updates), time, updates)
    checks.finish("fail")
    # A stable sort: of two rows of one track and time the later row is the last.
    order = np.lexsort((time, states.track))
    last = order[np.flatnonzero(np.diff(states.track[order], append=np.inf))]
    last = last[_alive(time[order], states.track[order], time[last])]
    if np.any(states.status >= CONFIRMED):
        last = last[states.status[last] >= CONFIRMED]
    return replace(
        track_table(states, covariance, last),
        score=score[last],
        hits=hits[last].astype(np.int64),
        last_update=last_update[last],
    )


def read_states(checks: RowChecks, dim: int, needed: tuple[str, ...], what: str) -> States:
    """Return what each row says; ``needed`` are columns beside times, tracks and states."""
    for name in ("time", "track", *state_names(dim), *needed):
        checks.require(name, what)
    time, iso_time = checks.times("time")
    track = checks.whole_numbers("track", TRACK)
    within = (TRACK_PLACE,) * dim + (TRACK_SPEED,) * dim
    mean = [
        checks.numbers(name, limits) for name, limits in zip(state_names(dim), within, strict=True)
    ]
    return States(time, iso_time, track, read_status(checks), np.stack(mean, axis=-1))


def read_status(checks: RowChecks) -> IntArray:
    """Return the codes of ``status``, -1 in bad rows; CONFIRMED where there is no such column."""
    if "status" not in checks.names:
        return np.full(len(checks), CONFIRMED)
    words = text_array(checks.text("status"))
    codes = np.full(len(words), -1, dtype=np.int64)
    for code, word in enumerate(STATUSES):
        codes[words == word] = code
    checks.refuse("status", codes < 0, "tentative, confirmed or coasting")
    return codes


def _whole_states(checks: RowChecks) -> tuple[States, FloatArray]:
    """Return states and covariances of a table of two or three dimensions."""
    has_height = checks.filled("z") or (len(checks) == 0 and {"z", "vz"} <= set(checks.names))
    dim = 3 if has_height else 2
    states = read_states(checks, dim, covariance_names(dim), _WHAT)
    return states, _read_covariances(checks, dim)


def track_table(states: States, covariance: FloatArray, rows: IntArray) -> TrackTable:
    """Return some rows; nothing is said of their scores and hits."""
    nothing, time = np.zeros(rows.size), states.time[rows]
    return TrackTable(
        time, states.track[rows].astype(np.int64), states.status[rows], states.mean[rows],
        covariance[rows], nothing, nothing.astype(np.int64), time,
    )  # fmt: skip


def _read_covariances(checks: RowChecks, dim: int) -> FloatArray:
    """Return covariances; a row whose numbers make no positive definite matrix is refused."""
    n = 2 * dim
    matrices = np.empty((len(checks), n, n))
    pairs = combinations_with_replacement(range(n), 2)
    for (row, column), name in zip(pairs, covariance_names(dim), strict=True):
        values = checks.numbers(name, TRACK_COVARIANCE)
        matrices[:, row, column] = matrices[:, column, row] = values
    good = np.flatnonzero(checks.good)
    bad = np.zeros(len(checks), dtype=bool)
    if good.size:
        # Scaled to correlations: metres and metres per second may differ in size by far.
        variances = np.diagonal(matrices[good], axis1=1, axis2=2)
        scale = 1.0 / np.sqrt(np.where(variances > 0, variances, 1.0))
        correlations = matrices[good] * scale[:, :, np.newaxis] * scale[:, np.newaxis, :]
        smallest = np.linalg.eigvalsh(correlations)[:, 0]
        bad[good] = (variances <= 0).any(axis=1) | (smallest <= 0)
    checks.refuse("p_x_x", bad, "the start of a positive definite covariance")
    return matrices


def _refuse_doubles(checks: RowChecks, states: States, takes_part: BoolArray) -> None:
    """Complain of every row but the first of a track at one time."""
    rows = np.flatnonzero(takes_part & checks.good)
    key = rows[np.lexsort((rows, states.time[rows], states.track[rows]))]
    same = (np.diff(states.track[key]) == 0) & (np.diff(states.time[key]) == 0)
    again = np.zeros(len(checks), dtype=np.bool_)
    again[key[1:][same]] = True
    checks.refuse("track", again, "one row of a track at one time")


def _alive(time: FloatArray, track: FloatArray, last: FloatArray) -> BoolArray:
    """Return which tracks live at the end; rows come by track, then time."""
    gaps = np.diff(time)[np.diff(track) == 0]
    gaps = gaps[gaps > 0]
    if gaps.size == 0:
        return np.ones(last.size, dtype=np.bool_)
    # Times are sums of periods, so that one period may come a rounding error short.
    return np.asarray(last.max() - last < np.median(gaps) * (1 - 1e-6))


def _require_same_plane(checks: RowChecks, frame: LocalFrame, mean: FloatArray) -> None:
    if not (checks.filled("lat") and checks.filled("lon")):
        return
    latitude, longitude = checks.numbers("lat", LATITUDE), checks.numbers("lon", LONGITUDE)
    good = checks.good
    here = frame.to_plane(latitude[good], longitude[good], np.zeros(int(good.sum())))[:, :2]
    apart = np.abs(here - mean[good, :2]).max(initial=0.0)
    if apart > _SAME_PLACE_M:
        raise DataFormatError(
            f"{checks.name}, columns x and y: on another plane than the reports, {apart:.0f} m "
            f"apart; expected the plane with its origin at latitude {frame.latitude_deg:g}, "
            f"longitude {frame.longitude_deg:g} (or [frame] origin as in that run's run.json)"
        )
