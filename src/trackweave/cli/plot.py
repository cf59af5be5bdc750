"""The command ``plot``: the picture of a run from its files."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.cli.edge import Voice
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import CONFIRMED
from trackweave.errors import InvalidInputError
from trackweave.formats.reading import read_reports
from trackweave.io.output import OutputFile
from trackweave.io.run_files import RunFiles, read_run, reports_file
from trackweave.plotting import ScanSeries, Scene, picture_of_run
from trackweave.plotting.run import FORMATS
from trackweave.run.drawing import scene_of, series_of, with_reports

__all__ = ["run_plot"]

PICTURE, PAGE = "plot.png", "html"
# Times that were written to a file and read back may differ in the last digits.
SAME_REPORT_S = 1e-3


def run_plot(
    voice: Voice,
    directory: Path,
    *,
    out: Path | None = None,
    reports: Path | None = None,
    truth: Path | None = None,
    history: bool = False,
    pixels: bool = False,
) -> dict[str, Any]:
    """Draw a run and write the picture; return what is on it.

    What is not told is looked for in the directory, where a demo's run holds it, and reports then
    where the run says that they were.
    """
    out = directory / PICTURE if out is None else out
    ending = out.suffix.lower().removeprefix(".")
    if ending not in (*FORMATS, PAGE):
        raise InvalidInputError(
            f"--out: {out}; expected a name that ends in .png, .svg, .pdf or .html"
        )
    run = read_run(directory)
    file = reports_file(run) if reports is None else reports
    if truth is None and (directory / "truth.csv").is_file():
        truth = directory / "truth.csv"
    inputs = [*directory.glob("*.*"), file, truth]
    place = OutputFile(out)
    place.check([path for path in inputs if path is not None and path.name != PICTURE])
    table, assignment = None, None
    try:
        if file is not None:
            table = _read_reports(file, run)
            assignment = _assignment(file, table, run)
    except InvalidInputError as err:
        if reports is not None:
            raise
        # Those that nobody asked for may be others.
        table = None
        voice.say(f"{err}; so they are left out")
    scene = scene_of(run, truth, f"the run in {run.path}", history=history, pixels=pixels)
    if table is None:
        scene = replace(scene, title=_title(run))
    else:
        scene = with_reports(scene, table, assignment)
    series = series_of(run)
    if scene.truth is not None and not _meet(scene.truth.time, series.time):
        voice.say(
            f"{truth}: times from {scene.truth.time.min():.10g} to {scene.truth.time.max():.10g}, "
            f"while the run's scans are from {series.time.min():.10g} to "
            f"{series.time.max():.10g}; is it another recording's?"
        )
    if ending == PAGE:
        from trackweave.service.picture import page_of_run

        place.write(page_of_run(run, scene, series, directory.resolve().name))
    else:
        place.write(picture_of_run(scene, series, ending))
    if table is None:
        voice.say("reports are not drawn, for their positions are not in the run; see --reports")
    voice.say(f"The picture is {out}.")
    return _found(run, scene, series, out)


def _meet(one: FloatArray, other: FloatArray) -> bool:
    """Tell whether times of two kinds are there together; no times are with all."""
    if not (one.size and other.size):
        return True
    return bool(one.min() <= other.max() and other.min() <= one.max())


def _read_reports(path: Path, run: RunFiles) -> ReportTable:
    frame = run.frame
    origin = None if frame is None else (frame.latitude_deg, frame.longitude_deg)
    return read_reports(
        path,
        told=run.record["input"].get("format"),
        frame_origin=origin,
        frame_projection="tangent" if frame is None else frame.projection,
        on_bad_row="skip",  # as the run may have done
    )


def _assignment(path: Path, reports: ReportTable, run: RunFiles) -> dict[int, int]:
    """Return the track of each row of the reports, by identifier."""
    table = run.assignments
    track_of = dict(zip(table.report.tolist(), table.track.tolist(), strict=True))
    time_of = dict(zip(table.report.tolist(), table.time.tolist(), strict=True))
    strangers = sum(
        abs(time_of.get(name, np.inf) - time) > SAME_REPORT_S
        for name, time in zip(reports.report.tolist(), reports.time.tolist(), strict=True)
    )
    if strangers:
        raise InvalidInputError(
            f"{path}: {strangers} of {len(reports)} reports are not in "
            f"{run.path / 'assignments.csv'}; expected the reports that were tracked"
        )
    tracks = [track_of[name] for name in reports.report.tolist()]
    return {row: track for row, track in enumerate(tracks) if track >= 0}


def _title(run: RunFiles) -> str:
    n_tracks = np.unique(run.tracks.track[run.tracks.status >= CONFIRMED]).size
    view = " (seen from above)" if run.tracks.dim == 3 else ""
    return f"{n_tracks:,} tracks from {len(run.assignments):,} reports{view}; reports not at hand"


def _found(run: RunFiles, scene: Scene, series: ScanSeries, out: Path) -> dict[str, Any]:
    shown = scene.tracks.track[scene.tracks.status >= CONFIRMED]
    return {
        "out": str(out),
        "tracks": int(np.unique(shown).size),
        "reports": len(run.assignments),
        "reports_drawn": scene.reports is not None,
        "targets": None if scene.truth is None else len(set(scene.truth.target.tolist())),
        "scans": series.time.size,
        "proven_scans": int(series.proven.sum()),
    }
