"""An engine that stays open for those who ask for it again and again, as a solver does."""

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

from trackweave.engine.choice import engine_of
from trackweave.engine.pool import Pool

__all__ = ["kept_engine"]

_KEPT: dict[tuple[str, int | None], Pool] = {}
"""The one that is open, if any: two would share the processors."""
_IN_USE = Lock()


@contextmanager
def kept_engine(name: str, workers: int | None = None) -> Iterator[Pool]:
    """Give the engine of this name that is open, to one thread at a time.

    Its workers take a second or more to start. They end with this process, when another engine is
    asked for, and when what the engine was given to do is broken off.

    Parameters
    ----------
    name, workers
        As for ``engine_of``.

    Yields
    ------
    The engine, without any task.
    """
    with _IN_USE:
        if (name, workers) not in _KEPT:
            _end()
            _KEPT[name, workers] = engine_of(name, workers)
        try:
            yield _KEPT[name, workers]
        except BaseException:
            _end()
            raise


def _end() -> None:
    while _KEPT:
        _KEPT.popitem()[1].close()
