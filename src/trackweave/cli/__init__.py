"""The command line. Only typer is imported before a command runs, so that help is instant."""

import gc

__all__ = ["main"]


def main() -> None:
    """Run the command line; the entry point of the program."""
    # Importing makes many objects and hardly any garbage: looking for it takes a tenth of a start.
    gc.disable()
    from trackweave.cli.signals import end_on_signals, open_closed_streams

    # First, so that an interrupt while typer is imported ends like any other.
    end_on_signals()
    open_closed_streams()
    from trackweave.cli.app import run

    run()
