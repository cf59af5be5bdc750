"""The commands demo, simulate, evaluate and schema."""

import json
import tomllib
from pathlib import Path

import pytest

from cli.conftest import Run
from cli.test_evaluate import Heard
from trackweave.cli.demo import run_demo
from trackweave.config import load_configuration
from trackweave.simulation import demo_configuration, demo_scenario

SCENARIO = """
duration = 20.0
[area]
low = [0.0, 0.0]
high = [500.0, 500.0]
[[sensors]]
name = "radar"
sigma = 5.0
detection_probability = 0.9
clutter_per_scan = 2.0
scan_period = 1.0
[[targets]]
position = [100.0, 100.0]
velocity = [10.0, 5.0]
"""


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "scenario.toml"
    path.write_text(SCENARIO)
    return path


def test_demo_writes_everything_and_finds_the_targets(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "demo"
    done = run("demo", "--out", out, "--json")
    assert done.exit_code == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["n_found"] == found["n_truth"] == 9
    assert found["right_share"] > 0.8
    assert sorted(path.name for path in out.iterdir()) == [
        "assignments.csv",
        "demo.png",
        "history.csv",
        "reports.csv",
        "run.json",
        "tracker.toml",
        "tracks.csv",
        "truth.csv",
    ]
    assert (out / "demo.png").read_bytes().startswith(b"\x89PNG")


def test_demo_ends_with_a_summary(tmp_path: Path) -> None:
    voice = Heard()
    run_demo(voice, tmp_path / "demo", 1)
    assert {"targets found", "worst gap to the bound"} <= set(voice.rows)


def test_demo_says_what_it_found_without_a_terminal(run: Run, tmp_path: Path) -> None:
    done = run("demo", "--out", tmp_path / "demo", "--seed", 2)
    assert done.stderr.startswith("targets found 9 of 9; GOSPA (cutoff 50 m) ")
    assert done.stderr.splitlines()[-1].endswith(f"all files are in {tmp_path / 'demo'}.")


def test_the_demos_configuration_is_one() -> None:
    text = demo_configuration(demo_scenario(), 3)
    assert load_configuration(tomllib.loads(text)).said("seed") == 3


def test_simulate_track_evaluate_is_a_circle(run: Run, scenario: Path, tmp_path: Path) -> None:
    scene, out = tmp_path / "scene", tmp_path / "out"
    made = run("simulate", scenario, "--out", scene, "--seed", 3, "--json")
    assert made.exit_code == 0, made.stderr
    assert json.loads(made.stdout)["targets"] == 1
    assert run("track", scene / "reports.csv", "--out", out).exit_code == 0
    judged = run(
        "evaluate", "--truth", scene / "truth.csv", "--tracks", out / "tracks.csv",
        "--assignments", out / "assignments.csv", "--json",
    )  # fmt: skip
    assert judged.exit_code == 0, judged.stderr
    found = json.loads(judged.stdout)
    assert found["n_found"] == 1
    assert found["right_share"] > 0.8
    assert found["gospa"] < 50


def test_tracking_into_a_simulation_is_refused_and_loses_nothing(
    run: Run, scenario: Path, tmp_path: Path
) -> None:
    scene = tmp_path / "scene"
    run("simulate", scenario, "--out", scene)
    before = {path.name: path.read_bytes() for path in scene.iterdir()}
    done = run("track", scene / "reports.csv", "--out", scene)
    assert done.exit_code == 2
    assert "holds a run of `trackweave simulate`" in done.stderr
    assert {path.name: path.read_bytes() for path in scene.iterdir()} == before


def test_a_run_does_not_replace_its_own_priors(run: Run, scenario: Path, tmp_path: Path) -> None:
    scene, out = tmp_path / "scene", tmp_path / "out"
    run("simulate", scenario, "--out", scene)
    reports = scene / "reports.csv"
    assert run("track", reports, "--out", out).exit_code == 0
    before = (out / "tracks.csv").read_bytes()
    done = run("track", reports, "--priors", out / "tracks.csv", "--out", out)
    assert done.exit_code == 2
    assert "its tracks.csv is an input of this run" in done.stderr
    assert (out / "tracks.csv").read_bytes() == before


def test_simulate_gives_the_same_bytes_for_the_same_seed(
    run: Run, scenario: Path, tmp_path: Path
) -> None:
    for name, seed in (("one", 1), ("two", 1), ("three", 2)):
        run("simulate", scenario, "--out", tmp_path / name, "--seed", seed)
    files = ("reports.csv", "truth.csv", "run.json")
    one, two, three = (
        [(tmp_path / name / file).read_bytes() for file in files]
        for name in ("one", "two", "three")
    )
    assert one == two
    assert one[0] != three[0]


def test_evaluate_needs_the_truth_of_each_report(run: Run, scenario: Path, tmp_path: Path) -> None:
    scene = tmp_path / "scene"
    run("simulate", scenario, "--out", scene)
    bare = tmp_path / "assignments.csv"
    bare.write_text("report,track\n1,1\n")
    done = run(
        "evaluate", "--truth", scene / "truth.csv", "--tracks", scene / "truth.csv",
        "--assignments", bare,
    )  # fmt: skip
    assert done.exit_code == 2
    assert len(done.stderr.splitlines()) == 1


def test_evaluate_prints_no_table_but_to_a_terminal(run: Run, tmp_path: Path) -> None:
    truth, tracks = tmp_path / "truth.csv", tmp_path / "tracks.csv"
    truth.write_text("time,target,x,y\n0,a,0,0\n1,a,1,0\n")
    tracks.write_text("time,track,status,x,y\n0,1,confirmed,0,3\n1,1,confirmed,1,3\n")
    done = run("evaluate", "--truth", truth, "--tracks", tracks)
    assert done.exit_code == 0, done.stderr
    assert len(done.stderr.splitlines()) == 1  # a table is for terminals
    assert run("evaluate", "--truth", truth, "--tracks", tracks, "--quiet").stderr == ""


def test_tracks_of_another_time_are_refused(run: Run, tmp_path: Path) -> None:
    truth, tracks = tmp_path / "truth.csv", tmp_path / "tracks.csv"
    truth.write_text("time,target,x,y\n0,a,0,0\n1,a,1,0\n")
    tracks.write_text("time,track,status,x,y\n1000,1,confirmed,0,3\n1001,1,confirmed,1,3\n")
    done = run("evaluate", "--truth", truth, "--tracks", tracks)
    assert done.exit_code == 2
    assert len(done.stderr.splitlines()) == 1
    assert "from 1000 to 1001 s" in done.stderr
    assert "from 0 to 1 s; expected tracks and truth of the same time" in done.stderr


def test_schema_accepts_what_the_configuration_accepts(run: Run) -> None:
    schema = json.loads(run("schema").stdout)
    assert schema["title"] == "tracker.toml"
    assert set(schema["properties"]) == {
        "seed", "motion", "sensors", "window", "search", "lifecycle", "output", "frame",
        "growth", "tracker", "plots", "fusion", "live",
    }  # fmt: skip
    search = schema["$defs"]["SearchSection"]
    assert "population" in search["properties"]
    assert search["additionalProperties"] is False
