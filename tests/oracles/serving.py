"""A desk that remembers what is handed in, and a server of it on this machine."""

import asyncio
import socket
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import Any

import httpx
import numpy as np
import polars as pl
from websockets.sync.client import connect

from trackweave.domain.frames import LocalFrame
from trackweave.service.desk import Picture, Receipt, Rejected, Rows
from trackweave.service.fanout import Fanout, Listener
from trackweave.service.web.application import Application
from trackweave.service.web.files import Asset
from trackweave.service.web.server import WebServer
from trackweave.service.web.settings import Tls, WebSettings

# However busy the machine is.
get = partial(httpx.get, timeout=60)
post = partial(httpx.post, timeout=60)
listen = partial(connect, open_timeout=60)
FRAME = LocalFrame(48.0, 11.0)
PAGE = {
    "/": Asset(b"<!doctype html><title>map</title>", "text/html; charset=utf-8", '"1"'),
    "/large.bin": Asset(bytes(1 << 24), "application/octet-stream", '"3"'),
    "/main.js": Asset(b"export {}", "text/javascript; charset=utf-8", '"2"'),
}


def tracks_table(count: int, *, is_on_earth: bool = True, seed: int = 1) -> pl.DataFrame:
    """Return tracks as a tracks file has them, every third tentative."""
    rng = np.random.default_rng(seed)
    place = rng.uniform(-50_000, 50_000, (count, 2))
    velocity = rng.normal(0, 100, (count, 2))
    columns: dict[str, Any] = {
        "time": np.full(count, 1_700_000_000.25),
        "track": np.arange(1, count + 1),
        "status": [("confirmed", "coasting", "tentative")[k % 3] for k in range(count)],
        "x": place[:, 0],
        "y": place[:, 1],
    }
    if is_on_earth:
        latitude, longitude, _ = FRAME.to_geodetic(place)
        columns |= {"lat": latitude, "lon": longitude}
    columns |= {"vx": velocity[:, 0], "vy": velocity[:, 1]}
    columns |= {"p_x_x": np.full(count, 100.0), "p_x_y": np.zeros(count)}
    columns |= {"p_y_y": np.full(count, 400.0), "hits": np.full(count, 7)}
    return pl.DataFrame(columns).with_columns(
        time=pl.from_epoch((pl.col("time") * 1e6).cast(pl.Int64), "us").dt.replace_time_zone("UTC")
    )


class RememberingDesk:
    """Takes what has a finite x or latitude, and shows what it is given to show."""

    def __init__(self, count: int = 6, *, is_on_earth: bool = True) -> None:
        self.taken: list[Rows] = []
        self.sequence = 0
        self.fault: Exception | None = None
        self.status = "ok"
        self.is_listening = True
        self.names = ["radar"]
        frame = FRAME if is_on_earth else None
        table = tracks_table(count, is_on_earth=is_on_earth)
        self.shown = Picture(1_700_000_000.25, table, frame)
        self.fanout = Fanout(self.picture)

    async def accept(self, rows: Rows) -> Receipt:
        if self.fault is not None:
            raise self.fault
        await asyncio.sleep(0)
        name = "x" if "x" in rows.table.columns else "lat"
        numbers = rows.table[name].cast(pl.Float64, strict=False)
        wrong = (numbers.is_null() | numbers.is_nan()).to_numpy()
        self.taken.append(rows)
        self.sequence += 1
        refused = tuple(Rejected(int(row), f"{name}: no number") for row in rows.row[wrong])
        return Receipt(len(wrong) - len(refused), refused, self.sequence)

    def picture(self) -> Picture:
        return self.shown

    def track(self, identifier: str) -> dict[str, Any] | None:
        return {"track": "1", "trail": [[0.0, 1.0, 2.0]]} if identifier == "1" else None

    def sensors(self) -> list[dict[str, Any]]:
        return [
            {"name": n, "reports": 3, "reports_per_s": 1.5, "silent": False} for n in self.names
        ]

    def health(self) -> dict[str, Any]:
        return {
            "status": self.status, "sequence": self.sequence, "listening": self.is_listening,
        }  # fmt: skip

    def counters(self) -> dict[str, float]:
        return {"reports_total": 3.0, "lag_seconds": 0.25, "bad name": 1.0}

    def subscribe(self, *, reports: bool = False) -> Listener:
        return self.fanout.subscribe(reports=reports)


class Serving:
    """A server in a thread of its own, for as long as the block runs."""

    def __init__(
        self,
        desk: Any,
        settings: WebSettings | None = None,
        host: str = "127.0.0.1",
        tls: Tls | None = None,
    ) -> None:
        self.desk = desk
        self.application = Application(desk, settings or WebSettings(), PAGE)
        self.server = WebServer(self.application, host, 0, tls)
        self.loop = asyncio.new_event_loop()
        self.faults: list[dict[str, Any]] = []
        self.loop.set_exception_handler(lambda _, context: self.faults.append(context))
        self._thread = threading.Thread(target=self.loop.run_forever, daemon=True)
        self.port = 0

    def __enter__(self) -> "Serving":
        self._thread.start()
        self.port = self.run(self.server.start())
        return self

    def __exit__(self, *_: object) -> None:
        self.run(self.server.stop())
        self.loop.call_soon_threadsafe(self.loop.stop)
        self._thread.join()
        self.loop.close()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def run(self, work: Any) -> Any:
        """Return what a coroutine returns that the server's loop runs."""
        return asyncio.run_coroutine_threadsafe(work, self.loop).result(60)

    def call(self, function: Callable[..., Any], *given: Any) -> Any:
        """Return what a function returns that the server's loop calls."""
        done: Future[Any] = Future()

        def carry_out() -> None:
            try:
                done.set_result(function(*given))
            except BaseException as err:
                done.set_exception(err)

        self.loop.call_soon_threadsafe(carry_out)
        return done.result(60)

    def connect(self) -> socket.socket:
        """Return a bare connection."""
        return socket.create_connection(("127.0.0.1", self.port), timeout=60)

    def talk(self, data: bytes) -> bytes:
        """Return all that comes back until the server ends the connection."""
        with self.connect() as peer:
            peer.sendall(data)
            return read_all(peer)


def until(holds: Callable[[], object], seconds: float = 60.0) -> bool:
    """Wait for something to hold; how long it takes is nobody's business."""
    end = time.monotonic() + seconds
    while not holds() and time.monotonic() < end:
        time.sleep(0.05)
    return bool(holds())


def read_all(peer: socket.socket) -> bytes:
    """Return what comes until the other side ends."""
    pieces = []
    try:
        while piece := peer.recv(1 << 16):
            pieces.append(piece)
    except ConnectionError:
        pass
    return b"".join(pieces)
