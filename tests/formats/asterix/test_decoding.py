"""Data blocks in all that they come in, split anywhere, and damaged."""

from collections.abc import Callable, Iterable
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from polars.testing import assert_frame_equal

from oracles.asterix_records import (
    block,
    ethernet,
    final,
    pcap,
    pcapng,
    random_record,
    record,
    udp,
)
from trackweave.formats.asterix import FORMAT
from trackweave.formats.asterix.decoding import AsterixDecoder, categories_of, is_asterix
from trackweave.formats.format import HEAD_BYTES
from trackweave.formats.registry import recognised

DAY_S = 86_400.0
# 2024-05-01, an hour after midnight.
CLOCK = datetime(2024, 5, 1, 1, tzinfo=UTC).timestamp()


def plot(time: float = 3600.0, station: int = 1, mile: int = 50) -> bytes:
    return record(
        n1=f"00{station:02x}", n2=f"{round(time * 128):06x}", n3="a0", n4=f"{mile:02x}804000"
    )


def decoded(pieces: Iterable[bytes], edition: str = "2") -> tuple[pl.DataFrame, AsterixDecoder]:
    decoder = AsterixDecoder(edition)
    tables = [decoder.feed(piece) for piece in pieces] + [decoder.finish()]
    found = [table for table in tables if table is not None]
    return pl.concat(found, how="diagonal") if found else pl.DataFrame(), decoder


def split(data: bytes, rng: np.random.Generator, count: int = 20) -> list[bytes]:
    cuts = np.sort(rng.integers(0, len(data) + 1, count)).tolist()
    return [data[a:b] for a, b in zip([0, *cuts], [*cuts, len(data)], strict=True)]


WRAPPED: dict[str, Callable[[list[bytes]], bytes]] = {
    "blocks": b"".join,
    "final": lambda blocks: final(*blocks),
    "pcap": lambda blocks: pcap(*((CLOCK, ethernet(udp(each))) for each in blocks)),
    "pcap of a big-endian machine": lambda blocks: pcap(
        *((CLOCK, ethernet(udp(each))) for each in blocks), order=">"
    ),
    "virtual network": lambda blocks: pcap(
        *((CLOCK, ethernet(udp(each), tags=2)) for each in blocks)
    ),
    "cooked": lambda blocks: pcap(
        *((CLOCK, bytes(14) + b"\x08\0" + udp(each)) for each in blocks), link=113
    ),
    "cooked anew": lambda blocks: pcap(
        *((CLOCK, b"\x08\0" + bytes(18) + udp(each)) for each in blocks), link=276
    ),
    "IP alone": lambda blocks: pcap(*((CLOCK, udp(each)) for each in blocks), link=101),
    "loopback": lambda blocks: pcap(
        *((CLOCK, b"\2\0\0\0" + udp(each)) for each in blocks), link=0
    ),
    "pcapng": lambda blocks: pcapng(*((CLOCK, ethernet(udp(each))) for each in blocks)),
    "pcapng of a big-endian machine": lambda blocks: pcapng(
        *((CLOCK, ethernet(udp(each))) for each in blocks), order=">"
    ),
    "six octets before each block": lambda blocks: pcap(
        (CLOCK, ethernet(udp(b"".join((len(b) + 6).to_bytes(2, "big") + b"\2\xbb@5" + b
                                      for b in blocks)))),
    ),
    "no network": lambda blocks: pcap(
        *((CLOCK, ethernet(b"\xaa\xaa\3" + each, kind=3 + len(each))) for each in blocks)
    ),
}  # fmt: skip


@pytest.mark.parametrize("way", WRAPPED)
def test_blocks_are_found_in_all_that_they_come_in(way: str) -> None:
    blocks = [block(48, plot(mile=mile), plot(mile=mile + 1)) for mile in range(0, 80, 2)]
    data = WRAPPED[way](blocks)
    whole, decoder = decoded([data])
    assert [round(each / 1852 - 0.5) for each in whole["range_m"]] == list(range(80))
    assert decoder.skips.count == 0
    moment = 3600.0 if way in ("blocks", "final") else datetime(2024, 5, 1, 1, tzinfo=UTC)
    assert whole["time"].unique().to_list() == [moment]
    in_pieces, _ = decoded(split(data, np.random.default_rng(3)))
    assert_frame_equal(in_pieces, whole)
    assert is_asterix(data, "")
    found = recognised(data[:65536], "recording")
    assert found is not None
    assert found.name == FORMAT.name


def test_ipv6_is_read_and_fragments_are_counted() -> None:
    datagram = udp(block(48, plot()))[20:]
    fixed = b"\x60\0\0\0" + len(datagram).to_bytes(2, "big") + b"\x11\x40" + bytes(32)
    fragment = b"\x60\0\0\0" + len(datagram).to_bytes(2, "big") + b"\x2c\x40" + bytes(32)
    in_4 = bytearray(udp(block(48, plot())))
    in_4[6] = 0x20
    packets = [ethernet(fixed + datagram, 0x86DD), ethernet(fragment + datagram, 0x86DD),
               ethernet(bytes(in_4)), ethernet(b"\0" * 30, 0x0806)]  # fmt: skip
    table, decoder = decoded([pcap(*((CLOCK, packet) for packet in packets))])
    assert len(table) == 1
    assert [each.what for each in decoder.skips.listed] == ["a fragment of an IP packet"] * 2
    assert decoder.facts.sentences() == ["packets of other protocols than UDP: 1"]


@pytest.mark.parametrize("link", [0, 1, 101, 113, 276])
@pytest.mark.parametrize("kept", [0, 3, 15, 21, 30, 50])
def test_nothing_is_read_behind_a_packet_that_is_cut_off(link: int, kept: int) -> None:
    whole = {0: b"\2\0\0\0", 1: bytes(12) + b"\x08\0", 101: b"", 113: bytes(14) + b"\x08\0",
             276: b"\x08\0" + bytes(18)}[link] + udp(block(48, plot(), plot()))  # fmt: skip
    alone = AsterixDecoder()
    alone.feed(pcap((CLOCK, whole[:kept]), link=link))
    behind = AsterixDecoder()
    behind.feed(pcap((CLOCK, whole[:kept]), link=link) + whole[kept:])
    assert alone.skips.listed == behind.skips.listed[:1]
    assert alone.skips.listed[0].what == "a packet that is cut off"


def test_what_is_no_asterix_in_a_capture_is_counted() -> None:
    packets = [
        ethernet(udp(b"\xde\xad\xbe\xef of another program")),
        ethernet(udp(block(48, plot()))),
    ]
    table, decoder = decoded([pcap(*((CLOCK, packet) for packet in packets))])
    assert (len(table), decoder.skips.count) == (1, 0)
    assert decoder.facts.sentences() == ["datagrams that are no ASTERIX: 1"]


def test_times_go_on_over_midnight() -> None:
    moments = [DAY_S - 10, DAY_S - 1, 1.0, DAY_S - 0.5, 5.0, 40_000.0, 70_000.0, DAY_S - 1, 2.0]
    table, _ = decoded([block(48, plot(moment)) for moment in moments])
    days = [0, 0, 1, 0, 1, 1, 1, 1, 2]
    assert table["time"].to_list() == [m + d * DAY_S for m, d in zip(moments, days, strict=True)]


def test_a_captures_clock_gives_the_day() -> None:
    midnight = datetime(2024, 5, 2, tzinfo=UTC).timestamp()
    late, early = plot(DAY_S - 1), plot(1.0)
    packets = [(midnight + 0.5, late), (midnight - 0.5, early), (midnight + 3, early)]
    table, _ = decoded([pcap(*((at, ethernet(udp(block(48, p)))) for at, p in packets))])
    assert [each.isoformat() for each in table["time"]] == [
        "2024-05-01T23:59:59+00:00", "2024-05-02T00:00:01+00:00", "2024-05-02T00:00:01+00:00",
    ]  # fmt: skip


def test_short_times_of_category_001_go_on_from_category_002() -> None:
    def short(time: float) -> bytes:
        return block(1, record(n1="0001", n3="19404000", n7=f"{round(time * 128) % 65536:04x}"))

    said = block(2, record(n1="0001", n4=f"{7000 * 128:06x}"))
    untimed = block(1, record(n1="0001", n3="19404000"))
    data = said + short(6999.5) + short(7000.25) + untimed + short(7200.0)
    for pieces in ([data], [bytes([octet]) for octet in data]):
        assert decoded(pieces)[0]["time"].to_list() == [6999.5, 7000.25, 7000.25, 7200.0]
    blind = b"".join(short(time) for time in (500.0, 511.0, 513.0))
    assert decoded([blind])[0]["time"].to_list() == [500.0, 511.0, 513.0]


def test_a_damaged_record_costs_no_other_block() -> None:
    blocks = [block(48, plot(mile=mile), plot(mile=mile + 1)) for mile in range(0, 20, 2)]
    bad = bytearray(b"".join(blocks))
    second = len(blocks[0]) + 3
    bad[second : second + 5] = b"\xff" * 5  # announces more items than there are
    table, decoder = decoded([bytes(bad)])
    assert len(table) == 18
    assert decoder.skips.count == 1
    assert decoder.skips.listed[0].offset == second
    assert decoder.skips.listed[0].what.startswith("category 048")


@pytest.mark.parametrize("length", [1, 7, 200, 65535])
def test_a_wrong_length_and_noise_between_cost_what_they_touch(length: int) -> None:
    blocks = [block(48, plot(mile=mile), plot(mile=mile + 1)) for mile in range(0, 60, 2)]
    wrong = bytes([48]) + length.to_bytes(2, "big") + blocks[10][3:]
    noise = b"\x00\xff\x07noise\xff\xfe\x00"
    data = b"".join([*blocks[:10], wrong, *blocks[11:20], noise, *blocks[20:]])
    table, decoder = decoded([data])
    assert len(table) >= (40 if length == 200 else 54)
    assert 1 <= decoder.skips.count <= 5
    in_pieces, again = decoded([bytes([octet]) for octet in data])
    assert_frame_equal(in_pieces, table, check_column_order=False)
    assert again.skips == decoder.skips


def test_a_file_that_is_cut_off_says_so() -> None:
    data = block(48, plot(), plot())
    table, decoder = decoded([data + data[:20]])
    assert len(table) == 2
    assert [(each.offset, each.what) for each in decoder.skips.listed] == [
        (len(data), "data block that is cut off")
    ]


def test_an_older_edition_of_category_021_is_asked_for() -> None:
    old = random_record(categories_of("0.26")[21].layouts[0], np.random.default_rng(1), 0.9)
    _, decoder = decoded([block(21, old)])
    assert "edition_021" in decoder.skips.listed[0].what
    assert is_asterix(block(21, old), "")


@pytest.mark.parametrize("way", ["blocks", "pcap", "pcapng", "final"])
def test_damaged_and_split_input_is_never_an_error(way: str) -> None:
    rng = np.random.default_rng(11)
    layouts = [(n, each.layouts[0]) for n, each in categories_of().items()]
    blocks = []
    for number, layout in layouts * 4:
        blocks.append(block(number, *(random_record(layout, rng) for _ in range(3))))
    good = WRAPPED[way](blocks)
    for _ in range(12):
        data = bytearray(good)
        for _ in range(int(rng.integers(1, 12))):
            match rng.integers(3):
                case 0:
                    data[rng.integers(len(data))] = rng.integers(256)
                case 1:
                    at = int(rng.integers(len(data)))
                    del data[at : at + int(rng.integers(1, 40))]
                case _:
                    at = int(rng.integers(len(data)))
                    data[at:at] = rng.bytes(int(rng.integers(1, 40)))
        whole, first = decoded([bytes(data)])
        pieces, second = decoded(split(bytes(data), rng))
        assert first.skips == second.skips
        assert first.n_records == second.n_records
        if first.n_records:
            assert_frame_equal(pieces, whole, check_column_order=False)


@pytest.mark.parametrize(
    "text", ["0,1,2\n0,3,4\n" * 50, "time,x,y\n1,2,3\n", "!AIVDM,1,1\n", "\x01\n", ""]
)
def test_other_files_are_not_taken_for_it(text: str) -> None:
    assert not is_asterix(text.encode(), "recording.raw")


@pytest.mark.shared
def test_a_real_feed_of_seven_radars(shared: Path) -> None:
    content = (shared / "data/asterix/cat_034_048.pcap").read_bytes()
    table, decoder = decoded([content])
    assert decoder.skips.count == 0
    assert decoder.n_records == 162
    assert (len(table), table["sensor"].n_unique()) == (126, 7)
    assert table.unique().height == 63  # each was captured twice
    assert table["azimuth_deg"].is_between(0.0, 360.0).all()
    assert [each.date().isoformat() for each in table["time"].unique()][:1] == ["2016-05-05"]
    place = decoder.facts.places["025/012"]
    assert (round(place.latitude_deg, 4), round(place.longitude_deg, 4)) == (43.571, 16.4061)
    assert decoder.facts.scan_periods["025/012"] == pytest.approx(4.945, abs=1e-3)
    last = table.filter(pl.col("sensor") == "025/012")["time"].max()
    assert 0.0 < decoder.marks["025/012"] - last.timestamp() < 5.0


@pytest.mark.shared
@pytest.mark.parametrize(
    "name",
    ["ais_pyais", "ap3", "autoferry", "cell_btrack", "kitti", "mot_tud_campus", "opensky",
     "radar_bcn"],
)  # fmt: skip
def test_no_other_recording_is_taken_for_it(shared: Path, name: str) -> None:
    for path in (shared / "data" / name).rglob("*.*"):
        if path.is_file():
            with path.open("rb") as file:
                assert not is_asterix(file.read(65536), path.name), path


@pytest.mark.parametrize("number", [4, 19, 30, 63, 247])
def test_a_file_of_categories_that_are_not_read_is_asterix_all_the_same(number: int) -> None:
    blocks = block(number, b"\x80\0\1") + block(number, b"\x80\0\1\2")
    assert is_asterix(blocks, "x.dat")
    assert is_asterix((blocks * 10_000)[:HEAD_BYTES], "x.dat")
    assert not is_asterix(blocks[:-1], "x.dat")
    assert not is_asterix(blocks + b"\0", "x.dat")


def test_octets_at_random_behind_a_category_are_no_asterix() -> None:
    rng = np.random.default_rng(2)
    for size in (1, 3, 4, 300, 3000):
        for _ in range(300):
            assert not is_asterix(b"\4" + rng.bytes(size), "x.dat")


def test_records_of_021_without_any_place_hint_at_another_edition() -> None:
    nowhere = block(21, b"\x80\0\1")
    _, decoder = decoded([nowhere, nowhere])
    (note,) = decoder.facts.notes
    assert "edition_021 may be another (--from 'asterix?edition_021=0.26'; 2, 0.26" in note
    placed = block(21, b"\x84\0\1" + b"\x10\0\0" * 2)
    table, decoder = decoded([nowhere, placed, nowhere])
    assert len(table) == 1
    assert decoder.facts.notes == []
