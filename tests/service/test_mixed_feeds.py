"""Feeds that differ: in who names sensors, in what times count from, in what comes twice."""

import re
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from service.asterix import marker, plot
from service.test_engine import rows_of
from trackweave.config import load_configuration
from trackweave.domain.facts import Facts
from trackweave.errors import DataFormatError
from trackweave.formats.asterix.decoding import AsterixDecoder
from trackweave.formats.jsonl import JsonlDecoder
from trackweave.formats.reading import read_reports
from trackweave.service.board import Board
from trackweave.service.engine import Engine
from trackweave.service.inputs.outbox import completed
from trackweave.service.learning import learned
from trackweave.service.office import Office, Order
from trackweave.service.publish import Publisher, target_of
from trackweave.service.records import Arrived, Kind, packed_reports
from trackweave.service.saying import Saying
from trackweave.service.sorting_in import checked_rows
from trackweave.service.spec import Spec

SENSOR = {"sigma": 5.0, "detection_probability": 0.9, "clutter_density": 1e-8, "scan_period": 1.0}
TOLD: dict[str, Any] = {
    "motion": {"process_noise": 1.0, "max_speed": 50.0},
    "lifecycle": {"new_target_density": 1e-9},
}
NOON = datetime(2026, 3, 5, 12, tzinfo=UTC).timestamp()


def boat(sensor: str, times: Any, y: float = 0.0) -> pl.DataFrame:
    """Return what a sensor tells of one boat."""
    time = np.asarray(times, dtype=float)
    x = 10.0 * (time - time[0]) + 3.0 * np.sin(7.0 * time)
    return pl.DataFrame(
        {"time": time, "sensor": [sensor] * time.size, "x": x, "y": y + 2.0 * np.cos(5.0 * time)}
    )


def arrived(frame: pl.DataFrame) -> Arrived:
    return Arrived(frame, "test", Facts())


def dated(frame: pl.DataFrame) -> pl.DataFrame:
    return frame.with_columns((pl.col("time") * 1e6).cast(pl.Int64).cast(pl.Datetime("us", "UTC")))


def test_what_comes_without_a_name_is_a_sensor_beside_others() -> None:
    view = {"max_range_m": 500.0}
    sensors = {"default": {**SENSOR, "field_of_view": view}, "w": SENSOR}
    found = {each.name: each for each in Spec({**TOLD, "sensors": sensors}).settings().sensors}
    assert sorted(found) == ["default", "w"]
    assert found["default"].field_of_view is not None
    assert found["w"].field_of_view is None


def test_a_sensor_heard_later_is_what_the_file_tells_of_any(tmp_path: Path) -> None:
    told = load_configuration({**TOLD, "sensors": {"default": SENSOR}})
    office, board = Office.open(tmp_path), Board()

    def take(kind: int, payload: bytes) -> None:
        sequence = office.journal.append(kind, payload)
        office.take([Order(sequence, kind, payload)], board)
        found = office.learn(told, anew=False)
        if found is not None:
            take(Kind.CONFIGURE, found.spec.payload())

    for time in range(8):
        for name in "AB"[: 1 + (time >= 4)]:
            y = 300.0 if name == "B" else 0.0
            piece = boat(name, [float(time)], y).with_columns(x=pl.lit(10.0 * time))
            take(Kind.REPORTS, packed_reports(piece, "test", Facts()))
    assert sorted(office.engine.sensors) == ["A", "B"]
    assert office.engine.counts.strange == 1
    assert office.missing == ""
    office.close()
    # Read back, the file is complete again.
    again = load_configuration(tmp_path / "tracker.toml")
    assert {"A", "B"} <= set(again.table("sensors"))


def test_whose_reports_are_of_another_kind_is_said_once(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    office, board, told = Office.open(tmp_path), Board(), load_configuration(None)
    saying = Saying(office)
    polar = pl.DataFrame({"time": [2.0], "sensor": ["A"], "range_m": [9.0], "azimuth_deg": [1.0]})
    payload = packed_reports(polar, "test", Facts())
    spec = Spec({**TOLD, "sensors": {"A": SENSOR}})
    office.take([Order(1, Kind.CONFIGURE, spec.payload())], board)
    assert saying.health("", 0.0, [], told)["message"] is None
    office.take([Order(number, Kind.REPORTS, payload) for number in (2, 3)], board)
    health = saying.health("", 0.0, [], told)
    office.close()
    assert (health["status"], health["unfit"]) == ("ok", 2)
    assert "sensor A: reports measure otherwise than those by which" in health["message"]
    assert [each.getMessage() for each in caplog.records].count("reports left out as unfit") == 1


def test_a_report_of_json_whose_time_is_null_has_that_of_receipt() -> None:
    decoder = JsonlDecoder()
    table = decoder.feed(b'{"time": null, "x": 1.0, "y": 2.0}\n{"x": 1.0, "y": 2.0}\n')
    assert table is not None
    assert completed(table)["time"].null_count() == 0
    # Pieces of damaged lines have no time either.
    assert [each.what for each in decoder.skips.listed] == [
        "no report: an object with a time, or null, and a measurement"
    ]


def test_seconds_from_1970_and_dates_are_one_axis() -> None:
    times = NOON + np.arange(0.0, 60.0)
    heard = [arrived(dated(boat("A", times))), arrived(boat("B", times + 0.4))]
    found = learned(load_configuration({**TOLD, "sensors": {"default": SENSOR}}), heard, Facts())
    assert found is not None
    assert found.spec.iso_time
    assert sorted(found.spec.configuration["sensors"]) == ["A", "B"]
    first = [float(checked_rows(each.table, found.spec).time[0]) for each in heard]
    assert first == [NOON, NOON + 0.4]


def test_seconds_of_no_date_beside_dates_are_refused() -> None:
    spec = Spec({**TOLD, "sensors": {"A": SENSOR}}, iso_time=True)
    found = checked_rows(boat("A", [29.0, 30.0, NOON]).with_columns(x=pl.lit(1.0)), spec)
    assert found.time.tolist() == [NOON]
    assert [each.message("body") for each in found.skipped] == [
        f"body, row {row}, column time: {time}; expected a date, as other reports tell, or "
        "seconds from 1970 UTC"
        for row, time in ((1, 29), (2, 30))
    ]


def test_a_radars_times_of_day_are_dated_by_when_they_come() -> None:
    decoder = AsterixDecoder()
    midnight = datetime(2026, 3, 5, tzinfo=UTC).timestamp()
    told = []
    # Its clock is ahead of ours by a second, over midnight too.
    for received in (midnight + 43_200.0, midnight + 86_399.5):
        decoder.received = received
        table = decoder.feed(plot((received + 1.0) % 86_400.0, 5e4, 30.0))
        assert table is not None
        told += table["time"].dt.epoch("ms").to_list()
    assert told == [1000 * (midnight + 43_201.0), 1000 * (midnight + 86_400.5)]
    undated = AsterixDecoder().feed(marker(36_000.0, 0.0) + plot(36_000.0, 5e4, 30.0))
    assert undated is not None
    assert undated["time"].to_list() == [36_000.0]


def test_two_files_of_which_one_tells_dates_say_so(tmp_path: Path) -> None:
    dated(boat("A", NOON + np.arange(5.0))).write_csv(tmp_path / "a.csv")
    boat("B", np.arange(5.0)).write_csv(tmp_path / "b.csv")
    with pytest.raises(DataFormatError, match=re.escape("b.csv, column time: 0, but")):
        read_reports([tmp_path / "a.csv", tmp_path / "b.csv"])
    boat("B", NOON + np.arange(5.0)).write_csv(tmp_path / "b.csv")
    both = read_reports([tmp_path / "a.csv", tmp_path / "b.csv"])
    assert both.iso_time
    assert (both.time.min(), both.time.max()) == (NOON, NOON + 4.0)


@pytest.mark.parametrize("later", [1, 3, 12])
@pytest.mark.parametrize("named", [False, True])
def test_a_copy_that_comes_scans_later_counts_once(later: int, *, named: bool) -> None:
    frame = boat("A", np.arange(25.0))
    if named:
        frame = frame.with_columns(identity=pl.lit("abc123"))
    spec = Spec({**TOLD, "sensors": {"A": SENSOR}})
    once = [(Kind.CONFIGURE, spec.payload())]
    twice = list(once)
    pieces = [packed_reports(frame[k], "test", Facts()) for k in range(frame.height)]
    for number, piece in enumerate(pieces):
        once.append((Kind.REPORTS, piece))
        twice.append((Kind.REPORTS, piece))
        if number >= later:
            twice.append((Kind.REPORTS, pieces[number - later]))
    expected, found = rows_of(once), rows_of(twice)
    assert expected["track"].n_unique() == 1
    assert found.equals(expected)


def test_what_tells_heights_is_published_in_the_air() -> None:
    frame = boat("A", np.arange(20.0)).with_columns(height_m=pl.lit(900.0))
    low = boat("A", np.arange(20.0), 5000.0).with_columns(height_m=pl.lit(None, dtype=pl.Float64))
    spec = Spec({**TOLD, "sensors": {"A": SENSOR}, "frame": {"origin": [50.0, 10.0]}})
    plane = read_reports(pl.DataFrame({"time": [0.0], "lat": [50.0], "lon": [10.0]})).frame
    engine, board = Engine(), Board()
    engine.take(1, Kind.CONFIGURE, Spec(spec.configuration, frame=plane).payload())
    for time in range(20):
        piece = pl.concat([frame[time], low[time]]).with_columns(
            lat=50.0 + pl.col("y") / 111_000.0, lon=10.0 + pl.col("x") / 71_000.0
        )
        payload = packed_reports(piece.drop("x", "y"), "test", Facts())
        engine.take(engine.sequence + 1, Kind.REPORTS, payload)
    drawn = board.draw(engine)
    assert drawn is not None
    publisher = Publisher(target_of("udp://127.0.0.1:9?format=cot"))
    publisher(drawn)
    kinds = re.findall(rb'type="(a-u-.)"', b"".join(publisher._due()))
    assert sorted(kinds) == [b"a-u-A", b"a-u-G"]
