"""Programs that users have, as clients of the real service; what is not here is left out."""

import json
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from service.serving import PATIENCE_S, Service, free_port

pytestmark = pytest.mark.slow
BEGIN, SCANS, BOATS = datetime(2026, 11, 23, 10, 0, tzinfo=UTC), 40, 4
CONFIGURATION = """
[frame]
origin = [54.5, 10.25]
[motion]
process_noise = 0.1
max_speed = 30.0
[lifecycle]
new_target_density = 1e-8
[sensors.pier]
measurement = "position"
sigma = 10.0
detection_probability = 0.9
clutter_density = 1e-9
scan_period = 2.0
"""


@pytest.fixture(scope="module")
def ports() -> dict[str, int]:
    return {"tcp": free_port()}


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory, ports: dict[str, int]) -> Iterator[Service]:
    """Run a service that tracks four boats."""
    folder = tmp_path_factory.mktemp("clients")
    (folder / "tracker.toml").write_text(CONFIGURATION)
    found = Service(
        folder / "data", "--config", str(folder / "tracker.toml"),
        "--listen", f"tcp://127.0.0.1:{ports['tcp']}?format=asterix",
    )  # fmt: skip
    try:
        found.post([_report(scan, boat) for scan in range(SCANS) for boat in range(BOATS)])
        end = time.monotonic() + PATIENCE_S
        while len(found.get("/tracks")["features"]) < BOATS:
            assert time.monotonic() < end, found.get("/healthz")
            time.sleep(0.2)
        yield found
    finally:
        assert found.terminate() == 0


def _report(scan: int, boat: int) -> dict[str, Any]:
    moment = BEGIN + timedelta(seconds=2.0 * scan)
    return {
        "time": moment.isoformat(), "sensor": "pier",
        "lat": 54.5 + 0.01 * boat + 1e-4 * scan, "lon": 10.25 + 0.02 * boat,
    }  # fmt: skip


def _run(*words: str, given: bytes = b"") -> bytes:
    if shutil.which(words[0]) is None:
        pytest.skip(f"{words[0]} is not here")
    return subprocess.run(words, input=given, capture_output=True, check=True, timeout=60).stdout


def test_curl_hands_reports_in_and_fetches_tracks(service: Service) -> None:
    url = f"http://127.0.0.1:{service.port}"
    rows = b"time,sensor,lat,lon\n2026-11-23T10:00:00Z,pier,54.6,10.3\n"
    receipt = json.loads(_run("curl", "-sS", "--data-binary", "@-", f"{url}/reports", given=rows))
    assert (receipt["accepted"], receipt["rejected"]) == (1, [])
    assert len(json.loads(_run("curl", "-sS", f"{url}/tracks"))["features"]) >= BOATS
    assert b"<kml" in _run("curl", "-sS", f"{url}/tracks?format=kml")


def test_netcat_sends_a_capture(service: Service, ports: dict[str, int], shared: Path) -> None:
    capture = (shared / "data" / "asterix" / "cat_034_048.pcap").read_bytes()
    if shutil.which("nc") is None:  # what it does, then
        with socket.create_connection(("127.0.0.1", ports["tcp"])) as sock:
            sock.sendall(capture)
    else:
        _run("nc", "-N", "127.0.0.1", str(ports["tcp"]), given=capture)
    end = time.monotonic() + PATIENCE_S
    while (found := service.get("/healthz")["inputs"][0])["reports"] < 126:
        assert time.monotonic() < end, found
        time.sleep(0.2)
    assert found["skipped"] == 0


def test_a_client_of_websockets_gets_a_picture_and_then_what_changes(service: Service) -> None:
    client = pytest.importorskip("websockets.sync.client")
    with client.connect(f"ws://127.0.0.1:{service.port}/stream", max_size=None) as stream:
        first = json.loads(stream.recv(timeout=30))
        assert (first["type"], first["full"]) == ("tracks", True)
        assert len(first["changed"]) >= BOATS
        service.post([_report(scan, boat) for scan in (SCANS, SCANS + 1) for boat in range(BOATS)])
        kinds = set[str]()
        while "tracks" not in kinds:
            said = json.loads(stream.recv(timeout=30))
            kinds.add(said["type"])
        assert "full" not in said
        assert said["changed"]


def test_gdal_reads_tracks(service: Service, tmp_path: Path) -> None:
    geopandas = pytest.importorskip("geopandas")
    frame = geopandas.read_file(f"http://127.0.0.1:{service.port}/tracks", engine="pyogrio")
    assert frame.crs.to_epsg() == 4326
    assert len(frame) >= BOATS
    assert set(frame.geometry.geom_type) == {"Point"}
    assert frame.total_bounds[1] == pytest.approx(54.5, abs=0.02)
    # Metres, as a user would ask for them.
    assert frame.to_crs(25832).total_bounds[1] == pytest.approx(6.04e6, abs=2e4)


def test_a_reader_of_stone_soup_takes_tracks_files(service: Service) -> None:
    generic = pytest.importorskip("stonesoup.reader.generic")
    parts = sorted((service.log.with_suffix("") / "tracks").iterdir())
    reader = generic.CSVGroundTruthReader(
        parts[0], state_vector_fields=["x", "vx", "y", "vy"], time_field="time",
        path_id_field="track",
    )  # fmt: skip
    paths = {path for _, paths in reader for path in paths}
    assert len(paths) >= BOATS
    longest = max(paths, key=len)
    assert len(longest) > SCANS // 2
    # A ten-thousandth of a degree north in two seconds.
    speed = longest[-1].state_vector[3]
    assert speed == pytest.approx(111.3e3 * 1e-4 / 2.0, rel=0.2)
    assert longest[0].timestamp.replace(tzinfo=UTC) >= BEGIN
