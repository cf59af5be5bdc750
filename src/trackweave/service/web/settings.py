"""What may be told of who is let in, and how much of anything anybody may have."""

import ipaddress
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated
from urllib.parse import urlsplit

from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.keys import Key
from trackweave.service.web.tokens import Tokens

__all__ = ["Limits", "Tls", "WebSettings", "origin_of"]

_SOME_SECONDS = Key("a number of seconds from 0.1 to 3600", 0.1, 3600)
_SOME = Key("a whole number from 1 to 100000", 1, 100_000)
_RATE = Key("a number above 0, at most 1e6", 1e-3, 1e6)


@dataclass(frozen=True, slots=True)
class Limits:
    """How much anybody may have.

    Parameters
    ----------
    body_bytes
        Length of a request's body.
    head_s, body_s
        Seconds within which a request's head, and then its body, must have come.
    stall_s
        Seconds after which a connection that does not read what it is sent is cut.
    connections, per_address
        As many are open at once, in all and of one address. Addresses of this machine and of
        proxies have no share of their own.
    streams
        As many connections listen to the stream at once.
    bodies_bytes
        As much of bodies is held at once, in all.
    requests_per_s
        Requests of one address, of which twice as many may come at once.
    failures_per_min
        Wrong tokens of one address, of which as many may come at once; after them also right ones
        are refused.
    session_s
        Seconds after which the page asks for the token again.
    """

    body_bytes: Annotated[int, Key("a whole number from 1024 to 2**30", 1024, 1 << 30)] = 8 << 20
    head_s: Annotated[float, _SOME_SECONDS] = 10.0
    body_s: Annotated[float, _SOME_SECONDS] = 30.0
    stall_s: Annotated[float, _SOME_SECONDS] = 20.0
    connections: Annotated[int, _SOME] = 512
    per_address: Annotated[int, _SOME] = 64
    streams: Annotated[int, _SOME] = 200
    bodies_bytes: Annotated[int, Key("a whole number from 1024 to 2**32", 1024, 1 << 32)] = (
        64 << 20
    )
    requests_per_s: Annotated[float, _RATE] = 1000.0
    failures_per_min: Annotated[float, _RATE] = 10.0
    session_s: Annotated[float, Key("a number of seconds from 1 to 1e7", 1, 1e7)] = 43_200.0

    def __post_init__(self) -> None:
        settle(self)


@dataclass(frozen=True, slots=True)
class Tls:
    """What a connection is encrypted with.

    Parameters
    ----------
    certificate, key
        Files in PEM.
    """

    certificate: Path
    key: Path


@dataclass(frozen=True, slots=True)
class WebSettings:
    """Who is let in, and what the page may fetch.

    Parameters
    ----------
    tokens
        What opens the service; None where everybody on this machine may come in.
    origins
        Further origins from which the page may be used, such as "https://tracks.example.org"
        where a proxy stands before the service.
    proxies
        Addresses or networks of proxies, whose word for who asks is taken (``X-Forwarded-For``).
    is_encrypted
        Whether browsers reach the service by https, here or at a proxy: cookies are then never
        sent in clear.
    tiles
        URL of map tiles with ``{z}``, ``{x}`` and ``{y}``: its origin is the only foreign one that
        the page may fetch from. None for none.
    attribution
        What to say of the tiles' makers.
    limits
        How much anybody may have.
    """

    tokens: Tokens | None = None
    origins: tuple[str, ...] = ()
    proxies: tuple[str, ...] = ()
    is_encrypted: bool = False
    tiles: str | None = None
    attribution: str | None = None
    limits: Limits = field(default_factory=Limits)

    def __post_init__(self) -> None:
        settle(self)
        for origin in self.origins:
            if origin_of(origin) != origin:
                raise InvalidInputError(
                    f"origin {origin!r:.80}; expected one such as https://tracks.example.org"
                )
        for proxy in self.proxies:
            try:
                ipaddress.ip_network(proxy)
            except ValueError:
                raise InvalidInputError(
                    f"proxy {proxy!r:.80}; expected an address or a network, such as 10.0.0.0/8"
                ) from None
        if self.tiles is not None and not (
            origin_of(self.tiles) and all(part in self.tiles for part in ("{z}", "{x}", "{y}"))
        ):
            raise InvalidInputError(
                f"tiles {self.tiles!r:.80}; expected a URL with {{z}}, {{x}} and {{y}}"
            )


def origin_of(url: str) -> str | None:
    """Return the origin of a URL as browsers write it, None where it has none of the web."""
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError:
        return None
    # What goes into a header of ours has no letter that could end one.
    is_plain = host is not None and re.fullmatch(r"[a-z0-9.-]+|[0-9a-f:.]+", host) is not None
    if parts.scheme not in ("http", "https") or host is None or not is_plain:
        return None
    name = f"[{host}]" if ":" in host else host
    usual = {"http": 80, "https": 443}[parts.scheme]
    return f"{parts.scheme}://{name}" + ("" if port in (None, usual) else f":{port}")
