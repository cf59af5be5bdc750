"""The same messages to many listeners, none of whom can make them wait or grow."""

import asyncio
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import polars as pl

from trackweave.domain.frames import LocalFrame
from trackweave.service.desk import Json, Picture
from trackweave.service.messages import as_text, full_message, track_messages, tracks_message

__all__ = ["Fanout", "Listener"]

MOST_WAITING = 1 << 20
"""What waits for a listener at most [characters]: more than a picture of some 4,000 tracks."""


class Listener:
    """What waits for one who listens: first a full picture, then what came since.

    One for whom more than ``MOST_WAITING`` waits has fallen behind: all of it is forgotten, and
    what is read next is the full picture of that moment.
    """

    def __init__(self, fanout: "Fanout", *, reports: bool) -> None:
        self.reports = reports
        self._fanout = fanout
        self._waiting: deque[str] = deque()
        self._length = 0
        self._is_behind = True
        self._is_closed = False
        self._woken = asyncio.Event()
        self._woken.set()

    def __aiter__(self) -> "Listener":
        return self

    async def __anext__(self) -> str:
        await self._woken.wait()
        if self._is_closed:
            raise StopAsyncIteration
        if self._is_behind:
            self._is_behind = False
            self._keep(self._fanout.latest)
            text = self._fanout.full()
        else:
            text = self._waiting.popleft()
            self._length -= len(text)
        if not self._waiting:
            self._woken.clear()
        return text

    def close(self) -> None:
        """Want no more. The iteration ends; a second call does nothing."""
        self._is_closed = True
        self._woken.set()
        self._fanout.forget(self)

    def put(self, text: str) -> None:
        """Let a message wait, or all of them be replaced by a full picture."""
        if self._is_behind:
            return
        if self._length + len(text) > MOST_WAITING:
            self._waiting.clear()
            self._length = 0
            self._is_behind = True
            self._fanout.resynchronised += 1
        else:
            self._keep((text,))
        self._woken.set()

    def _keep(self, texts: Sequence[str]) -> None:
        self._waiting.extend(texts)
        self._length += sum(map(len, texts))


class Fanout:
    """Makes each message once and hands it to all who listen.

    Parameters
    ----------
    picture
        Returns all live tracks; asked when a listener comes or has fallen behind.

    Attributes
    ----------
    resynchronised
        How often a listener had fallen behind.
    """

    def __init__(self, picture: Callable[[], Picture]) -> None:
        self.resynchronised = 0
        self._picture = picture
        self._listeners: list[Listener] = []
        self._full: str | None = None
        self._latest: dict[str, str] = {}

    def __len__(self) -> int:
        """Return how many listen."""
        return len(self._listeners)

    @property
    def wants_reports(self) -> bool:
        """Whether anybody wants messages of reports."""
        return any(each.reports for each in self._listeners)

    @property
    def latest(self) -> tuple[str, ...]:
        """What was last said of each thing but tracks and reports."""
        return tuple(self._latest.values())

    def subscribe(self, *, reports: bool = False) -> Listener:
        """Return a new listener, with messages of reports where they are wanted."""
        listener = Listener(self, reports=reports)
        self._listeners.append(listener)
        return listener

    def forget(self, listener: Listener) -> None:
        """Hand a listener nothing more."""
        if listener in self._listeners:
            self._listeners.remove(listener)

    def full(self) -> str:
        """Return the full picture as a message; the same text until tracks change."""
        if self._full is None:
            self._full = as_text(full_message(self._picture()))
        return self._full

    def tracks(
        self,
        time: float,
        changed: pl.DataFrame,
        ended: Sequence[str] = (),
        frame: LocalFrame | None = None,
    ) -> None:
        """Tell of tracks that changed, after ``picture`` already returns them so.

        Parameters
        ----------
        time
            Up to when reports are in them [s].
        changed
            Rows of a tracks table.
        ended
            Which tracks are no more.
        frame
            The plane of ``x`` and ``y``.
        """
        self._full = None
        if self._listeners:
            self._put(tracks_message(time, track_messages(changed, frame), ended))

    def reports(self, time: float, rows: Sequence[Any]) -> None:
        """Tell those who asked for reports of some: ``[x, y, sensor, track or null]`` each."""
        wanting = [each for each in self._listeners if each.reports]
        if wanting:
            text = as_text({"type": "reports", "time": time, "rows": rows})
            for each in wanting:
                each.put(text)

    def send(self, message: Mapping[str, Any]) -> None:
        """Tell of something else, such as "sensors" or "status"; who comes later hears the last.

        Parameters
        ----------
        message
            An object with its kind in ``type``.
        """
        self._latest[str(message["type"])] = as_text(message)
        self._put(message)

    def close(self) -> None:
        """Let all listeners' iterations end."""
        for each in tuple(self._listeners):
            each.close()

    def _put(self, message: Json | Mapping[str, Any]) -> None:
        if self._listeners:
            text = as_text(message)
            for each in tuple(self._listeners):
                each.put(text)
