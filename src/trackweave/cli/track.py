"""The command ``track``."""

from pathlib import Path
from time import perf_counter
from typing import Any

from trackweave.cli.edge import Voice, shown, summary_of
from trackweave.config import load_configuration, with_learned
from trackweave.config.fill import UNUSED
from trackweave.config.presets import preset_notes
from trackweave.errors import InvalidInputError
from trackweave.formats.reading import read_reports
from trackweave.formats.writing import try_on, writers_named, written
from trackweave.io.output import OutputDirectory
from trackweave.io.tables import OnBadRow
from trackweave.run import track
from trackweave.run.record import with_file, with_seed
from trackweave.summaries import counted

__all__ = ["run_track", "what_was_assumed"]


def run_track(
    voice: Voice,
    reports: list[Path],
    out: Path,
    *,
    config: Path | None,
    preset: str | None,
    priors: Path | None,
    seed: int | None,
    deadline_ms: float | None,
    on_bad_row: OnBadRow,
    told: str | None = None,
    also: list[str] | None = None,
    learned: Path | None = None,
    engine: str | None = None,
    workers: int | None = None,
) -> dict[str, Any]:
    """Track reports and write what was found; return the run's totals."""
    begin = perf_counter()
    further = writers_named(also)
    place = OutputDirectory(out, "track")
    place.check(
        [*reports, config, priors, learned], [f"tracks{each.endings[0]}" for each in further]
    )
    if deadline_ms is not None and not 0 < deadline_ms < float("inf"):
        raise InvalidInputError(
            f"--deadline-ms: {deadline_ms}; expected a number > 0 of milliseconds"
        )
    configuration = load_configuration(config)
    if learned is not None:
        configuration = with_learned(configuration, load_configuration(learned))
    used = seed if seed is not None else (configuration.said("seed") or 0)
    origin = configuration.said("frame", "origin")
    table = read_reports(
        reports,
        told=told,
        frame_origin=None if origin is None else (origin[0], origin[1]),
        frame_projection=configuration.said("frame", "projection") or "tangent",
        on_bad_row=on_bad_row,
        kinds=configuration.plugins.kinds(),
        places=configuration.places(),
    )
    try_on(further, table)
    # Before a search to the letter of a document takes minutes, not after.
    early = preset_notes(preset)
    for line in early:
        voice.say(line)
    with voice.progress("tracking") as progress:
        result = track(
            table,
            configuration,
            preset=preset,
            priors=priors,
            rng=used,
            deadline=None if deadline_ms is None else deadline_ms / 1e3,
            progress=progress,
            engine=engine,
            workers=workers,
        )
    record = with_file(result.run, *reports, told=told)
    record = with_seed(record, used, None if seed is None else "command line")
    place.write({**result.files(), **written(further, result.output())}, record)
    late = [note for note in record["notes"] if note not in early]
    # What was told and not used comes before what was estimated in its place.
    unused = [note for note in late if note.startswith(UNUSED)]
    for line in [
        *unused,
        *what_was_assumed(record),
        *(note for note in late if note not in unused),
    ]:
        voice.say(line)
    found = {**summary_of(record, out, "scan"), "time_s": perf_counter() - begin}
    skipped = len(record["skipped_rows"])
    left = f"; {counted(skipped, 'row')} left out (run.json: skipped_rows)" if skipped else ""
    line = (
        f"{counted(found['tracks'], 'track')}, {found['assigned_reports']:,} of "
        f"{counted(found['reports'], 'report')} assigned, in {out}{left}"
    )
    voice.results("Tracks", found, elsewhere=line)
    # Who asks for JSON is told nothing else.
    return {**found, "notes": record["notes"]}


def what_was_assumed(record: dict[str, Any]) -> list[str]:
    """Return a line for each table of the configuration in which something was estimated."""
    told: dict[str, list[str]] = {}
    for key, source in record["sources"].items():
        if source == "estimated":
            table, _, name = key.rpartition(".")
            told.setdefault(table, []).append(f"{name} {shown(_value(record, key))}")
    return [f"estimated {table}: {', '.join(values)}" for table, values in told.items()]


def _value(record: dict[str, Any], key: str) -> Any:
    """Return a value by its dotted key; a sensor's name may hold dots itself."""
    table, rest = record["configuration"], key
    if key.startswith("sensors."):
        sensor, _, name = key.removeprefix("sensors.").rpartition(".")
        return table["sensors"][sensor][name]
    for part in rest.split("."):
        table = table[part]
    return table
