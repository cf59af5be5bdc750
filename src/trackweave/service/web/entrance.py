"""Who is let in: by name, origin, rate and token, in this order."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from trackweave.service.web.asking import (
    bearer_of,
    cookie_of,
    header,
    is_local_host,
    is_own_origin,
)
from trackweave.service.web.buckets import Buckets
from trackweave.service.web.sessions import Sessions
from trackweave.service.web.settings import WebSettings

__all__ = ["Entrance", "Refusal"]

_CHANGES_NOTHING = ("GET", "HEAD")
_HEAD_BYTES, _ADDRESS_BYTES = 16_384, 2048


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why somebody is not let in.

    Parameters
    ----------
    status
        HTTP's.
    reason
        In a word, for counting.
    message
        For whoever asked.
    headers
        What goes with it.
    """

    status: int
    reason: str
    message: str
    headers: Mapping[str, str] = field(default_factory=dict)


class Entrance:
    """Decides who may come in.

    Parameters
    ----------
    settings
        Who is let in.
    """

    def __init__(self, settings: WebSettings) -> None:
        limits = settings.limits
        self.sessions = Sessions(limits.session_s)
        self.cookie = "__Host-trackweave" if settings.is_encrypted else "trackweave"
        self._settings = settings
        self._requests = Buckets(limits.requests_per_s, max(1.0, 2 * limits.requests_per_s))
        self._failures = Buckets(limits.failures_per_min / 60, max(1.0, limits.failures_per_min))

    def refusal(self, scope: Mapping[str, Any], address: str, *, is_open: bool) -> Refusal | None:
        """Return why a request is not let in, None where it is.

        Parameters
        ----------
        scope
            The request.
        address
            Who asks.
        is_open
            Whether what is asked for needs no token.

        Returns
        -------
        The reason, None for none.
        """
        found = _malformed(scope) or self._foreign(scope)
        if found is not None:
            return found
        wait = self._requests.take(address)
        if wait:
            return _too_many("requests", wait)
        if self._settings.tokens is None or is_open or self._has_session(scope):
            return None
        token = bearer_of(scope)
        if token is None:
            return Refusal(401, "token", "no token; expected Authorization: Bearer …", _CHALLENGE)
        wait = self._failures.wait_s(address)
        if wait:
            return _too_many("failures", wait)
        if self.opens(token, address):
            return None
        return Refusal(401, "token", "not a token of ours", _CHALLENGE)

    def opens(self, token: str, address: str) -> bool:
        """Tell whether a token opens the service; an address that guessed too often learns no."""
        tokens = self._settings.tokens
        if tokens is None or self._failures.wait_s(address):
            return False
        if tokens.matches(token):
            return True
        self._failures.take(address)
        return False

    def session_of(self, scope: Mapping[str, Any]) -> str | None:
        """Return the session that a request shows, whether it holds or not."""
        return cookie_of(scope, self.cookie)

    def _foreign(self, scope: Mapping[str, Any]) -> Refusal | None:
        """Return why a page of somebody else may not do this, None where it may, or is none."""
        settings = self._settings
        if settings.tokens is None and not is_local_host(scope, settings):
            return Refusal(
                421, "host", "called by another name; expected localhost or an address of it"
            )
        if _needs_own_origin(scope) and not is_own_origin(scope, settings):
            return Refusal(403, "origin", "from another origin; expected the service's own page")
        return None

    def _has_session(self, scope: Mapping[str, Any]) -> bool:
        # Whoever shows a token is judged by it.
        session = self.session_of(scope) if header(scope, "authorization") is None else None
        return session is not None and self.sessions.holds(session)


_CHALLENGE = {"www-authenticate": 'Bearer realm="trackweave"'}


def _malformed(scope: Mapping[str, Any]) -> Refusal | None:
    if scope.get("http_version") not in ("1.0", "1.1"):
        return Refusal(505, "version", "another HTTP; expected 1.1")
    if sum(len(name) + len(value) for name, value in scope["headers"]) > _HEAD_BYTES:
        return Refusal(431, "head", f"more than {_HEAD_BYTES:,} bytes of headers")
    if len(scope["raw_path"]) + len(scope["query_string"]) > _ADDRESS_BYTES:
        return Refusal(414, "head", f"an address of more than {_ADDRESS_BYTES:,} bytes")
    return None


def _needs_own_origin(scope: Mapping[str, Any]) -> bool:
    return scope["type"] == "websocket" or scope["method"] not in _CHANGES_NOTHING


def _too_many(reason: str, wait: float) -> Refusal:
    return Refusal(
        429, reason, "too often; expected a pause", {"retry-after": str(max(1, round(wait)))}
    )
