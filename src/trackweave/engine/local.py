"""Workers that are processes of this machine: spawned, with a pipe each, watched by sentinels."""

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait
from time import monotonic
from types import ModuleType
from typing import Any

from trackweave.engine.protocol import Death, Worker
from trackweave.engine.serving import Served

__all__ = ["LocalHost"]

_SPAWN = multiprocessing.get_context("spawn")

LEAST_S = 1.0
"""A message is given at least so long [s]: limits of tasks may be shorter than the way of one."""


class LocalHost:
    """Brings processes of this machine.

    Parameters
    ----------
    time_limit
        A process that is stopped in the middle of a message longer than pipes hold would hold up
        the caller: after so long, but not before LEAST_S, it is killed [s]. None for never.
    """

    def __init__(self, time_limit: float | None = None) -> None:
        self._hired: list[_Process] = []
        self._over = threading.Event()
        if time_limit is not None:
            limit = max(time_limit, LEAST_S)
            threading.Thread(target=self._watch, args=(limit,), daemon=True).start()

    def hire(self) -> "_Process":
        """Return a new process, which is still starting."""
        self._hired = [each for each in self._hired if not each.is_over]
        self._hired.append(_Process())
        return self._hired[-1]

    def wait(
        self, workers: Sequence[Worker], seconds: float | None
    ) -> list[tuple[Worker, bytes | Death]]:
        """Return replies and deaths as soon as there are any, nothing when the time is over."""
        owner: dict[Any, _Process] = {}
        for worker in workers:
            if isinstance(worker, _Process):
                owner |= {worker.pipe: worker, worker.process.sentinel: worker}
        ready = wait(list(owner), seconds)
        # A reply that was sent before the worker died still counts.
        heard = dict.fromkeys(owner[each] for each in ready)
        return [(worker, worker.heard()) for worker in heard]

    def close(self) -> None:
        """Leave nothing behind: processes are ended one by one."""
        self._over.set()

    def _watch(self, limit: float) -> None:
        """Kill what is in the middle of a message for too long."""
        while not self._over.wait(limit / 4):
            for each in list(self._hired):
                since = each.since
                if since is not None and monotonic() - since > limit:
                    each.process.kill()


class _Process:
    """A process that answers calls."""

    since: float | None = None
    """When the message began that is on its way; None for none."""
    is_over = False

    def __init__(self) -> None:
        self.pipe, theirs = _SPAWN.Pipe()
        self.process = _SPAWN.Process(target=_serve, args=(theirs,), daemon=True)
        with _without_main():
            self.process.start()
        theirs.close()

    def send(self, call: bytes) -> None:
        """Send a call; a dead process says nothing, and is found by its sentinel."""
        with suppress(OSError), self._on_its_way():
            self.pipe.send_bytes(call)

    def heard(self) -> bytes | Death:
        """Return the reply that is there, or why there will be none."""
        try:
            if self.pipe.poll():
                with self._on_its_way():
                    return self.pipe.recv_bytes()
        except (EOFError, OSError):
            pass
        self.process.join()
        code = self.process.exitcode or 0
        return Death(f"was killed by signal {-code}" if code < 0 else f"ended with status {code}")

    def kill(self) -> None:
        """End it at once, whatever it does."""
        self.is_over = True
        self.process.kill()
        self.process.join()
        self.pipe.close()

    @contextmanager
    def _on_its_way(self) -> Iterator[None]:
        self.since = monotonic()
        try:
            yield
        finally:
            self.since = None


@contextmanager
def _without_main() -> Iterator[None]:
    """Keep a new process from running the caller's script anew, which need not be guarded."""
    # Work is a function of an importable module, so that no worker needs what the script defines.
    own = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = own


def _serve(pipe: Connection) -> None:
    """Answer calls until the caller is gone."""
    # Control-C reaches the whole group of processes; the caller decides what ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_caller, daemon=True).start()
    served = Served()
    with suppress(EOFError, OSError):
        while True:
            pipe.send_bytes(served.reply(pipe.recv_bytes()))


def _end_with_caller() -> None:
    """End as soon as the process that asked for the work has ended, by whatever signal."""
    caller = multiprocessing.parent_process()
    if caller is not None:
        wait([caller.sentinel])
        os._exit(1)
