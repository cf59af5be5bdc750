"""The real ``serve``: acknowledged is on the disk, and ``replay`` makes the same bytes."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from service.recordings import positions
from service.serving import PATIENCE_S, Service, free_port
from trackweave.service.journal import Journal
from trackweave.service.records import Kind, arrived
from trackweave.toml_file import read_toml

pytestmark = pytest.mark.slow


def toml_of(configuration: dict[str, Any], path: Path) -> Path:
    """Write a configuration as a file; return its path."""
    lines = [f"{key} = {json.dumps(value)}" for key, value in configuration.items()
             if not isinstance(value, dict)]  # fmt: skip
    for name, table in configuration.items():
        if isinstance(table, dict) and name != "sensors":
            lines += [f"[{name}]", *(f"{key} = {json.dumps(v)}" for key, v in table.items())]
    for name, table in configuration["sensors"].items():
        lines += [f"[sensors.{name}]", *(f"{key} = {json.dumps(v)}" for key, v in table.items())]
    path.write_text("\n".join(lines) + "\n")
    assert read_toml(path, "a configuration")
    return path


def replayed(folder: Path, out: Path) -> dict[str, bytes]:
    """Return the tracks files that the journal alone gives."""
    done = subprocess.run(
        [sys.executable, "-m", "trackweave", "replay", str(folder), "--out", str(out), "--json"],
        capture_output=True, check=True,
    )  # fmt: skip
    assert json.loads(done.stdout)["last_record"] > 0
    return {path.name: path.read_bytes() for path in sorted(out.iterdir())}


def wait_until_still(folder: Path) -> None:
    """Wait until files are there, and have not grown for two seconds."""
    end, size = time.monotonic() + PATIENCE_S, -1
    while time.monotonic() < end:
        before, size = size, sum(path.stat().st_size for path in folder.iterdir())
        if 0 < size == before:
            return
        time.sleep(2.0)


def rows_in(folder: Path) -> list[tuple[float, str, float]]:
    """Return time, sensor and x of all reports in a journal that nobody has open."""
    journal = Journal.open(folder / "journal")
    try:
        tables = [arrived(r.payload).table for r in journal.records() if r.kind == Kind.REPORTS]
    finally:
        journal.close()
    return [row for table in tables for row in table.select("time", "sensor", "x").rows()]


def test_a_recording_that_is_not_there_is_refused_at_once(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "trackweave", "serve", "--listen", f"replay:{tmp_path}/none.csv",
         "--data", str(tmp_path / "data"), "--page", f"127.0.0.1:{free_port()}"],
        capture_output=True, text=True, timeout=PATIENCE_S, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert "none.csv" in done.stderr
    assert done.stderr.strip().endswith("no such file; expected a recording")
    assert not (tmp_path / "data").exists()


@pytest.mark.slow
def test_nothing_acknowledged_is_lost_and_replay_is_equal_to_the_byte(tmp_path: Path) -> None:
    frame, configuration = positions()
    config = toml_of(configuration, tmp_path / "told.toml")
    folder, acknowledged = tmp_path / "data", list[tuple[float, str, float]]()
    lines, place = frame.to_dicts(), 0
    for lot in (120, 150, 180):
        service = Service(folder, "--config", str(config))
        killer = threading.Timer(lot / 400.0, service.kill)
        try:
            while place < len(lines):
                part = lines[place : place + 3]
                place += 3
                assert service.post(part)["accepted"] == len(part)
                acknowledged += [(each["time"], each["sensor"], each["x"]) for each in part]
                if not killer.is_alive():
                    killer.start()
        except (OSError, ValueError, RuntimeError):
            pass  # killed while it answered
        killer.join()
    stored = rows_in(folder)
    assert len(acknowledged) > 10
    assert set(acknowledged) <= set(stored)
    # Whatever the killed ones had written of tracks, one that begins again brings it to an end.
    service = Service(folder, "--config", str(config))
    # Killed so soon, they may have left it unconfigured.
    assert service.wait_for("configured_by", 1)["configured"]
    for begin in range(place, len(lines), 60):
        assert service.post(lines[begin : begin + 60])
    wait_until_still(folder / "tracks")
    assert service.terminate() == 0
    own = {path.name: path.read_bytes() for path in sorted((folder / "tracks").iterdir())}
    again = replayed(folder, tmp_path / "again")
    assert own.keys() == again.keys()
    assert all(again[name].startswith(content) for name, content in own.items())
    # What the last one was told after its last step, replay takes in as well.
    assert sum(map(len, own.values())) > 0.5 * sum(map(len, again.values()))
    assert replayed(folder, tmp_path / "and again") == again


@pytest.mark.slow
def test_ends_on_sigterm_and_reads_its_configuration_anew_on_sighup(tmp_path: Path) -> None:
    frame, configuration = positions()
    config = toml_of(configuration, tmp_path / "told.toml")
    service = Service(tmp_path / "data", "--config", str(config))
    receipt = service.post(frame[:200].to_dicts())
    assert receipt["accepted"] == 200
    assert not receipt["rejected"]
    first = service.wait_for("configured_by", 1)["configured_by"]
    toml_of({**configuration, "window": {"depth": 3}}, config)
    service.process.send_signal(signal.SIGHUP)
    service.wait_for("configured_by", first + 1)
    whole = {"time": 30.0, "sensor": "pier", "x": 1.0, "y": 2.0}
    mixed = service.post([whole, {**whole, "y": None}])
    assert (mixed["accepted"], mixed["rejected"][0]["row"]) == (1, 2)
    begun = time.monotonic()
    assert service.terminate() == 0
    assert time.monotonic() - begun < 2.0
    journal = Journal.open(tmp_path / "data" / "journal")
    said = [json.loads(r.payload) for r in journal.records() if r.kind == Kind.CONFIGURE]
    journal.close()
    assert [each["configuration"].get("window", {}).get("depth") for each in said][-1] == 3


@pytest.mark.slow
def test_a_demonstration_leaves_nothing_behind_even_while_it_compiles(tmp_path: Path) -> None:
    place = tmp_path / "temporary"
    place.mkdir()
    # Without kernels of earlier runs it compiles for a minute, and is ended in the midst of it.
    environment = {**os.environ, "TMPDIR": str(place), "NUMBA_CACHE_DIR": str(tmp_path / "none")}
    port = free_port()
    process = subprocess.Popen(
        [sys.executable, "-m", "trackweave", "serve", "--demo", "--page", f"127.0.0.1:{port}"],
        env=environment, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    end = time.monotonic() + PATIENCE_S
    while not list(place.glob("trackweave-*/service/journal/*")):
        assert time.monotonic() < end
        time.sleep(0.05)
    time.sleep(1.0)
    process.send_signal(signal.SIGTERM)
    assert process.wait(PATIENCE_S) == 0
    assert not list(place.glob("trackweave-????????"))


@pytest.mark.slow
def test_standard_input_becomes_tracks(tmp_path: Path) -> None:
    lines = ["time,sensor,x,y"]
    lines += [f"{2 * k},pier,{500 * a + 10 * k},{300 * a + 4 * k}" for k in range(60)
              for a in range(4)]  # fmt: skip
    table = tmp_path / "reports.csv"
    table.write_text("\n".join(lines) + "\n")
    with table.open("rb") as feed:
        service = Service(tmp_path / "data", "--listen", "stdin:?format=csv", stdin=feed)
    try:
        end = time.monotonic() + PATIENCE_S
        while len(service.get("/tracks")["features"]) < 4:
            assert time.monotonic() < end, service.get("/healthz")
            time.sleep(0.2)
        told = service.get("/healthz")["inputs"][0]
        assert (told["reports"], told["ended"]) == (240, True)
    finally:
        assert service.terminate() == 0


def test_a_folder_of_somebody_else_is_left_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "mine" / "tracks").mkdir(parents=True)
    kept = tmp_path / "mine" / "tracks" / "tracks-00001.csv"
    kept.write_text("mine\n")
    given = ["serve", "--data", str(tmp_path / "mine"), "--page", f"127.0.0.1:{free_port()}"]
    done = subprocess.run(
        [sys.executable, "-m", "trackweave", *given], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "it holds tracks and no journal; expected a new or empty folder" in done.stderr
    assert kept.read_text() == "mine\n"
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["tracks"]
