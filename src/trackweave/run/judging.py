"""Tracks against the truth, whatever they come as."""

import os
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from trackweave.domain.frames import LocalFrame
from trackweave.domain.tracks import TrackTable
from trackweave.domain.truth import TruthTable
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.fields import checked_count, checked_number
from trackweave.formats.reading import load
from trackweave.io.frames_out import tracks_frame
from trackweave.io.tables import RawTable, TableSource, is_table_file
from trackweave.io.truth import read_assignments, read_tracks, read_truth_on_plane
from trackweave.metrics import AssignmentQuality, Evaluation, assignment_quality
from trackweave.metrics import evaluate as measure
from trackweave.run.result import Result, TrackingResult

__all__ = [
    "Claimed", "Truth", "compared", "doubts_on_cutoff", "doubts_on_times", "evaluate",
    "quality_in", "truth_on",
]  # fmt: skip

Truth: TypeAlias = TableSource | RawTable | TruthTable
Claimed: TypeAlias = TableSource | TrackTable | TruthTable | Result
SHARED = 0.5
"""Of the time of truth and tracks both usually have so much."""
# An IDF1 below this, and tracks so many cutoffs away at most, ask whether the cutoff is too small;
# at so many moments that is looked at.
RARELY, FARTHEST, MOMENTS = 0.3, 300.0, 50
# Another unit, other axes or a clock that is so many of the tracks' steps off explain it if
# targets are so many times nearer to tracks then.
CLEARLY, MOST_STEPS_LATER = 0.2, 40
# Of more rows of tracks a clock is not looked for: it takes as many looks as there are steps.
MOST_ROWS = 100_000


def evaluate(  # noqa: PLR0913 the one function that users call with everything
    truth: Truth | None = None,
    tracks: Claimed | None = None,
    assignments: TableSource | None = None,
    *,
    cutoff: float = 50.0,
    order: float = 2.0,
    max_gap: float | None = None,
    window: int = 10,
) -> Evaluation:
    """Return how far tracks are from the truth.

    Confirmed and coasting rows are interpolated linearly to the truth's times; nothing is
    extrapolated. Every measure is taken over these times. Where nobody knows where targets were,
    but of which target each report is, ``evaluate(assignments=...)`` has the measures of reports.

    Parameters
    ----------
    truth
        Where targets really were: a path of a CSV or Parquet file, a pandas, polars or Arrow
        table with ``time,target,x,y`` or ``time,target,lat,lon``, or a ``TruthTable``; a file of
        another format as ``trackweave formats`` lists them. None for the measures of reports
        alone.
    tracks
        What ``track`` or ``fuse`` returned, its ``tracks`` or ``history``, a path or table of
        tracks, a ``TrackTable``, or a ``TruthTable`` whose targets are the tracks' names. Without
        a truth a result of ``track`` whose reports tell their targets, or None.
    assignments
        A path or table of assignments with a column ``target``, for the measures of reports. A
        result of ``track`` has its own where its reports tell their targets.
    cutoff
        Distance from which a track is not a target's [m], in all measures; positive. Some five
        times the reports' noise is a fair choice: 50 suits noise of 10.
    order
        Exponent p of GOSPA, OSPA and OSPA(2); at least 1.
    max_gap
        Longest time between two rows of a track that is bridged [s]; None for 1.5 times the
        tracks' own period.
    window
        Number of the truth's times over which OSPA(2) is taken; at least 1.

    Returns
    -------
    All measures; those of reports are None where assignments or targets are not known.

    Raises
    ------
    InvalidInputError
        If a table cannot be used, dimensions or times do not fit together, or a parameter is out
        of range.

    Warns
    -----
    UserWarning
        Where truth and tracks share hardly any time, or lie farther apart than the cutoff.

    Examples
    --------
    >>> import polars as pl
    >>> from trackweave import evaluate
    >>> truth = pl.DataFrame({"time": [0, 1], "target": [1, 1], "x": [0, 9], "y": [0, 0]})
    >>> tracks = pl.DataFrame({"time": [0, 1], "track": [7, 7], "x": [3, 9], "y": [4, 0]})
    >>> evaluate(truth, tracks).motp
    2.5
    """
    cutoff, order = checked_number(cutoff, "cutoff"), checked_number(order, "order")
    max_gap = None if max_gap is None else checked_number(max_gap, "max_gap")
    window = checked_count(window, "window", 1)
    quality = quality_in(assignments) if assignments is not None else _own_quality(tracks)
    if truth is None:
        return _of_reports(quality if tracks is None or isinstance(tracks, Result) else None)
    true, claimed = compared(truth, tracks)
    for doubt in doubts_on_times(true, claimed):
        warnings.warn(doubt, UserWarning, stacklevel=2)
    found = measure(true, claimed, cutoff=cutoff, order=order, max_gap=max_gap, window=window)
    for doubt in doubts_on_cutoff(found, true, claimed):
        warnings.warn(doubt, UserWarning, stacklevel=2)
    return found if quality is None else found.with_assignments(quality)


def _of_reports(quality: AssignmentQuality | None) -> Evaluation:
    """Return the measures of reports alone; refuse what tells none."""
    if quality is None:
        raise InvalidInputError(
            "truth: None; expected where targets were, or assignments (or a result of track) with "
            "a column target and no other tracks, for the measures of reports alone"
        )
    return Evaluation().with_assignments(quality)


def compared(
    truth: Truth, tracks: Claimed | None, told: str | None = None
) -> tuple[TruthTable, TrackTable | TruthTable]:
    """Return truth and tracks as values, on one plane; refuse them where their times differ."""
    # ``told`` is the format of tracks that are no table, as ``load`` takes it.
    if isinstance(truth, TruthTable):
        true, frame = truth, None
    else:
        true, frame = read_truth_on_plane(_loaded(truth))
    found: Any = tracks
    if isinstance(tracks, Result):
        found = tracks.values.tracks
        if frame is not None:
            found = tracks_frame(found, tracks.values.frame)
    if isinstance(found, TrackTable | TruthTable):
        if frame is not None:
            raise InvalidInputError(
                f"truth: in latitudes and longitudes, which a {type(found).__name__} is not; "
                "expected columns x and y, or tracks as a table with lat and lon"
            )
        claimed: TrackTable | TruthTable = found
    else:
        claimed = read_tracks(_tracks_loaded(found, told), frame)
    _require_common_time(_named(truth, "truth"), true, _named(tracks, "tracks"), claimed)
    return true, claimed


def truth_on(truth: Truth, frame: LocalFrame | None, place: str) -> TruthTable:
    """Return the truth on a run's own plane; refuse one in latitudes where the run is not."""
    if isinstance(truth, TruthTable):
        return truth
    true, plane = read_truth_on_plane(_loaded(truth), frame)
    if frame is None and plane is not None:
        raise InvalidInputError(
            f"{_named(truth, 'truth')}: in latitudes and longitudes, which {place} is not; "
            "expected columns x and y"
        )
    return true


def _loaded(truth: Any) -> Any:
    """Return the table of a truth that is a file of any format, anything else as it is."""
    return load(truth) if isinstance(truth, str | os.PathLike) else truth


def _tracks_loaded(tracks: Any, told: str | None) -> Any:
    """Return the table of tracks in a file of a format of reports, anything else as it is."""
    # As trackers of video write them; what stands for the target there is the track.
    if not isinstance(tracks, str | os.PathLike):
        return tracks
    tracks = Path(tracks)
    if (tracks / "tracks.csv").is_file():  # a run's directory
        tracks = tracks / "tracks.csv"
    if is_table_file(tracks):
        return tracks
    table = load(tracks, told)
    if "track" in table.columns.columns or "target" not in table.columns.columns:
        return table
    return replace(table, columns=table.columns.rename({"target": "track"}))


def quality_in(assignments: TableSource) -> AssignmentQuality:
    """Return how rightly reports were assigned, of a table with a column ``target``."""
    table = read_assignments(assignments)
    if table.target is None:
        raise DataFormatError(
            f"{_named(assignments, 'assignments')}: no column target; expected the truth of each "
            "report, which passes through when the reports have it"
        )
    return assignment_quality(table.target, table.track)


def _own_quality(tracks: Claimed | None) -> AssignmentQuality | None:
    """Return the measures of the reports of a result that knows their targets."""
    if not isinstance(tracks, TrackingResult) or "target" not in tracks.values.reports.carried:
        return None
    values, reports = tracks.values, tracks.values.reports
    given = [values.assignment.get(row, -1) for row in range(len(reports))]
    targets = list(reports.carried["target"])
    if reports.unavailable is not None:
        # In assignments.csv they have a row each, of no track.
        targets += list(reports.unavailable.carried["target"])
    return assignment_quality(targets, given + [-1] * (len(targets) - len(given)))


def _named(source: object, otherwise: str) -> str:
    """Return what messages call a table."""
    if isinstance(source, RawTable):
        return source.name
    return str(source) if isinstance(source, str | os.PathLike) else otherwise


def doubts_on_times(true: TruthTable, claimed: TrackTable | TruthTable) -> list[str]:
    """Return a sentence where truth and tracks share less than half of the time of either."""
    if len(true) == 0 or len(claimed) == 0:
        return []
    spans = [(float(table.time.min()), float(table.time.max())) for table in (true, claimed)]
    (begin, end), (first, last) = spans
    shared = min(end, last) - max(begin, first)
    if shared >= SHARED * max(end - begin, last - first):
        return []
    return [
        f"truth is from {begin:.15g} to {end:.15g} s and tracks from {first:.15g} to {last:.15g} "
        "s: if both are of the same, one counts its times otherwise, such as 25 frames a second "
        "for 10"
    ]


def doubts_on_cutoff(
    found: Evaluation, true: TruthTable, claimed: TrackTable | TruthTable
) -> list[str]:
    """Return a sentence where most targets' nearest track is beyond the cutoff all the time."""
    # It tells the unit, the axes or the clock of the truth where these explain that.
    cutoff = found.cutoff
    if cutoff is None or found.idf1 is None or found.idf1 >= RARELY or not len(claimed):
        return []
    usual = _usually_apart(true, claimed)
    if not cutoff < usual < np.inf:
        return []
    for words, apart in _otherwise(true, claimed):
        if apart < min(cutoff, CLEARLY * usual):
            return [
                f"truth: half of the targets have no track nearer than {usual:.3g} m at a time, "
                f"but {apart:.3g} m if {words}; expected metres, x east, y north and the tracks' "
                "clock"
            ]
    if usual >= FARTHEST * cutoff:
        return []
    return [
        f"cutoff {cutoff:g} m: half of the targets have no track nearer than {usual:.3g} m at a "
        "time; if reports are no more exact than that, a larger cutoff judges them"
    ]


def _otherwise(true: TruthTable, claimed: TrackTable | TruthTable) -> Iterator[tuple[str, float]]:
    """Yield what a truth's numbers may mean, and how far apart targets and tracks are then."""
    for unit, metres in (("kilometres", 1e3), ("millimetres", 1e-3), ("nautical miles", 1852.0)):
        changed = replace(true, position=metres * true.position)
        yield f"it is in {unit}", _usually_apart(changed, claimed)
    order = [1, 0, *range(2, true.dim)]
    swapped = replace(true, position=true.position[:, order])
    yield "its x and y are exchanged", _usually_apart(swapped, claimed)
    if len(claimed) > MOST_ROWS:
        return
    times = np.unique(claimed.time)
    step = float(np.median(np.diff(times))) if times.size > 1 else 0.0
    later = step * np.arange(1, MOST_STEPS_LATER + 1)
    apart = {
        sign * each: _usually_apart(replace(true, time=true.time - sign * each), claimed)
        for each in later.tolist()
        for sign in (1.0, -1.0)
    }
    if apart:
        best = min(apart, key=lambda each: apart[each])
        way = "ahead" if best > 0 else "behind"
        yield f"its clock is some {abs(best):.3g} s {way}", apart[best]


def _usually_apart(true: TruthTable, claimed: TrackTable | TruthTable) -> float:
    """Return how far the nearest track is usually from a target [m]; infinite for none."""
    place = claimed.position if isinstance(claimed, TruthTable) else claimed.mean
    nearest, moments = list[float](), np.unique(true.time)
    some = moments[np.unique(np.linspace(0, moments.size - 1, MOMENTS).astype(np.int64))]
    step = float(np.median(np.diff(moments))) if moments.size > 1 else 0.0
    for moment in some.tolist():
        # Truth is interpolated for the measures; to tell what is far off, the nearest rows do.
        apart = np.abs(claimed.time - moment)
        rows = apart <= max(float(apart.min()), 0.5 * step)
        there = true.position[true.time == moment]
        if float(apart.min()) <= step:
            offset = there[:, None] - place[rows, : true.dim][None]
            nearest += np.linalg.norm(offset, axis=2).min(axis=1).tolist()
    return float(np.median(nearest)) if nearest else np.inf


def _require_common_time(
    truth: str, true: TruthTable, tracks: str, claimed: TrackTable | TruthTable
) -> None:
    """Refuse tracks of another time: every measure would say that nothing was found."""
    if len(true) == 0 or len(claimed) == 0:
        return
    (begin, end), (first, last) = (
        (float(table.time.min()), float(table.time.max())) for table in (true, claimed)
    )
    if last < begin or first > end:
        raise InvalidInputError(
            f"{tracks}: from {first:.15g} to {last:.15g} s, {truth}: from {begin:.15g} to "
            f"{end:.15g} s; expected tracks and truth of the same time"
        )
