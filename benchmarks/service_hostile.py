"""Hostile messages over the live service's routes and stream: no crash, no entry, bounded memory.

    python benchmarks/service_hostile.py --messages 1000000 --connections 10000

A service with a token runs in a process of its own, with its rate limits out of the way, so that
what comes reaches whatever it is meant for. Told are what was answered, what got in (nothing may),
the service's memory and CPU, and whether it still answers.
"""

import argparse
import asyncio
import json
import multiprocessing
import os
import resource
import struct
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

TOKEN = "benchmark token, long enough"
ROUTES = ("/", "/tracks", "/tracks/1", "/sensors", "/healthz", "/metrics", "/stream", "/page.json")
AT_ONCE = 40
REPORTS = b"".join(b'{"time": %d, "sensor": "a", "x": %d, "y": 3.5}\n' % (k, k) for k in range(9))
BODIES = (
    (b"jsonl", REPORTS),
    (b"csv", b"time,sensor,x,y\n1,a,2,3\n2,a,3,4\n3,b,4,5\n"),
    (b"asterix", bytes.fromhex("30002ff7021901c9352440a8a80c2d28ff4e0df7a00c1ac4cf380f27aa4060be"
                               "0e5200bb00004020f50a0ba0b4f09b0b00")),
    (b"ais", b"!AIVDM,1,1,,B,15MwkT1P37G?fl0EJbR0OwT0@MS8,0*4E\n" * 3),
    (b"sbs", b"MSG,3,1,1,4CA2D6,1,2023/01/01,00:00:01.0,,,,37000,,,51.4,-1.1,,,,,,\n"),
)  # fmt: skip
END = b"\r\n0\r\n\r\n"
HELLO = (
    b"GET /stream HTTP/1.1\r\nhost: localhost\r\nupgrade: websocket\r\nconnection: Upgrade\r\n"
    b"sec-websocket-version: 13\r\nsec-websocket-key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
)
ALLOWED = b"authorization: Bearer " + TOKEN.encode() + b"\r\n"
FALSE = (
    b"", b"authorization: Bearer x\r\n", b"authorization: Basic YTpi\r\n",
    b"cookie: trackweave=x\r\n", b"authorization: Bearer \r\n",
    b"authorization: bearer " + b"A" * 3000 + b"\r\n",
    b"cookie: " + b"trackweave=;" * 200 + b"\r\n", b"x-forwarded-for: 127.0.0.1\r\n",
)  # fmt: skip
TRAVERSALS = (
    b"/../../etc/passwd", b"/%2e%2e/%2e%2e/etc/passwd", b"/..%2f..%2fetc/passwd", b"//etc/passwd",
    b"/tracks/..%5c..%5cx", b"/%00", b"/%ff%fe", b"/tracks?format=../../x", b"*",
    b"/" + b"a" * 9000, b"http://evil.example/tracks", b"/tracks/%0d%0aset-cookie:a=b",
)  # fmt: skip


class Desk:
    """Takes what is handed in, and counts."""

    def __init__(self) -> None:
        from trackweave.service.desk import Picture
        from trackweave.service.fanout import Fanout

        self.taken = 0
        numbers = {name: [1.0] for name in ("time", "x", "y", "vx", "vy", "lat", "lon")}
        self._picture = Picture(
            1.0, pl.DataFrame({"track": [1], "status": ["confirmed"], **numbers})
        )
        self.subscribe = Fanout(self.picture).subscribe

    async def accept(self, rows: Any) -> Any:
        """Take reports."""
        from trackweave.service.desk import Receipt

        self.taken += len(rows.table)
        return Receipt(len(rows.table), (), self.taken)

    def picture(self) -> Any:
        """Return one track."""
        return self._picture

    def track(self, identifier: str) -> dict[str, Any] | None:
        """Return it."""
        return {"track": "1"} if identifier == "1" else None

    def sensors(self) -> list[dict[str, Any]]:
        """Return one."""
        return [{"name": "a", "reports": self.taken}]

    def health(self) -> dict[str, Any]:
        """Say that all is well."""
        return {"status": "ok", "sequence": self.taken}

    def counters(self) -> dict[str, float]:
        """Return how many reports were taken."""
        return {"taken_total": float(self.taken)}


def serve(pipe: Any, folder: str) -> None:
    """Serve until told to end; what is sent back are the port and, in the end, the CPU time."""

    async def run() -> None:
        from trackweave.service.web.application import Application
        from trackweave.service.web.server import WebServer
        from trackweave.service.web.settings import Limits, WebSettings
        from trackweave.service.web.tokens import line_of, read_tokens

        file = Path(folder, "tokens")
        file.write_text(line_of(TOKEN))
        limits = Limits(requests_per_s=1e6, failures_per_min=1e6, head_s=3.0, body_s=2.0)
        settings = WebSettings(tokens=read_tokens(file), limits=limits)
        server = WebServer(Application(Desk(), settings, {}), "127.0.0.1", 0)
        pipe.send(await server.start())
        while not pipe.poll():
            await asyncio.sleep(0.05)
        await server.stop()
        await asyncio.sleep(1.0)  # what decoded has ended
        own, others = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, -1))
        pipe.send((own.ru_utime + own.ru_stime, others.ru_utime + others.ru_stime))

    import logging

    logging.disable(logging.CRITICAL)
    asyncio.run(run())


@contextmanager
def serving() -> Iterator[tuple[int, int, Any]]:
    """Yield a service's port, its process, and what ends it and returns its CPU times."""
    ours, theirs = multiprocessing.get_context("spawn").Pipe()
    with tempfile.TemporaryDirectory() as folder:
        process = multiprocessing.get_context("spawn").Process(target=serve, args=(theirs, folder))
        process.start()
        port = ours.recv()

        def end() -> Any:
            ours.send(None)
            return ours.recv()

        try:
            yield port, process.pid or 0, end
        finally:
            process.join(30)
            if process.is_alive():
                process.kill()


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """Return bytes with some flipped, left out, doubled, put in or cut off."""
    found = bytearray(data)
    for _ in range(int(rng.integers(1, 6))):
        place = int(rng.integers(0, len(found) + 1))
        end = min(len(found), place + int(rng.integers(1, 20)))
        what = rng.integers(0, 5)
        if what == 0 and place < len(found):
            found[place] ^= 1 << int(rng.integers(0, 8))
        elif what == 1:
            del found[place:end]
        elif what == 2:
            found[place:place] = found[place:end] * int(rng.integers(1, 40))
        elif what == 3:
            found[place:place] = rng.integers(0, 256, int(rng.integers(1, 9)), np.uint8).tobytes()
        elif rng.random() < 0.2:
            del found[place:]
    return bytes(found)


def request(rng: np.random.Generator) -> tuple[str, bytes, bool]:
    """Return a hostile request: its kind, its bytes, and whether it shows the right token."""
    kind = ("mutated", "false token", "path", "body", "mutated body")[rng.integers(0, 5)]
    route = ROUTES[rng.integers(0, len(ROUTES))].encode()
    name, body = BODIES[rng.integers(0, len(BODIES))]
    head = b"host: localhost\r\nconnection: close\r\n"
    false = FALSE[rng.integers(0, len(FALSE))]
    post = b"POST /reports?format=" + name + b" HTTP/1.1\r\n"
    if kind == "mutated":
        whole = (b"GET " + route, post, HELLO)[rng.integers(0, 3)]
        whole = whole if whole is HELLO else whole + b" HTTP/1.1\r\n" + head
        return kind, mutated(whole + false + b"content-length: 5\r\n\r\nabcde", rng), False
    if kind == "false token":
        method = (b"GET", b"POST", b"PUT", b"HEAD", b"OPTIONS", b"TRACE")[rng.integers(0, 6)]
        return kind, method + b" " + route + b" HTTP/1.1\r\n" + head + false + b"\r\n", False
    if kind == "path":
        path = TRAVERSALS[rng.integers(0, len(TRAVERSALS))]
        return kind, b"GET " + path + b" HTTP/1.1\r\n" + head + false + b"\r\n", False
    body = mutated(body, rng)
    if kind == "mutated body":
        length = b"content-length: %d\r\n\r\n" % len(body)
        return kind, post + head + ALLOWED + length + body, True
    chunks = (
        b"transfer-encoding: chunked\r\n\r\n" + b"%x\r\n" % len(body) + body + b"\r\n0\r\n\r\n"
    )
    return kind, post + head + false + mutated(chunks, rng), False


def frames(rng: np.random.Generator) -> bytes:
    """Return one hostile WebSocket frame, mutated or of random parts."""
    size = int(rng.choice([0, 1, 5, 125, 126, 300, 5000]))
    opcode, flags = int(rng.integers(0, 16)), int(rng.choice([0x80, 0, 0xC0, 0x90]))
    length = size if size < 126 else 126
    said = struct.pack("!BB", flags | opcode, 0x80 | length) + (
        struct.pack("!H", size) if length == 126 else b""
    )
    whole = said + bytes(4) + rng.integers(0, 256, size, np.uint8).tobytes()
    return mutated(whole, rng) if rng.random() < 0.5 else whole


async def exchange(port: int, data: bytes, *, ends: bool) -> bytes:
    """Return the beginning of what comes back, empty where the connection just ends."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    try:
        writer.write(data)
        if ends:  # in place of waiting until the service gives up on the rest
            writer.write_eof()
        return await asyncio.wait_for(reader.read(4096), 60)
    except (ConnectionError, TimeoutError) as err:
        return b"" if isinstance(err, ConnectionError) else b"TIMEOUT "
    finally:
        writer.transport.abort()


async def attack(port: int, count: int, seed: int) -> Counter[str]:
    """Send hostile messages; count answers by kind and status, and what got in."""
    rng = np.random.default_rng(seed)
    found: Counter[str] = Counter()
    left = count

    async def work() -> None:
        nonlocal left
        while left > 0:
            if rng.random() < 0.05:
                burst = min(left, 20)
                left -= burst
                sent = HELLO + ALLOWED + b"\r\n" + b"".join(frames(rng) for _ in range(burst))
                await exchange(port, sent, ends=True)
                found["frame"] += burst
                continue
            left -= 1
            kind, data, is_allowed = request(rng)
            answer = await exchange(port, data, ends=kind in ("mutated", "body"))
            status = answer.partition(b" ")[2][:3].decode("latin-1")
            found[f"{kind}: {status or 'ended'}"] += 1
            if not is_allowed and status[:1] == "2":
                found["ENTRIES"] += 1

    await asyncio.gather(*(work() for _ in range(AT_ONCE)))
    return found


async def hold(port: int, count: int) -> int:
    """Open connections that say half a head; return how many the service still holds after all."""
    opened = []
    for _ in range(count):
        try:
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
        except OSError:
            break
        writer.write(b"GET /healthz HTTP/1.1\r\nx: ")
        opened.append((reader, writer))
        if len(opened) >= 600:  # more of the oldest than the service keeps, so that ours suffice
            opened.pop(0)[1].transport.abort()
    alive = await healthy(port)
    for _, writer in opened:
        writer.transport.abort()
    return int(alive["connections"])


async def healthy(port: int) -> dict[str, float]:
    """Return how the service is, as told through its own door."""
    begin = time.perf_counter()
    data = b"GET /metrics HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n" + ALLOWED + b"\r\n"
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(data)
    text = (await asyncio.wait_for(reader.read(-1), 60)).decode()
    writer.transport.abort()
    assert text.startswith("HTTP/1.1 200"), text[:200]
    lines = dict(line.rsplit(" ", 1) for line in text.partition("\r\n\r\n")[2].splitlines())
    return {
        "connections": float(lines["trackweave_connections"]),
        "taken": float(lines["trackweave_taken_total"]),
        "answers_s": time.perf_counter() - begin,
    }


def memory_mb(process: int) -> float:
    """Return what a process holds of memory [MB]."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def measure(messages: int, connections: int, seed: int = 1) -> dict[str, Any]:
    """Return what became of a service under so many messages and connections."""
    with serving() as (port, process, end):
        asyncio.run(attack(port, min(messages, 500), seed + 1))  # all is imported and warm
        before = memory_mb(process)
        halves = [asyncio.run(attack(port, messages // 2, seed + k)) for k in (2, 3)][:2]
        between = memory_mb(process)
        held = asyncio.run(hold(port, connections)) if connections else 0
        after = memory_mb(process)
        state = asyncio.run(healthy(port))
        cpu, decoding_cpu = end()
    answers = sum(halves, Counter())
    return {
        "messages": sum(answers.values()) - answers["ENTRIES"],
        "entries": answers["ENTRIES"],
        "without an answer in 60 s": sum(n for k, n in answers.items() if "TIM" in k),
        "connections held of those opened": [held, connections],
        "memory_mb": [round(before, 1), round(between, 1), round(after, 1)],
        "cpu_s": [round(cpu, 1), round(decoding_cpu, 1)],
        "reports taken with the right token": int(state["taken"]),
        "answers": dict(sorted(answers.items())),
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=1_000_000)
    parser.add_argument("--connections", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    told = parser.parse_args()
    print(json.dumps(measure(told.messages, told.connections, told.seed), indent=1))
