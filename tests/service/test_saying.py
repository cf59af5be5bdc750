"""How the service says that it is, and why."""

import asyncio
from pathlib import Path

from service.serving import free_port
from trackweave.config import load_configuration
from trackweave.service.clerk import Clerk
from trackweave.service.desk import Json
from trackweave.service.inputs.source import source_of
from trackweave.service.office import Office


def health_of(folder: Path, *urls: str) -> Json:
    """Return what a service says of itself before anything runs."""

    async def said() -> Json:
        sources = [source_of(url) for url in urls]
        clerk = Clerk(Office.open(folder), lambda: load_configuration({}), sources)
        try:
            return clerk.health()
        finally:
            await clerk.close()

    return asyncio.run(said())


def test_an_input_that_does_not_listen_yet_is_named(tmp_path: Path) -> None:
    url = f"udp://127.0.0.1:{free_port()}?format=csv"
    health = health_of(tmp_path, "stdin:?format=csv", url)
    assert health["status"] == "starting"
    assert health["listening"] is False
    assert health["message"].startswith(url)
    assert [each["listening"] for each in health["inputs"]] == [True, False]


def test_without_inputs_that_are_sent_to_nothing_is_waited_for(tmp_path: Path) -> None:
    health = health_of(tmp_path, "stdin:?format=csv")
    assert health["listening"] is True
    assert "kernels" in health["message"]
