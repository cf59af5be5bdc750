"""The command ``fuse``."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trackweave.cli.edge import Voice, telling_compiling
from trackweave.config.fusion import order_of
from trackweave.errors import InvalidInputError
from trackweave.io.encoding import encode_table
from trackweave.io.output import OutputDirectory
from trackweave.io.tables import ENDINGS
from trackweave.run.fusing import FusionResult, fuse

__all__ = ["FuseRequest", "run_fuse"]


@dataclass(frozen=True, slots=True)
class FuseRequest:
    """What the command was asked for.

    Parameters
    ----------
    tracks
        Files of tracks.
    out
        Directory for the files.
    names
        Names of sensors, each as NAME=FILE; a file that is not among ``tracks`` is one more.
    options
        What is not to be as by default, as ``fuse`` takes it; None is as good as left out.
    config
        A configuration, of which the table ``[fusion]`` counts where ``options`` are silent.
    preset
        Name of a preset.
    seed
        Seed of the random numbers; None for the configuration's, else 0.
    """

    tracks: Sequence[Path]
    out: Path
    names: Sequence[str]
    options: dict[str, Any]
    config: Path | None = None
    preset: str | None = None
    seed: int | None = None


@telling_compiling
def run_fuse(request: FuseRequest, voice: Voice) -> dict[str, Any]:
    """Fuse files of tracks and write what was found; return the run's totals."""
    files = _named_files(request.tracks, request.names)
    place = OutputDirectory(request.out, "fuse")
    place.check([*files.values(), *([request.config] if request.config else [])])
    order = order_of(request.config, request.options)
    seed = request.seed if request.seed is not None else order.seed or 0
    with voice.progress("fusing") as progress:
        result = fuse(
            files,
            order,
            preset=request.preset,
            rng=seed,
            progress=progress,
        )
    record = result.run
    place.write(_tables(result), record)
    for line in [*_assumed(record), *_registered(record), *record["notes"]]:
        voice.say(line)
    found = _summary(record, request.out)
    voice.table("Objects", [(name.replace("_", " "), _shown(v)) for name, v in found.items()])
    return found


def _named_files(tracks: Sequence[Path], names: Sequence[str]) -> dict[str, Path]:
    """Return each sensor's file: named as asked for, or else after the file."""
    given: dict[Path, str] = {}
    for text in names:
        name, sign, file = text.partition("=")
        if not (sign and name.strip() and file.strip()):
            raise InvalidInputError(f"--name: {text!r:.80}; expected NAME=FILE, such as A=a.csv")
        if Path(file.strip()) in given:
            raise InvalidInputError(f"--name: {file.strip()} twice; expected each file once")
        given[Path(file.strip())] = name.strip()
    paths = [*tracks, *(path for path in given if path not in tracks)]
    files: dict[str, Path] = {}
    for path in paths:
        name = given.get(path, _stem(path))
        if name in files:
            raise InvalidInputError(
                f"{path}: sensor {name}, as is {files[name]}; expected a name of its own, such as "
                f"--name {name}2={path}"
            )
        files[name] = path
    return files


def _stem(path: Path) -> str:
    """Return a file's name without its ending."""
    for ending in sorted(ENDINGS, key=len, reverse=True):
        if path.name.lower().endswith(ending):
            return path.name[: -len(ending)] or path.name
    return path.name


def _tables(result: FusionResult[Any]) -> dict[str, bytes]:
    return {
        "associations.csv": encode_table(result.associations, "associations.csv"),
        "tracks.csv": encode_table(result.tracks, "tracks.csv"),
    }


def _assumed(record: dict[str, Any]) -> list[str]:
    """Return a line on what the tracks told of themselves."""
    if record["sources"]["process_noise"] != "estimated":
        return []
    value = record["configuration"]["process_noise"]
    return [f"estimated from the covariances: process_noise {_shown(value)} m²/s³"]


def _registered(record: dict[str, Any]) -> list[str]:
    """Return a line for each sensor that was registered."""
    lines = []
    for name, found in record["registrations"].items():
        numbers = ", ".join(
            f"{what.replace('_', ' ')} {_shown(value)} ± {_shown(found['sigma'][what])}"
            for what, value in found["bias"].items()
            if found["sigma"][what] > 0.0
        )
        lines.append(
            f"{name} beside {found['reference']}, from {len(found['pairs'])} tracks: {numbers}"
        )
    return lines


def _summary(record: dict[str, Any], out: Path) -> dict[str, Any]:
    """Return a run's totals, as ``--json`` prints them."""
    timing = record["timing"]
    return {
        **record["totals"],
        "cpu_ms_per_update": timing["median_cpu_ms"],
        "time_s": timing["wall_ms"] / 1e3,
        "seed": record["seed"],
        "out": str(out),
    }


def _shown(value: Any) -> str:
    if value is None:
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
