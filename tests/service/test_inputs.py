"""Inputs as they run: a process each, spoken to by real clients of each kind."""

import json
import os
import select
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from formats.samples import BLOCKS, LINES, NMEA, ROWS, SBS
from service.asterix import marker, plot
from service.serving import free_port
from trackweave.errors import InvalidInputError
from trackweave.service.inputs.outbox import FRAME, MARKS, REPORTS, completed, told_times
from trackweave.service.inputs.source import source_of
from trackweave.service.records import arrived

PATIENCE_S = 60.0
SAMPLES = {
    "asterix": (BLOCKS, 3), "ais": (NMEA, 4), "sbs": (SBS, 2), "jsonl": (LINES, 3),
    "csv": (ROWS, 5),
}  # fmt: skip
"""Bytes of each format, and how many reports are in them."""
HEADER, ROW = b"time,sensor,x,y\n", b"%d,pier,1.5,2\n"


class Listening:
    """An input's process, and what it hands on."""

    def __init__(self, process: "subprocess.Popen[bytes]") -> None:
        self.process = process
        self.tables: list[pl.DataFrame] = []
        self.state: dict[str, Any] = {}
        self.marks: list[tuple[int, dict[str, float]]] = []
        """Marks of beams, with how many reports had come before."""
        self._kept = b""

    def read(self, is_done: Callable[["Listening"], bool]) -> None:
        """Take what it hands on until that is enough, or it ends."""
        assert self.process.stdout is not None
        end = time.monotonic() + PATIENCE_S
        while not is_done(self):
            assert time.monotonic() < end, self.state
            if not select.select([self.process.stdout], [], [], 0.2)[0]:
                continue
            data = os.read(self.process.stdout.fileno(), 65_536)
            if not data:
                return
            self._kept += data
            self._take()

    def reports(self) -> int:
        """Return how many reports have come."""
        return sum(table.height for table in self.tables)

    def _take(self) -> None:
        while len(self._kept) >= FRAME.size:
            kind, n_words, n_body = FRAME.unpack_from(self._kept)
            begin, end = FRAME.size + n_words, FRAME.size + n_words + n_body
            if len(self._kept) < end:
                return
            words, body = self._kept[FRAME.size : begin], self._kept[begin:end]
            self._kept = self._kept[end:]
            if kind == REPORTS:
                self.tables.append(arrived(body).table)
            elif kind == MARKS:
                self.marks.append((self.reports(), json.loads(words)["marks"]))
            else:
                self.state = json.loads(words)


@contextmanager
def listening(url: str) -> Iterator[Listening]:
    """Run an input; end it afterwards."""
    with subprocess.Popen(
        [sys.executable, "-m", "trackweave.service.inputs", json.dumps(url)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    ) as process:  # fmt: skip
        try:
            yield Listening(process)
        finally:
            process.kill()


def connected(port: int) -> socket.socket:
    """Return a connection, once somebody listens."""
    end = time.monotonic() + PATIENCE_S
    while True:
        try:
            return socket.create_connection(("127.0.0.1", port))
        except ConnectionRefusedError:
            assert time.monotonic() < end
            time.sleep(0.1)


def enough(count: int) -> Callable[[Listening], bool]:
    """Return what tells whether so many reports are there, and how the input is."""
    return lambda found: found.reports() >= count and bool(found.state)


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_standard_input_is_read_to_its_end(name: str) -> None:
    data, count = SAMPLES[name]
    with listening(f"stdin:?format={name}&sensor=pier") as found:
        assert found.process.stdin is not None
        found.process.stdin.write(data)
        found.process.stdin.close()
        found.read(lambda each: bool(each.state.get("ended")))
    assert found.reports() == count
    assert found.state["skipped"] > 0  # each sample has something that is no report
    assert all(table["time"].null_count() == 0 for table in found.tables)
    assert all(table["sensor"].null_count() == 0 for table in found.tables)


def test_the_end_of_a_sector_is_told_behind_its_reports_and_at_once() -> None:
    port, said = free_port(), [marker(36_000.0, 0.0), plot(36_000.1, 3e4, 9.0)]
    said.append(plot(36_000.2, 4e4, 18.0) + marker(36_000.5, 45.0))
    with (
        listening(f"udp://127.0.0.1:{port}?format=asterix") as heard,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
    ):
        sender.connect(("127.0.0.1", port))
        heard.read(lambda each: "clients" in each.state)
        for message in said:
            sender.send(message)
        heard.read(lambda each: bool(each.marks))
        ((count, marks),) = heard.marks
        # Dated by when it came.
        assert (count, marks["025/011"] % 86_400.0) == (2, 36_000.5)


def test_standard_input_hands_on_what_came_while_nothing_more_comes() -> None:
    with listening("stdin:?format=csv&sensor=pier") as found:
        assert found.process.stdin is not None
        for lap in range(1, 3):
            found.process.stdin.write(b"time,x,y\n1,2,3\n2,3,4\n" if lap == 1 else b"3,4,5\n")
            found.process.stdin.flush()
            found.read(enough(lap + 1))
    assert found.reports() == 3


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_a_connection_may_split_anywhere_and_come_again(name: str) -> None:
    (data, count), port = SAMPLES[name], free_port()
    with listening(f"tcp://127.0.0.1:{port}?format={name}") as found:
        for lap in range(2):
            with connected(port) as sock:
                for begin in range(0, len(data), 37):
                    sock.sendall(data[begin : begin + 37])
                    time.sleep(0.002)
            found.read(enough((lap + 1) * count))
        found.read(lambda each: each.state["clients"] == 0)
    assert found.reports() == 2 * count


def test_an_input_fetches_from_a_server_that_goes_away() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        with listening(f"tcp://127.0.0.1:{port}?format=csv&connect=1") as found:
            for lap in range(2):
                sock, _ = server.accept()
                with sock:
                    sock.sendall(HEADER + ROW % lap + ROW % lap)
                found.read(enough(2 * (lap + 1)))
    assert [time for table in found.tables for time in table["time"]] == [0.0, 0.0, 1.0, 1.0]


def test_csv_datagrams_go_by_the_header_that_their_sender_sent_last() -> None:
    port = free_port()
    with listening(f"udp://127.0.0.1:{port}?format=csv") as found:
        found.read(lambda each: bool(each.state))  # it listens
        senders = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(3)]
        for sender, data in (
            (0, HEADER + ROW % 1), (0, ROW % 2), (0, b"3,pier,2.5"), (0, ROW % 4),
            (1, ROW % 5),  # it has named no columns yet
            (1, HEADER + ROW % 6),
            (0, HEADER + ROW % 7),  # the same again
            (0, b"y,x,t\n8,1,9\n"),
            (2, b"timestamp,x,y\n2026-11-23T10:00:00Z,1,2\n"),
        ):  # fmt: skip
            senders[sender].sendto(data, ("127.0.0.1", port))
            time.sleep(0.01)
        found.read(lambda each: each.reports() >= 7 and each.state["skipped"] >= 2)
        for sender in senders:
            sender.close()
    seconds = [each for each in found.tables if each["time"].dtype == pl.Float64]
    assert sorted(t for table in seconds for t in table["time"]) == [1.0, 2.0, 4.0, 6.0, 7.0, 9.0]
    last = pl.concat(seconds, how="diagonal_relaxed").filter(pl.col("time") == 9.0)
    assert last.select("x", "y", "sensor").row(0) == (1.0, 8.0, "default")
    dated = [each for each in found.tables if each["time"].dtype != pl.Float64]
    assert [str(t) for table in dated for t in table["time"]] == ["2026-11-23 10:00:00+00:00"]
    assert found.state["skipped"] == 2


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_a_client_of_websockets_is_heard(name: str) -> None:
    client = pytest.importorskip("websockets.sync.client")
    (data, count), port = SAMPLES[name], free_port()
    with listening(f"ws://127.0.0.1:{port}?format={name}") as found:
        connected(port).close()
        with client.connect(f"ws://127.0.0.1:{port}") as stream:
            if name == "asterix":
                stream.send(data)
            else:  # a message of text is a line at least; one of bytes is a piece
                for number, line in enumerate(data.splitlines()):
                    stream.send(line + b"\n" if number % 2 else line.decode("utf-8"))
        found.read(enough(count))
    assert found.reports() == count


def test_a_web_page_is_no_client() -> None:
    client = pytest.importorskip("websockets.sync.client")
    port = free_port()
    with listening(f"ws://127.0.0.1:{port}?format=csv"):
        connected(port).close()
        with pytest.raises(client.InvalidStatus, match="403"):
            client.connect(f"ws://127.0.0.1:{port}", origin="http://127.0.0.1:8700")


def test_a_recording_comes_at_its_pace_after_what_comes_at_once(tmp_path: Path) -> None:
    path = tmp_path / "recording.csv"
    path.write_bytes(HEADER + b"".join(ROW % second for second in range(1000)))
    with listening(f"replay:{path}?speed=2&ahead=100") as found:
        assert found.process.stdin is not None
        found.process.stdin.close()
        begun = time.monotonic()
        found.read(enough(101))
        at_once, took = found.reports(), time.monotonic() - begun
        found.read(enough(at_once + 2))
        waited = time.monotonic() - begun
    # Two a second, beyond those of the first hundred seconds.
    assert 101 <= at_once <= 103 + 2 * took
    assert at_once + 2 <= 101 + 2 * (waited + 0.1) + 1


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("replay:a.csv?ahead=-1", "ahead '-1'; expected a number from 0 s to 3600"),
        ("replay:a.csv?speed=fast", "speed 'fast'; expected a number from 0 \\(as fast"),
        ("replay:a.csv?speed=nan", "speed 'nan'"),
        ("udp://127.0.0.1:1?format=parquet", "expected one of bytes in a stream"),
        ("tcp://127.0.0.1?format=csv", "expected tcp://HOST:PORT"),
        ("stdin:", "no format"),
    ],
)
def test_an_address_that_is_none_is_refused_by_what_is_wrong(url: str, said: str) -> None:
    with pytest.raises(InvalidInputError, match=said):
        source_of(url)


def test_times_are_understood_under_other_names_and_as_text() -> None:
    rows = [{"timestamp": "2026-11-23T10:00:00Z", "x": 1.0}, {"timestamp": None, "x": 2.0}]
    table = completed(pl.DataFrame(rows), "pier")
    assert table["time"][0] == "2026-11-23T10:00:00Z"
    first, last, count, _ = told_times(table)["pier"]
    assert (first, count) == (1795428000.0, 2)
    assert last == pytest.approx(time.time(), abs=60.0)
    seconds = completed(pl.DataFrame({"time": ["12.5", " "], "x": ["1", "2"]}), "pier")
    assert float(seconds["time"][1]) == pytest.approx(time.time(), abs=60.0)
    nowhere = completed(pl.DataFrame({"x": [1.0], "time": [None]}))
    assert nowhere["time"].null_count() == 0
