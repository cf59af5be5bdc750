"""Datagrams and connections, each sender's bytes to a decoder of its own."""

import selectors
import socket
import time
from collections.abc import Callable
from contextlib import suppress

import polars as pl

from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.formats.format import Decoder
from trackweave.plugin_faults import told_as_theirs
from trackweave.service.inputs.outbox import SOON, Outbox
from trackweave.service.inputs.source import Source

__all__ = ["Feed", "listen_tcp", "listen_udp", "visit_tcp"]

CHUNK = 65_536
MOST_SENDERS = 64
"""So many decoders are kept; beyond, that of the sender who has been silent longest goes."""
LONGEST_PAUSE = 30.0
"""Longest wait before a connection is tried again [s]."""


class Feed:
    """One sender's bytes and their decoder.

    A document that is no such document as a whole is counted, and the next begins; so is what a
    plug-in's decoder fails at, which is told as its fault.
    """

    def __init__(self, make: Callable[[], Decoder], outbox: Outbox) -> None:
        self._make, self._outbox = make, outbox
        self._decoder = make()
        self._counted = 0
        self._marks: dict[str, float] = {}
        self._complaint = ""
        self.heard = time.monotonic()

    def take(self, data: bytes) -> None:
        """Decode further bytes."""
        self.heard = time.monotonic()
        if hasattr(self._decoder, "received"):
            # Times of the day are dated by when they come.
            self._decoder.received = time.time()
        self._hand_on(self._decoder.feed, data)

    def take_whole(self, data: bytes) -> None:
        """Decode a datagram: nothing of it is waited for, and nothing of it spoils the next."""
        self.take(data)
        cut = getattr(self._decoder, "cut", None)
        if cut is not None:
            self._hand_on(cut)

    def end(self) -> None:
        """Decode what is left."""
        self._hand_on(self._decoder.finish)

    def _hand_on(self, decode: Callable[..., pl.DataFrame | None], *data: bytes) -> None:
        """Hand on what the decoder makes of bytes; where it fails a new one takes what follows."""
        try:
            table = decode(*data)
        except DataFormatError as err:
            self._begin_anew(str(err))
            return
        except Exception:
            try:
                with told_as_theirs(self._decoder, "readers", decode.__name__):
                    raise
            except InvalidInputError as err:
                self._begin_anew(str(err))
            return
        self._outbox.skipped += self._decoder.skips.count - self._counted
        self._counted = self._decoder.skips.count
        self._outbox.add(table, self._decoder.facts)
        self._complain(getattr(self._decoder, "complaint", ""))
        marks = getattr(self._decoder, "marks", None)
        if marks and marks != self._marks:
            self._outbox.mark({n: t for n, t in marks.items() if self._marks.get(n) != t})
            self._marks = dict(marks)

    def _complain(self, complaint: str) -> None:
        """Say why a decoder can read nothing, and no more of it once it can."""
        if complaint:
            self._outbox.message = complaint[:300]
        elif self._complaint and self._outbox.message == self._complaint[:300]:
            self._outbox.message = ""
        self._complaint = complaint

    def _begin_anew(self, message: str) -> None:
        self._outbox.message = message[:300]
        self._outbox.skipped += 1
        self._decoder, self._counted = self._make(), 0


def listen_udp(source: Source, make: Callable[[], Decoder], outbox: Outbox) -> None:
    """Take datagrams for ever; each sender has a decoder of its own."""
    sock = _bound(source, socket.SOCK_DGRAM)
    with suppress(OSError):
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
    sock.settimeout(SOON)
    outbox.listens()
    feeds: dict[object, Feed] = {}
    while True:
        try:
            data, sender = sock.recvfrom(CHUNK)
        except TimeoutError:
            outbox.flush()
            continue
        except OSError:  # a sender's host says that nobody listens there
            continue
        if sender not in feeds:
            if len(feeds) >= MOST_SENDERS:
                del feeds[min(feeds, key=lambda each: feeds[each].heard)]
            feeds[sender] = Feed(make, outbox)
            outbox.clients = len(feeds)
        feeds[sender].take_whole(data)


def listen_tcp(source: Source, make: Callable[[], Decoder], outbox: Outbox) -> None:
    """Take connections for ever; each has a decoder of its own."""
    server = _bound(source, socket.SOCK_STREAM)
    server.listen(MOST_SENDERS)
    server.setblocking(False)
    outbox.listens()
    with selectors.DefaultSelector() as ready:
        ready.register(server, selectors.EVENT_READ, None)
        while True:
            events = ready.select(SOON)
            for key, _ in events:
                if key.data is None:
                    _admit(server, ready, Feed(make, outbox))
                else:
                    _read(key, ready)
            outbox.clients = len(ready.get_map()) - 1
            outbox.flush(at_once=not events)


def visit_tcp(source: Source, make: Callable[[], Decoder], outbox: Outbox) -> None:
    """Fetch from a sender for ever; one that goes away is tried again, ever more rarely."""
    pause = 1.0
    while True:
        try:
            with socket.create_connection((source.host, source.port), timeout=10.0) as sock:
                outbox.clients, outbox.message, pause = 1, "", 1.0
                sock.settimeout(SOON)
                _drain(sock, Feed(make, outbox), outbox)
        except OSError as err:
            outbox.message = f"{source.host}:{source.port}: {err.strerror or err}"
        outbox.clients = 0
        outbox.flush()
        time.sleep(pause)
        pause = min(2.0 * pause, LONGEST_PAUSE)


def _drain(sock: socket.socket, feed: Feed, outbox: Outbox) -> None:
    while True:
        try:
            data = sock.recv(CHUNK)
        except TimeoutError:
            outbox.flush()
            continue
        if not data:
            feed.end()
            return
        feed.take(data)


def _admit(server: socket.socket, ready: selectors.BaseSelector, feed: Feed) -> None:
    try:
        sock, _ = server.accept()
    except OSError:
        return
    if len(ready.get_map()) > MOST_SENDERS:
        sock.close()
        return
    sock.setblocking(False)
    ready.register(sock, selectors.EVENT_READ, feed)


def _read(key: selectors.SelectorKey, ready: selectors.BaseSelector) -> None:
    sock: socket.socket = key.fileobj  # type: ignore[assignment]
    try:
        data = sock.recv(CHUNK)
    except BlockingIOError:
        return
    except OSError:
        data = b""
    if data:
        key.data.take(data)
        return
    key.data.end()
    ready.unregister(sock)
    sock.close()


def _bound(source: Source, kind: socket.SocketKind) -> socket.socket:
    family = socket.AF_INET6 if ":" in source.host else socket.AF_INET
    sock = socket.socket(family, kind)
    if kind is socket.SOCK_STREAM:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    sock.bind((source.host, source.port))
    return sock
