"""Who asks, as far as a request tells and can be believed."""

import ipaddress
from collections.abc import Mapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import urlsplit

from trackweave.service.addresses import is_loopback
from trackweave.service.web.settings import WebSettings, origin_of

__all__ = ["address_of", "bearer_of", "cookie_of", "header", "is_local_host", "is_own_origin"]

Scope = Mapping[str, Any]


def header(scope: Scope, name: str) -> str | None:
    """Return a header of a request, None where there is none or more than one."""
    wanted = name.encode("ascii")
    found = [value for key, value in scope["headers"] if key == wanted]
    return found[0].decode("latin-1") if len(found) == 1 else None


def address_of(scope: Scope, proxies: tuple[str, ...]) -> str:
    """Return the address that asks; a proxy of ours is believed who asked it.

    Parameters
    ----------
    scope
        A request.
    proxies
        Addresses and networks of proxies.

    Returns
    -------
    The last address that no proxy of ours has.
    """
    client = scope.get("client")
    address = str(client[0]) if client else "unknown"
    told = b",".join(value for key, value in scope["headers"] if key == b"x-forwarded-for")
    before = told.decode("latin-1").split(",") if proxies and told else []
    while before and _is_of(address, proxies):
        found = before.pop().strip()
        try:
            address = str(ipaddress.ip_address(found.strip("[]")))
        except ValueError:
            break
    return address


def bearer_of(scope: Scope) -> str | None:
    """Return the token that a request shows, None where it shows none."""
    kind, _, token = (header(scope, "authorization") or "").partition(" ")
    return token.strip() if kind.lower() == "bearer" and token.strip() else None


def cookie_of(scope: Scope, name: str) -> str | None:
    """Return a cookie of a request, None where there is none."""
    try:
        found = SimpleCookie(header(scope, "cookie") or "").get(name)
    except CookieError:
        return None
    return None if found is None else found.value


def is_own_origin(scope: Scope, settings: WebSettings) -> bool:
    """Tell whether a request comes from our own page, or from no page at all."""
    if header(scope, "sec-fetch-site") in ("cross-site", "same-site"):
        # Browsers alone say this, and no page can make them lie.
        return header(scope, "origin") in settings.origins
    if not any(key == b"origin" for key, _ in scope["headers"]):
        return True
    origin, host = header(scope, "origin"), header(scope, "host")
    if origin is None or host is None:
        return False
    if origin in settings.origins:
        return True
    return origin_of(origin) == origin and urlsplit(origin).netloc == host.lower()


def is_local_host(scope: Scope, settings: WebSettings) -> bool:
    """Tell whether the service was called by a name of this machine, or of a page of ours.

    A page of somebody else whose name was made to lead here (DNS rebinding) calls it by that name.

    Parameters
    ----------
    scope
        A request.
    settings
        Further origins, by whose names it may be called as well.

    Returns
    -------
    Whether it was.
    """
    host = header(scope, "host")
    if host is None:  # of HTTP/1.0, which browsers do not speak
        return not any(key == b"host" for key, _ in scope["headers"])
    try:
        name = urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return False
    if any(urlsplit(origin).hostname == name for origin in settings.origins):
        return True
    # Names are not looked up: where they lead is what cannot be believed.
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return name == "localhost"
    return is_loopback(name)


def _is_of(address: str, networks: tuple[str, ...]) -> bool:
    try:
        found = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return False
    mapped = getattr(found, "ipv4_mapped", None) or found
    return any(mapped in ipaddress.ip_network(network) for network in networks)
