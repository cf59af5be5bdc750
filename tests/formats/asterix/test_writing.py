"""Tracks written as category 062 and read again."""

from datetime import UTC, datetime

import numpy as np
import polars as pl
import pytest

from trackweave.formats.asterix.decoding import AsterixDecoder
from trackweave.formats.format import Output
from trackweave.formats.registry import format_named

MIDNIGHT = datetime(2024, 5, 2, tzinfo=UTC)


def tracks(**more: object) -> pl.DataFrame:
    return pl.DataFrame(
        {
            "time": [86399.5, 86399.5, 86401.0],
            "track": [7, 8, 7],
            "status": ["tentative", "confirmed", "coasting"],
            "x": [1000.2, -2000.0, 1500.0],
            "y": [10.0, 20.0, 30.0],
            "lat": [45.0, -22.5, 45.001],
            "lon": [8.0, -179.999, 8.001],
            "vx": [100.1, -50.0, 99.9],
            "vy": [0.0, 12.3, 0.1],
            "p_x_x": [100.0, 400.0, 900.0],
            "p_x_y": [-25.0, 0.0, 36.0],
            "p_y_y": [100.0, 400.0, 1e12],
            "p_vx_vx": [4.0, 4.0, 4.0],
            "p_vy_vy": [1.0, 1.0, 1.0],
            **more,
        }
    )


def written(rows: pl.DataFrame, assignments: pl.DataFrame | None = None) -> bytes:
    writer = format_named("asterix-062", writes=True).writer
    assert writer is not None
    return writer(Output(rows, assignments=assignments))["tracks.ast"]


def read(data: bytes) -> pl.DataFrame:
    decoder = AsterixDecoder()
    table = decoder.feed(data)
    assert decoder.finish() is None
    assert decoder.skips.count == 0
    assert table is not None
    return table


def test_tracks_come_back_to_within_half_a_unit() -> None:
    rows = tracks()
    back = read(written(rows))
    assert back["time"].to_list() == rows["time"].to_list()  # through midnight
    assert back["track_number"].to_list() == [7, 8, 7]
    assert back["status"].to_list() == ["tentative", "confirmed", "coasting"]
    for name, half in (("lat", 90 / 2**25), ("lon", 90 / 2**25), ("vx", 0.125), ("vy", 0.125)):
        assert np.abs(back[name] - rows[name]).max() <= half + 1e-12


def test_dates_and_planes_and_heights_come_through_as_far_as_they_can() -> None:
    dates = [datetime(2024, 5, 1, 23, 59, 59, 500000, tzinfo=UTC)] * 2 + [MIDNIGHT]
    rows = tracks(z=[1000.0, 2000.0, 3000.0], time=dates).drop("lat", "lon")
    back = read(written(rows))
    assert back["time"].to_list() == [86399.5, 86399.5, 86400.0]
    assert back["x"].to_list() == [1000.0, -2000.0, 1500.0]
    assert np.abs(back["height_m"] - rows["z"]).max() <= 0.96


def test_names_come_from_most_of_a_tracks_reports() -> None:
    reports = pl.DataFrame(
        {
            "track": [7, 7, 7, 8, None],
            "identity": ["3c660c", "3c660c", "ffffff", "a ship", "111111"],
            "callsign": ["DLH65A", "DLH65A", None, "ö", None],
            "mode_a": ["7070", "1000", "7070", "9999", None],
        }
    )
    back = read(written(tracks(), reports))
    assert back["identity"].to_list() == ["3c660c", None, "3c660c"]
    assert back["callsign"].to_list() == ["DLH65A", None, "DLH65A"]
    assert back["mode_a"].to_list() == ["7070", None, "7070"]


def test_tracks_named_by_words_are_numbered_and_what_cannot_be_said_is_left_out() -> None:
    far = tracks(track=["a", "b", "a"], x=[1e9, 0.0, 0.0], vx=[1e6, None, 1.0])
    back = read(written(far))
    assert back["track_number"].to_list() == [1, 2, 1]
    assert back["vx"].to_list() == [None, None, 1.0]


def test_blocks_fit_into_datagrams_and_no_track_makes_no_block() -> None:
    rows = pl.concat([tracks()[:1]] * 200).with_columns(track=pl.int_range(200))
    data, place, lengths = written(rows), 0, list[int]()
    while place < len(data):
        lengths.append(int.from_bytes(data[place + 1 : place + 3], "big"))
        place += lengths[-1]
    assert len(lengths) > 5
    assert max(lengths) <= 1472
    assert written(tracks()[:0]) == b""


def test_libasterix_reads_what_is_written() -> None:
    pytest.importorskip("asterix.generated", reason="needs libasterix")
    from oracles import libasterix

    found = list[dict[str, int]]()
    for category, content in libasterix.blocks(written(tracks(ax=[1.0] * 3, ay=[-0.5] * 3))):
        records = libasterix.records(libasterix.specification(category), content)
        assert records is not None
        found += records
    first, second, third = found
    assert first["105/LAT"] == round(45.0 / (180 / 2**25))
    assert second["105/LON"] == round(-179.999 / (180 / 2**25))
    assert (first["100/X"], first["185/VX"], first["210/AX"], first["210/AY"]) == (
        2000,
        400,
        4,
        -2,
    )
    assert (first["500/APC/X"], first["500/COV"], first["500/ATV/X"]) == (20, -10, 8)
    assert third["500/APC/Y"] == 65535
    assert (first["080/CNF"], first["080/TSB"], third["080/TSB"], third["080/CST"]) == (1, 1, 0, 1)
    assert (first["290/TRK"], third["290/TRK"], third["070"]) == (0, 6, 128)
