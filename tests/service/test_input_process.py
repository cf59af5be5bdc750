"""An input as the service sees it: whether it listens, what it says, and how it ends."""

import asyncio
import logging
import socket
from collections.abc import Callable
from typing import Any

import pytest

from service.serving import PATIENCE_S, free_port
from trackweave.service.inputs.process import Input
from trackweave.service.inputs.source import source_of


class Heard:
    """What an input has handed on."""

    def __init__(self) -> None:
        self.reports = 0

    async def take(self, payload: bytes, count: int, told: Any) -> None:
        """Count reports."""
        self.reports += count


def logged(caplog: pytest.LogCaptureFixture, event: str) -> int:
    """Return how many lines of the log are of an event."""
    return sum(record.getMessage() == event for record in caplog.records)


async def until(is_so: Callable[[], bool]) -> None:
    """Return once something is so."""
    async with asyncio.timeout(PATIENCE_S):
        while not is_so():
            await asyncio.sleep(0.05)


async def run(url: str, look: Callable[[Input, Heard], Any]) -> None:
    """Run an input while it is looked at."""
    heard = Heard()
    found = Input(source_of(url), heard.take, lambda marks: None, asyncio.Event())
    task = asyncio.create_task(found.run())
    try:
        await look(found, heard)
    finally:
        task.cancel()
        await found.close()


def test_what_is_sent_once_it_says_that_it_listens_is_heard() -> None:
    port = free_port()

    async def look(found: Input, heard: Heard) -> None:
        assert not found.is_ready
        await asyncio.wait_for(found.has_told.wait(), PATIENCE_S)
        assert found.is_ready
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.sendto(b"time,x,y\n1,2,3\n", ("127.0.0.1", port))
        await until(lambda: heard.reports == 1)

    asyncio.run(run(f"udp://127.0.0.1:{port}?format=csv", look))


@pytest.mark.parametrize("scheme", ["tcp", "ws"])
def test_a_server_says_that_it_listens_once_senders_can_connect(scheme: str) -> None:
    port = free_port()

    async def look(found: Input, heard: Heard) -> None:
        await until(lambda: found.is_ready)
        with socket.create_connection(("127.0.0.1", port)) as sock:
            assert sock.getpeername() == ("127.0.0.1", port)

    asyncio.run(run(f"{scheme}://127.0.0.1:{port}?format=jsonl", look))


def test_an_address_that_is_taken_is_said_once_and_does_not_count_as_listening(
    caplog: pytest.LogCaptureFixture,
) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))

        async def look(found: Input, heard: Heard) -> None:
            await asyncio.wait_for(found.has_told.wait(), PATIENCE_S)
            assert not found.is_ready
            assert "in use" in found.state["message"]

        with caplog.at_level(logging.WARNING, "trackweave.service"):
            asyncio.run(run(f"udp://127.0.0.1:{taken.getsockname()[1]}?format=csv", look))
    assert logged(caplog, "input") == 1


def test_csv_without_its_header_is_said_once_until_the_header_comes(
    caplog: pytest.LogCaptureFixture,
) -> None:
    port = free_port()

    async def look(found: Input, heard: Heard) -> None:
        await until(lambda: found.is_ready)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.connect(("127.0.0.1", port))
            for time in range(3):
                sender.send(b"%d,2,3\n" % time)
            await until(lambda: found.state["skipped"] == 3)
            assert "before any header" in found.state["message"]
            sender.send(b"time,x,y\n4,2,3\n")
            await until(lambda: heard.reports == 1)
            await until(lambda: not found.state["message"])

    with caplog.at_level(logging.WARNING, "trackweave.service"):
        asyncio.run(run(f"udp://127.0.0.1:{port}?format=csv", look))
    assert logged(caplog, "input") == 1


def test_a_process_that_is_killed_is_one_line_of_the_log_and_begun_anew(
    caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    port = free_port()

    async def look(found: Input, heard: Heard) -> None:
        await until(lambda: found.is_ready)
        assert found._process is not None
        found._process.kill()
        await until(lambda: not found.is_ready)
        assert "begun anew" in found.state["message"]
        await until(lambda: found.is_ready and not found.state["message"])

    with caplog.at_level(logging.WARNING, "trackweave.service"):
        asyncio.run(run(f"udp://127.0.0.1:{port}?format=csv", look))
    assert logged(caplog, "input ended") == 1
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.parametrize("url", ["stdin:?format=csv", "tcp://127.0.0.1:9?format=csv&connect=1"])
def test_what_waits_for_its_reader_is_never_waited_for(url: str) -> None:
    async def made() -> bool:
        found = Input(source_of(url), Heard().take, lambda marks: None, asyncio.Event())
        return found.is_ready and found.has_told.is_set()

    assert asyncio.run(made())
