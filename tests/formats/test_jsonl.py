"""JSON lines: numbers keep their kind, and names are texts."""

import polars as pl

from trackweave.cli.convert import run_convert
from trackweave.cli.edge import Voice
from trackweave.formats.jsonl import JsonlDecoder
from trackweave.formats.reading import load


def decoded(*lines: str) -> pl.DataFrame:
    found = JsonlDecoder().feed("\n".join(lines).encode())
    assert found is not None
    return found


def test_whole_numbers_stay_whole_and_names_are_texts():
    table = decoded(
        '{"time": 0, "x": 1, "y": 2, "sensor": 1, "identity": 211000001, "track": 7}',
        '{"time": 1, "x": 1, "y": 2, "sensor": 1, "identity": "211000001", "track": 8}',
    )
    assert table["sensor"].to_list() == ["1", "1"]
    assert table["identity"].to_list() == ["211000001", "211000001"]
    assert table["track"].to_list() == [7, 8]
    assert table["track"].dtype == pl.Int64
    assert table["time"].dtype == pl.Float64


def test_identifiers_of_many_digits_stay_apart():
    line = '{{"time": 0, "x": 1, "y": 2, "report": {0}, "number": {0}}}'
    table = decoded(line.format(9007199254740993), line.format(9007199254740992))
    assert table["report"].to_list() == ["9007199254740993", "9007199254740992"]
    assert table["number"].to_list() == [9007199254740993, 9007199254740992]


def test_a_column_that_begins_with_whole_numbers_may_go_on_with_others():
    line = '{{"time": 0, "x": 1, "y": 2, "speed": {}}}'
    decoder = JsonlDecoder()
    first = decoder.feed("\n".join(map(line.format, (3, 4.5, 10**30))).encode())
    later = decoder.feed(line.format(6).encode())
    assert first is not None
    assert later is not None
    assert first["speed"].to_list() == [3.0, 4.5, 1e30]
    assert later["speed"].to_list() == [6.0]


def test_reports_become_lines_and_come_back(tmp_path):
    text = "time,sensor,x,y,identity,target\n0.0,1,1.5,2.0,211000001,5\n1.0,1,1.5,2.5,,\n"
    (tmp_path / "reports.csv").write_text(text)
    voice = Voice(quiet=True)
    run_convert(voice, tmp_path / "reports.csv", tmp_path / "lines.jsonl")
    run_convert(voice, tmp_path / "lines.jsonl", tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text() == text
    assert len(load(tmp_path / "lines.jsonl")) == 2
