"""Bodies are decoded in a process of their own: what harms it harms nothing else.

A body of a few kilobytes can claim to hold gigabytes (Parquet), and whatever decodes it holds the
interpreter. So the process has little room, and a time for each body; where either is spent it
is ended and another begins.
"""

import asyncio
import multiprocessing
import signal
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from io import BytesIO
from multiprocessing.connection import Connection
from typing import Any

import polars as pl

from trackweave.errors import InvalidInputError
from trackweave.service.web.bodies import Decoded

__all__ = ["DecodingProcess"]

_ROOM = 2 << 30
"""What decoding may take [bytes] beyond what the process takes before it begins."""


class DecodingProcess:
    """Decodes one body after the other in another process.

    Parameters
    ----------
    seconds
        How long a body may take.
    room
        What decoding may take of memory [bytes].
    """

    def __init__(self, seconds: float = 30.0, room: int = _ROOM) -> None:
        self._seconds, self._room = seconds, room
        self._process: Any = None
        self._pipe: Any = None
        self._is_closed = False
        self._starting = threading.Lock()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="trackweave-decoding")

    async def start(self) -> None:
        """Begin the process ahead of the first body, which then need not wait for it."""
        with suppress(EOFError, OSError):  # as where it is closed meanwhile
            await asyncio.get_running_loop().run_in_executor(self._thread, self._begin)

    async def decode(self, data: bytes, told: str | None) -> Decoded:
        """Return the reports of a body; see ``bodies.decoded``.

        Parameters
        ----------
        data
            The body.
        told
            Its format; None to find it by the content.

        Returns
        -------
        Reports, and what could not be decoded.

        Raises
        ------
        InvalidInputError
            If it cannot be decoded, or not within the time and room that there are.
        """
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._thread, self._decode, data, told)

    def close(self) -> None:
        """End the process, whatever it does; a second call does nothing."""
        if self._is_closed:
            return
        self._is_closed = True
        with self._starting:
            if self._process is not None:
                self._process.kill()
        # Only the thread that uses the pipe closes it.
        self._thread.submit(self._end)
        self._thread.shutdown(wait=False)

    def _decode(self, data: bytes, told: str | None) -> Decoded:
        try:
            self._begin()
            # Where it is killed the pipe breaks, whichever way it is used just then.
            watch = threading.Timer(self._seconds, self._process.kill)
            watch.start()
            try:
                self._pipe.send((data, told))
                is_right, found = self._pipe.recv()
            finally:
                watch.cancel()
        except (EOFError, OSError):
            self._end()
            raise InvalidInputError(
                f"body: takes more than {self._seconds:g} s or {self._room >> 20} MiB to decode; "
                "expected less at a time"
            ) from None
        if not is_right:
            raise InvalidInputError(found)
        table, *rest = found
        return Decoded(pl.read_ipc(BytesIO(table)), *rest)

    def _begin(self) -> None:
        if self._pipe is not None and self._process.is_alive():
            return
        self._end()
        # Not a fork: it would hold the service's sockets and files.
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        with self._starting:
            if self._is_closed:
                raise EOFError
            self._process = context.Process(
                target=_work, args=(theirs, self._room), name="trackweave-decoding", daemon=True
            )
            self._process.start()
        theirs.close()
        self._pipe.recv()  # that it has begun

    def _end(self) -> None:
        process, self._process = self._process, None
        pipe, self._pipe = self._pipe, None
        if process is not None:
            process.kill()
            process.join()
        if pipe is not None:
            with suppress(OSError):
                pipe.close()


def _work(pipe: Connection, room: int) -> None:
    """Decode what comes until nobody sends any more, or takes the answers."""
    # A terminal's Ctrl-C goes to all of its processes; the service says when to end.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    from trackweave.service.web.bodies import decoded

    decoded(b'{"time": 0, "x": 0, "y": 0}', None)
    _confine(room)
    with suppress(EOFError, OSError):  # a service that was killed; its child has nobody to tell
        pipe.send(True)
        while True:
            pipe.send(_answer(*pipe.recv()))


def _answer(data: bytes, told: str | None) -> tuple[bool, Any]:
    from trackweave.service.web.bodies import decoded

    try:
        found = decoded(data, told)
        table = BytesIO()
        found.table.write_ipc(table)
    except MemoryError:
        return False, "body: takes too much memory to decode; expected less at a time"
    except InvalidInputError as err:
        return False, str(err)
    except BaseException as err:  # a panic of polars; somebody else's reader may fail in any way
        return False, f"body: cannot be decoded ({type(err).__name__})"
    rest = (found.row, found.facts, found.rejected, found.rejected_count)
    return True, (table.getvalue(), *rest)


def _confine(room: int) -> None:
    """Let the process take no more memory than it has and some more, where systems can do that."""
    try:
        import resource
        from pathlib import Path

        pages = int(Path("/proc/self/statm").read_text().split()[0])
        most = pages * resource.getpagesize() + room
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
    except (ImportError, OSError, ValueError):
        return
