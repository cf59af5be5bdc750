"""Every record is a report, a counted skip, or counted among what is no report by its nature."""

import numpy as np
import polars as pl
import pytest

from formats.samples import AIRCRAFT, KITTI_LABELS, MOT, NMEA, SBS, STATE_TABLE, STATES
from trackweave.errors import DataFormatError
from trackweave.formats.format import Decoder
from trackweave.formats.reading import chosen, load


def decoded(told: str, data: bytes) -> tuple[Decoder, pl.DataFrame]:
    found, settings = chosen(told)
    assert found.decoder is not None
    decoder = found.decoder(**settings)
    frames = [each for each in (decoder.feed(data), decoder.finish()) if each is not None]
    return decoder, pl.concat(frames, how="diagonal_relaxed") if frames else pl.DataFrame()


def test_results_with_a_confidence_of_minus_one_are_reports():
    # The example that MOTChallenge gives of a file of results.
    text = (
        b"1, 3, 794.27, 247.59, 71.245, 174.88, -1, -1, -1, -1\n"
        b"1, 6, 1648.1, 119.61, 66.504, 163.24, -1, -1, -1, -1\n"
        b"2, 3, 796.0, 247.59, 71.245, 174.88, 0.25, -1, -1, -1\n"
    )
    decoder, table = decoded("mot", text)
    assert table["target"].to_list() == [3, 6, 3]
    assert table["strength"].to_list() == [None, None, 0.25]
    assert decoder.facts.left_out == {}
    assert "strength" not in decoded("mot", text[:110])[1].columns


def test_a_detection_may_have_any_confidence():
    _, table = decoded("mot", b"1,-1,1,2,3,4,-1,-1,-1,-1\n1,-1,5,2,3,4,0,-1,-1,-1\n")
    assert table["strength"].to_list() == [-1.0, 0.0]


def test_boxes_that_are_not_to_be_judged_are_counted():
    text = b"1,1,9,2,3,4,1,1,0.9\n1,2,5,2,3,4,0,8,1\n2,2,5,2,3,4,0,8,1\n"
    decoder, table = decoded("mot", text)
    assert len(table) == 1
    assert list(decoder.facts.left_out.values()) == [2]


@pytest.mark.parametrize(
    ("told", "data", "counts"),
    [
        ("kitti", KITTI_LABELS, {"regions DontCare, which are no objects": 1}),
        (
            "kitti?kind=Van",
            KITTI_LABELS,
            {"regions DontCare, which are no objects": 1, "objects of other kinds than Van": 1},
        ),
        ("sbs", SBS, {"messages without a position, which report nothing": 1}),
        ("readsb", AIRCRAFT, {"aircraft without a position, which report nothing": 1}),
        ("opensky", STATES, {"states without a position, which report nothing": 1}),
        ("opensky", STATE_TABLE, {"states without a position, which report nothing": 1}),
        ("ais", NMEA, {"lines without an AIS sentence": 1}),
        ("mot", MOT, {}),
    ],
)
def test_what_is_no_report_by_its_nature_is_counted(told, data, counts):
    assert decoded(told, data)[0].facts.left_out == counts


def test_a_position_that_the_next_snapshot_repeats_is_counted():
    twice = AIRCRAFT + AIRCRAFT
    decoder, table = decoded("readsb", twice)
    assert len(table) == 2
    assert decoder.facts.left_out["positions that the snapshot before had told"] == 2


MESSAGE = SBS.split(b"\n")[0].rstrip(b"\r")


@pytest.mark.parametrize(
    "line",
    [MESSAGE.replace(b"MSG,3", b"MSG,z"), MESSAGE[:60], MESSAGE[:70],
     MESSAGE.replace(b"51.45735", b"x").replace(b"-1.02826", b"y")],
)  # fmt: skip
def test_a_damaged_message_of_an_aircraft_is_skipped(line):
    decoder, table = decoded("sbs", line + b"\n" + MESSAGE + b"\n")
    assert (len(table), decoder.skips.count) == (1, 1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "data", "keep"),
    [("sbs", (MESSAGE + b"\n") * 20, 0), ("opensky", b"\n".join(
        [STATE_TABLE.split(b"\n")[0], *[STATE_TABLE.split(b"\n")[1]] * 20, b""]), 1),
     ("mot", b"".join(b"%d,%d,5.5,6.5,7,8,0.5,-1,-1,-1\n" % (k, k) for k in range(1, 21)), 0),
     ("kitti", KITTI_LABELS.split(b"\n")[1].join([b"", *[b"\n"] * 20]), 0)],
)  # fmt: skip
def test_each_line_is_a_report_or_counted_whatever_becomes_of_one(name, data, keep):
    rng = np.random.default_rng(7)
    letters = b'0123456789.-,abczXnaif "{}[]:\\\x00\xff\t '
    for _ in range(400):
        lines = data.split(b"\n")
        number = int(rng.integers(keep, keep + 20))
        line = bytearray(lines[number])
        for _ in range(int(rng.choice([1, 3, 10]))):
            place = int(rng.integers(len(line)))
            new = [rng.choice(list(letters))] * int(rng.integers(3))
            line[place : place + int(rng.choice([0, 1, 5]))] = bytes(map(int, new))
            if not line:
                break
        lines[number] = bytes(line)
        decoder, table = decoded(name, b"\n".join(lines))
        counted = decoder.skips.count + sum(decoder.facts.left_out.values())
        assert len(table) + counted >= 20 - (not line.strip()), bytes(line)


def test_a_note_says_what_was_left_out(tmp_path):
    path = tmp_path / "labels.txt"
    path.write_bytes(KITTI_LABELS)
    assert "regions DontCare, which are no objects: 1" in load(path).notes
    path.write_bytes(b"1,2,5,2,3,4,0,8,1\n" * 3)
    with pytest.raises(DataFormatError, match=r"not to be judged: 3\)"):
        load(path)


def test_a_table_of_opensky_may_have_every_cell_quoted():
    lines = STATE_TABLE.decode().splitlines()
    quoted = "\n".join(",".join(f'"{cell}"' for cell in line.split(",")) for line in lines)
    decoder, found = decoded("opensky", quoted.encode())
    other, plain = decoded("opensky", STATE_TABLE)
    assert found.equals(plain)
    assert decoder.skips.count == other.skips.count
