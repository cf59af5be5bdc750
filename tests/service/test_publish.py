"""What ``--publish`` sends: each datagram, and each stream, is read again by a reader."""

import asyncio
import json
import socket
import xml.etree.ElementTree as ET
from contextlib import suppress

import numpy as np
import polars as pl
import pytest

from trackweave.domain.frames import LocalFrame
from trackweave.errors import InvalidInputError
from trackweave.formats.reading import chosen
from trackweave.service import publish
from trackweave.service.board import Drawn
from trackweave.service.desk import Picture
from trackweave.service.publish import LARGEST, Publisher, target_of

FRAME = LocalFrame(54.5, 10.25)
READ = {"asterix-062": "asterix", "readsb": "readsb", "jsonl": "jsonl"}
"""Formats that the package reads as well, and the names of their readers."""


def drawn(count: int) -> Drawn:
    """Return a picture of tracks on a line to the east."""
    x = 100.0 * np.arange(count)
    latitude, longitude, _ = FRAME.to_geodetic(np.stack([x, 0.0 * x], axis=-1))
    zero, four = np.zeros(count), np.full(count, 4.0)
    date = pl.Series([1_795_434_949_000_000] * count).cast(pl.Datetime("us", "UTC"))
    table = pl.DataFrame(
        {
            "time": date, "track": np.arange(1, count + 1), "status": ["confirmed"] * count,
            "x": x, "y": zero, "lat": latitude, "lon": longitude, "vx": four, "vy": zero,
            "p_x_x": four, "p_x_y": zero, "p_x_vx": zero, "p_x_vy": zero, "p_y_y": four,
            "p_y_vx": zero, "p_y_vy": zero, "p_vx_vx": four, "p_vx_vy": zero, "p_vy_vy": four,
            "score": four, "hits": np.full(count, 3), "last_update": date,
        }
    )  # fmt: skip
    return Drawn(Picture(1_795_434_949.0, table, FRAME), table, ())


async def _sent(scheme: str, name: str, count: int) -> list[bytes]:
    """Return what arrives: datagrams, or the one stream."""
    kind = socket.SOCK_DGRAM if scheme == "udp" else socket.SOCK_STREAM
    with socket.socket(socket.AF_INET, kind) as sock:
        sock.bind(("127.0.0.1", 0))
        if scheme == "tcp":
            sock.listen(1)
        url = f"{scheme}://127.0.0.1:{sock.getsockname()[1]}?format={name}"
        publisher = Publisher(target_of(url))
        publisher(drawn(count))
        work = asyncio.create_task(publisher.run())
        found = await asyncio.to_thread(_received, sock, scheme)
        work.cancel()
        await asyncio.gather(work, return_exceptions=True)
        await asyncio.sleep(0.01)  # the connection is closed
        assert publisher.message == ""
        return found


def _received(sock: socket.socket, scheme: str) -> list[bytes]:
    found: list[bytes] = []
    peer = sock if scheme == "udp" else sock.accept()[0]
    peer.settimeout(3.0)
    with peer, suppress(TimeoutError):
        while data := peer.recv(1 << 16):
            found.append(data)
            peer.settimeout(0.5)
    return found if scheme == "udp" else [b"".join(found)]


def sent(scheme: str, name: str, count: int, monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """Return what arrives of some tracks."""
    monkeypatch.setattr(publish, "EVERY", 0.05)
    return asyncio.run(_sent(scheme, name, count))


@pytest.mark.parametrize("count", [3, 400])
@pytest.mark.parametrize("scheme", ["udp", "tcp"])
@pytest.mark.parametrize("name", sorted(READ))
def test_what_is_read_again_is_what_was_sent(
    name: str, scheme: str, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, settings = chosen(READ[name])
    assert found.decoder is not None
    # A line for each: more at once than a socket's buffer holds are lost, as datagrams may be.
    count = min(count, 60) if (name, scheme) == ("jsonl", "udp") else count
    pieces, tables = sent(scheme, name, count, monkeypatch), []
    decoder = found.decoder(**settings)
    for piece in pieces:
        # A datagram stands for itself: whoever missed the others can read it.
        decoder = found.decoder(**settings) if scheme == "udp" else decoder
        tables += [decoder.feed(piece), decoder.finish() if scheme == "udp" else None]
        assert decoder.skips.count == 0
        assert scheme == "tcp" or len(piece) <= LARGEST
    rows = pl.concat([each for each in tables if each is not None], how="diagonal_relaxed")
    latitude, longitude, _ = FRAME.to_geodetic(np.array([[100.0 * (count - 1), 0.0]]))
    assert rows.height == count
    assert float(rows["lat"][-1]) == pytest.approx(latitude[0], abs=1e-5)
    assert float(rows["lon"][-1]) == pytest.approx(longitude[0], abs=1e-5)


@pytest.mark.parametrize("count", [3, 400])
def test_each_datagram_of_geojson_and_cot_is_a_document(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[int] = []
    for piece in sent("udp", "geojson", count, monkeypatch):
        told = json.loads(piece)
        assert told["type"] == "FeatureCollection"
        seen += [each["id"] for each in told["features"]]
        assert all(each["geometry"]["type"] == "Point" for each in told["features"])
    assert seen == list(range(1, count + 1))
    events = [ET.fromstring(piece) for piece in sent("udp", "cot", 30, monkeypatch)]
    assert [event.get("uid") for event in events] == [f"trackweave-{n}" for n in range(1, 31)]
    for event in events:
        point = event.find("point")
        assert point is not None
        assert {"lat", "lon", "hae", "ce", "le"} <= set(point.keys())
        assert {"version", "type", "time", "start", "stale", "how"} <= set(event.keys())


def test_a_stream_of_geojson_is_a_document_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    (stream,) = sent("tcp", "geojson", 400, monkeypatch)
    assert stream.endswith(b"\n")
    assert [len(json.loads(line)["features"]) for line in stream.splitlines()] == [400]


def test_whom_reports_told_of_says_what_a_thing_is() -> None:
    publisher = Publisher(target_of("udp://127.0.0.1:9?format=cot"))
    rows = drawn(2).changed.with_columns(identity=pl.Series(["211000001", None]))
    (text, *more) = publisher._written(rows, FRAME)
    kinds = [ET.fromstring(line).get("type") for line in b"".join([text, *more]).splitlines()]
    assert kinds == ["a-u-S", "a-u-G"]


@pytest.mark.parametrize("name", ["ctc", "geff", "kitti", "mot"])
def test_formats_that_are_no_messages_are_refused(name: str) -> None:
    with pytest.raises(InvalidInputError, match=f"format {name} is of several files"):
        target_of(f"udp://127.0.0.1:4242?format={name}")
