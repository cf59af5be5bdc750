"""JSON lines: numbers keep their kind, and names are texts."""

import polars as pl
import pytest

from trackweave.cli.convert import run_convert
from trackweave.cli.edge import Voice
from trackweave.formats.jsonl import JsonlDecoder
from trackweave.formats.reading import load
from trackweave.formats.readsb import ReadsbDecoder


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


LINE = '{{"time": {0}, "x": {0}.5, "y": 3.25, "sensor": "a", "more": {{"b": [1, 2]}}}}'
CUTS = ["}}", "]}}", '"b": [1, 2]}}', '{"b": [1, 2]}}', '": {"b": [1, 2]}}']


def damaged(line: str) -> list[str]:
    """Return a line with each of its marks left out or told twice, and cut off in places."""
    marks = [k for k, letter in enumerate(line) if letter in '{}[]":,']
    lost = [line[:k] + line[k + 1 :] for k in marks]
    twice = [line[:k] + line[k] + line[k:] for k in marks]
    return [*lost, *twice, *(line.removesuffix(end) for end in CUTS), line + '"', "nonsense", "]"]


@pytest.mark.parametrize("neighbours", [1, 2, 3])
def test_whatever_is_wrong_with_lines_the_next_is_read_and_each_is_told(neighbours):
    good = LINE.format(1)
    for wrong in damaged(good):
        lines = [LINE.format(k) for k in range(10)]
        lines[5 : 5 + neighbours] = [wrong] * neighbours
        decoder, count = JsonlDecoder(), 0
        for number, line in enumerate(lines):
            found = decoder.feed(f"{line}\n".encode())
            count += 0 if found is None else len(found)
            if number > 5 + neighbours:  # at once, not when the stream ends
                assert count >= number + 1 - neighbours, wrong
        decoder.finish()
        assert count >= 10 - neighbours, wrong
        # One without a comma, or with a mark within a text, may still be a report.
        assert count + decoder.skips.count >= 10, (wrong, decoder.skips.listed)


def test_a_line_without_its_end_costs_itself_alone():
    lines = [LINE.format(k) for k in range(2000)]
    lines[5] = lines[5].removesuffix("}")
    lines[9] = lines[9].replace('"a"', 'a"')
    decoder = JsonlDecoder()
    found = decoder.feed("\n".join(lines).encode())
    decoder.finish()
    assert found is not None
    assert found["time"].to_list() == [k for k in range(2000) if k not in (5, 9)]
    ends = [sum(len(line) + 1 for line in lines[:k]) for k in (5, 9)]
    assert [(each.offset, each.what) for each in decoder.skips.listed] == [
        (end, "no JSON") for end in ends
    ]


def test_an_object_may_still_take_several_lines():
    found = JsonlDecoder().feed(
        b'{\n  "time": 1,\n  "x": 2,\n  "more": {\n    "b": [\n 1]\n  },\n  "y": 3\n}\n'
        b'{"time": 2, "x": 3, "y": 4}{"time": 3, "x": 3, "y": 4}'
    )
    assert found is not None
    assert found["time"].to_list() == [1.0, 2.0, 3.0]


def test_an_aircraft_without_its_end_costs_itself_alone():
    line = '{{"now": {}, "hex": "4ca2d6", "lat": 51.{}, "lon": 1.0, "flight": "A"}}'
    lines = [line.format(k, k) for k in range(100)]
    lines[3] = lines[3].removesuffix("}")
    lines[7] = lines[7].removesuffix('"}')
    decoder = ReadsbDecoder()
    found = decoder.feed("\n".join(lines).encode())
    assert found is not None
    assert len(found) == 98
    assert decoder.skips.count == 2
