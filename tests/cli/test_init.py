"""The command that writes a commented configuration."""

import json
import tomllib
from pathlib import Path

import numpy as np

from cli.conftest import Run, write_reports


def test_a_run_with_the_file_is_the_run_without(run: Run, tmp_path: Path) -> None:
    reports, config = write_reports(tmp_path / "r.csv", n_scans=30), tmp_path / "tracker.toml"
    assert run("init", reports, "-o", config).exit_code == 0
    assert run("track", reports, "--out", tmp_path / "a").exit_code == 0
    assert run("track", reports, "--config", config, "--out", tmp_path / "b").exit_code == 0
    for name in ("tracks.csv", "assignments.csv", "history.csv"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    one, two = (json.loads((tmp_path / name / "run.json").read_text()) for name in "ab")
    assert one["configuration"] == two["configuration"]


def test_writes_tracker_toml_where_it_stands(
    run: Run, reports: Path, monkeypatch, tmp_path
) -> None:
    monkeypatch.chdir(tmp_path)
    done = run("init", reports)
    assert done.exit_code == 0
    assert "estimated motion: process_noise" in done.stderr
    assert done.stdout == ""
    values = tomllib.loads((tmp_path / "tracker.toml").read_text())
    assert values["seed"] == 0
    assert values["sensors"]["default"]["scan_period"] == 1.0


def test_leaves_a_file_that_is_there_unless_forced(run: Run, reports: Path, config: Path) -> None:
    before = config.read_bytes()
    refused = run("init", reports, "-o", config)
    assert refused.exit_code == 2
    assert "--force" in refused.stderr
    assert config.read_bytes() == before
    assert run("init", reports, "-o", config, "--force").exit_code == 0
    assert config.read_bytes() != before


def test_never_replaces_its_own_input(run: Run, reports: Path) -> None:
    before = reports.read_bytes()
    assert run("init", reports, "-o", reports, "--force").exit_code == 2
    assert reports.read_bytes() == before


def test_json_holds_what_the_file_holds(run: Run, reports: Path, tmp_path: Path) -> None:
    config = tmp_path / "c.toml"
    done = run("init", reports, "-o", config, "--json")
    found = json.loads(done.stdout)
    values = tomllib.loads(config.read_text())
    assert found["configuration"]["motion"]["max_speed"] == values["motion"]["max_speed"]
    assert found["sources"]["motion.max_speed"] == "estimated"
    assert found["out"] == str(config)


def test_quiet_says_nothing(run: Run, reports: Path, tmp_path: Path) -> None:
    done = run("init", reports, "-o", tmp_path / "c.toml", "--quiet")
    assert (done.stdout, done.stderr, done.exit_code) == ("", "", 0)


def test_refuses_a_file_without_reports(run: Run, tmp_path: Path) -> None:
    (tmp_path / "r.csv").write_text("time,x,y\n")
    done = run("init", tmp_path / "r.csv", "-o", tmp_path / "c.toml")
    assert done.exit_code == 2
    assert "no data rows; expected at least one" in done.stderr
    assert not (tmp_path / "c.toml").exists()


def test_leaves_out_bad_rows_when_told_to(run: Run, reports: Path, tmp_path: Path) -> None:
    with reports.open("a") as file:
        file.write("13,nonsense,0,a,red\n")
    out = tmp_path / "c.toml"
    assert run("init", reports, "-o", out).exit_code == 2
    assert run("init", reports, "-o", out, "--on-bad-row", "skip").exit_code == 0


def test_takes_frames_for_times_and_says_so(run: Run, reports: Path, tmp_path: Path) -> None:
    frames = tmp_path / "frames.csv"
    frames.write_text(reports.read_text().replace("time,", "frame,", 1))
    found = []
    for name in (reports, frames):
        done = run("init", name, "-o", tmp_path / "tracker.toml", "--force", "--json")
        found.append(json.loads(done.stdout))
    assert found[0]["configuration"] == found[1]["configuration"]
    assert set(found[1]["notes"]) - set(found[0]["notes"]) == {
        "column frame: taken for time, for there is no column time"
    }


def test_of_a_radar_that_sweeps_a_sector_it_writes_what_a_run_finds(
    run: Run, tmp_path: Path
) -> None:
    rows = ["time,range_m,azimuth_deg"]
    for sweep in range(40):
        for target in range(6):
            azimuth = 5.0 + 15.0 * target + 0.02 * sweep
            rows.append(f"{4.0 * sweep + azimuth / 25.0:.3f},{2000 + 300 * target},{azimuth:.2f}")
    (tmp_path / "r.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    done = run("init", tmp_path / "r.csv", "-o", tmp_path / "t.toml")
    assert done.exit_code == 0, done.stderr
    assert "sweeps a sector" in done.stderr
    assert "scans" not in tomllib.loads((tmp_path / "t.toml").read_text())["sensors"]["default"]


def test_of_two_radars_whose_places_nobody_told_it_writes_nothing_that_needs_them(
    run: Run, tmp_path: Path
) -> None:
    rng, lines = np.random.default_rng(1), ["time,sensor,range_m,azimuth_deg"]
    start, speed = rng.uniform(-3e4, 3e4, (8, 2)), rng.normal(0.0, 120.0, (8, 2))
    for look in range(40):
        for late, name, at in ((0.0, "north", (0.0, 2e4)), (1.3, "south", (5e3, -1.5e4))):
            time = 4.0 * look + late
            east, north = (start + time * speed - at).T
            away = np.hypot(east, north) + rng.normal(0.0, 50.0, 8)
            angle = np.degrees(np.arctan2(east, north)) % 360.0
            lines += [f"{time},{name},{r:.0f},{a:.2f}" for r, a in zip(away, angle, strict=True)]
    reports, config = tmp_path / "two.csv", tmp_path / "two.toml"
    reports.write_text("\n".join(lines) + "\n")
    done = run("init", reports, "-o", config)
    assert done.exit_code == 0
    assert "sensors.south.position: give where it stands" in done.stderr
    sensors = tomllib.loads(config.read_text())["sensors"].values()
    assert not any("field_of_view" in each for each in sensors)
    assert {each.get("hidden_share", 0.0) for each in sensors} == {0.0}
