"""``WS /stream``: a full picture, then what changes, to whoever reads it."""

import asyncio
from contextlib import suppress

from starlette.websockets import WebSocket, WebSocketDisconnect

from trackweave.service.desk import Desk, Subscription
from trackweave.service.web.answers import refusal
from trackweave.service.web.entrance import Entrance
from trackweave.service.web.settings import Limits
from trackweave.service.web.tally import Tally

__all__ = ["Stream"]

_NOTHING_EXPECTED, _NOT_READING, _ENDS = 1008, 1013, 1001


class Stream:
    """Sends messages to those who listen.

    Parameters
    ----------
    desk
        Whom messages come from.
    entrance
        Who still may listen.
    limits
        How many may listen, and for how long one need not read.
    tally
        Where to count.
    """

    def __init__(self, desk: Desk, entrance: Entrance, limits: Limits, tally: Tally) -> None:
        self._desk, self._entrance, self._limits, self._tally = desk, entrance, limits, tally
        self._open = 0
        tally.measured["streams"] = lambda: float(self._open)

    async def __call__(self, websocket: WebSocket) -> None:
        """Answer ``WS /stream``."""
        if self._open >= self._limits.streams:
            self._tally.add("refused_total", reason="streams")
            full = refusal(503, "too many listen already; expected a try later", retry_after="10")
            await websocket.send_denial_response(full)
            return
        self._open += 1
        try:
            await websocket.accept()
            wants_reports = websocket.query_params.get("reports") == "1"
            messages = self._desk.subscribe(reports=wants_reports)
            try:
                code = await self._serve(websocket, messages)
            finally:
                messages.close()
            with suppress(WebSocketDisconnect, RuntimeError):
                async with asyncio.timeout(1.0):
                    await websocket.close(code)
        except (WebSocketDisconnect, TimeoutError):
            return
        finally:
            self._open -= 1

    async def _serve(self, websocket: WebSocket, messages: Subscription) -> int:
        """Send until either side has enough; return why."""
        sending = asyncio.ensure_future(self._send(websocket, messages))
        # Whoever listens has nothing to say: a message is as much an end as leaving.
        hearing = asyncio.ensure_future(websocket.receive())
        try:
            await asyncio.wait((sending, hearing), return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in (sending, hearing):
                task.cancel()
            await asyncio.gather(sending, hearing, return_exceptions=True)
        if sending.done() and not sending.cancelled() and sending.exception() is None:
            return sending.result()
        return _NOTHING_EXPECTED

    async def _send(self, websocket: WebSocket, messages: Subscription) -> int:
        session = self._entrance.session_of(websocket.scope)
        is_by_session = session is not None and self._entrance.sessions.holds(session)
        async for text in messages:
            if is_by_session and not self._entrance.sessions.holds(session or ""):
                return _NOTHING_EXPECTED
            try:
                async with asyncio.timeout(self._limits.stall_s):
                    await websocket.send_text(text)
            except TimeoutError:
                self._tally.add("stalled_total")
                return _NOT_READING
            self._tally.add("stream_messages_total")
            self._tally.add("stream_characters_total", len(text))
        return _ENDS
