"""Tests of reading a run's files back."""

from pathlib import Path

import numpy as np
import pytest

from cli.run_directory import write_run
from trackweave.domain.tracks import COASTING, CONFIRMED, TENTATIVE
from trackweave.errors import DataFormatError
from trackweave.io.run_files import read_run


@pytest.fixture
def directory(tmp_path: Path) -> Path:
    return write_run(tmp_path / "run")


def test_reads_states_and_the_positions_covariance(directory: Path) -> None:
    tracks = read_run(directory).tracks
    assert len(tracks) == 12
    assert tracks.status[:4].tolist() == [CONFIRMED, TENTATIVE, CONFIRMED, TENTATIVE]
    assert tracks.status[-1] == COASTING
    np.testing.assert_array_equal(tracks.mean[3], [45.0, 40.0, -5.0, 0.0])
    np.testing.assert_array_equal(tracks.covariance[3, :2, :2], [[16.0, 1.0], [1.0, 9.0]])


def test_reads_assignments_and_scans(directory: Path) -> None:
    run = read_run(directory)
    assert run.assignments.track.tolist() == [1, -1] * 6
    assert run.assignments.sensor.tolist() == ["a", "a", "b", "b"] * 3
    time, gap = run.scans("time", "gap")
    assert time.tolist() == [0, 1, 2, 3, 4, 5]
    assert np.isnan(gap[4])
    cpu = run.cpu_ms()
    assert cpu is not None
    assert cpu[0] == 1.5


def test_reads_the_planes_origin_and_dates(tmp_path: Path) -> None:
    directory = write_run(tmp_path / "run", geodetic=True)
    for name in ("tracks.csv", "history.csv"):
        head, *rows = (directory / name).read_text().splitlines()
        dated = [f"2026-03-01T09:30:0{row}" for row in rows]
        (directory / name).write_text("\n".join([head, *dated]) + "\n")
    run = read_run(directory)
    assert run.frame is not None
    assert (run.frame.latitude_deg, run.frame.longitude_deg) == (51.5, -0.25)
    assert run.iso_time
    assert np.ptp(run.tracks.time) == 5.0


def test_reads_the_planes_projection(tmp_path: Path) -> None:
    plane = {"dimensions": 2, "frame_origin": [51.5, 0.0], "frame_projection": "stereographic"}
    frame = read_run(write_run(tmp_path / "run", input=plane)).frame
    assert frame is not None
    assert frame.projection == "stereographic"
    plane["frame_projection"] = "mercator"
    with pytest.raises(DataFormatError, match="key frame_projection: not as expected"):
        read_run(write_run(tmp_path / "other", input=plane))


def test_refuses_a_run_in_one_dimension(tmp_path: Path) -> None:
    with pytest.raises(DataFormatError, match="key dimensions: 1; expected 2 or 3"):
        read_run(write_run(tmp_path / "run", input={"dimensions": 1}))
