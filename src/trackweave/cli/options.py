"""Options that several commands have."""

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

__all__ = [
    "FromOption",
    "JsonOption",
    "OnBadRow",
    "OutOption",
    "QuietOption",
    "ReportsArgument",
    "SeedOption",
    "required",
]

OnBadRow = Literal["fail", "skip"]
OutOption = Annotated[
    Path,
    typer.Option(
        "--out", "-o", help="Directory for the files: new, empty, or that of its earlier run."
    ),
]
JsonOption = Annotated[
    bool, typer.Option("--json", help="Print the result as one JSON object on standard output.")
]
QuietOption = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]
SeedOption = Annotated[
    int | None,
    typer.Option(min=0, help="Seed of the random numbers; the same seed gives the same files."),
]


def required(metavar: str, explained: str) -> Any:
    """Return an argument that a command cannot do without."""
    return typer.Argument(metavar=metavar, help=explained, show_default=False)


ReportsArgument = Annotated[
    list[Path],
    required(
        "REPORTS",
        "Reports: a file of any format that `formats` lists, - for standard input, or several "
        "files of one network of sensors.",
    ),
]
FromOption = Annotated[
    str | None,
    typer.Option(
        "--from",
        help="Format of the input, where its content does not tell; `formats` lists them.",
    ),
]
