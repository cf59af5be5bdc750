"""What is rehearsed before the first scan, and what is not rehearsed twice."""

import asyncio
import subprocess
import sys
from pathlib import Path

import pytest

from trackweave.config import load_configuration
from trackweave.service.clerk import Clerk
from trackweave.service.office import Office
from trackweave.service.rehearsing import Rehearsal

KERNELS = """
from trackweave.config import load_configuration
from trackweave.service.rehearsing import Rehearsal
from trackweave.warming.packing import kernels
came = lambda: sum(sum(kernel._cache.came.values()) for _, kernel in kernels())
before = came()
Rehearsal().run(load_configuration({}))
print(came() - before)
"""


@pytest.mark.slow
def test_reaches_the_kernels_of_a_tracker() -> None:
    done = subprocess.run(
        [sys.executable, "-c", KERNELS], check=True, capture_output=True, text=True
    )
    assert int(done.stdout) > 20


def test_what_was_rehearsed_is_not_needed_again_and_what_is_new_is() -> None:
    rehearsal = Rehearsal()
    nothing = load_configuration({})
    assert rehearsal.needs(nothing)
    rehearsal.run(nothing)
    assert not rehearsal.needs(nothing)
    # Told or learned, it is the same way of running; numbers compile nothing.
    full = {
        "motion": {"model": "constant-velocity", "process_noise": 2.0},
        "sensors": {"pier": {"measurement": "position", "sigma": 3.0, "scan_period": 2.0}},
    }
    assert not rehearsal.needs(load_configuration(full))
    for other in (
        {"motion": {"model": "imm"}},
        {"sensors": {"pier": {"measurement": "bearing"}}},
        {"sensors": {"default": {"scans": False}}},
        {"tracker": {"kind": "nearest-neighbour"}},
    ):
        assert rehearsal.needs(load_configuration(other))
    assert rehearsal.needs(nothing, dim=3)


def test_says_starting_until_it_is_ready(tmp_path: Path) -> None:
    async def status() -> str:
        clerk = Clerk(Office.open(tmp_path), lambda: load_configuration({}))
        try:
            return str(clerk.health()["status"])
        finally:
            await clerk.close()

    assert asyncio.run(status()) == "starting"
