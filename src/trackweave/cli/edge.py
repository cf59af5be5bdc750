"""Where the program meets the world: exit statuses, one message for an error, progress."""

import functools
import gc
import os
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib import import_module
from math import isfinite
from pathlib import Path
from typing import Any, TextIO

import typer

__all__ = [
    "Voice",
    "carry_out",
    "done_by",
    "last_resort",
    "named_output",
    "show_json",
    "show_our_warnings",
    "shown",
    "summary_of",
    "with_status",
]

BAD_INPUT, OURS, INTERRUPTED = 2, 1, 130
READER_LEFT = 141
"""What a shell tells of a program that SIGPIPE ended, as most programs are."""
DEBUG = "TRACKWEAVE_DEBUG"


def with_status(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that ends with the right exit status, and never with a traceback.

    0 success; 2 bad usage, bad input or an environment that refuses; 130 interrupted; 141 nobody
    reads the output any more; 1 a failure of ours. With the environment variable TRACKWEAVE_DEBUG
    set, the traceback is shown too.
    """

    @functools.wraps(command)
    def guarded(*args: Any, **options: Any) -> None:
        try:
            command(*args, **options)
        except typer.Exit:
            raise
        except KeyboardInterrupt:
            _complain("interrupted", INTERRUPTED)
        except MemoryError:
            _complain("not enough memory", BAD_INPUT)
        except BrokenPipeError:
            _forget_output()
            raise typer.Exit(READER_LEFT) from None
        except Exception as err:
            _explain(err)
        except BaseException as err:
            # A panic of polars, which derives from BaseException only.
            if type(err).__name__ != "PanicException":
                raise
            _explain(RuntimeError(f"{type(err).__name__}: {err}"))

    return guarded


def done_by(target: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Return what makes a command of its options: ``module.function`` of this package takes them.

    It is imported when the command runs.
    """

    def command_of(options: Callable[..., None]) -> Callable[..., None]:
        @with_status
        @functools.wraps(options)
        def command(*, json: bool = False, quiet: bool = False, **given: Any) -> None:
            module, _, name = target.partition(".")
            run = getattr(import_module(f"trackweave.cli.{module}"), name)
            carry_out(run, json=json, quiet=quiet, **given)

        return command

    return command_of


def carry_out(run: Callable[..., Any], *, json: bool, quiet: bool, **given: object) -> None:
    """Run what a command does, with a voice first, and print what it returns where JSON is asked.

    A word is said where kernels are compiled meanwhile.
    """
    if not gc.isenabled():
        # While it imported, ``main`` had no garbage looked for. What came with the imports stays:
        # the first search, which would look through all of it, takes a tenth of a start.
        gc.freeze()
        gc.enable()
    voice = Voice(quiet=quiet or json)
    with voice.compiling():
        found = run(voice, **given)
    if json:
        show_json(found)


def _forget_output() -> None:
    """Let the interpreter flush into nothing: whoever read the output has left."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _explain(err: Exception) -> None:
    """Say what went wrong in one line and exit."""
    from trackweave.errors import NumericalError, TrackweaveError

    if os.environ.get(DEBUG):
        traceback.print_exc()
    if isinstance(err, TrackweaveError) and not isinstance(err, NumericalError):
        _complain(_one_line(err), BAD_INPUT)
    if isinstance(err, OSError) and err.errno is not None:
        place = f"{err.filename}: " if err.filename else ""
        _complain(f"{place}{err.strerror}", BAD_INPUT)
    _complain(
        f"trackweave failed: {type(err).__name__}: {_one_line(err)}. This is our fault: please "
        f"report it with what you ran; {DEBUG}=1 shows where it happened.",
        OURS,
    )


def _one_line(err: Exception) -> str:
    return " ".join(str(err).split())


def _complain(message: str, status: int) -> None:
    typer.echo(message, err=True)
    raise typer.Exit(status) from None


def show_json(result: Any) -> None:
    """Print a result as one JSON object."""
    from trackweave.io.encoding import encode_json

    with named_output():
        typer.echo(encode_json(result).decode("utf-8"), nl=False)


@contextmanager
def named_output() -> Iterator[None]:
    """Let a failure to print, as on a full disk, name standard output as what failed."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as err:
        _forget_output()
        raise OSError(err.errno, err.strerror, "standard output") from err


@contextmanager
def last_resort() -> Iterator[None]:
    """End without a traceback where help or the version cannot be printed."""
    try:
        with named_output():
            yield
    except SystemExit as err:
        # Typer's own answer to a broken pipe is 1, which is our word for a failure of ours.
        if isinstance(err.__context__, BrokenPipeError):
            _forget_output()
            sys.exit(READER_LEFT)
        raise
    except BrokenPipeError:
        _forget_output()
        sys.exit(READER_LEFT)
    except OSError as err:
        _forget_output()
        with suppress(OSError):
            typer.echo(f"{err.filename}: {err.strerror}", err=True)
        sys.exit(BAD_INPUT)


def show_our_warnings() -> None:
    """Say what this package warns of in a line each; a user cannot act on other libraries'."""
    warnings.simplefilter("ignore")
    warnings.filterwarnings("always", category=UserWarning, module=r"trackweave(\.|$)")
    warnings.showwarning = _note


def _note(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    # What NumPy and the like warn of inside our modules has a category of its own.
    if category is UserWarning:
        typer.echo(f"note: {' '.join(str(message).split())}", err=True)


class Voice:
    """What a command says while it works: to standard error, and nothing when told to be quiet.

    Parameters
    ----------
    quiet
        Whether to say nothing but errors.
    """

    def __init__(self, *, quiet: bool) -> None:
        self.quiet = quiet
        self.on_terminal = sys.stderr.isatty() and not quiet

    def say(self, text: str) -> None:
        """Print a line."""
        if not self.quiet:
            typer.echo(text, err=True)

    @contextmanager
    def compiling(self) -> Iterator[None]:
        """Say that kernels compile, where that takes more than a second while the block runs."""
        from trackweave.run.kernels import COMPILING, compiling_told

        with compiling_told(lambda: self.say(COMPILING)):
            yield

    def table(self, title: str, rows: list[tuple[str, str]], elsewhere: str = "") -> None:
        """Print a small table on a terminal; elsewhere a line, where there is one to say."""
        # Elsewhere --json is what to read; the line is so that nobody misses what came of it.
        if not self.on_terminal:
            if elsewhere:
                self.say(elsewhere)
            return
        from rich.console import Console
        from rich.table import Table

        table = Table(title=title, title_justify="left", show_header=False)
        table.add_column(style="bold")
        # Numbers stand under one another by their ends, words by their beginnings.
        is_words = any(value[:1].isalpha() for _, value in rows)
        table.add_column(justify="left" if is_words else "right")
        for row in rows:
            table.add_row(*row)
        Console(stderr=True).print(table)

    def results(
        self, title: str, found: dict[str, Any], digits: int = 4, elsewhere: str = ""
    ) -> None:
        """Print what a command found, a row for each name; elsewhere as of ``table``."""
        rows = [
            (name.replace("_", " "), shown(value, digits=digits)) for name, value in found.items()
        ]
        self.table(title, rows, elsewhere)

    @contextmanager
    def progress(self, what: str) -> Iterator[Callable[[int, int], None] | None]:
        """Show a bar on a terminal while the block runs; yields what to call with done and all."""
        if not self.on_terminal:
            yield None
            return
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

        columns = ("{task.description}", BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task(what, total=None)

            def advance(done: int, total: int) -> None:
                bar.update(task, completed=done, total=total)

            yield advance


def shown(value: Any, unit: str = "", *, digits: int = 4) -> str:
    """Return a value for people, with a dash for none."""
    if value is None or (isinstance(value, float) and not isfinite(value)):
        return "–"
    text = f"{value:.{digits}g}" if isinstance(value, float) else str(value)
    return f"{text} {unit}" if unit else text


def summary_of(record: Mapping[str, Any], out: Path, step: str) -> dict[str, Any]:
    """Return the totals of a run by its record, as ``--json`` prints them."""
    timing = record["timing"]
    return {
        **record["totals"],
        f"cpu_ms_per_{step}": timing["median_cpu_ms"],
        "time_s": timing["wall_ms"] / 1e3,
        "seed": record["seed"],
        "out": str(out),
    }
