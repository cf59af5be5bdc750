"""The page's login: a form for the token, a cookie for the browser."""

import html
import logging
from urllib.parse import parse_qs

from starlette.requests import Request
from starlette.responses import RedirectResponse, Response

from trackweave.service.log import say
from trackweave.service.web.entrance import Entrance
from trackweave.service.web.posting import read_body
from trackweave.service.web.settings import Limits, WebSettings

__all__ = ["LOGIN_PATHS", "Login"]

_LOG = logging.getLogger("trackweave.service.web")
LOGIN_PATHS = ("/login", "/login.css", "/favicon.ico")
"""What whoever is not let in is shown."""
_FORM_LIMITS = Limits(body_bytes=4096, body_s=10.0)
_POLICY = (
    "default-src 'none'; style-src 'self'; form-action 'self'; base-uri 'none'; "
    "frame-ancestors 'none'"
)
_STYLE = """:root { color-scheme: light dark; font: 16px/1.5 system-ui, sans-serif }
body { display: grid; place-items: center; min-height: 90vh; margin: 0 }
form { display: grid; gap: .75rem; width: min(22rem, 90vw) }
h1 { font-size: 1.25rem; margin: 0 }
input, button { font: inherit; padding: .5rem .75rem }
.wrong { font-weight: 600; margin: 0 }
"""
_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>trackweave: log in</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="stylesheet" href="/login.css"></head>
<body><form method="post" action="/login"><h1>trackweave</h1>{said}
<label for="token">Token</label>
<input id="token" name="token" type="password" autocomplete="current-password" required autofocus>
<button>Log in</button></form></body></html>
"""


class Login:
    """Lets browsers in.

    Parameters
    ----------
    entrance
        Who is let in.
    settings
        Whether there are tokens, and whether browsers come by https.
    """

    def __init__(self, entrance: Entrance, settings: WebSettings) -> None:
        self._entrance, self._settings = entrance, settings

    async def form(self, _: Request) -> Response:
        """Answer ``GET /login``."""
        return _to_page() if self._settings.tokens is None else _form("")

    async def style(self, _: Request) -> Response:
        """Answer ``GET /login.css``."""
        return Response(_STYLE, media_type="text/css", headers={"cache-control": "no-cache"})

    async def enter(self, request: Request) -> Response:
        """Answer ``POST /login``."""
        body = await read_body(request, _FORM_LIMITS)
        if isinstance(body, Response):
            return body
        try:
            told = parse_qs(body.decode("utf-8"), max_num_fields=5).get("token", [""])[0].strip()
        except ValueError:
            told = ""
        address = request.scope["trackweave.address"]
        if not self._entrance.opens(told, address):
            say(_LOG, logging.WARNING, "login refused", address=address)
            return _form("Not a token of this service, or too many tries.", 401)
        say(_LOG, logging.INFO, "login", address=address)
        answer = _to_page()
        answer.set_cookie(
            self._entrance.cookie,
            self._entrance.sessions.begin(),
            max_age=int(self._settings.limits.session_s),
            secure=self._settings.is_encrypted,
            httponly=True,
            samesite="strict",
        )
        return answer

    async def leave(self, request: Request) -> Response:
        """Answer ``POST /logout``."""
        session = self._entrance.session_of(request.scope)
        if session is not None:
            self._entrance.sessions.end(session)
        answer = RedirectResponse("/login", status_code=303)
        answer.delete_cookie(
            self._entrance.cookie,
            secure=self._settings.is_encrypted,
            httponly=True,
            samesite="strict",
        )
        return answer


def _to_page() -> Response:
    return RedirectResponse("/", status_code=303)


def _form(said: str, status: int = 200) -> Response:
    words = f'<p class="wrong" role="alert">{html.escape(said)}</p>' if said else ""
    headers = {"content-security-policy": _POLICY, "cache-control": "no-store"}
    return Response(
        _PAGE.replace("{said}", words), status, headers=headers, media_type="text/html"
    )
