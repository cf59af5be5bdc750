"""Options that several commands have."""

from typing import Annotated

import typer

__all__ = ["JsonOption", "QuietOption", "SeedOption"]

JsonOption = Annotated[
    bool, typer.Option("--json", help="Print the result as one JSON object on standard output.")
]
QuietOption = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]
SeedOption = Annotated[
    int | None,
    typer.Option(min=0, help="Seed of the random numbers; the same seed gives the same files."),
]
