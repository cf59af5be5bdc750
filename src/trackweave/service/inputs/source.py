"""What ``--listen`` names: an address, a format, and how the reports are called."""

from dataclasses import dataclass
from typing import Any
from urllib.parse import parse_qsl, urlencode, urlsplit

from trackweave.errors import InvalidInputError
from trackweave.formats.reading import chosen

__all__ = ["SCHEMES", "Source", "source_of"]

SCHEMES = ("udp", "tcp", "ws", "stdin", "replay")
_OWN = ("format", "sensor", "speed", "connect", "loop", "ahead")
FASTEST, FARTHEST = 1e6, 3600.0


@dataclass(frozen=True, slots=True)
class Source:
    """An input, every word checked.

    Parameters
    ----------
    url
        As it was told.
    scheme
        One of ``SCHEMES``.
    host, port
        Where to listen or to connect.
    path
        A file that is replayed.
    told
        The format, and what its reader is told, such as "mot?frame_rate=30"; None to find it by
        the content.
    sensor
        What the sensor of reports is called that name none; None for "default".
    speed
        How much faster than it was a recording is replayed; 0 for as fast as it can be taken.
    connect
        Whether a connection is made instead of waited for.
    loop
        Whether a recording begins again after its end, with times that go on.
    ahead
        So much of a recording comes at once, before the rest takes its time [s].
    """

    url: str
    scheme: str
    host: str = ""
    port: int = 0
    path: str = ""
    told: str | None = None
    sensor: str | None = None
    speed: float = 1.0
    connect: bool = False
    loop: bool = False
    ahead: float = 0.0


def source_of(url: str) -> Source:
    """Return the input that a URL names.

    Parameters
    ----------
    url
        Such as ``udp://127.0.0.1:8600?format=asterix``, ``tcp://HOST:PORT?connect=1``,
        ``ws://HOST:PORT?format=jsonl``, ``stdin:?format=ais`` or ``replay:FILE?speed=10``.

    Returns
    -------
    The input.

    Raises
    ------
    InvalidInputError
        If it is none; the message says what was expected.
    """
    parts = urlsplit(url)
    if parts.scheme not in SCHEMES:
        raise InvalidInputError(f"--listen {url!r:.100}: expected one of {_EXAMPLES}")
    query = dict(parse_qsl(parts.query, keep_blank_values=True))
    rest = {key: value for key, value in query.items() if key not in _OWN}
    name = query.get("format")
    if name is None and parts.scheme != "replay":
        raise InvalidInputError(f"--listen {url!r:.100}: no format; expected ?format=NAME")
    if name is None and rest:
        raise InvalidInputError(f"--listen {url!r:.100}: {', '.join(rest)}; expected speed")
    told = None
    if name is not None:
        told = name + ("?" + urlencode(rest) if rest else "")
        if chosen(told)[0].decoder is None and parts.scheme != "replay":
            raise InvalidInputError(
                f"--listen {url!r:.100}: format {name}; expected one of bytes in a stream"
            )
    host, port = _address(url, parts)
    return Source(
        url, parts.scheme, host, port, _path(url, parts), told, query.get("sensor"),
        _number(url, query, "speed", (1.0, FASTEST)), query.get("connect") == "1",
        query.get("loop") == "1", _number(url, query, "ahead", (0.0, FARTHEST)),
    )  # fmt: skip


_EXAMPLES = (
    "udp://HOST:PORT?format=…, tcp://HOST:PORT?format=…, ws://HOST:PORT?format=…, "
    "stdin:?format=…, replay:FILE?speed=10"
)


def _address(url: str, parts: Any) -> tuple[str, int]:
    if parts.scheme not in ("udp", "tcp", "ws"):
        return "", 0
    try:
        host, port = parts.hostname, parts.port
    except ValueError:
        host = port = None
    if not host or port is None:
        raise InvalidInputError(f"--listen {url!r:.100}: expected {parts.scheme}://HOST:PORT")
    return str(host), int(port)


def _path(url: str, parts: Any) -> str:
    if parts.scheme != "replay":
        return ""
    path = (f"//{parts.netloc}" if parts.netloc else "") + parts.path
    if not path:
        raise InvalidInputError(f"--listen {url!r:.100}: no file; expected replay:FILE?speed=10")
    return str(path)


def _number(url: str, query: dict[str, str], name: str, bounds: tuple[float, float]) -> float:
    """Return what is told of a recording, or the first of the bounds; the second is the most."""
    usual, most = bounds
    try:
        found = float(query.get(name, usual))
    except ValueError:
        found = -1.0
    if not 0.0 <= found <= most:
        meaning = " (as fast as it can be taken)" if name == "speed" else " s"
        raise InvalidInputError(
            f"--listen {url!r:.100}: {name} {query[name]!r:.20}; expected a number from "
            f"0{meaning} to {most:g}"
        )
    return found
