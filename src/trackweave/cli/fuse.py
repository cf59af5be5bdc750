"""The command ``fuse``."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from trackweave.cli.edge import Voice, shown, summary_of
from trackweave.config.fusion import order_of
from trackweave.errors import InvalidInputError
from trackweave.io.encoding import encode_table
from trackweave.io.output import OutputDirectory
from trackweave.io.tables import ENDINGS
from trackweave.run.fusing import fuse
from trackweave.summaries import counted

__all__ = ["run_fuse"]


def run_fuse(
    voice: Voice,
    *,
    tracks: Sequence[Path] | None,
    out: Path,
    name: Sequence[str] | None,
    config: Path | None,
    preset: str | None,
    seed: int | None,
    **options: Any,
) -> dict[str, Any]:
    """Fuse files of tracks and write what was found; return the run's totals."""
    options = _nested(**options)
    files = _named_files(tracks or [], name or [])
    place = OutputDirectory(out, "fuse")
    place.check([*files.values(), config])
    order = order_of(config, options)
    used = seed if seed is not None else order.seed or 0
    with voice.progress("fusing") as progress:
        result = fuse(files, order, preset=preset, rng=used, progress=progress)
    record = result.run
    tables = {"associations.csv": result.associations, "tracks.csv": result.tracks}
    place.write({name: encode_table(table, name) for name, table in tables.items()}, record)
    for line in [*_assumed(record), *_registered(record), *record["notes"]]:
        voice.say(line)
    found = summary_of(record, out, "update")
    line = (
        f"{counted(found['objects'], 'object')} from {counted(found['local_tracks'], 'track')} of "
        f"{counted(found['sensors'], 'sensor')}, in {out}"
    )
    voice.results("Objects", found, elsewhere=line)
    return found


def _nested(
    *, register: bool, bias: str | None, false_rejection: float | None,
    correlation: str | None, search: str | None, **options: Any,
) -> dict[str, Any]:  # fmt: skip
    """Return what the options say as the table ``[fusion]`` has it, None where they are silent."""
    if bias is not None and not register:
        raise InvalidInputError(f"--bias {bias}: expected --register beside it")
    return {
        **options,
        "register": register or None,
        "bias": None if bias is None else [word.strip() for word in bias.split(",")],
        "statistic": {"false_rejection": false_rejection, "correlation": correlation},
        "search": {"method": search},
    }


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


def _assumed(record: dict[str, Any]) -> list[str]:
    """Return a line on what the tracks told of themselves."""
    if record["sources"]["process_noise"] != "estimated":
        return []
    value = record["configuration"]["process_noise"]
    return [f"estimated from the covariances: process_noise {shown(value)} m²/s³"]


def _registered(record: dict[str, Any]) -> list[str]:
    """Return a line for each sensor that was registered."""
    lines = []
    for name, found in record["registrations"].items():
        numbers = ", ".join(
            f"{what.replace('_', ' ')} {shown(value)} ± {shown(found['sigma'][what])}"
            for what, value in found["bias"].items()
            if found["sigma"][what] > 0.0
        )
        lines.append(
            f"{name} beside {found['reference']}, from {len(found['pairs'])} tracks: {numbers}"
        )
    return lines
