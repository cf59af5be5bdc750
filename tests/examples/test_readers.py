"""The readers in ``examples/``: what they make of the recordings, and of small files like them."""

import importlib.util
import json
import math
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import polars as pl
import pytest

from trackweave import read_reports

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def reader(name: str) -> ModuleType:
    path = EXAMPLES / f"{name}.py"
    spec = importlib.util.spec_from_file_location(f"example_{name}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def distance_to_truth(reports: pl.DataFrame, truth: pl.DataFrame) -> np.ndarray:
    """Return how far the nearest report of each scan is from where the target then was."""
    time, true = truth["time"].to_numpy(), truth.select("x", "y").to_numpy()
    nearest = []
    for (moment,), scan in reports.group_by("time", maintain_order=True):
        if time[0] <= moment <= time[-1]:
            place = [np.interp(moment, time, true[:, axis]) for axis in range(2)]
            off = scan.select("x", "y").to_numpy() - place
            nearest.append(np.linalg.norm(off, axis=1).min())
    return np.array(nearest)


def write_scenario(folder: Path, scans: list[dict], truth: list[list[dict]]) -> Path:
    folder.mkdir()
    (folder / f"{folder.name}_detections.json").write_text(json.dumps(scans))
    (folder / f"{folder.name}_groundTruth.json").write_text(json.dumps(truth))
    return folder


def scan_of(sensor: int, time: float, measurement: object) -> dict:
    return {
        "sensorID": sensor,
        "time": time,
        "ownshipPosition": [100.0, 7.0],
        "measurement": measurement,
    }


def vessel(number: int, time: float, north: float, east: float) -> dict:
    return {"targetID": number, "time": time, "position": [north, east, 0.0]}


def test_a_ferrys_reports_are_east_and_north_and_bearings_clockwise(tmp_path: Path) -> None:
    scans = [
        scan_of(2, 50.25, [[1.0, 2.0], [30.0, 40.0]]),  # two plots: norths, then easts
        scan_of(1, 50.5, [5.0, 6.0]),  # one plot
        scan_of(1, 51.0, []),
        scan_of(3, 51.25, -math.pi / 2),  # one bearing, to the west
        scan_of(4, 51.5, [0.0, math.nan]),
    ]
    truth = [[vessel(1, 50.0 + k / 2, 10.0 * k, k), vessel(2, 50.0 + k / 2, math.nan, 0.0)]
             for k in range(4)]  # fmt: skip
    truth += [[vessel(2, 50.0 + k / 2, 3.0, 4.0)] for k in range(4)]
    reports, true = reader("autoferry").read(write_scenario(tmp_path / "scenario", scans, truth))
    assert reports.rows() == [
        (0.25, "radar", 37.0, 101.0, None, 7.0, 100.0),
        (0.25, "radar", 47.0, 102.0, None, 7.0, 100.0),
        (0.5, "lidar", 13.0, 105.0, None, 7.0, 100.0),
        (1.25, "ir", None, None, 270.0, 7.0, 100.0),
        (1.5, "eo", None, None, 0.0, 7.0, 100.0),
    ]
    first = true.filter(pl.col("target") == "havfruen").row(1, named=True)
    assert first == {"time": 0.5, "target": "havfruen", "x": 1.0, "y": 10.0}
    assert true["x"].is_nan().sum() == 0


@pytest.mark.shared
@pytest.mark.parametrize("scenario", [2, 4, 13, 16])
def test_a_ferrys_radar_lies_near_the_vessels_and_its_camera_looks_at_them(
    shared: Path, scenario: int
) -> None:
    folder = shared / "data" / "autoferry" / f"scenario{scenario}"
    reports, truth = reader("autoferry").read(folder)
    radar = reports.filter(pl.col("sensor") == "radar")
    for name in ("havfruen", "other"):
        near = distance_to_truth(radar, truth.filter(pl.col("target") == name)) < 20.0
        assert near.mean() > 0.7  # as the recording's own page says: 78 to 99 % but for hiding
    eo = reports.filter(pl.col("sensor") == "eo")
    own = truth.filter(pl.col("target") == "other")
    place = [np.interp(eo["time"], own["time"], own[axis]) for axis in ("x", "y")]
    seen = np.degrees(np.arctan2(place[0] - eo["sensor_x"], place[1] - eo["sensor_y"]))
    off = (eo["bearing_deg"].to_numpy() - seen + 180.0) % 360.0 - 180.0
    # Of all that the camera sees, about one in each picture is the vessel; mirrored, none is.
    assert (np.abs(off) < 3.0).sum() > 0.4 * eo["time"].n_unique()


@pytest.mark.shared
def test_reads_what_is_known_of_each_recording(shared: Path) -> None:
    data = shared / "data"
    turns, boat = reader("joyride").read(data / "ntnu_joyride/joyride.mat")
    assert (len(turns), len(boat)) == (432, 238)
    assert np.median(distance_to_truth(turns, boat)) < 25.0
    assert len(read_reports(turns)) == len(turns)


@pytest.mark.shared
def test_a_reader_runs_as_a_script(shared: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / "autoferry.py"),
         str(shared / "data/autoferry/scenario2"), str(tmp_path / "out"), "--sensors", "radar"],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    assert done.stdout == "437 reports of radar\n"
    reports = read_reports(tmp_path / "out" / "reports.csv")
    assert reports.sensors == ("radar",)
    assert (tmp_path / "out" / "truth.csv").exists()


@pytest.mark.parametrize("name", ["autoferry", "joyride"])
def test_a_missing_recording_is_named(name: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / f"{name}.py"), str(tmp_path / "none"), str(tmp_path)],
        check=False, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 1
    assert str(tmp_path / "none") in done.stderr
    assert "Traceback" not in done.stderr
