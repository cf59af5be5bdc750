"""Whoever is slow, many or long has bounded room and time; everybody else is served meanwhile."""

import json
import logging
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack

import pytest

from oracles.serving import RememberingDesk, Serving, get, post, read_all, until
from trackweave.service.log import LogLine
from trackweave.service.web.connections import Connections
from trackweave.service.web.settings import Limits, WebSettings
from trackweave.service.web.tally import Tally

BODY = 1 << 16
HEAD = b"POST /reports HTTP/1.1\r\nhost: localhost\r\n"
REFUSED = [b"%d" % status for status in (400, 414, 421, 431, 501, 505)]
LIMITS = Limits(
    head_s=1.0, body_s=1.0, stall_s=1.5, connections=20, body_bytes=BODY, bodies_bytes=4 * BODY
)


@pytest.fixture
def serving() -> Iterator[Serving]:
    with Serving(RememberingDesk(), WebSettings(limits=LIMITS)) as running:
        yield running
        assert running.faults == []


def busy(serving: Serving) -> int:
    """Return how many connections wait for an answer."""
    found = serving.call(lambda: list(serving.server._connections._open))
    return sum(each.transport is not None and not each.is_waited_for() for each in found)


def cut(serving: Serving, reason: str) -> float:
    return serving.application.tally.count("connections_cut_total", reason=reason)


@pytest.mark.parametrize(
    "begin",
    [b"", b"GET", b"GET /tracks HTTP/1.1\r\nhost: localhost\r\nx: ", b"\x16\x03\x01\x02\x00"],
)
def test_a_head_that_never_ends_is_cut(serving: Serving, begin: bytes) -> None:
    with serving.connect() as peer:
        peer.sendall(begin)
        found = read_all(peer)
    assert found == b"" or found.startswith(b"HTTP/1.1 400")
    assert until(lambda: not len(serving.server._connections))


def test_a_head_that_trickles_is_cut(serving: Serving) -> None:
    with serving.connect() as peer:
        peer.sendall(b"GET /tracks HTTP/1.1\r\n")
        try:
            for k in range(100):
                peer.sendall(b"x-%d: 1\r\n" % k)
                time.sleep(0.1)
            is_cut = False
        except OSError:
            is_cut = True
    assert is_cut
    assert cut(serving, "head") == 1


def test_a_connection_that_asked_once_and_then_trickles_is_cut(serving: Serving) -> None:
    with serving.connect() as peer:
        peer.sendall(b"GET /healthz HTTP/1.1\r\nhost: localhost\r\n\r\nGET /healthz HT")
        assert read_all(peer).startswith(b"HTTP/1.1 200")


def test_a_body_that_never_ends_is_answered_and_cut(serving: Serving) -> None:
    for length in (b"content-length: 1000", b"transfer-encoding: chunked"):
        found = serving.talk(HEAD + length + b"\r\n\r\n")
        assert found.startswith(b"HTTP/1.1 408")
    assert until(lambda: not len(serving.server._connections))


def test_bodies_beyond_the_limit_are_refused_said_or_not(serving: Serving) -> None:
    long = b"x" * (BODY + 1)
    done = post(f"{serving.url}/reports", content=long)
    assert done.status_code == 413
    said = serving.talk(HEAD + b"content-length: 99999999999999\r\n\r\n")
    assert said.startswith(b"HTTP/1.1 413")
    with serving.connect() as peer:
        peer.sendall(HEAD + b"transfer-encoding: chunked\r\n\r\n")
        try:
            for _ in range(100):
                peer.sendall(b"1000\r\n" + b"x" * 4096 + b"\r\n")
        except OSError:
            pass
        found = read_all(peer)
    assert found == b"" or found.startswith(b"HTTP/1.1 413")
    assert serving.desk.taken == []


def test_a_body_in_chunks_is_taken_whole(serving: Serving) -> None:
    line = b'{"time": 1, "x": 1, "y": 1}\n'

    def pieces() -> Iterator[bytes]:
        for k in range(100):
            yield (line * 100)[k * 28 : (k + 1) * 28 - 5]
            yield (line * 100)[(k + 1) * 28 - 5 : (k + 1) * 28]

    done = post(f"{serving.url}/reports", content=pieces())
    assert done.json()["accepted"] == 100


def test_only_so_much_of_bodies_is_held_at_once() -> None:
    limits = Limits(body_s=600.0, body_bytes=BODY, bodies_bytes=4 * BODY)
    with Serving(RememberingDesk(), WebSettings(limits=limits)) as running:
        posting = f"{running.url}/reports"
        with ExitStack() as stack:
            for _ in range(4):
                peer = stack.enter_context(running.connect())
                peer.sendall(HEAD + b"content-length: %d\r\n\r\n" % BODY)
            assert until(lambda: busy(running) == 4)
            assert post(posting, content=b"x" * BODY).status_code == 503
        assert until(lambda: post(posting, content=b"{}").status_code == 200)


@pytest.mark.parametrize(
    "message",
    [
        b"\r\n\r\n\r\n",
        b"GET / HTTP/9.9\r\n\r\n",
        b"GET /\xff HTTP/1.1\r\nhost: localhost\r\n\r\n",
        b"GET / HTTP/1.1\r\nhost: a\r\nhost: b\r\n\r\n",
        b"GET / HTTP/1.1\r\n\r\n",
        b"G\x00T / HTTP/1.1\r\nhost: localhost\r\n\r\n",
        b"GET / HTTP/1.1\r\nhost: localhost\r\nx\x00: y\r\n\r\n",
        b"GET / HTTP/1.1\r\nhost: localhost\r\n" + b"x: y\r\n" * 9000 + b"\r\n",
        b"GET /" + b"a" * 100_000 + b" HTTP/1.1\r\nhost: localhost\r\n\r\n",
        # Two lengths, and a length that is none: what proxies and servers read in two ways.
        HEAD + b"content-length: 3\r\ncontent-length: 4\r\n\r\n",
        HEAD + b"content-length: -1\r\n\r\n",
        HEAD + b"content-length: 0x10\r\n\r\n",
        HEAD + b"transfer-encoding: gzip, chunked\r\n\r\n",
        HEAD + b"transfer-encoding: chunked\r\n\r\nzz\r\n",
        b"\x16\x03\x01" + bytes(500),
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
    ],
)
def test_what_is_no_request_is_refused(serving: Serving, message: bytes) -> None:
    found = serving.talk(message)
    assert found == b"" or found.split()[1] in REFUSED, found
    assert until(lambda: not serving.server._state.connections)
    assert get(f"{serving.url}/healthz").is_success


def test_a_length_and_chunks_together_carry_no_second_request(serving: Serving) -> None:
    hidden = b"GET /tracks HTTP/1.1\r\nhost: localhost\r\n\r\n"
    found = serving.talk(
        HEAD + b"content-length: 5\r\ntransfer-encoding: chunked\r\n\r\n0\r\n\r\n" + hidden
    )
    assert found.count(b"HTTP/1.1 ") <= 2
    assert b"FeatureCollection" not in found or found.startswith(b"HTTP/1.1 200")


def test_whoever_does_not_read_an_answer_is_cut() -> None:
    with (
        Serving(RememberingDesk(), WebSettings(limits=LIMITS)) as running,
        running.connect() as peer,
    ):
        peer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        peer.sendall(b"GET /large.bin HTTP/1.1\r\nhost: localhost\r\n\r\n")
        assert until(lambda: cut(running, "stalled") == 1)
        assert until(lambda: not len(running.server._connections))
        assert get(f"{running.url}/healthz").is_success


def test_connections_that_ask_nothing_make_room_for_those_that_do(serving: Serving) -> None:
    with ExitStack() as stack:
        for _ in range(3 * LIMITS.connections):
            stack.enter_context(serving.connect())
        assert get(f"{serving.url}/healthz").is_success
        assert len(serving.server._connections) <= LIMITS.connections
        assert cut(serving, "displaced") >= LIMITS.connections


def test_connections_that_ask_leave_no_room_for_more() -> None:
    limits = Limits(connections=20, body_s=600.0)
    with Serving(RememberingDesk(), WebSettings(limits=limits)) as running, ExitStack() as stack:
        for _ in range(limits.connections):
            peer = stack.enter_context(running.connect())
            peer.sendall(HEAD + b"content-length: 9\r\n\r\n")
        assert until(lambda: busy(running) == 20)
        with running.connect() as peer:
            assert read_all(peer) == b""
        assert running.application.tally.count("connections_refused_total", reason="all") == 1


def test_one_address_from_afar_has_its_share() -> None:
    connections = Connections(Limits(per_address=3), Tally())
    found = [connections.admit(Peer("203.0.113.1")) for _ in range(5)]
    assert [each is not None for each in found] == [True, True, True, False, False]
    assert connections.admit(Peer("203.0.113.2")) is not None
    assert found[0] is not None
    connections.left(found[0])
    connections.left(found[0])
    assert connections.admit(Peer("203.0.113.1")) is not None
    assert connections.admit(Peer("203.0.113.1")) is None
    assert connections.admit(Peer(None)) is None


class Peer:
    """What is asked of a socket when it comes."""

    def __init__(self, address: str | None) -> None:
        self._address = address

    def getpeername(self) -> tuple[str, int]:
        if self._address is None:
            raise OSError
        return self._address, 1


def test_log_lines_cannot_be_forged(serving: Serving) -> None:
    lines: list[str] = []

    class Keeping(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            lines.append(LogLine().format(record))

    handler, logger = Keeping(), logging.getLogger("trackweave.service.web")
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.DEBUG)
    try:
        forged = "/x%0a{%22event%22:%22login%22}%0d%1b[2J%e2%80%ae%7f?token=secret"
        for host in (b"localhost", b"evil.example"):
            head = b"GET %s HTTP/1.1\r\nhost: %s\r\nconnection: close\r\n\r\n"
            serving.talk(head % (forged.encode(), host))
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
    assert [json.loads(line)["event"] for line in lines] == ["request", "refused"]
    assert all(line.isascii() and line.isprintable() for line in lines)
    assert all(json.loads(line)["path"].startswith('/x\n{"event":"login"}') for line in lines)
    assert "secret" not in "".join(lines)
