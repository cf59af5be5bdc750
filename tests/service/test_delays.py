"""Up to when nothing is waited for, and a clock that stands while inputs are not read."""

import asyncio
from pathlib import Path

import polars as pl
import pytest

from trackweave.config import load_configuration
from trackweave.domain.facts import Facts
from trackweave.service import clerk as clerks
from trackweave.service.clerk import Clerk
from trackweave.service.delays import Delays, Standstill
from trackweave.service.office import Office
from trackweave.service.records import packed_reports


def test_what_waited_while_inputs_were_not_read_is_not_late() -> None:
    delays, still = Delays(), Standstill()

    def tell(time: float, now: float) -> None:
        delays.note({"pier": [time, time, 1]}, still.clock(now))

    def until(now: float) -> float:
        return delays.until(still.clock(now))["pier"]

    for second in range(20):
        tell(float(second), 1000.0 + second + 0.2)
    # From 1019.3 on nothing is read for a minute; then all that waited comes at once.
    still.begin(1019.3)
    assert until(1079.0) == until(1019.3) < 20.0
    still.begin(1050.0)  # it stands already
    still.end(1079.3)
    for second in range(20, 80):
        now = 1079.4 + 0.05 * (second - 20)
        assert until(now) < second
        tell(float(second), now)
    # In time again, it closes again.
    for second in range(80, 400):
        tell(float(second), 1000.0 + second + 0.2)
    assert until(1400.0) > 330.0


def test_the_clock_stands_while_too_much_waits_for_the_tracker(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clerks, "MOST_WAITING", 0)
    table = pl.DataFrame({"time": [1.0], "sensor": ["pier"], "x": [1.0], "y": [2.0]})
    payload = packed_reports(table, "udp", Facts())

    async def handed() -> tuple[float, bool, float]:
        clerk = Clerk(Office.open(tmp_path), lambda: load_configuration({}))
        try:
            clerk._wait.reports = 1
            task = asyncio.create_task(clerk._handed(payload, 1, {"pier": [1.0, 1.0, 1]}))
            await asyncio.sleep(0.1)
            stood = clerk._standstill.clock(1e6) - clerk._standstill.clock(1e3)
            waits = not task.done()
            clerk._wait.reports = 0
            await task
            return stood, waits, clerk._standstill.clock(1e6) - clerk._standstill.clock(1e3)
        finally:
            await clerk.close()

    stood, waits, went_on = asyncio.run(handed())
    assert (stood, waits) == (0.0, True)
    assert went_on == pytest.approx(1e6 - 1e3)
