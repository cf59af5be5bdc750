"""AIS: what a receiver's sentences become."""

from collections import Counter

import polars as pl
import pytest

from trackweave.formats.ais import AisDecoder


def decoded(data: bytes) -> tuple[pl.DataFrame, AisDecoder]:
    decoder = AisDecoder()
    frames = [frame for frame in (decoder.feed(data), decoder.finish()) if frame is not None]
    return pl.concat(frames, how="diagonal_relaxed") if frames else pl.DataFrame(), decoder


def with_sum(body: str) -> str:
    total = 0
    for byte in body.encode():
        total ^= byte
    return f"!{body}*{total:02X}\n"


SHIP = "AIVDM,1,1,,B,15NBj>PP1gG>1PVKTDTUJOv00<0M,0"


def test_each_way_of_telling_the_time_of_receipt_is_understood():
    lines = [
        "\\s:r1,c:1609841515*46\\" + with_sum(SHIP),
        "\\c:1609841516000,s:r2*46\\" + with_sum(SHIP),
        "$PGHP,1,2021,1,5,10,11,57,250,338,2,,1,09*17\n" + with_sum(SHIP),
        "1609841518 " + with_sum(SHIP),
        "2021-01-05 10:11:59.5 " + with_sum(SHIP),
        with_sum(SHIP).strip() + ",r003669945,1609841520\n",
        with_sum(SHIP),
        "1609841521500 " + with_sum(SHIP),
        with_sum(SHIP).strip() + ",1609841522500\n",
    ]
    found, _ = decoded("".join(lines).encode())
    seconds = (found["time"].dt.epoch("ms") / 1e3 - 1609841500).to_list()
    assert seconds == [15.0, 16.0, 17.25, 18.0, 19.5, 20.0, None, 21.5, 22.5]
    assert found["station"].to_list() == ["r1", "r2", *[None] * 7]


def test_a_time_that_no_calendar_has_is_none():
    text = "\\c:16098415150000000000*46\\" + with_sum(SHIP) + "1609841518 " + with_sum(SHIP)
    found, _ = decoded(text.encode())
    assert found["time"].is_null().to_list() == [True, False]


def test_a_time_in_digits_of_another_script_is_none():
    text = f"\\c:７٣*46\\{with_sum(SHIP)}１600000000 {with_sum(SHIP)}1609841518 {with_sum(SHIP)}"
    found, _ = decoded(text.encode())
    assert found["time"].is_null().to_list() == [True, True, False]


def test_a_message_of_two_sentences_has_the_time_of_its_first():
    # Message 19 (class B, extended): its payload, cut in two.
    whole = "C5N3SRgPEnJGEBT>NhWAwwo862PaLELTBJ:V00000000S0D:R220"
    lines = [
        "\\c:100000000*00\\" + with_sum(f"AIVDM,2,1,7,A,{whole[:20]},0"),
        "\\c:200000000*00\\" + with_sum(f"AIVDM,2,2,7,A,{whole[20:]},0"),
    ]
    found, decoder = decoded("".join(lines).encode())
    assert found["message"].to_list() == [19]
    assert found["time"].dt.epoch("s").to_list() == [100000000]
    assert decoder.skips.count == 0


def test_parts_that_never_come_are_told():
    _, decoder = decoded(("x\n" + with_sum("AIVDM,2,1,7,A,C5N3SRgPEnJGEBT>NhWA,0")).encode())
    assert [(skip.offset, "missing" in skip.what) for skip in decoder.skips.listed] == [(2, True)]


def test_a_position_that_the_ship_does_not_know_is_the_code_for_it():
    fields = [(1, 6), (0, 2), (366967295, 30), (0, 23), (181 * 600_000, 28), (91 * 600_000, 27),
              (3600, 12), (511, 9), (60, 6), (0, 25)]  # fmt: skip
    bits = "".join(f"{value:0{size}b}" for value, size in fields)
    sixes = [int(bits[place : place + 6], 2) for place in range(0, len(bits), 6)]
    payload = "".join(chr(six + (48 if six < 40 else 56)) for six in sixes)
    found, _ = decoded(with_sum(f"AIVDM,1,1,,A,{payload},0").encode())
    assert len(found) == 1
    assert found.select("lat", "lon").row(0) == (91.0, 181.0)


@pytest.mark.shared
@pytest.mark.parametrize("name", ["tests/nmea_data_sample.txt", "examples/gatehouse.nmea"])
def test_positions_are_those_of_pyais(shared, name):
    pyais = pytest.importorskip("pyais")
    path = shared / "data" / "ais_pyais" / name
    ours, _ = decoded(path.read_bytes())
    theirs = []
    with pyais.FileReaderStream(str(path)) as sentences:
        for sentence in sentences:
            try:
                message = sentence.decode()
            except pyais.exceptions.AISBaseException:
                continue
            if message.msg_type in {1, 2, 3, 9, 18, 19, 27}:
                theirs.append((f"{int(message.mmsi):09d}", message.lat, message.lon))
    rows = ours.select("identity", "lat", "lon").rows()
    assert Counter((who, round(lat, 5), round(lon, 5)) for who, lat, lon in rows) == Counter(
        (who, round(lat, 5), round(lon, 5)) for who, lat, lon in theirs
    )
