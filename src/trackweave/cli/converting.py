"""The commands that turn one format into another, and list them all."""

from pathlib import Path
from typing import Annotated

import typer

from trackweave.cli.edge import done_by
from trackweave.cli.options import FromOption, JsonOption, OnBadRow, QuietOption, required

__all__ = ["convert", "formats"]


@done_by("convert.run_convert")
def convert(
    source: Annotated[
        Path,
        required(
            "IN", "Reports or tracks of any format, - for standard input, or a run's directory."
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="What to write; replaced if there.")],
    told: FromOption = None,
    to: Annotated[
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
    on_bad_row: Annotated[
        OnBadRow, typer.Option(help="Stop at a bad row of a table, or leave it out and go on.")
    ] = "fail",
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Turn reports or tracks of one format into another.

    Reports become a table (.csv, .csv.gz, .parquet) that `track` reads; tracks, or reports that
    say whose they are (target), become any format that can be written. A directory of a run gives
    its tracks.
    """


@done_by("convert.run_formats")
def formats(json: JsonOption = False) -> None:
    """List the formats, what each carries and loses, and what its reader may be told."""
