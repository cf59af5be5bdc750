"""Interrupts and endings from outside: one line, the right status, no file half written."""

import os
import signal
import sys
from contextlib import suppress
from types import FrameType
from typing import NoReturn

__all__ = ["end_at_once", "end_on_signals", "open_closed_streams"]

_SHOW_CURSOR = b"\x1b[?25h"


def end_on_signals() -> None:
    """From here on, let Control-C and SIGTERM end the program at once and leave nothing behind.

    Not by an exception: compiled modules and finalisers that meet one while they load hide it or
    print it. What is being written is finished first (``trackweave.io.output``).
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, _end)


def _end(number: int, frame: FrameType | None) -> None:
    with suppress(OSError):
        if os.isatty(2):  # a progress bar hides it
            os.write(2, _SHOW_CURSOR)
    if number == signal.SIGTERM:
        # As if nobody had caught it: who sent it sees that it was obeyed.
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        os.kill(os.getpid(), signal.SIGTERM)
    with suppress(OSError):
        os.write(2, b"interrupted\n")
    os._exit(128 + number)


def end_at_once() -> NoReturn:
    """End with status 0, without taking the interpreter apart.

    That takes more than a second once kernels are loaded, and longer on a busy machine. Whoever
    calls this has closed all files.
    """
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(0)


def open_closed_streams() -> None:
    """Put something in the place of standard streams that the caller has closed.

    Else the next file that is opened would be taken for one of them. What is said to a closed
    standard error is lost; output has nowhere to go, which is an error as on a full disk.
    """
    for number, mode in ((0, os.O_RDONLY), (1, os.O_RDONLY), (2, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, mode)  # the lowest free number, which is this one
    # They are for the whole life of the program.
    if sys.stdout is None:
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
