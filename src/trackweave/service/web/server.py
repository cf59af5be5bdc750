"""Lets an application be reached: sockets, TLS, and an end within a time."""

import asyncio
import logging
import socket
import ssl
from contextlib import suppress
from functools import partial
from typing import Any

from uvicorn.server import ServerState

from trackweave.errors import InvalidInputError, OutputError
from trackweave.service.addresses import checked_listening, shown_address
from trackweave.service.log import say
from trackweave.service.web.application import Application
from trackweave.service.web.connections import Connection, Connections
from trackweave.service.web.protocols import Config, HttpProtocol, StreamProtocol
from trackweave.service.web.settings import Tls

__all__ = ["WebServer", "tls_context"]

_LOG = logging.getLogger("trackweave.service.web")
_SWEEP_S = 0.5
_HEAD_BYTES = 16_384
_MESSAGE_BYTES = 4096
"""What a listener may say at most; it has nothing to say."""
_PING_S = 20.0
_KEEP_ALIVE_S = 5


class WebServer:
    """Listens at one address.

    Its accepting is its own, uvicorn's protocols speak: who is connected is counted before TLS
    begins, and signals are left to the service.

    Parameters
    ----------
    application
        What answers.
    host, port
        Where to listen; port 0 for any that is free.
    tls
        What to encrypt with, None for nothing.

    Raises
    ------
    InvalidInputError
        If other machines could reach it without token and TLS, or the files are no certificate.
    """

    def __init__(
        self, application: Application, host: str, port: int, tls: Tls | None = None
    ) -> None:
        tokens = application.settings.tokens
        checked_listening(host, has_token=tokens is not None, has_tls=tls is not None)
        if tokens is not None and tokens.has_short:
            # What is guessed from afar must be long.
            checked_listening(host, has_token=False, has_tls=tls is not None)
        self._context = None if tls is None else tls_context(tls)
        self._application, self._host, self._port = application, host, port
        self._connections = Connections(application.settings.limits, application.tally)
        self._state = ServerState()
        self._config = _config(application)
        self._config.connections = self._connections
        self._listening: list[socket.socket] = []
        self._tasks: set[asyncio.Task[Any]] = set()

    @property
    def url(self) -> str:
        """Where the page is."""
        scheme = "http" if self._context is None else "https"
        return f"{scheme}://{shown_address(self._host, self._port)}/"

    async def start(self) -> int:
        """Listen.

        Returns
        -------
        The port.

        Raises
        ------
        OutputError
            If the address cannot be had.
        """
        self._config.load()
        # What comes from outside must not fill the log.
        logging.getLogger("uvicorn.error").setLevel(logging.ERROR)
        self._listening = await _sockets(self._host, self._port)
        self._port = int(self._listening[0].getsockname()[1])
        for each in self._listening:
            self._go(self._accept(each))
        self._go(self._sweep())
        self._go(self._application.start())
        return self._port

    async def stop(self, grace_s: float = 1.0) -> None:
        """Listen no more, and end what is open within a time.

        Parameters
        ----------
        grace_s
            How long requests that are being answered may take [s].
        """
        for task in tuple(self._tasks):
            task.cancel()
        for each in self._listening:
            each.close()
        for protocol in tuple(self._state.connections):
            with suppress(Exception):  # whatever state it is in, it is aborted below
                protocol.shutdown()
        with suppress(TimeoutError):
            async with asyncio.timeout(grace_s):
                while len(self._connections):
                    await asyncio.sleep(0.01)
        self._connections.abort_all()
        await asyncio.sleep(0.01)  # they learn of it
        for task in tuple(self._state.tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, *self._state.tasks, return_exceptions=True)
        self._application.close()

    def _go(self, work: Any) -> "asyncio.Task[Any]":
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    async def _accept(self, listening: socket.socket) -> None:
        loop = asyncio.get_running_loop()
        while True:
            try:
                peer, _ = await loop.sock_accept(listening)
            except OSError as err:  # no file descriptors left, or gone already
                say(_LOG, logging.WARNING, "not accepted", error=str(err))
                await asyncio.sleep(0.1)
                continue
            connection = self._connections.admit(peer)
            if connection is None:
                peer.close()
            else:
                connection.task = self._go(self._greet(peer, connection))
                connection.task.add_done_callback(partial(self._greeted, peer, connection))

    async def _greet(self, peer: socket.socket, connection: Connection) -> None:
        """Give a connection its protocol, after TLS where there is any."""
        limits = self._application.settings.limits
        handshake = None if self._context is None else limits.head_s
        with suppress(OSError):
            peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        with suppress(OSError, TimeoutError):
            await asyncio.get_running_loop().connect_accepted_socket(
                lambda: _Greeter(self, connection),
                peer,
                ssl=self._context,
                ssl_handshake_timeout=handshake,
            )

    def _greeted(
        self, peer: socket.socket, connection: Connection, _: "asyncio.Task[Any]"
    ) -> None:
        """Forget a connection that was given up, perhaps before its greeting began."""
        if connection.transport is None:
            peer.close()
            self._connections.left(connection)
            self._application.tally.add("connections_cut_total", reason="greeting")

    async def _sweep(self) -> None:
        while True:
            await asyncio.sleep(_SWEEP_S)
            self._connections.sweep()

    def made(self, connection: Connection, transport: asyncio.Transport) -> None:
        """Hand a connection that is ready to the protocol that answers it."""
        self._connections.entered(connection, transport)
        protocol = HttpProtocol(config=self._config, server_state=self._state, app_state={})
        protocol.connection_made(transport)
        transport.set_protocol(protocol)


class _Greeter(asyncio.Protocol):
    """Stands in until there is a transport, of which the protocol's own can then be found."""

    def __init__(self, server: WebServer, connection: Connection) -> None:
        self._server, self._connection = server, connection

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._server.made(self._connection, transport)


def tls_context(tls: Tls) -> ssl.SSLContext:
    """Return what encrypts connections, TLS 1.2 or later.

    Parameters
    ----------
    tls
        Certificate and key.

    Returns
    -------
    The context.

    Raises
    ------
    InvalidInputError
        If the files cannot be read or do not go together.
    """
    for option, path in (("--certificate", tls.certificate), ("--key", tls.key)):
        if not path.is_file():
            raise InvalidInputError(f"{option}: {path}: no such file; expected one in PEM")
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        # Nobody is there to be asked for a password.
        context.load_cert_chain(tls.certificate, tls.key, password=lambda: b"")
    except (ssl.SSLError, OSError, ValueError) as err:
        said = getattr(err, "reason", None) or getattr(err, "strerror", None) or err
        raise InvalidInputError(
            f"{tls.certificate}, {tls.key}: {said}; expected a certificate and its key in PEM, "
            "without a password"
        ) from err
    return context


def _config(application: Application) -> Config:
    limits = application.settings.limits
    return Config(
        application,
        http=HttpProtocol,
        ws=StreamProtocol,
        lifespan="off",
        interface="asgi3",
        log_config=None,
        access_log=False,
        proxy_headers=False,
        server_header=False,
        date_header=False,
        timeout_keep_alive=_KEEP_ALIVE_S,
        h11_max_incomplete_event_size=_HEAD_BYTES,
        ws_max_size=_MESSAGE_BYTES,
        ws_per_message_deflate=False,
        ws_ping_interval=_PING_S,
        ws_ping_timeout=limits.stall_s,
    )


async def _sockets(host: str, port: int) -> list[socket.socket]:
    """Return sockets that listen at all addresses of a name."""
    loop = asyncio.get_running_loop()
    where = shown_address(host, port)
    try:
        found = await loop.getaddrinfo(
            host or None, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )
    except (OSError, UnicodeError) as err:
        raise OutputError(f"{where}: no such address; expected one of this machine") from err
    listening: list[socket.socket] = []
    try:
        for family, kind, protocol, _, address in dict.fromkeys(found):
            each = socket.socket(family, kind, protocol)
            listening.append(each)
            each.setblocking(False)
            each.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            if family == socket.AF_INET6:
                each.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
            # Where any port will do, all addresses of a name get the same.
            taken = listening[0].getsockname()[1] if port == 0 and len(listening) > 1 else port
            each.bind((address[0], taken, *address[2:]))
            each.listen(1024)
    except OSError as err:
        for each in listening:
            each.close()
        raise OutputError(f"{where}: {err.strerror or err}; expected one that is free") from err
    return listening
