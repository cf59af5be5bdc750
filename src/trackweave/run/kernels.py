"""Whether kernels are being compiled, so that nobody takes it for hanging."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter

__all__ = ["compiling_told"]

PATIENCE = 1.0
"""How long compiling may take without a word [s]."""


@contextmanager
def compiling_told(tell: Callable[[], None]) -> Iterator[None]:
    """Have it told, once, when compiling takes more than a second while the block runs."""
    # Kernels that an earlier run left on the disk are not compiled again; another command, or
    # another method, may need others.
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

    teller = Teller()
    event.register("numba:compile", teller)  # type: ignore[no-untyped-call]
    try:
        yield
    finally:
        event.unregister("numba:compile", teller)  # type: ignore[no-untyped-call]
