"""uvicorn's protocols, made to bear whatever comes."""

import asyncio
import logging
from typing import Any, cast

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from trackweave.service.log import say
from trackweave.service.web.connections import Connections

__all__ = ["Config", "HttpProtocol", "StreamProtocol"]

_LOG = logging.getLogger("trackweave.service.web")


class Config(uvicorn.Config):
    """uvicorn's configuration, with who is connected."""

    connections: Connections


class HttpProtocol(H11Protocol):
    """HTTP/1.1, until a WebSocket takes over."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin."""
        super().connection_made(transport)
        connection = _connections(self).of(transport)
        if connection is not None:
            connection.is_waited_for = self._is_waited_for

    def data_received(self, data: bytes) -> None:
        """Take bytes; whatever is wrong with them ends this connection and nothing else."""
        try:
            super().data_received(data)
        except Exception as err:
            _give_up(self, err)

    def connection_lost(self, exc: Exception | None) -> None:
        """Be forgotten."""
        super().connection_lost(exc)
        _forget(self)

    def _is_waited_for(self) -> bool:
        return self.cycle is None or self.cycle.response_complete


class StreamProtocol(WebSocketsSansIOProtocol):
    """A WebSocket."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin."""
        super().connection_made(transport)
        connection = _connections(self).of(transport)
        if connection is not None:
            connection.is_waited_for = self._is_waited_for
            connection.has_asked = True

    def data_received(self, data: bytes) -> None:
        """Take bytes; whatever is wrong with them ends this connection and nothing else."""
        try:
            super().data_received(data)
        except Exception as err:
            _give_up(self, err)
        if not self.handshake_initiated:
            # What HTTP took for a whole head was none: it would wait for one for ever.
            self.transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        """Be forgotten."""
        super().connection_lost(exc)
        _forget(self)

    def pause_writing(self) -> None:
        """Read no more either: each ping that is read is answered, and answers would pile up."""
        super().pause_writing()
        self.transport.pause_reading()

    def resume_writing(self) -> None:
        """Go on."""
        super().resume_writing()
        if not self.read_paused:
            self.transport.resume_reading()

    def _is_waited_for(self) -> bool:
        return not self.handshake_complete


def _connections(protocol: Any) -> Connections:
    return cast("Config", protocol.config).connections


def _give_up(protocol: Any, err: Exception) -> None:
    say(_LOG, logging.WARNING, "connection given up", error=type(err).__name__)
    # One of a pair may have begun when it failed: both are forgotten.
    for each in tuple(protocol.connections):
        if each.transport is protocol.transport:
            protocol.connections.discard(each)
    protocol.connections.add(protocol)  # which its own end takes out again
    protocol.transport.abort()


def _forget(protocol: Any) -> None:
    connections = _connections(protocol)
    connection = connections.of(protocol.transport)
    if connection is not None:
        connections.left(connection)
