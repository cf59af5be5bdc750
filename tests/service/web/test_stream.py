"""What whoever listens is sent, and what becomes of whoever does not read or talks."""

import json
import socket

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection

from oracles.serving import FRAME, RememberingDesk, Serving, listen, read_all, tracks_table, until
from trackweave.service.web.settings import Limits, WebSettings

HEAD = (
    b"GET /stream HTTP/1.1\r\nhost: localhost\r\nupgrade: websocket\r\nconnection: Upgrade\r\n"
    b"sec-websocket-version: 13\r\nsec-websocket-key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
)


def url(serving: Serving, query: str = "") -> str:
    return f"ws://127.0.0.1:{serving.port}/stream{query}"


def code_of_end(stream: ClientConnection) -> int | None:
    """Return with which code the server ends the stream, None for none."""
    try:
        while True:
            stream.recv(timeout=60)
    except ConnectionClosed as closed:
        return closed.rcvd.code if closed.rcvd else None


def test_a_full_picture_comes_first_and_then_what_changed() -> None:
    desk = RememberingDesk(4)
    with Serving(desk) as running, listen(url(running)) as stream:
        first = json.loads(stream.recv())
        assert (first["type"], first["full"], first["ended"]) == ("tracks", True, [])
        assert [each["track"] for each in first["changed"]] == ["1", "2", "3", "4"]
        assert {"status", "time", "x", "y", "vx", "vy", "latitude"} <= set(first["changed"][0])
        running.call(desk.fanout.tracks, 5.0, tracks_table(1), ["3"], FRAME)
        then = json.loads(stream.recv())
        assert "full" not in then
        assert (then["time"], then["ended"]) == (5.0, ["3"])
        assert [each["track"] for each in then["changed"]] == ["1"]
        running.call(desk.fanout.send, {"type": "status", "load": float("nan")})
        assert json.loads(stream.recv()) == {"type": "status", "load": None}


def test_reports_come_to_whoever_asks_for_them() -> None:
    desk = RememberingDesk(1)
    with (
        Serving(desk) as running,
        listen(url(running, "?reports=1")) as one,
        listen(url(running)) as other,
    ):
        assert one.recv()
        assert other.recv()
        running.call(desk.fanout.reports, 1.0, [[1.0, 2.0, "radar", None]])
        running.call(desk.fanout.send, {"type": "status"})
        assert json.loads(one.recv())["type"] == "reports"
        assert json.loads(other.recv())["type"] == "status"


@pytest.mark.parametrize("message", ["hello", b"\x00\xff", '{"type": "tracks"}'])
def test_whoever_talks_is_not_listened_to(message: str | bytes) -> None:
    with Serving(RememberingDesk()) as running, listen(url(running)) as stream:
        assert stream.recv()
        stream.send(message)
        assert code_of_end(stream) == 1008


def test_too_long_a_message_ends_the_connection() -> None:
    with Serving(RememberingDesk()) as running, listen(url(running)) as stream:
        assert stream.recv()
        stream.send("x" * 100_000)
        assert code_of_end(stream) in (1009, None)
        assert until(lambda: not len(running.desk.fanout))


def test_whoever_does_not_read_is_given_up_and_takes_no_memory() -> None:
    desk = RememberingDesk(2000)
    limits = Limits(stall_s=1.0)
    with Serving(desk, WebSettings(limits=limits)) as running, running.connect() as peer:
        peer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        peer.sendall(HEAD)
        assert until(lambda: len(desk.fanout) == 1)
        changed = tracks_table(2000)
        for k in range(20):  # some 600 kB each
            running.call(desk.fanout.tracks, float(k), changed, [], FRAME)
            waiting = sum(each._length for each in desk.fanout._listeners)
            assert waiting <= 1 << 20
        assert until(lambda: not len(desk.fanout))
        assert until(lambda: not len(running.server._connections))


def test_whoever_was_behind_goes_on_with_a_fresh_full_picture() -> None:
    desk = RememberingDesk(2000)
    with Serving(desk) as running, listen(url(running), max_size=None, max_queue=1) as stream:
        changed = tracks_table(2000)
        for k in range(40):
            running.call(desk.fanout.tracks, float(k), changed, [], FRAME)
        assert desk.fanout.resynchronised >= 1
        running.call(desk.fanout.tracks, 99.0, tracks_table(1), [], FRAME)
        found = []
        while not found or found[-1]["time"] != 99.0:
            found.append(json.loads(stream.recv(timeout=60)))
            if found[-1].get("full") and len(found) > 1:
                break
        assert any(each.get("full") for each in found[1:])
        assert len(found) < 60


def test_pings_that_nobody_reads_the_answers_of_pile_up_nowhere() -> None:
    desk = RememberingDesk(1)
    limits = Limits(stall_s=2.0)
    ping = b"\x89\xfd\x00\x00\x00\x00" + b"x" * 125
    with Serving(desk, WebSettings(limits=limits)) as running, running.connect() as peer:
        peer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        peer.sendall(HEAD)
        assert until(lambda: len(desk.fanout) == 1)
        peer.settimeout(0.5)
        largest = 0
        try:
            for _ in range(2000):
                peer.sendall(ping * 64)
                open_ones = running.call(lambda: list(running.server._connections._open))
                sizes = [c.transport.get_write_buffer_size() for c in open_ones if c.transport]
                largest = max(largest, *sizes, 0)
        except OSError:
            pass
        assert 0 < largest < 2_000_000
        assert until(lambda: not len(running.server._connections))


@pytest.mark.parametrize(
    "frame",
    [
        b"\x81\x05hello",  # not masked
        b"\xf1\x80\x00\x00\x00\x00",  # reserved bits
        b"\x83\x80\x00\x00\x00\x00",  # an operation that is none
        b"\x81\xff\xff\xff\xff\xff\xff\xff\xff\xff\x00\x00\x00\x00",  # 2^64 - 1 bytes
        b"\x89\xfe\x01\x00\x00\x00\x00\x00" + bytes(256),  # too long a ping
        b"\x80\x80\x00\x00\x00\x00",  # goes on with nothing
        b"\x88\x81\x00\x00\x00\x00\x00",  # half a code of closing
        b"\x81\x82\x00\x00\x00\x00\xff\xfe",  # no UTF-8
        b"\x88\x80\x00\x00\x00\x00",  # leaves
    ],
)
def test_no_frame_does_harm(frame: bytes) -> None:
    with Serving(RememberingDesk()) as running:
        with running.connect() as peer:
            peer.sendall(HEAD)
            assert until(lambda: len(running.desk.fanout) == 1)
            peer.sendall(frame)
            read_all(peer)  # the server ends it
        assert until(lambda: not len(running.desk.fanout))
        assert until(lambda: not running.server._state.connections)
        assert running.faults == []


def test_an_upgrade_that_is_none_is_forgotten() -> None:
    many = b"".join(b"x-%d: 1\r\n" % k for k in range(300))
    broken = [
        HEAD.replace(b"\r\n\r\n", b"\r\n" + many + b"\r\n"),
        HEAD.replace(b"version: 13", b"version: 7"),
        HEAD.replace(b"key: AAAAAAAAAAAAAAAAAAAAAA==", b"key: short"),
        HEAD.replace(b"/stream", b"/tracks"),
        HEAD.replace(b"/stream", b"/%00%ff"),
        HEAD.replace(b"GET", b"POST"),
    ]
    with Serving(RememberingDesk()) as running:
        for head in broken:
            found = running.talk(head)
            assert not found.startswith(b"HTTP/1.1 101"), found
        assert until(lambda: not running.server._state.connections)
        assert len(running.server._connections) == 0


def test_only_so_many_may_listen() -> None:
    limits = Limits(streams=2)
    with Serving(RememberingDesk(), WebSettings(limits=limits)) as running:
        with listen(url(running)), listen(url(running)):
            with pytest.raises(InvalidStatus) as refused, listen(url(running)):
                pass
            assert refused.value.response.status_code == 503
        assert until(lambda: running.application.tally.measured["streams"]() == 0)
        with listen(url(running)) as stream:
            assert stream.recv()


def test_the_service_ends_though_somebody_listens() -> None:
    with Serving(RememberingDesk()) as running, listen(url(running)) as stream:
        assert stream.recv()
        running.run(running.server.stop())
        assert code_of_end(stream) == 1012
        assert not len(running.server._connections)
