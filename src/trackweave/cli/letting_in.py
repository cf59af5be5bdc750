"""The command ``token``."""

import os
from pathlib import Path
from typing import Annotated, Any

import typer

from trackweave.cli.edge import Voice, carry_out, with_status
from trackweave.cli.options import JsonOption, QuietOption, required

__all__ = ["run_token", "token"]


@with_status
def token(
    file: Annotated[Path, required("FILE", "The service's --token-file; added to if there.")],
    name: Annotated[str, typer.Option(help="Whose token it is, for whoever reads the file.")] = "",
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Make a token that opens the live service, and print it, once.

    The file keeps its digest alone: whoever reads it cannot come in. `serve --token-file FILE`.
    """
    carry_out(run_token, file=file, json=json, quiet=quiet, name=name, shows=not json)


def run_token(voice: Voice, file: Path, *, name: str, shows: bool) -> dict[str, Any]:
    """Add a token's digest to a file that only its owner can read; return the token."""
    from trackweave.errors import InvalidInputError
    from trackweave.service.web.tokens import line_of, new_token

    if not name.isprintable():
        raise InvalidInputError(f"--name {name!r:.80}: expected a name of one line")
    if file.exists() and not file.is_file():
        raise InvalidInputError(f"{file}: not a regular file; expected a file of tokens")
    found = new_token()
    descriptor = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
    with open(descriptor, "a", encoding="utf-8") as lines:  # noqa: PTH123 it is open already
        is_within_a_line = file.read_bytes()[-1:] not in (b"", b"\n")
        lines.write(("\n" if is_within_a_line else "") + line_of(found, name) + "\n")
    if shows:
        typer.echo(found)
        voice.say(f"{file}: holds its digest; the token is not shown again")
    return {"token": found, "out": str(file)}
