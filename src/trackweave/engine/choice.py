"""Engines by name."""

import os
from importlib import import_module
from operator import index
from typing import Any

from trackweave.engine.local import LocalHost
from trackweave.engine.pool import Pool
from trackweave.engine.protocol import EngineError, Host
from trackweave.errors import InvalidInputError

__all__ = ["engine_of", "processors", "require_engine"]

MOST_WORKERS = 10_000
"""More processes than any machine here has."""


def engine_of(
    name: str = "local", workers: int | None = None, *, time_limit: float | None = None
) -> Pool:
    """Return an engine by its name.

    Parameters
    ----------
    name
        ``local`` for processes of this machine; ``ray`` for Ray on this machine; ``ray://HOST``
        or ``ray://HOST:PORT`` for a cluster of Ray.
    workers
        How many tasks are carried out at a time; None for as many as there are processors here.
    time_limit
        Wall clock after which a worker counts as hung [s]; None for none.

    Returns
    -------
    The engine, a context that ends its workers when it is left.

    Raises
    ------
    InvalidInputError
        If the name or a number cannot be used.
    EngineError
        If Ray is missing, or the cluster does not answer.
    """
    require_engine(name, workers)
    count = processors() if workers is None else index(workers)
    if time_limit is not None and not time_limit > 0:
        raise InvalidInputError(f"time_limit: {time_limit!r:.80}; expected seconds > 0, or None")
    host: Host = LocalHost(time_limit) if name == "local" else _on_ray(name, count)
    return Pool(host, count, time_limit=time_limit)


def require_engine(name: Any, workers: Any) -> None:
    """Refuse what is no engine's name, and what is no number of workers nor None."""
    if not isinstance(name, str) or not (name in {"local", "ray"} or name.startswith("ray://")):
        raise InvalidInputError(f"engine: {name!r:.80}; expected local, ray or ray://HOST")
    count = 1 if workers is None else _whole(workers)
    if count is None or not 1 <= count <= MOST_WORKERS:
        raise InvalidInputError(
            f"workers: {workers!r:.80}; expected a whole number from 1 to {MOST_WORKERS}"
        )


def _whole(number: Any) -> int | None:
    """Return a whole number as Python's, None where it is none."""
    if isinstance(number, bool) or not hasattr(number, "__index__"):
        return None
    try:
        return index(number)
    except TypeError:  # an array of several, or of others
        return None


def processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _on_ray(name: str, workers: int) -> Host:
    try:
        host: Host = import_module("trackweave.engine.on_ray").RayHost(name, workers)
    except ModuleNotFoundError as err:
        if err.name != "ray":
            raise
        raise EngineError(
            f"engine: {name!r:.80} needs Ray, which is not installed; expected "
            "pip install 'trackweave[ray]', or the engine local"
        ) from None
    return host
