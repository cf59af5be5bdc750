"""Workers that are processes of this machine: spawned, with a pipe each, watched by sentinels."""

import multiprocessing
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait
from time import monotonic
from types import ModuleType
from typing import Any

from trackweave.engine.alive import Pulse, beat, end_with_caller
from trackweave.engine.protocol import Death, Worker
from trackweave.engine.serving import Served

__all__ = ["LocalHost"]

_SPAWN = multiprocessing.get_context("spawn")

LOOK_S = 5.0
"""So often processes are looked at [s]."""
LEAST_S = 1.0
"""A message is given at least so long [s]: limits of tasks may be shorter than the way of one."""


class LocalHost:
    """Brings processes of this machine; one that gives no sign of life for a minute is killed.

    Parameters
    ----------
    time_limit
        A process that is stopped in the middle of a message longer than pipes hold would hold up
        the caller: after so long, but not before LEAST_S, it is killed [s]. None for never.
    """

    def __init__(self, time_limit: float | None = None) -> None:
        self._hired: list[_Process] = []
        self._over = threading.Event()
        self._limit = None if time_limit is None else max(time_limit, LEAST_S)
        self._watching: threading.Thread | None = None

    def hire(self) -> "_Process":
        """Return a new process, which is still starting."""
        if self._watching is None:
            self._watching = threading.Thread(target=self._watch, daemon=True)
            self._watching.start()
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

    def _watch(self) -> None:
        """Kill what is stopped, or in the middle of a message for too long."""
        pause = LOOK_S if self._limit is None else min(LOOK_S, self._limit / 4)
        while not self._over.wait(pause):
            for each in list(self._hired):
                if each.pulse.is_stopped(pause):
                    each.end(f"gave no sign of life for {each.pulse.silence:g} s")
                elif self._is_over_limit(each.since):
                    each.process.kill()

    def _is_over_limit(self, since: float | None) -> bool:
        if self._limit is None or since is None:
            return False
        return monotonic() - since > self._limit


class _Process:
    """A process that answers calls."""

    since: float | None = None
    """When the message began that is on its way; None for none."""
    is_over = False
    _why: str | None = None

    def __init__(self) -> None:
        self.pipe, theirs = _SPAWN.Pipe()
        heard, beats = _SPAWN.Pipe(duplex=False)
        self.pulse = Pulse(heard)
        by_thread = threading.current_thread() is not threading.main_thread()
        self.process = _SPAWN.Process(
            target=_serve, args=(theirs, beats), kwargs={"by_thread": by_thread}, daemon=True
        )
        with _without_main():
            self.process.start()
        theirs.close()
        beats.close()

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
        if self._why is not None:
            return Death(self._why)
        code = self.process.exitcode or 0
        return Death(f"was killed by signal {-code}" if code < 0 else f"ended with status {code}")

    def end(self, why: str) -> None:
        """Kill it where nobody may be waiting, for a reason that is told once it is found dead."""
        self._why = why
        self.process.kill()

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


def _serve(pipe: Connection, beats: Connection, *, by_thread: bool) -> None:
    """Answer calls until the caller is gone."""
    # Control-C reaches the whole group of processes; the caller decides what ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_caller(by_thread=by_thread)
    beat(beats)
    served = Served()
    with suppress(EOFError, OSError):
        while True:
            pipe.send_bytes(served.reply(pipe.recv_bytes()))
