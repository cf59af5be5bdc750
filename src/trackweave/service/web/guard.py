"""What stands around all routes: refuses, adds headers, counts, and lets no fault out."""

import asyncio
import logging
import time
from collections.abc import Callable
from typing import Any

from starlette.responses import RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from trackweave.service.log import say
from trackweave.service.web.answers import refusal
from trackweave.service.web.asking import address_of, header
from trackweave.service.web.buckets import Buckets
from trackweave.service.web.entrance import Entrance, Refusal
from trackweave.service.web.settings import WebSettings
from trackweave.service.web.tally import Tally

__all__ = ["Guard"]

_LOG = logging.getLogger("trackweave.service.web")
_LINES_PER_S = 5.0
"""Lines on refused requests, of which ten times as many may come at once."""
_ALWAYS = {
    "x-content-type-options": "nosniff",
    # Without any, browsers send the login's form as of no origin.
    "referrer-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "x-frame-options": "DENY",
    "permissions-policy": "camera=(), geolocation=(), microphone=()",
}
_METHODS = ("GET", "HEAD", "POST", "OPTIONS", "PUT", "DELETE", "PATCH")


class Guard:
    """Stands before an application.

    Parameters
    ----------
    inner
        The application.
    entrance
        Who is let in.
    settings
        Proxies, and whether browsers come by https.
    tally
        Where to count.
    open_to_all
        Tells of a path whether it needs no token.
    """

    def __init__(
        self,
        inner: ASGIApp,
        entrance: Entrance,
        settings: WebSettings,
        tally: Tally,
        *,
        open_to_all: Callable[[str], bool],
    ) -> None:
        self._inner, self._entrance, self._settings = inner, entrance, settings
        self._tally, self._is_open = tally, open_to_all
        self._lines = Buckets(_LINES_PER_S, 10 * _LINES_PER_S)
        headers = dict(_ALWAYS)
        if settings.is_encrypted:
            headers["strict-transport-security"] = "max-age=31536000"
        self._headers = [(k.encode("ascii"), v.encode("ascii")) for k, v in headers.items()]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or hand it on."""
        if scope["type"] not in ("http", "websocket"):
            return
        address = address_of(scope, self._settings.proxies)
        scope["trackweave.address"] = address
        begin = time.perf_counter()
        status = 0

        async def sending(message: Message) -> None:
            nonlocal status
            if message["type"] in ("http.response.start", "websocket.http.response.start"):
                status = message["status"]
                message["headers"] = [*message.get("headers", ()), *self._headers]
            elif message["type"] == "websocket.accept":
                status = 101
            await send(message)

        is_open = self._is_open(scope["path"])
        found = self._entrance.refusal(scope, address, is_open=is_open)
        try:
            if found is None:
                await self._inner(scope, receive, sending)
            else:
                await self._refuse(found, scope, receive, sending)
        except asyncio.CancelledError:
            return  # the service ends, and the connection has
        except Exception:
            # Nothing that comes from outside ends the service, or shows more than that it failed.
            _LOG.exception("an answer failed")
            if not status:
                await refusal(500, "failed; the log says why")(scope, receive, sending)
        self._tally.add(
            "http_requests_total",
            method=_method(scope),
            status=str(status),
        )
        if found is None:
            took = round(1e3 * (time.perf_counter() - begin), 1)
            self._log(logging.DEBUG, "request", scope, status=status, took_ms=took)

    async def _refuse(self, found: Refusal, scope: Scope, receive: Receive, send: Send) -> None:
        self._tally.add("refused_total", reason=found.reason)
        if not self._lines.take(found.reason):
            self._log(logging.WARNING, "refused", scope, reason=found.reason, status=found.status)
        if found.reason == "token" and _is_for_people(scope):
            await RedirectResponse("/login", status_code=303)(scope, receive, send)
            return
        headers = {name.replace("-", "_"): value for name, value in found.headers.items()}
        await refusal(found.status, found.message, **headers)(scope, receive, send)

    def _log(self, level: int, event: str, scope: Scope, **fields: Any) -> None:
        if _LOG.isEnabledFor(level):
            # Without the query: a token that somebody puts there is not to stay in a log.
            told = {"address": scope["trackweave.address"], "method": _method(scope)}
            say(_LOG, level, event, **told, path=scope["path"], **fields)


def _is_for_people(scope: Scope) -> bool:
    """Tell whether somebody opens the page."""
    asks = scope["type"] == "http" and scope["method"] == "GET" and scope["path"] == "/"
    return asks and "text/html" in (header(scope, "accept") or "")


def _method(scope: Scope) -> str:
    if scope["type"] == "websocket":
        return "WS"
    return scope["method"] if scope["method"] in _METHODS else "other"
