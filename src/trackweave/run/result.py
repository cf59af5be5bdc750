"""What a run found, in one's hands: tables, pictures, measures, files, and a few lines of text."""

import os
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray
from trackweave.config.fill import Settings
from trackweave.domain.frames import LocalFrame
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import TrackTable
from trackweave.formats.format import Output
from trackweave.formats.track_rows import framed_rows, parents
from trackweave.io.columns import datetime_column, iso_text
from trackweave.io.encoding import encode_table
from trackweave.io.frames_out import assignments_frame, tracks_frame, with_parents
from trackweave.io.marking import marked
from trackweave.io.output import OutputDirectory
from trackweave.summaries import counted, summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from narwhals.typing import IntoDataFrame

    from trackweave.metrics import Evaluation
    from trackweave.run.judging import Truth

    Table = TypeVar("Table", bound=IntoDataFrame)
else:
    Table = TypeVar("Table")

__all__ = ["Result", "RunValues", "Table", "TrackingResult", "named"]

MOST_NAMES = 4


class Result(ABC):
    """What a run found; it prints as a few lines, never as its whole content."""

    run: dict[str, Any]
    values: Any

    @abstractmethod
    def _facts(self) -> dict[str, str]:
        """Return what there is to be said, a line for each name."""

    def __repr__(self) -> str:
        lines = [f"{name}: {told}" for name, told in self._facts().items()]
        return "\n  ".join([type(self).__name__, *lines])


@dataclass(frozen=True, slots=True, eq=False)
class RunValues:
    """A run's results as values of ``trackweave.domain``."""

    reports: ReportTable
    """What was tracked."""
    tracks: TrackTable
    """What was known after each scan."""
    history: TrackTable
    """Amended and smoothed after the fact."""
    assignment: Mapping[int, int]
    """From a report's row to its track."""
    settings: Settings
    """The configuration as used."""
    probability: FloatArray
    """Probability of each report's assignment, NaN where there is none."""
    parent: Mapping[int, int] | None = None
    """From a track to the one that it came of by division; None where none was looked for."""
    shared: Mapping[int, int] | None = None
    """From a merged report's row to the second track that it may be of; None where none was
    looked for."""

    __repr__ = summary

    @property
    def frame(self) -> LocalFrame | None:
        """The plane on which latitudes and longitudes were laid, None for plane coordinates."""
        return self.reports.frame

    def frames(self) -> dict[str, pl.DataFrame]:
        """Return the tables of a run by the names of their files."""
        found = assignments_frame(
            self.reports, self.assignment, self.probability, shared=self.shared
        )
        both = {"tracks": self.tracks, "history": self.history}
        frames = {
            name: tracks_frame(each, self.frame, iso_time=self.reports.iso_time)
            for name, each in both.items()
        }
        if self.parent is not None:
            frames = {name: with_parents(each, self.parent) for name, each in frames.items()}
        return {"tracks": frames["tracks"], "assignments": found, "history": frames["history"]}


@dataclass(frozen=True, eq=False, repr=False)
class TrackingResult(Result, Generic[Table]):
    """What a run found. Tables are of the kind that came in; of a file's reports, of polars.

    Parameters
    ----------
    tracks
        What was known after each scan, one row per live track.
    assignments
        One row per report with its track, after all amendments, in the order in which the reports
        came; no track = false alarm.
    history
        Like tracks, amended and smoothed after the fact.
    run
        The record of the run: configuration as used, each scan's cost and bound, totals.
    values
        The same as values of the library.
    inputs
        The files that were read.

    Examples
    --------
    >>> import polars as pl
    >>> import trackweave as tw
    >>> frames = pl.DataFrame({"frame": [2, 0, 1, 3], "x": [4.1, 0.0, 2.0, 6.0], "y": [1.0] * 4})
    >>> result = tw.track(frames)
    >>> result.reports.columns
    ['frame', 'x', 'y', 'track', 'probability']
    >>> print(repr(result).splitlines()[1])
      tracks: 1 from 4 reports, 100.0 % of them assigned
    >>> result.evaluate(frames.with_columns(target=1)).n_found
    1
    >>> result.plot().savefig("run.png")  # doctest: +SKIP
    >>> result.save("result")  # doctest: +SKIP
    """

    tracks: Table
    assignments: Table
    history: Table
    run: dict[str, Any]
    values: RunValues
    inputs: tuple[str | os.PathLike[str], ...] = ()
    _reports: Table | None = field(default=None)

    @cached_property
    def reports(self) -> Table:
        """The table that came in, row for row, with the columns ``track`` and ``probability``.

        Order, index, columns and their types are those of the table. Where it has columns of
        these two names itself, they are called ``reports_track`` and ``reports_probability``. A
        row that is of no track, or was skipped, has none. Of reports that came as a
        ``ReportTable``, the columns that a file of them has.
        """
        if self._reports is not None:
            return self._reports
        reports: Table = marked(None, self.values.reports, self.values.frames()["assignments"])
        return reports

    def plot(
        self, truth: "Truth | None" = None, *, history: bool = False, pixels: bool = False
    ) -> "Figure":
        """Draw the run as ``trackweave plot`` does.

        Parameters
        ----------
        truth
            Where targets really were, as ``evaluate`` takes it.
        history
            Whether to draw the smoothed history instead of what was known then.
        pixels
            Whether positions are those of an image, in pixels, y downwards.

        Returns
        -------
        A figure of matplotlib: the plan from above, and curves over time.

        Raises
        ------
        InvalidInputError
            If the truth cannot be used.
        """
        from trackweave.run.drawing import figure_of_result

        return figure_of_result(self, truth, history=history, pixels=pixels)

    def evaluate(
        self,
        truth: "Truth | None" = None,
        *,
        cutoff: float = 50.0,
        order: float = 2.0,
        max_gap: float | None = None,
        window: int = 10,
    ) -> "Evaluation":
        """Return how far the tracks are from the truth; see ``trackweave.evaluate``.

        Parameters
        ----------
        truth
            Where targets really were: a path or a table with ``time,target,x,y``. Left out, the
            measures of reports alone, which have to tell their targets.
        cutoff, order, max_gap, window
            As ``trackweave.evaluate`` takes them.

        Returns
        -------
        All measures, those of reports too where the reports tell their targets.

        Raises
        ------
        InvalidInputError
            If the truth cannot be used, or a parameter is out of range.
        """
        from trackweave.run.judging import evaluate

        return evaluate(truth, self, cutoff=cutoff, order=order, max_gap=max_gap, window=window)

    def save(self, directory: str | os.PathLike[str]) -> None:
        """Write the files of ``trackweave track --out``, all of them or none.

        Parameters
        ----------
        directory
            A new or empty directory, or that of an earlier run, whose files are replaced.

        Raises
        ------
        OutputError
            If the directory is another, or the environment refuses.
        """
        place = OutputDirectory(directory, "track")
        place.check(self.inputs)
        place.write(self.files(), self.run)

    def files(self) -> dict[str, bytes]:
        """Return the files of a run but for its record, by name."""
        own = {"tracks": self.tracks, "assignments": self.assignments, "history": self.history}
        frames: Any = own if self.values.reports.kind == "polars" else self.values.frames()
        return {f"{name}.csv": encode_table(frames[name], f"{name}.csv") for name in own}

    def output(self) -> Output:
        """Return what writers of further formats take."""
        frames = self.values.frames()
        return Output(
            frames["tracks"], frames["history"], frames["assignments"], self.values.frame
        )

    def to_napari(self) -> tuple[FloatArray, dict[str, Any], dict[int, list[int]]]:
        """Return what ``napari.Viewer.add_tracks`` takes.

        Returns
        -------
        A row for each state (track, frame, then z where there is one, y and x), properties of the
        rows, and the graph of tracks that come from others. Frames count the different times of
        the history from 0.
        """
        rows = framed_rows(self.output(), "napari")
        axes = ["z", "y", "x"] if self.values.reports.dim == 3 else ["y", "x"]
        data = rows.select("track", "frame", *axes).cast(pl.Float64).to_numpy()
        features = {"time": rows["seconds"].to_numpy(), "track": rows["track"].to_numpy()}
        graph = {track: [parent] for track, parent in sorted(parents(rows).items())}
        return data, features, graph

    def _facts(self) -> dict[str, str]:
        totals, told = self.run["totals"], self.run["input"]
        share = totals["assigned_reports"] / max(1, totals["reports"])
        first, last = told["first_time"], told["last_time"]
        span = f"{first:g} to {last:g} s"
        if self.values.reports.iso_time:
            span = " to ".join(iso_text(datetime_column("time", np.array([first, last]))))
        gap = totals["worst_gap"]
        worst = "no bound" if gap is None else f"worst gap {100 * gap:.2g} %"
        return {
            "tracks": f"{totals['tracks']:,} from {counted(totals['reports'], 'report')}, "
            f"{100 * share:.1f} % of them assigned",
            "sensors": named(told["sensors"]),
            "time": f"{span}, {counted(totals['scans'], 'scan')}",
            "certainty": f"{worst}, {totals['proven_scans']:,} scans proven optimal, "
            f"{totals['scans_optimal_among_kept']:,} among what was kept; "
            f'{counted(len(self.run["notes"]), "note")} in .run["notes"]',
        }

    def _repr_html_(self) -> str:
        from trackweave.run.drawing import inline_picture

        rows = "".join(
            f'<tr><th style="text-align:left">{escape(name)}</th>'
            f'<td style="text-align:left">{escape(told)}</td></tr>'
            for name, told in self._facts().items()
        )
        return f"<table>{rows}</table>{inline_picture(self)}"


def named(names: list[str]) -> str:
    """Return how many there are and what the first are called, such as 2 (north, south)."""
    more = ", …" if len(names) > MOST_NAMES else ""
    listed = ", ".join(f"{name:.20}" for name in names[:MOST_NAMES])
    return f"{len(names):,} ({listed}{more})"
