"""Whether kernels are being compiled, so that nobody takes it for hanging."""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from time import perf_counter

__all__ = ["COMPILING", "compiling_logged", "compiling_told"]

COMPILING = "compiling kernels that run here for the first time: a minute or two, once"
PATIENCE = 1.0
"""How long compiling may take without a word [s]."""
_IS_WATCHED = ContextVar("_IS_WATCHED", default=False)


def compiling_logged() -> None:
    """Tell whoever calls from Python: on standard error, where no logging is set up."""
    logging.getLogger("trackweave").warning(COMPILING)


@contextmanager
def compiling_told(tell: Callable[[], None] = compiling_logged) -> Iterator[None]:
    """Have it told, once, when compiling takes more than a second while the block runs.

    Of such blocks within one another the outermost tells.
    """
    # Kernels that an earlier run left on the disk are not compiled again; another command, or
    # another method, may need others.
    if _IS_WATCHED.get():
        yield
        return
    from numba.core import event

    class Teller(event.Listener):
        """Adds up for how long kernels were compiled, those that others needed within."""

        depth, begin, spent, is_told = 0, 0.0, 0.0, False

        def on_start(self, _: event.Event) -> None:
            if self.depth == 0:
                self.begin = perf_counter()
            self.depth += 1

        def on_end(self, _: event.Event) -> None:
            self.depth -= 1
            spent = self.spent + perf_counter() - self.begin
            if self.depth == 0:
                self.spent = spent
            if spent > PATIENCE and not self.is_told:
                self.is_told = True
                tell()

    teller, before = Teller(), _IS_WATCHED.set(True)
    event.register("numba:compile", teller)  # type: ignore[no-untyped-call]
    try:
        yield
    finally:
        event.unregister("numba:compile", teller)  # type: ignore[no-untyped-call]
        _IS_WATCHED.reset(before)
