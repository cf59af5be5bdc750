"""Who is connected: not too many, and none for long who asks nothing or does not read."""

import asyncio
import socket
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from trackweave.service.addresses import is_loopback
from trackweave.service.web.settings import Limits
from trackweave.service.web.tally import Tally

__all__ = ["Connection", "Connections"]

_LAST_BYTES_S = 3.0
"""How long a connection that is to end may take over it."""


@dataclass(eq=False, slots=True)
class Connection:
    """One that is open.

    Parameters
    ----------
    address
        Whose.
    task
        What greets it, until it has a transport.
    transport
        What it writes to.
    is_waited_for
        Tells whether it is its turn: no request of it is being answered.
    has_asked
        Whether a whole head of a request has ever come.
    since
        When each of its states began.
    """

    address: str
    task: "asyncio.Task[Any] | None" = None
    transport: asyncio.Transport | None = None
    is_waited_for: Callable[[], bool] = bool
    has_asked: bool = False
    since: dict[str, float] = field(default_factory=dict)

    def abort(self) -> None:
        """End it at once; what was still to be sent is lost."""
        if self.transport is not None:
            self.transport.abort()
        elif self.task is not None:
            self.task.cancel()

    def lasts(self, state: str, *, holds: bool, now: float) -> float:
        """Return for how long a state has held [s]."""
        if not holds:
            self.since.pop(state, None)
            return 0.0
        return now - self.since.setdefault(state, now)


class Connections:
    """All that are open.

    Parameters
    ----------
    limits
        How many there may be, and how slow.
    tally
        Where to count.
    clock
        Returns seconds that never go back.
    """

    def __init__(
        self, limits: Limits, tally: Tally, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._limits, self._tally, self._clock = limits, tally, clock
        self._open: dict[Connection, None] = {}  # in the order in which they came
        self._of_address: Counter[str] = Counter()
        self._of_transport: dict[asyncio.BaseTransport, Connection] = {}
        tally.measured["connections"] = lambda: float(len(self._open))

    def __len__(self) -> int:
        """Return how many are open."""
        return len(self._open)

    def admit(self, peer: socket.socket) -> Connection | None:
        """Return a new connection, None where there are too many.

        Where all places are taken, one goes to whoever comes from whoever has waited longest
        without having asked anything.

        Parameters
        ----------
        peer
            Its socket.

        Returns
        -------
        The connection.
        """
        try:
            address = str(peer.getpeername()[0])
        except (OSError, IndexError, TypeError):
            return None  # gone already
        if self._of_address[address] >= self._limits.per_address and not is_loopback(address):
            self._tally.add("connections_refused_total", reason="address")
            return None
        if len(self._open) >= self._limits.connections and not self._make_room():
            self._tally.add("connections_refused_total", reason="all")
            return None
        connection = Connection(address)
        self._open[connection] = None
        self._of_address[address] += 1
        return connection

    def entered(self, connection: Connection, transport: asyncio.Transport) -> None:
        """Note what a connection writes to."""
        connection.transport = transport
        self._of_transport[transport] = connection

    def of(self, transport: asyncio.BaseTransport) -> Connection | None:
        """Return the connection that writes to a transport."""
        return self._of_transport.get(transport)

    def left(self, connection: Connection) -> None:
        """Forget a connection."""
        if connection.transport is not None:
            self._of_transport.pop(connection.transport, None)
        if connection not in self._open:
            return
        del self._open[connection]
        self._of_address[connection.address] -= 1
        if not self._of_address[connection.address]:
            del self._of_address[connection.address]

    def sweep(self) -> None:
        """End those that are too slow; called about twice a second."""
        now = self._clock()
        for connection in tuple(self._open):
            reason = self._fault(connection, now)
            if reason is not None:
                self._tally.add("connections_cut_total", reason=reason)
                connection.abort()

    def abort_all(self) -> None:
        """End all at once."""
        for connection in tuple(self._open):
            connection.abort()

    def _fault(self, connection: Connection, now: float) -> str | None:
        transport, limits = connection.transport, self._limits
        if transport is None:  # greeted, which has its own time
            return None
        unread = transport.get_write_buffer_size() > 0
        is_ending = transport.is_closing()
        is_waited_for = not is_ending and connection.is_waited_for()
        connection.has_asked = connection.has_asked or not (is_ending or is_waited_for)
        # As long as it has something to read it is not its turn to ask.
        is_late, is_over = is_waited_for and not unread, is_ending and not unread
        if connection.lasts("ending", holds=is_over, now=now) > _LAST_BYTES_S:
            return "ending"
        if connection.lasts("waited for", holds=is_late, now=now) > limits.head_s:
            return "head"
        # Whoever reads has read all there is from time to time.
        if connection.lasts("unread", holds=unread, now=now) > limits.stall_s:
            return "stalled"
        return None

    def _make_room(self) -> bool:
        for connection in self._open:
            if connection.transport is None or (
                not connection.has_asked and connection.is_waited_for()
            ):
                self._tally.add("connections_cut_total", reason="displaced")
                connection.abort()
                self.left(connection)
                return True
        return False
