"""The commands that turn one format into another, and list them all."""

from pathlib import Path
from typing import Annotated, Any

import typer

from trackweave.cli.edge import Voice, carry_out, with_status
from trackweave.cli.options import FromOption, JsonOption, QuietOption, required

__all__ = ["convert", "formats"]


@with_status
def convert(
    source: Annotated[
        Path,
        required(
            "IN", "Reports or tracks of any format, - for standard input, or a run's directory."
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="What to write; replaced if there.")],
    from_format: FromOption = None,
    to_format: Annotated[
        str | None,
        typer.Option("--to", help="Format to write, where the name's ending does not tell."),
    ] = None,
    hide_identities: Annotated[
        bool,
        typer.Option(
            "--hide-identities",
            help="Write identities as the column target, the truth, which no tracker reads.",
        ),
    ] = False,
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Turn reports or tracks of one format into another.

    Reports become a table (.csv, .csv.gz, .parquet) that `track` reads; tracks, or reports that
    say whose they are (target), become any format that can be written. A directory of a run gives
    its tracks.
    """
    from trackweave.cli.convert import run_convert

    carry_out(
        run_convert, source, out, json=json, quiet=quiet,
        told=from_format, to=to_format, hide_identities=hide_identities,
    )  # fmt: skip


@with_status
def formats(json: JsonOption = False) -> None:
    """List the formats, what each carries and loses, and what its reader may be told."""
    carry_out(_run_formats, json=json, quiet=False)


def _run_formats(voice: Voice) -> dict[str, Any]:
    from trackweave.formats.registry import formats as known

    found = [
        {
            "name": each.name,
            "title": each.title,
            "reads": each.can_read,
            "writes": each.writer is not None,
            "endings": list(each.endings),
            "carries": each.carries,
            "loses": each.loses,
            "extra": each.extra,
            "options": {
                option.name: {
                    "default": option.default,
                    "meaning": option.meaning,
                    "choices": list(option.choices),
                }
                for option in each.options
            },
        }
        for each in known().values()
    ]
    if not voice.quiet:
        for line in _lines(found):
            typer.echo(line)
    return {"formats": found}


def _lines(found: list[dict[str, Any]]) -> list[str]:
    lines = []
    for each in sorted(found, key=lambda one: str(one["name"])):
        can = "+".join(word for word in ("reads", "writes") if each[word])
        extra = f"; needs pip install trackweave[{each['extra']}]" if each["extra"] else ""
        lines.append(f"{each['name']} ({can}): {each['title']}{extra}")
        lines.append(f"    carries {each['carries']}; loses {each['loses']}")
        for name, told in each["options"].items():
            choices = f" ({', '.join(told['choices'])})" if told["choices"] else ""
            lines.append(
                f"    --from '{each['name']}?{name}={told['default']}': {told['meaning']}{choices}"
            )
    return lines
