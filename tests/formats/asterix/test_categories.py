"""Each category: records typed octet by octet from its specification, and what they say."""

import math

import pytest

from oracles.asterix_records import block, record
from trackweave.formats.asterix.cat021 import EDITIONS
from trackweave.formats.asterix.decoding import AsterixDecoder

NOON = "545e80"  # 43,197 s after midnight, of 128 parts
MILE = 1852.0


def row(data: bytes, edition: str = "2") -> dict[str, object]:
    decoder = AsterixDecoder(edition)
    table = decoder.feed(data)
    assert decoder.finish() is None
    assert decoder.skips.count == 0
    assert table is not None
    assert len(table) == 1
    return table.row(0, named=True)


def approximately(expected: dict[str, object]) -> dict[str, object]:
    return {
        name: pytest.approx(value, rel=1e-12) if isinstance(value, float) else value
        for name, value in expected.items()
    }


def test_a_plot_of_category_048() -> None:
    data = record(
        n1="19c9",  # area 25, station 201
        n2=NOON,
        n3="a8",  # Mode S roll-call
        n4="32804000",  # 50.5 miles, a quarter of a turn
        n5="4e38",  # 7070, garbled
        n6="8578",  # flight level 350, not validated
        n7="6803c4fe",  # three replies, of which SSR -60 dBm, and -2 dBm of the primary
        n8="3c660c",
        n9="10c236d41820",  # DLH65A
        n11="0deb",
        n20="8003f0",  # Doppler -16 m/s, no doubt
    )
    assert row(block(48, data)) == approximately(
        {
            "time": 43197.0,
            "sensor": "025/201",
            "range_m": 50.5 * MILE,
            "azimuth_deg": 90.0,
            "range_rate_mps": -16.0,
            "height_m": 350 * 30.48,
            "strength": -2.0,
            "identity": "3c660c",
            "callsign": "DLH65A",
            "mode_a": "7070",
            "track_number": 0xDEB,
            "detection": "mode-s-roll-call",
            "mode_a_garbled": True,
            "height_unvalidated": True,
            "category": 48,
        }
    )


def test_a_garbled_height_is_none_and_a_doubtful_doppler_too() -> None:
    plot = row(block(48, record(n1="0001", n2=NOON, n4="32804000", n6="4578", n20="808010")))
    assert "height_m" not in plot
    assert "range_rate_mps" not in plot
    assert plot["height_garbled"]


def test_a_height_that_was_measured_comes_before_mode_c() -> None:
    plot = row(block(48, record(n1="0001", n2=NOON, n4="32804000", n6="0578", n19="0064")))
    assert plot["height_m"] == pytest.approx(2500 * 0.3048)


def test_a_range_beyond_256_miles_stands_in_the_reserved_expansion() -> None:
    far = {"n1": "0001", "n2": NOON, "n3": "a140", "n4": "ffff4000"}
    plot = row(block(48, record(**far, n28="0508012000")))
    assert plot["range_m"] == pytest.approx(288 * MILE)


def test_a_plot_and_a_track_of_category_001() -> None:
    said = record(n1="0001", n4=NOON)
    plot = record(n1="19c9", n2="30", n3="19404000", n4="0e38", n5="0578", n7="5e80", n9="04")
    track = record(n1="19c9", n2="a0", n3="0102", n4="19408000", n9="5e81")
    decoder = AsterixDecoder()
    table = decoder.feed(block(2, said) + block(1, plot, track))
    assert table is not None
    first, second = table.rows(named=True)
    assert first["detection"] == "psr+ssr"
    assert first["time"] == 43197.0
    assert first["range_m"] == pytest.approx(50.5 * MILE)
    assert first["azimuth_deg"] == 90.0
    assert first["mode_a"] == "7070"
    assert first["height_m"] == pytest.approx(350 * 30.48)
    assert first["range_rate_mps"] == pytest.approx(MILE / 64)
    assert (second["track_number"], second["azimuth_deg"]) == (0x102, 180.0)
    assert second["time"] == 43197.0 + 1 / 128


def test_reports_of_category_010() -> None:
    common = {"n1": "0001", "n2": "01", "n4": NOON}
    polar = row(block(10, record(**common, n3="60", n6="06344000", n9="000cffd8")))
    assert (polar["range_m"], polar["azimuth_deg"], polar["detection"]) == (1588.0, 90.0, "psr")
    assert (polar["vx"], polar["vy"]) == (3.0, -10.0)
    plane = row(block(10, record(**common, n7="fef5000a", n13="4ca7a8")))
    assert (plane["x"], plane["y"], plane["identity"]) == (-267.0, 10.0, "4ca7a8")
    earth = row(block(10, record(**common, n5="20000000f0000000", n6="06344000", n18="0064")))
    assert (earth["lat"], earth["lon"]) == (45.0, -22.5)
    assert "range_m" not in earth
    assert earth["height_m"] == pytest.approx(625 * 0.3048)


def test_a_report_of_category_020() -> None:
    earth = record(n1="0002", n2="40", n3=NOON, n4="00800000ffc00000", n8="0e38", n12="4ca7a8")
    assert row(block(20, earth)) == approximately(
        {
            "time": 43197.0,
            "sensor": "000/002",
            "lat": 45.0,
            "lon": -22.5,
            "identity": "4ca7a8",
            "mode_a": "7070",
            "category": 20,
        }
    )
    plane = row(block(20, record(n1="0002", n3=NOON, n5="000002fffffe", n14="0064")))
    assert (plane["x"], plane["y"]) == (1.0, -1.0)
    assert plane["height_m"] == pytest.approx(625 * 0.3048)


def test_a_report_of_category_021() -> None:
    data = record(
        n1="0003", n2="00", n3="0123", n5=NOON, n6="200000f00000", n11="4ca7a8", n19="0e38",
        n21="0578", n29="10c236d41820", n38="c4",
    )  # fmt: skip
    assert row(block(21, data)) == approximately(
        {
            "time": 43197.0,
            "sensor": "000/003",
            "lat": 45.0,
            "lon": -22.5,
            "height_m": 350 * 30.48,
            "strength": -60.0,
            "identity": "4ca7a8",
            "callsign": "DLH65A",
            "mode_a": "7070",
            "track_number": 0x123,
            "category": 21,
        }
    )


def test_a_finer_position_and_a_geometric_height_come_first() -> None:
    fine = record(n1="0003", n6="200000f00000", n7="10000000f8000000", n12=NOON, n16="0064",
                  n21="0578")  # fmt: skip
    found = row(block(21, fine))
    assert (found["lat"], found["lon"]) == (45.0, -22.5)
    assert found["height_m"] == pytest.approx(625 * 0.3048)
    assert found["time"] == 43197.0


@pytest.mark.parametrize(
    ("edition", "place"), [("0.26", "00800000ffc00000"), ("0.23", "200000f00000")]
)
def test_older_editions_of_category_021_are_told(edition: str, place: str) -> None:
    assert edition in EDITIONS
    data = record(n1="0003", n2="0000", n3=NOON, n4=place, n5="4ca7a8", n6="0064")
    found = row(block(21, data), edition)
    assert (found["lat"], found["lon"], found["identity"]) == (45.0, -22.5, "4ca7a8")
    assert found["height_m"] == pytest.approx(625 * 0.3048)


def test_a_track_of_category_062() -> None:
    data = record(
        n1="1964", n4=NOON, n5="00800000ffc00000", n6="000002fffffe", n7="0004fff8",
        n9="0e38", n10="0010c236d41820", n11="803c660c", n12="0539",
        n13="01010180", n17="0578", n18="0064",
    )  # fmt: skip
    assert row(block(62, data)) == approximately(
        {
            "time": 43197.0,
            "sensor": "025/100",
            "lat": 45.0,
            "lon": -22.5,
            "height_m": 625 * 0.3048,
            "identity": "3c660c",
            "callsign": "DLH65A",
            "mode_a": "7070",
            "track_number": 1337,
            "status": "coasting",
            "vx": 1.0,
            "vy": -2.0,
            "category": 62,
        }
    )


def test_category_034_tells_where_a_radar_stands_and_how_it_turns() -> None:
    decoder = AsterixDecoder()
    place = record(n1="19c9", n2="01", n3=NOON, n5="0279", n11="030c200000f00000")
    assert decoder.feed(block(34, place)) is None
    marks = [record(n1="190c", n2="01", n3=f"{128 * moment:06x}") for moment in (8, 12, 12, 16)]
    assert decoder.feed(block(34, *marks)) is None
    decoder.finish()
    told = decoder.facts.places["025/201"]
    assert (told.latitude_deg, told.longitude_deg, told.altitude_m) == (45.0, -22.5, 780.0)
    assert decoder.facts.scan_periods == {"025/201": 633 / 128, "025/012": 4.0}


def test_sectors_tell_a_turn_too() -> None:
    decoder = AsterixDecoder()
    for turn in range(3):
        for sector in range(0, 256, 64):
            moment = round(128 * (5.0 * turn + 5.0 * sector / 256))
            decoder.feed(
                block(34, record(n1="190c", n2="02", n3=f"{moment:06x}", n4=f"{sector:02x}"))
            )
    decoder.finish()
    assert decoder.facts.scan_periods == {"025/012": 5.0}


def test_marks_are_in_the_time_of_the_reports_past_midnight_too() -> None:
    def mark(moment: float) -> bytes:
        return block(34, record(n1="190c", n2="02", n3=f"{round(128 * moment):06x}", n4="40"))

    def plot(moment: float) -> bytes:
        return block(48, record(n1="190c", n2=f"{round(128 * moment):06x}", n4="32804000"))

    decoder = AsterixDecoder()
    decoder.feed(mark(86_399.0))
    assert decoder.marks == {}  # before the first report nobody knows of which day it is
    decoder.feed(plot(86_399.25) + mark(86_399.5))
    assert decoder.marks == {"025/012": 86_399.5}
    decoder.feed(mark(0.5))
    assert decoder.marks == {"025/012": 86_400.5}
    table = decoder.feed(plot(0.75))
    assert table is not None
    assert table["time"].to_list() == [86_400.75]


def test_a_place_that_is_not_on_the_earth_is_none() -> None:
    decoder = AsterixDecoder()
    assert decoder.feed(block(62, record(n1="1964", n4=NOON, n5="0100000100000000"))) is None
    assert decoder.feed(block(62, record(n1="1964", n4=NOON, n5="0000000002000001"))) is None
    table = decoder.feed(block(62, record(n1="1964", n4=NOON, n5="0100000002000000")))
    assert table is not None
    assert table.select("lat", "lon").rows() == [(90.0, 180.0)]


def test_what_is_there_without_a_detection_or_a_place_is_counted() -> None:
    decoder = AsterixDecoder()
    coasts = record(n1="0001", n2=NOON, n3="00", n4="32804000")
    nowhere = record(n1="0001", n2=NOON, n3="a0")
    assert decoder.feed(block(48, coasts, nowhere) + block(65, b"\x80\0\1")) is None
    decoder.finish()
    assert decoder.skips.count == 0
    assert decoder.facts.sentences() == [
        "data blocks of category 065, which is not read: 1",
        "records without a position, which report nothing: 1",
        "tracks of a radar that it did not detect, which report nothing: 1",
    ]


def test_a_report_without_a_time_is_left_to_the_reader() -> None:
    decoder = AsterixDecoder()
    table = decoder.feed(block(48, record(n1="0001", n4="32804000")))
    assert table is not None
    assert table["time"].to_list() == [None]
    assert not math.isnan(table["range_m"][0])
