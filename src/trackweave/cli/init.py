"""The command ``init``."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from trackweave.cli.edge import Voice, telling_compiling
from trackweave.cli.track import what_was_assumed
from trackweave.config import load_configuration
from trackweave.config.fill import Settings
from trackweave.config.write import commented_toml
from trackweave.domain.reports import ReportTable
from trackweave.errors import InvalidInputError, OutputError
from trackweave.io.output import OutputFile
from trackweave.io.reports import read_reports
from trackweave.run.doubles import doubles_of
from trackweave.run.observing import settle

__all__ = ["InitRequest", "run_init"]


@dataclass(frozen=True, slots=True)
class InitRequest:
    """What the command was asked for.

    Parameters
    ----------
    reports
        File of reports.
    out
        File for the configuration.
    force
        Whether to replace a file that is there.
    on_bad_row
        Whether to stop at a bad row or to go on.
    """

    reports: Path
    out: Path
    force: bool = False
    on_bad_row: Literal["fail", "skip"] | str = "fail"


@telling_compiling
def run_init(request: InitRequest, voice: Voice) -> dict[str, Any]:
    """Estimate a configuration, write it with comments, and return what was found."""
    place = OutputFile(request.out)
    place.check([request.reports])
    if request.out.exists() and not request.force:
        raise OutputError(f"{request.out}: there already; --force replaces it")
    reports = read_reports(
        request.reports, on_bad_row="skip" if request.on_bad_row == "skip" else "fail"
    )
    if len(reports) == 0:
        raise InvalidInputError(f"{request.reports}: no rows; expected at least one report")
    configuration = load_configuration(None)
    doubles, (settings, estimates) = doubles_of(
        reports, lambda once: settle(once, configuration, to_be_edited=True)
    )
    # What a run takes where nobody says a seed.
    notes = (*reports.notes, *doubles.notes(), *settings.notes)
    settings = replace(settings, values={**settings.values, "seed": 0}, notes=notes)
    text = commented_toml(
        settings,
        head=_head(request.reports, reports),
        remarks=estimates.remarks if estimates else {},
        doubts=estimates.doubts if estimates else {},
    )
    place.write(text.encode("utf-8"))
    found = _found(settings, request.out)
    for line in [*what_was_assumed(found), *settings.notes]:
        voice.say(line)
    voice.say(f"written: {request.out}")
    return found


def _found(settings: Settings, out: Path) -> dict[str, Any]:
    return {
        "out": str(out),
        "configuration": settings.values,
        "sources": settings.sources,
        "notes": list(settings.notes),
    }


def _head(source: Path, reports: ReportTable) -> list[str]:
    """Return what is said at the top of the file."""
    span = float(reports.time[-1] - reports.time[0])
    n_sensors = len(reports.sensors)
    return [
        f"Written by trackweave init from {source.name}: {len(reports)} reports of "
        f"{n_sensors} sensor{'' if n_sensors == 1 else 's'} in {span:.6g} s.",
        "Behind each value stands where it came from: estimated from these reports, or the "
        "default. An estimate is a start, and no replacement for a data sheet: write down what "
        "you know better. A key that is taken out is estimated anew at each run.",
    ]
