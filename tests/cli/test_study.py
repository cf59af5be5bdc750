"""The command study, run as it is."""

import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest

from cli.conftest import Run
from cli.test_hostile import refused
from trackweave.experiments.running import LOG

STUDY = """
[study]
seeds = 3
tell_sensors = true
[scenarios.sea]
file = "scene.toml"
sweep.sensors.clutter_per_scan = [1, 6]
[configurations.window.set]
motion = {process_noise = 0.1, max_speed = 30.0}
lifecycle.new_target_density = 1e-6
"""
SCENE = """
duration = 23.0
[area]
low = [0, 0]
high = [600, 600]
[[sensors]]
name = "radar"
sigma = 5.0
scan_period = 2.0
[[targets]]
position = [100, 100]
velocity = [12, 3]
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    (tmp_path / "scene.toml").write_text(SCENE)
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    return path


@pytest.mark.slow
def test_runs_a_study_and_tells_what_came_out(run: Run, study: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = run("study", study, "--out", out, "--workers", 1, "--json")
    assert done.exit_code == 0, done.stderr
    found = json.loads(done.stdout)
    assert (found["runs"], found["failed"], found["out"]) == (6, 0, str(out))
    assert [row["scenario.sensors.clutter_per_scan"] for row in found["summary"]] == [1, 6]
    assert (out / "report.md").read_text().startswith("# Study\n")
    assert (out / "runs.parquet").exists()


@pytest.mark.slow
def test_a_study_killed_at_any_time_goes_on(study: Path, tmp_path: Path) -> None:
    whole, out = tmp_path / "whole", tmp_path / "out"
    command = [sys.executable, "-m", "trackweave", "study", study, "--workers", "1", "--out"]
    for ending in (signal.SIGKILL, signal.SIGINT):
        process = subprocess.Popen([*command, out], stderr=subprocess.PIPE, text=True)
        begin, already = time.monotonic(), lines(out)
        while lines(out) == already:
            assert process.poll() is None
            assert time.monotonic() - begin < 120
            time.sleep(0.02)
        process.send_signal(ending)
        process.communicate(timeout=20)
        assert process.returncode == (130 if ending == signal.SIGINT else -ending)
        assert not (out / "runs.parquet").exists()
        assert 0 < lines(out) < 6
    for place in (out, whole):
        subprocess.run([*command, place], check=True, env={**os.environ, "TRACKWEAVE_DEBUG": "1"})
    for name in ("runs.parquet", "summary.csv", "differences.csv"):
        assert (out / name).read_bytes() == (whole / name).read_bytes()


def lines(out: Path) -> int:
    return (out / LOG).read_bytes().count(b"\n") if (out / LOG).exists() else 0


def test_too_many_runs_are_told_and_refused(run: Run, study: Path, tmp_path: Path) -> None:
    study.write_text(STUDY.replace("seeds = 3", "seeds = 500000"))
    out = tmp_path / "out"
    assert "1,000,000 runs; expected at most 10,000, or --yes" in refused(
        run, "study", study, "--out", out
    )
    assert not out.exists()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("seeds = 3", "seed = 3", "study.seed: unknown key; did you mean seeds?"),
        ("[1, 6]", "[1, 1]", "sweep.sensors.clutter_per_scan: 1 comes twice"),
        ("scene.toml", "seen.toml", "seen.toml: no such file; expected a scenario"),
        ("max_speed = 30.0", "max_sped = 30.0", "motion.max_sped: unknown key; did you mean"),
        ("seeds = 3", "seeds = ", "line 3"),
    ],
)
def test_each_mistake_is_one_sentence(
    run: Run, study: Path, tmp_path: Path, old: str, new: str, message: str
) -> None:
    study.write_text(STUDY.replace(old, new))
    assert message in refused(run, "study", study, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_engines_and_workers_that_there_are_not(run: Run, study: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    said = refused(run, "study", study, "--out", out, "--engine", "slurm")
    assert said == "engine: 'slurm'; expected local, ray or ray://HOST\n"
    assert "workers: 0; expected" in refused(run, "study", study, "--out", out, "--workers", 0)
    assert not out.exists()


def test_a_directory_that_is_not_its_own_stays_as_it_is(
    run: Run, study: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "letter.txt").write_text("dear")
    assert "not empty and not a run of trackweave" in refused(run, "study", study, "--out", out)
    assert [path.name for path in out.iterdir()] == ["letter.txt"]


@pytest.mark.slow
def test_searches_and_writes_a_configuration(run: Run, study: Path, tmp_path: Path) -> None:
    study.write_text(STUDY + "\n[configurations.window.sweep]\nwindow.depth = [2, 4]\n")
    out = tmp_path / "out"
    done = run("tune", study, "--out", out, "--workers", 1, "--json")
    assert done.exit_code == 0, done.stderr
    found = json.loads(done.stdout)
    written = tomllib.loads((out / "tuned.toml").read_text())
    assert set(written) - {"window"} == {"motion", "lifecycle"}
    # One of both, or neither where none is better than what nothing is changed of.
    assert written.get("window") == found["best"].get("window")
    assert written.get("window", {}).get("depth") in (None, 2, 4)
    assert "holds a run of `trackweave tune`" in refused(run, "study", study, "--out", out)


def test_nothing_to_search_is_told(run: Run, study: Path, tmp_path: Path) -> None:
    said = refused(run, "tune", study, "--out", tmp_path / "out")
    assert (
        "tune.configuration: left out; expected the name of a configuration with a sweep" in said
    )


@pytest.mark.slow
def test_a_study_whose_every_run_fails_is_refused(run: Run, study: Path, tmp_path: Path) -> None:
    study.write_text(STUDY.replace("seeds = 3", "seeds = 3\ntime_limit = 1e-6"))
    done = run("study", study, "--out", tmp_path / "out", "--workers", 1)
    assert done.exit_code == 2
    assert "study.toml: every run failed, the first with: " in done.stderr
    assert (tmp_path / "out" / "report.md").exists()
