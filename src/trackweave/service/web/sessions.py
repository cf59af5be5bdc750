"""Logins of the page: a random name in a cookie, of which only the digest is kept."""

import hashlib
import secrets
import time
from collections import OrderedDict
from collections.abc import Callable

__all__ = ["Sessions"]

_MOST = 1000


class Sessions:
    """Who is logged in, and until when.

    Parameters
    ----------
    seconds
        How long a login holds.
    clock
        Returns seconds that never go back.
    """

    def __init__(self, seconds: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._seconds, self._clock = seconds, clock
        self._until: OrderedDict[bytes, float] = OrderedDict()

    def begin(self) -> str:
        """Return a new session's name; where there are too many, the oldest ends."""
        name = secrets.token_urlsafe(32)
        self._until[_digest(name)] = self._clock() + self._seconds
        while len(self._until) > _MOST:
            self._until.popitem(last=False)
        return name

    def holds(self, name: str) -> bool:
        """Tell whether a session of that name has begun and not ended."""
        until = self._until.get(_digest(name))
        return until is not None and self._clock() < until

    def end(self, name: str) -> None:
        """End a session, if there is one of that name."""
        self._until.pop(_digest(name), None)


def _digest(name: str) -> bytes:
    # What is looked up is no secret: how long that takes tells nothing of the name.
    return hashlib.sha256(name.encode("utf-8", "surrogateescape")).digest()
