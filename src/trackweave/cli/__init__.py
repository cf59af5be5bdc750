"""The command line. Only typer is imported before a command runs, so that help is instant."""

from trackweave.cli.app import app, main

__all__ = ["app", "main"]
