"""The command line. Only typer is imported before a command runs, so that help is instant."""

import sys

__all__ = ["main"]


def main() -> None:
    """Run the command line; the entry point of the program."""
    try:
        # Inside, so that an interrupt while typer is imported ends like any other.
        from trackweave.cli.app import run

        run()
    except KeyboardInterrupt:
        sys.exit(130)
