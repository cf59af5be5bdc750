"""From a capture to tracks, with nothing told."""

import json
import math
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from cli.conftest import Run, run  # noqa: F401 the fixture
from oracles.asterix_records import block, ethernet, pcap, record, udp

CLOCK = 1_714_500_000.0
TURN_S, HEIGHT_M = 4.0, 9000.0
PLACE = (45.0, 9.0)


def capture(*, with_place: bool) -> bytes:
    """Return what a radar sends of three aircraft that fly straight."""
    packets = []
    for turn in range(20):
        north = CLOCK + TURN_S * turn
        place = f"0064{round(45 * 2**23 / 180):06x}{round(9 * 2**23 / 180):06x}"
        more = {"n11": place} if with_place else {}
        packets.append((north, block(34, record(n1="19c9", n2="01", n3=of_day(north), **more))))
        for number in range(3):
            east, up_north = where(number, TURN_S * turn)
            azimuth = math.degrees(math.atan2(east, up_north)) % 360
            moment = north + TURN_S * azimuth / 360
            slant = math.hypot(east, up_north, HEIGHT_M)
            polar = f"{round(slant / 1852 * 256):04x}{round(azimuth / 360 * 65536) % 65536:04x}"
            plot = record(n1="19c9", n2=of_day(moment), n3="a0", n4=polar,
                          n6=f"{round(HEIGHT_M / 7.62):04x}", n8=f"3c660{number}")  # fmt: skip
            packets.append((moment, block(48, plot)))
    return pcap(*((moment, ethernet(udp(each))) for moment, each in sorted(packets)))


def of_day(moment: float) -> str:
    return f"{round(moment % 86400 * 128):06x}"


def where(number: int, time: float) -> tuple[float, float]:
    return 20_000 + 15_000 * number - 150 * time, 30_000 - 20_000 * number + 100 * time


def test_a_radar_that_says_where_it_stands_needs_no_configuration(
    run: Run,  # noqa: F811
    tmp_path: Path,
) -> None:
    recording = tmp_path / "recorded.pcap"
    recording.write_bytes(capture(with_place=True))
    out = tmp_path / "out"
    done = run("track", recording, "--out", out, "--also", "asterix-062,geojson")
    assert done.exit_code == 0, done.output
    tracks = pl.read_csv(out / "tracks.csv", try_parse_dates=True)
    last = tracks.filter(pl.col("time") == pl.col("time").max())
    assert len(last) == 3
    seconds = last["time"].dt.epoch("us")[0] / 1e6 - CLOCK
    frame = json.loads((out / "run.json").read_text())
    assert frame["configuration"]["sensors"]["025/201"]["scan_period"] == pytest.approx(TURN_S)
    for number in range(3):
        east, north = where(number, seconds)
        off_east = (last["lon"] - PLACE[1]) * 111_320 * math.cos(math.radians(45.1)) - east
        off_north = (last["lat"] - PLACE[0]) * 111_132 - north
        assert np.hypot(off_east, off_north).min() < 700.0
    back = tw.read_reports(out / "tracks.ast")
    assert len(back.time) == len(tracks)


def test_a_radar_whose_place_nobody_says_is_asked_for(
    run: Run,  # noqa: F811
    tmp_path: Path,
) -> None:
    recording = tmp_path / "recorded.pcap"
    both = capture(with_place=True), capture(with_place=False).replace(b"\x19\xc9", b"\x19\xca")
    recording.write_bytes(both[0] + both[1][24:])
    done = run("track", recording, "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert "sensors.025/202.position" in done.output
    assert "where the sensor stands" in done.output
    assert '[sensors."025/202"] a line such as position = ' in done.output
