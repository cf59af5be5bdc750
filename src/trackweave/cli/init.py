"""The command ``init``."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from trackweave.cli.edge import Voice
from trackweave.cli.track import what_was_assumed
from trackweave.config import load_configuration
from trackweave.config.fill import Settings
from trackweave.config.learned import learned_keys
from trackweave.config.write import commented_toml
from trackweave.domain.reports import ReportTable
from trackweave.errors import InvalidInputError, OutputError
from trackweave.estimation.refine import LEAST_CHAINS_REPORTS
from trackweave.formats.reading import read_reports
from trackweave.io.output import OutputFile
from trackweave.io.tables import OnBadRow
from trackweave.run import track
from trackweave.run.doubles import doubles_of
from trackweave.run.observing import settle, with_facts
from trackweave.run.registering import registration_of

__all__ = ["run_init", "run_learn"]


def run_init(
    voice: Voice,
    reports: list[Path],
    out: Path,
    *,
    force: bool = False,
    on_bad_row: OnBadRow = "fail",
    told: str | None = None,
) -> dict[str, Any]:
    """Estimate a configuration, write it with comments, and return what was found."""
    place = _place(out, reports, force=force)
    table = _read(reports, told, on_bad_row)
    registration = registration_of(table, with_facts(load_configuration(None), table))
    table, configuration = registration.reports, registration.configuration
    doubles, (settings, estimates) = doubles_of(
        table, lambda once: settle(once, configuration, to_be_edited=True)
    )
    # What a run takes where nobody says a seed.
    notes = (*table.notes, *registration.notes(), *doubles.notes(), *settings.notes)
    settings = replace(
        registration.entered(settings), values={**settings.values, "seed": 0}, notes=notes
    )
    text = commented_toml(
        settings,
        head=_head(reports, table),
        remarks=estimates.remarks if estimates else {},
        doubts=estimates.doubts if estimates else {},
    )
    place.write(text.encode("utf-8"))
    found = _found(settings, out)
    for line in [*what_was_assumed(found), *settings.notes]:
        voice.say(line)
    voice.say(f"written: {out}")
    return found


def run_learn(
    voice: Voice,
    reports: list[Path],
    out: Path,
    *,
    force: bool = False,
    on_bad_row: OnBadRow = "fail",
    told: str | None = None,
) -> dict[str, Any]:
    """Track reports, write what they told of sensors and objects, and return what was found."""
    place = _place(out, reports, force=force)
    table = _read(reports, told, on_bad_row)
    with voice.progress("tracking") as progress:
        result = track(table, progress=progress)
    assigned = result.run["totals"]["assigned_reports"]
    if assigned < LEAST_CHAINS_REPORTS:
        raise InvalidInputError(
            f"{reports[0]}: {assigned} of {len(table)} reports are in tracks; expected at least "
            f"{LEAST_CHAINS_REPORTS} to learn from"
        )
    settings = result.values.settings
    values = learned_keys(settings.values, settings.sources)
    if table.frame is not None:
        # Places on the plane count from here.
        origin = [table.frame.latitude_deg, table.frame.longitude_deg]
        values["frame"] = {"origin": origin, "projection": table.frame.projection}
    settings = replace(settings, values=values)
    head = [
        _head(reports, table)[0].replace("init", "init --learn", 1),
        "What was learned of sensors and objects, for track --learned and serve --learned: it "
        "counts where a configuration is silent.",
    ]
    place.write(commented_toml(settings, head=head).encode("utf-8"))
    for line in settings.notes:
        voice.say(line)
    voice.say(f"written: {out}")
    return {"out": str(out), "learned": values, "notes": list(settings.notes)}


def _place(out: Path, reports: list[Path], *, force: bool) -> OutputFile:
    """Return where a file goes that is not there yet, or may be replaced."""
    place = OutputFile(out)
    place.check(reports)
    if out.exists() and not force:
        raise OutputError(f"{out}: there already; --force replaces it")
    return place


def _read(reports: list[Path], told: str | None, on_bad_row: OnBadRow) -> ReportTable:
    """Return the reports, of which there has to be one."""
    table = read_reports(reports, told=told, on_bad_row=on_bad_row)
    if len(table) == 0:
        raise InvalidInputError(f"{reports[0]}: no rows; expected at least one report")
    return table


def _found(settings: Settings, out: Path) -> dict[str, Any]:
    return {
        "out": str(out),
        "configuration": settings.values,
        "sources": settings.sources,
        "notes": list(settings.notes),
    }


def _head(sources: list[Path], reports: ReportTable) -> list[str]:
    """Return what is said at the top of the file."""
    span = float(reports.time[-1] - reports.time[0])
    n_sensors = len(reports.sensors)
    names = ", ".join(source.name for source in sources)
    return [
        f"Written by trackweave init from {names}: {len(reports)} reports of "
        f"{n_sensors} sensor{'' if n_sensors == 1 else 's'} in {span:.6g} s.",
        "Behind each value stands where it came from: estimated from these reports, or the "
        "default. An estimate is a start, and no replacement for a data sheet: write down what "
        "you know better. A key that is taken out is estimated anew at each run.",
    ]
