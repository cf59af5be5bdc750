"""Signs of life of a process of this machine, and its end with the one that started it."""

import ctypes
import multiprocessing
import os
import signal
import sys
import threading
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from time import sleep

__all__ = ["SILENT_S", "Pulse", "beat", "end_with_caller"]

BEAT_S = 1.0
"""So often a process says that it is alive [s]."""
SILENT_S = 60.0
"""One that has not said so for this long is stopped [s]: kernels leave others their turn."""
_ON_DEATH_OF_PARENT = 1
"""What ``prctl`` calls the signal that comes when the parent is gone."""


class Pulse:
    """Whether a process still says that it is alive.

    Parameters
    ----------
    beats
        What it says so by.
    """

    def __init__(self, beats: Connection) -> None:
        self._beats, self.silence, self._has_begun = beats, 0.0, False

    def is_stopped(self, passed: float) -> bool:
        """Tell whether it was silent for too long, asked again after so many seconds."""
        # Counted from look to look: where all are stopped together, as by Control-Z, no look
        # sees anything. How long one may take to start is not asked here.
        heard = False
        with suppress(EOFError, OSError):
            while self._beats.poll():
                self._beats.recv_bytes()
                heard = True
        self._has_begun |= heard
        self.silence = 0.0 if heard or not self._has_begun else self.silence + passed
        return self.silence >= SILENT_S


def beat(beats: Connection) -> None:
    """Say again and again that this process is alive, from a thread of its own."""
    threading.Thread(target=_beat, args=(beats,), daemon=True).start()


def _beat(beats: Connection) -> None:
    # Where nobody listens for hours the pipe is full, and this waits.
    with suppress(OSError):
        while True:
            beats.send_bytes(b"")
            sleep(BEAT_S)


def end_with_caller(*, by_thread: bool) -> None:
    """End as soon as the process that asked for the work has ended, by whatever signal.

    Parameters
    ----------
    by_thread
        Whether another thread than its main one started this process.
    """
    threading.Thread(target=_end_with_caller, daemon=True).start()
    # A stopped process runs no thread. Linux ends it all the same, but with the thread that
    # started it, so that this must not be one that ends before.
    if sys.platform == "linux" and not by_thread:
        with suppress(OSError, AttributeError):
            ctypes.CDLL(None).prctl(_ON_DEATH_OF_PARENT, signal.SIGKILL)


def _end_with_caller() -> None:
    caller = multiprocessing.parent_process()
    if caller is not None:
        wait([caller.sentinel])
        os._exit(1)
