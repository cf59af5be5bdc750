"""The command ``init``."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from trackweave.cli.edge import Voice
from trackweave.cli.track import what_was_assumed
from trackweave.config import load_configuration
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
from trackweave.run.heights import registered
from trackweave.run.observing import settle
from trackweave.run.pieces import pieces_in

__all__ = ["run_init"]


def run_init(
    voice: Voice,
    reports: list[Path],
    out: Path,
    *,
    learn: Path | None,
    force: bool,
    on_bad_row: OnBadRow,
    told: str | None,
) -> dict[str, Any]:
    """Estimate a configuration, or learn one; write it with comments, return what was found."""
    place = OutputFile(out if learn is None else learn)
    place.check(reports)
    if place.path.exists() and not force:
        raise OutputError(f"{place.path}: there already; --force replaces it")
    table = read_reports(reports, told=told, on_bad_row=on_bad_row)
    if len(table) == 0:
        raise InvalidInputError(f"{reports[0]}: no rows; expected at least one report")
    write = _estimate if learn is None else _learn
    found = write(voice, reports, table, place)
    voice.say(f"written: {place.path}")
    return {"out": str(place.path), **found}


def _estimate(
    voice: Voice, reports: list[Path], table: ReportTable, place: OutputFile
) -> dict[str, Any]:
    is_numbered = table.scan is not None
    heights, registration = registered(table, load_configuration(None))
    pieces = pieces_in(registration.reports, registration.configuration)
    table, configuration = pieces.joined, pieces.configuration
    doubles, (settings, estimates) = doubles_of(
        table, lambda once: settle(once, configuration, to_be_edited=True)
    )
    # What a run takes where nobody says a seed.
    notes = (
        *table.notes,
        *heights.notes(),
        *registration.notes(),
        *pieces.notes(),
        *doubles.notes(),
        *settings.notes,
    )
    settings = registration.entered(pieces.entered(settings))
    values, sources = {**settings.values, "seed": 0}, settings.sources
    if table.scan is not None and not is_numbered:
        # What was told by sweeps or bursts is found in the reports again, if nothing denies it.
        denied = {"rotation", "scans"}
        values["sensors"] = {
            name: {key: value for key, value in own.items() if key not in denied}
            for name, own in settings.values["sensors"].items()
        }
        sources = {
            key: source for key, source in sources.items() if key.rpartition(".")[2] not in denied
        }
    settings = replace(settings, values=values, sources=sources, notes=notes)
    text = commented_toml(
        settings,
        head=_head(reports, table),
        remarks=estimates.remarks if estimates else {},
        doubts=estimates.doubts if estimates else {},
    )
    place.write(text.encode("utf-8"))
    found = {
        "configuration": settings.values,
        "sources": settings.sources,
        "notes": list(settings.notes),
    }
    for line in [*what_was_assumed(found), *settings.notes]:
        voice.say(line)
    return found


def _learn(
    voice: Voice, reports: list[Path], table: ReportTable, place: OutputFile
) -> dict[str, Any]:
    """Track reports, write what they told of sensors and objects."""
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
    return {"learned": values, "notes": list(settings.notes)}


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
