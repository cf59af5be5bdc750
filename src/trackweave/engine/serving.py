"""What happens in a worker: calls in, replies out, both as bytes."""

import multiprocessing
import pickle
from threading import Event
from typing import Any, Literal

from trackweave.errors import InvalidInputError, TrackweaveError

__all__ = ["GREETING", "Kind", "Served", "is_worker", "packed_call", "unpacked_reply"]

Kind = Literal["do", "make", "ask", "greet"]


def packed_call(kind: Kind, of: Any = None, args: tuple[Any, ...] = ()) -> bytes:
    """Return a call as bytes: of a function, or of the actor's method by its name."""
    name = getattr(of, "__name__", of)
    if kind in {"do", "make"} and (not callable(of) or of.__module__ == "__main__"):
        raise InvalidInputError(
            f"work: {name!r:.80}; expected a function of a module that workers can import"
        )
    try:
        return pickle.dumps((kind, of, args))
    except (pickle.PicklingError, AttributeError, TypeError) as err:
        raise InvalidInputError(
            f"work: {name!r:.80} cannot be sent to a worker ({err}); expected a function of a "
            "module that workers can import, and arguments that can be pickled"
        ) from err


GREETING = packed_call("greet")
"""A call that says only that the worker is there."""


_SERVING = Event()


def is_worker() -> bool:
    """Tell whether this process is itself a worker, which had better bring no others."""
    # Processes of this machine may not bring any where they end with their caller; on Ray all
    # would wait for a processor that they hold themselves.
    return _SERVING.is_set() or multiprocessing.current_process().daemon


class Served:
    """A worker's own side: carries out calls, keeps the actor if it houses one."""

    def __init__(self) -> None:
        _SERVING.set()
        self._actor: Any = None

    def reply(self, call: bytes) -> bytes:
        """Return what comes of a call; an error is a reply like any other."""
        try:
            kind, of, args = pickle.loads(call)
            return pickle.dumps((True, self._carried_out(kind, of, args)))
        except Exception as err:
            return pickle.dumps((False, _told(err)))

    def _carried_out(self, kind: Kind, of: Any, args: tuple[Any, ...]) -> Any:
        if kind == "do":
            return of(*args)
        if kind == "make":
            self._actor = of(*args)
        return getattr(self._actor, of)(*args) if kind == "ask" else None


def unpacked_reply(reply: bytes) -> tuple[bool, Any]:
    """Return whether a call went well, and its value or what went wrong."""
    went_well, value = pickle.loads(reply)
    return went_well, value


def _told(err: Exception) -> str:
    """Return an error in one line; our own errors speak for themselves."""
    text = " ".join(str(err).split())
    return text if isinstance(err, TrackweaveError) else f"{type(err).__name__}: {text}"
