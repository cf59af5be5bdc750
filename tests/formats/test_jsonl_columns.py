"""Columns of JSON lines are those of reports."""

from trackweave.formats.jsonl import JsonlDecoder


def test_what_is_no_report_makes_no_column():
    good, bad = b'{"time": 1, "x": 2, "y": 3}\n', b'{"time": 1, "odd": 4, "x": "no", "y": 3}\n'
    for pieces in ([good + bad], [good, bad]):
        decoder = JsonlDecoder()
        frames = [decoder.feed(piece) for piece in pieces]
        assert frames[0] is not None
        assert frames[0].columns == ["time", "x", "y"]
        assert decoder.skips.count == 1
