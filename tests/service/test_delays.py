"""Up to when nothing is waited for, and a clock that stands while inputs are not read."""

import asyncio
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from trackweave.config import load_configuration
from trackweave.domain.facts import Facts
from trackweave.errors import InvalidInputError
from trackweave.service import clerk as clerks
from trackweave.service import delays as delaying
from trackweave.service.clerk import Clerk
from trackweave.service.delays import Delays, Standstill
from trackweave.service.desk import Rows
from trackweave.service.inputs.outbox import told_times
from trackweave.service.office import Office
from trackweave.service.records import Kind, packed_reports
from trackweave.service.spec import Spec


def test_what_waited_while_inputs_were_not_read_is_not_late() -> None:
    delays, still = Delays(), Standstill()

    def tell(time: float, now: float) -> None:
        delays.note({"pier": [time, time, 1, 0.0]}, still.clock(now))

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


def heard_with(pace: float, jump: float = 0.0) -> tuple[Delays, float]:
    """Return what is known of a radar at a pace, and of AIS that told once; and the time now."""
    delays, now = Delays(), 1000.0
    delays.note({"ais": [0.0, 0.0, 1, 0.0]}, now)
    for step in range(100):
        now = 1000.0 + 0.2 * step
        first = 0.2 * pace * step + (jump if step > 50 else 0.0)
        delays.note({"radar": [first, first + 0.19 * pace, 9, 0.19 * pace]}, now)
    return delays, now


def test_who_falls_silent_does_not_hold_up_a_recording_that_is_sent_fast() -> None:
    delays, now = heard_with(40.0)
    # Of some 792 s those that came in the last five seconds wait for what it may have to say.
    assert delays.overtaken("ais", now) == pytest.approx(792.0 - 200.0, abs=10.0)
    assert delays.overtaken("radar", now) <= 0.0


@pytest.mark.parametrize("jump", [3600.0, -3600.0])
def test_a_clock_that_is_set_overtakes_nobody(jump: float) -> None:
    delays, now = heard_with(1.0, jump)
    assert delays.overtaken("ais", now) < now - 1000.0


def test_reports_that_overlap_and_come_out_of_order_overtake_nobody() -> None:
    """Live, each second brings what was seen in the last three: the others go on as the clock."""
    delays = Delays()
    delays.note({"ais": [0.0, 0.0, 1, 0.0]}, 1000.0)
    for second in range(300):
        last = second - 1.5 * (second % 2)
        delays.note({"radar": [last - 3.0, last, 9, 3.0]}, 1000.0 + second)
    assert delays.overtaken("ais", 1300.0) < 302.0
    assert delays.closed({"ais": 0.0, "radar": 298.0}, 1300.0)["ais"] < 305.0


def test_who_falls_silent_in_what_comes_at_once_is_overtaken() -> None:
    delays = Delays()
    told = {"a": [0.0, 897.0, 900, 897.0], "b": [0.0, 8.0, 4, 8.0]}
    delays.note(told, 1000.0)
    assert delays.closed({"a": 897.0, "b": 8.0}, 1006.0)["b"] == 897.0


def test_a_time_that_is_off_is_no_course() -> None:
    table = pl.DataFrame({"time": [0.0, 30.0, 50.0, 3650.0], "sensor": ["pier"] * 4})
    assert told_times(table) == {"pier": [0.0, 3650.0, 4, 50.0]}


def told_in_sectors(behind: float) -> Delays:
    """Return what is known of a radar that tells a sector of half a second, then its end.

    What it saw comes so long after the mark of the moment [s].
    """
    delays = Delays()
    for sector in range(60):
        begin, now = 0.5 * sector, 1000.0 + 0.5 * (sector + 1)
        delays.note({"radar": [begin - behind, begin + 0.49 - behind, 30, 0.49]}, now)
        delays.mark({"radar": begin + 0.5})
    return delays


def test_a_radar_that_ends_its_sectors_itself_is_waited_for_no_longer() -> None:
    until = told_in_sectors(0.0).until(1030.0)["radar"]
    assert 30.0 <= until < 30.01
    # The clock alone would wait for what usually comes half a second later.
    assert told_in_sectors(0.0).until(1030.4)["radar"] == until


def test_a_radar_whose_plots_follow_its_marks_later_is_waited_for() -> None:
    until = told_in_sectors(2.0).until(1030.0)["radar"]
    assert 27.4 < until < 28.01


def test_a_mark_of_another_clock_counts_for_nothing() -> None:
    delays = told_in_sectors(0.0)
    before = delays.until(1030.0)
    delays.mark({"radar": 90_000.0, "unheard": 5.0})
    assert delays.until(1030.0) == before


def test_one_time_that_cannot_be_closes_nothing_far_ahead(tmp_path: Path) -> None:
    table = {"time": [1.0, 2.0], "sensor": ["pier", "pier"], "x": [1.0, 2.0], "y": [2.0, 3.0]}
    configuration = {
        "sensors": {"pier": {"sigma": {"x": 1.0, "y": 1.0}, "detection_probability": 0.9,
                             "clutter_density": 1e-6}},
        "motion": {"process_noise": 1.0, "max_speed": 10.0},
        "lifecycle": {"new_target_density": 1e-6},
    }  # fmt: skip
    office = Office.open(tmp_path)
    try:
        office.engine.take(1, Kind.CONFIGURE, Spec(configuration).payload())
        payload = packed_reports(pl.DataFrame(table), "udp", Facts())
        office.engine.take(2, Kind.REPORTS, payload)
        office.delays.note({"pier": [1.0, 2.0, 2, 1.0]}, 1000.0)
        assert 0.9 < office.closing(1000.1)["pier"] < 2.1
        office.delays.note({"pier": [90_000.0, 90_000.0, 1, 0.0]}, 1000.2)
        assert office.closing(1000.3)["pier"] < 8.0
    finally:
        office.close()


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
            task = asyncio.create_task(clerk._handed(payload, 1, {"pier": [1.0, 1.0, 1, 0.0]}))
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


def test_names_of_sensors_have_an_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(delaying, "MOST_SENSORS", 2)
    first = pl.DataFrame(
        {"time": [1.0, 1.0], "sensor": ["a", "b"], "x": [1.0] * 2, "y": [2.0] * 2}
    )
    other = first.with_columns(sensor=pl.Series(["b", "c"]))

    async def told() -> tuple[list[str], int, int]:
        clerk = Clerk(Office.open(tmp_path), lambda: load_configuration({}))
        messages = []
        journal = clerk._office.journal
        try:
            for table in (first, other, first):
                await clerk._handed(packed_reports(table, "udp", Facts()), 2, told_times(table))
            taken = journal.last
            try:
                await clerk.accept(Rows(other, np.arange(2), "http", Facts()))
            except InvalidInputError as err:
                messages.append(str(err))
            return messages, taken, journal.last
        finally:
            await clerk.close()

    messages, taken, last = asyncio.run(told())
    assert messages == ["column sensor: 3 sensors in all; expected at most 2"]
    # Two of reports and one that says how many were dropped; the refused ones are nowhere.
    assert taken == last == 3


def test_the_clock_does_not_go_on_for_a_service_that_gets_no_core() -> None:
    clock = Standstill()
    clock.miss(3.0)
    assert clock.clock(10.0) == 7.0
    # While it stands anyway nothing is missed twice.
    clock.begin(11.0)
    clock.miss(2.0)
    clock.end(14.0)
    assert clock.clock(15.0) == 9.0
