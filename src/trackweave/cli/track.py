"""The command ``track``."""

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any, Literal

from trackweave.cli.edge import Voice, telling_compiling
from trackweave.config import load_configuration
from trackweave.config.presets import preset_notes
from trackweave.errors import InvalidInputError
from trackweave.io.output import OutputDirectory
from trackweave.io.reports import read_reports
from trackweave.run import track as run
from trackweave.run.record import with_file, with_seed

__all__ = ["Request", "run_track", "summary", "what_was_assumed"]


@dataclass(frozen=True, slots=True)
class Request:
    """What the command was asked for.

    Parameters
    ----------
    reports
        File of reports.
    out
        Directory for the files.
    config
        Configuration file.
    preset
        Name of a preset.
    priors
        Tracks file to set out from.
    seed
        Seed; None for the configuration's.
    deadline_ms
        Wall clock per scan [ms].
    on_bad_row
        Whether to stop at a bad row or to go on.
    """

    reports: Path
    out: Path
    config: Path | None
    preset: str | None
    priors: Path | None
    seed: int | None
    deadline_ms: float | None
    on_bad_row: Literal["fail", "skip"] | str


@telling_compiling
def run_track(request: Request, voice: Voice) -> dict[str, Any]:
    """Track a file of reports and write what was found; return the run's totals."""
    begin = perf_counter()
    place = OutputDirectory(request.out, "track")
    place.check([request.reports, request.config, request.priors])
    if request.deadline_ms is not None and not 0 < request.deadline_ms < float("inf"):
        raise InvalidInputError(
            f"--deadline-ms: {request.deadline_ms}; expected a number > 0 of milliseconds"
        )
    configuration = load_configuration(request.config)
    seed = request.seed if request.seed is not None else (configuration.seed or 0)
    origin = configuration.frame.origin
    reports = read_reports(
        request.reports,
        frame_origin=None if origin is None else (origin[0], origin[1]),
        frame_projection=configuration.frame.projection or "tangent",
        on_bad_row="skip" if request.on_bad_row == "skip" else "fail",
    )
    # Before a search to the letter of a document takes minutes, not after.
    early = preset_notes(request.preset)
    for line in early:
        voice.say(line)
    with voice.progress("tracking") as progress:
        result = run(
            reports,
            configuration,
            preset=request.preset,
            priors=request.priors,
            rng=seed,
            deadline=None if request.deadline_ms is None else request.deadline_ms / 1e3,
            progress=progress,
        )
    record = with_file(result.run, request.reports)
    record = with_seed(record, seed, None if request.seed is None else "command line")
    place.write(result.files(), record)
    late = [note for note in record["notes"] if note not in early]
    for line in [*what_was_assumed(record), *late]:
        voice.say(line)
    found = {**summary(record, request.out), "time_s": perf_counter() - begin}
    voice.table("Tracks", [(name.replace("_", " "), _shown(v)) for name, v in found.items()])
    return found


def summary(record: dict[str, Any], out: Path) -> dict[str, Any]:
    """Return a run's totals, as ``--json`` prints them."""
    totals, timing = record["totals"], record["timing"]
    return {
        **totals,
        "cpu_ms_per_scan": timing["median_cpu_ms"],
        "time_s": timing["wall_ms"] / 1e3,
        "seed": record["seed"],
        "out": str(out),
    }


def what_was_assumed(record: dict[str, Any]) -> list[str]:
    """Return a line for each table of the configuration in which something was estimated."""
    told: dict[str, list[str]] = {}
    for key, source in record["sources"].items():
        if source == "estimated":
            table, _, name = key.rpartition(".")
            told.setdefault(table, []).append(f"{name} {_shown(_value(record, key))}")
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


def _shown(value: Any) -> str:
    if value is None:
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
