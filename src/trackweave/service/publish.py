"""Tracks out to others as they change: a datagram or a line for each, in any format written."""

import asyncio
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from urllib.parse import parse_qsl, urlsplit

import polars as pl

from trackweave.domain.frames import LocalFrame
from trackweave.errors import InvalidInputError
from trackweave.formats.format import Format, Output
from trackweave.formats.registry import format_named
from trackweave.service.board import Drawn

__all__ = ["Publisher", "Target", "target_of"]

EVERY = 1.0
"""Seconds between two sendings."""
MOST_WAITING = 1 << 20
"""Bytes that wait for a receiver who does not read; beyond, what is newer is dropped."""
NO_MESSAGES = frozenset({"ctc", "geff", "kitti", "mot"})
"""Formats of several files, or of frames and boxes, which tracks that change have none of."""
LARGEST = 60_000
"""Longest datagram [bytes]."""
LONGEST_PAUSE = 30.0


@dataclass(frozen=True, slots=True)
class Target:
    """Where tracks are sent, and how they are written."""

    url: str
    scheme: str
    host: str
    port: int
    format: Format


def target_of(url: str) -> Target:
    """Return what ``--publish`` names, such as ``udp://127.0.0.1:4242?format=cot``.

    Parameters
    ----------
    url
        What the user told.

    Returns
    -------
    Where to send, and how.

    Raises
    ------
    InvalidInputError
        If it names nothing that can be sent to.
    """
    parts = urlsplit(url)
    query = dict(parse_qsl(parts.query, keep_blank_values=True))
    try:
        host, port = parts.hostname, parts.port
    except ValueError:
        host = port = None
    if parts.scheme not in ("udp", "tcp") or not host or port is None or set(query) != {"format"}:
        raise InvalidInputError(
            f"--publish {url!r:.100}: expected udp://HOST:PORT?format=… or tcp://HOST:PORT?format=…"
        )
    form = format_named(query["format"], writes=True)
    if form.name in NO_MESSAGES:
        raise InvalidInputError(
            f"--publish {url!r:.100}: format {form.name} is of several files or of "
            "boxes; expected one of messages, such as asterix-062, cot, geojson, jsonl or readsb"
        )
    return Target(url, parts.scheme, host, port, form)


class Publisher:
    """Sends what changed, once a second.

    Parameters
    ----------
    target
        Where to and how.
    """

    def __init__(self, target: Target) -> None:
        self.target = target
        self.sent = self.dropped = 0
        self.message = ""
        self._drawn: Drawn | None = None
        self._parts: list[pl.DataFrame] = []

    def __call__(self, drawn: Drawn) -> None:
        """Take in what changed."""
        self._drawn = drawn
        self._parts.append(drawn.changed)

    async def run(self) -> None:
        """Send for ever."""
        way = self._datagrams if self.target.scheme == "udp" else self._connection
        await way()

    def _due(self) -> Iterator[bytes]:
        """Yield what is to be sent now."""
        drawn, parts = self._drawn, self._parts
        self._parts = []
        if drawn is None or not parts:
            return
        rows = pl.concat(parts, how="diagonal_relaxed")
        rows = rows.filter(pl.col("status") != "tentative")
        rows = rows.unique("track", keep="last", maintain_order=True)
        if rows.is_empty():
            return
        try:
            yield from self._written(rows, drawn.picture.frame)
        except InvalidInputError as err:
            self.message = str(err)

    def _written(self, rows: pl.DataFrame, frame: LocalFrame | None) -> Iterator[bytes]:
        """Yield tracks in pieces that can be sent."""
        writer = self.target.format.writer
        assert writer is not None
        # Whom reports tell of and how high is no column of a track, but says what kind it is.
        told = [name for name in ("identity", "height_m") if name in rows.columns]
        named = rows.select("track", *told) if told else None
        states = rows.drop(told)
        files = writer(Output(states, assignments=named, frame=frame)).values()
        pieces = [piece for data in files for piece in _cut(data, self.target.format)]
        if self.target.scheme == "tcp":
            # One document after another: each ends its line.
            is_text = not self.target.format.name.startswith("asterix")
            for piece in pieces:
                yield piece if not is_text or piece.endswith(b"\n") else piece + b"\n"
        elif rows.height > 1 and max(map(len, pieces), default=0) > LARGEST:
            # No datagram holds the document: several of fewer tracks each.
            half = rows.height // 2
            yield from self._written(rows[:half], frame)
            yield from self._written(rows[half:], frame)
        else:
            yield from pieces

    async def _datagrams(self) -> None:
        family = socket.AF_INET6 if ":" in self.target.host else socket.AF_INET
        with socket.socket(family, socket.SOCK_DGRAM) as sock:
            sock.setblocking(False)
            while True:
                await asyncio.sleep(EVERY)
                for data in self._due():
                    with suppress(OSError):  # nobody listens there
                        sock.sendto(data, (self.target.host, self.target.port))
                        self.sent += 1

    async def _connection(self) -> None:
        pause = 1.0
        while True:
            try:
                _, writer = await asyncio.open_connection(self.target.host, self.target.port)
            except OSError as err:
                self.message = str(err.strerror or err)
                await asyncio.sleep(pause)
                pause = min(2.0 * pause, LONGEST_PAUSE)
                continue
            pause, self.message = 1.0, ""
            try:
                with suppress(OSError):
                    await self._sent_to(writer)
            finally:
                writer.close()

    async def _sent_to(self, writer: asyncio.StreamWriter) -> None:
        while not writer.is_closing():
            begun = time.monotonic()
            for data in self._due():
                if writer.transport.get_write_buffer_size() > MOST_WAITING:
                    self.dropped += 1
                    continue
                writer.write(data)
                self.sent += 1
            await asyncio.sleep(max(0.0, EVERY - (time.monotonic() - begun)))


def _cut(data: bytes, form: Format) -> Iterator[bytes]:
    """Yield a file's content in pieces that each mean something."""
    cutter: Callable[[bytes], Iterator[bytes]] = _whole
    if form.name.startswith("asterix"):
        cutter = _blocks
    elif form.name in ("cot", "jsonl"):
        cutter = _lines
    yield from cutter(data)


def _whole(data: bytes) -> Iterator[bytes]:
    yield data


def _lines(data: bytes) -> Iterator[bytes]:
    yield from data.splitlines(keepends=True)


def _blocks(data: bytes) -> Iterator[bytes]:
    """Yield data blocks of ASTERIX, as many at once as go into a datagram."""
    begin = end = 0
    while end + 3 <= len(data):
        length = int.from_bytes(data[end + 1 : end + 3], "big")
        if length < 3:
            return
        if end + length - begin > LARGEST and end > begin:
            yield data[begin:end]
            begin = end
        end += length
    if end > begin:
        yield data[begin:end]
