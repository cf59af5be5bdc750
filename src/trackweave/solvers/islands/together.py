"""Tasks on threads, which a stop reaches wherever they are."""

from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait
from threading import Event
from typing import TypeVar

from trackweave.solvers.protocol import Stop

__all__ = ["run_together"]

LOOK = 0.002
"""Time between two looks at the clock while others work [s]."""

Result = TypeVar("Result")


def run_together(
    tasks: Sequence[Callable[[Stop], Result]], n_threads: int, stop: Stop | None
) -> tuple[list[Result], bool]:
    """Run tasks on so many threads; return what they return, and if a stop was asked for."""
    # Each task takes a stop of its own. The given one is asked in the caller's thread alone, and
    # never again when it has said to stop.
    halt = Event()
    if n_threads == 1:

        def asked() -> bool:
            if stop is not None and not halt.is_set() and stop():
                halt.set()
            return halt.is_set()

        return [task(asked) for task in tasks], halt.is_set()
    with ThreadPoolExecutor(n_threads) as pool:
        try:
            running = [pool.submit(task, halt.is_set) for task in tasks]
            look = None if stop is None else LOOK
            while wait(running, look, FIRST_EXCEPTION).not_done and not halt.is_set():
                # With nothing to ask, only a failure wakes before all are done.
                if stop is None or stop() or _has_failed(running):
                    halt.set()
        except BaseException:
            # Not to wait for the end of all tasks when the stop fails, or the user breaks off.
            halt.set()
            raise
    return [task.result() for task in running], halt.is_set()


def _has_failed(running: Sequence[Future[Result]]) -> bool:
    """Tell whether a task ended by an error."""
    return any(task.done() and task.exception() is not None for task in running)
