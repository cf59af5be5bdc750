"""Who may be listened to: this machine alone, unless whoever comes shows a token over TLS."""

import ipaddress
import socket

from trackweave.errors import InvalidInputError

__all__ = ["checked_listening", "is_loopback", "shown_address"]


def is_loopback(host: str) -> bool:
    """Tell whether a name or an address leads to this machine alone.

    Parameters
    ----------
    host
        A name or an IPv4 or IPv6 address, without brackets. An empty one stands for all addresses.

    Returns
    -------
    Whether everything it stands for is loopback; False where a name is not known.
    """
    try:
        return _is_loopback(host)
    except ValueError:
        pass
    try:
        found = socket.getaddrinfo(
            host or None, None, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )
    except (OSError, UnicodeError):
        return False
    return bool(found) and all(_is_loopback(str(entry[4][0])) for entry in found)


def checked_listening(host: str, *, has_token: bool, has_tls: bool) -> None:
    """Refuse to be reached from other machines without a token and TLS.

    Parameters
    ----------
    host
        Where to listen.
    has_token
        Whether every request needs a token.
    has_tls
        Whether connections are encrypted.

    Raises
    ------
    InvalidInputError
        If it leads beyond this machine and one of them is missing.
    """
    if (has_token and has_tls) or is_loopback(host):
        return
    missing = [
        option
        for option, is_there in (
            ("--token-file", has_token),
            ("--certificate and --key", has_tls),
        )
        if not is_there
    ]
    raise InvalidInputError(
        f"{shown_address(host)}: reached from other machines, without {' and '.join(missing)}; "
        "expected an address of this machine, such as 127.0.0.1, or a token and TLS"
    )


def shown_address(host: str, port: int | None = None) -> str:
    """Return an address as it is written in a URL."""
    name = f"[{host}]" if ":" in host else host or "all addresses"
    return name if port is None else f"{name}:{port}"


def _is_loopback(address: str) -> bool:
    found = ipaddress.ip_address(address.partition("%")[0])
    mapped = getattr(found, "ipv4_mapped", None)
    return (mapped or found).is_loopback
