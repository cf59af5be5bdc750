"""Reports over WebSockets: each connection has a decoder of its own."""

import threading
import time
from collections.abc import Callable
from typing import Any

from trackweave.errors import InvalidInputError
from trackweave.formats.format import Decoder
from trackweave.service.inputs.outbox import SOON, Outbox
from trackweave.service.inputs.sockets import MOST_SENDERS, Feed
from trackweave.service.inputs.source import Source

__all__ = ["listen_ws"]

LARGEST = 1 << 20
"""Longest message [bytes]."""


def listen_ws(source: Source, make: Callable[[], Decoder], outbox: Outbox) -> None:
    """Take messages for ever; those of browsers' pages, which name an origin, are refused."""
    try:
        from websockets.exceptions import ConnectionClosed
        from websockets.sync.server import ServerConnection, serve
    except ImportError as err:
        raise InvalidInputError(
            "ws:// needs websockets; pip install 'trackweave[service]'"
        ) from err
    lock = threading.Lock()

    def take(connection: ServerConnection) -> None:
        with lock:
            if outbox.clients >= MOST_SENDERS:
                return
            outbox.clients += 1
            feed = Feed(make, outbox)
        try:
            for message in connection:
                data = message.encode() if isinstance(message, str) else message
                with lock:
                    feed.take(data if data.endswith(b"\n") else data + _ending(message))
        except ConnectionClosed:
            pass
        finally:
            with lock:
                feed.end()
                outbox.clients -= 1

    def flush() -> None:
        while True:
            time.sleep(SOON)
            with lock:
                outbox.flush()

    threading.Thread(target=flush, daemon=True).start()
    with serve(take, source.host, source.port, max_size=LARGEST, origins=[None]) as server:
        outbox.listens()
        server.serve_forever()


def _ending(message: Any) -> bytes:
    """Return what ends a message: one of text is a line at least."""
    return b"\n" if isinstance(message, str) else b""
