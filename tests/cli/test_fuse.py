"""The command fuse."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest

from cli.conftest import Run
from oracles.local_tracks import sensor_table

PLACES = {1: (0.0, 0.0), 2: (0.0, 400.0), 3: (300.0, 900.0)}


def write(path: Path, seed: int, places: dict[int, tuple[float, float]] = PLACES) -> Path:
    times = [float(time) for time in range(6)]
    path.parent.mkdir(exist_ok=True)
    sensor_table(np.random.default_rng(seed), places, times).write_csv(path)
    return path


@pytest.fixture
def files(tmp_path: Path) -> list[Path]:
    return [write(tmp_path / "radar.csv", 1), write(tmp_path / "lidar.csv", 2)]


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_writes_associations_tracks_and_a_record(
    run: Run, files: list[Path], tmp_path: Path
) -> None:
    done = run("fuse", *files, "--out", tmp_path / "out", "--json")
    assert done.exit_code == 0, done.stderr
    assert done.stderr == ""
    found = json.loads(done.stdout)
    assert (found["sensors"], found["objects"], found["common_objects"]) == (2, 3, 3)
    out = tmp_path / "out"
    assert {row["sensor"] for row in rows(out / "associations.csv")} == {"radar", "lidar"}
    assert len(rows(out / "tracks.csv")) == 18
    record = json.loads((out / "run.json").read_text())
    assert (record["command"], record["seed"]) == ("fuse", 0)
    assert record["files"] == ["associations.csv", "run.json", "tracks.csv"]


def test_repeats_itself_byte_by_byte_and_replaces_its_own_run(
    run: Run, files: list[Path], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    seen = []
    for _ in range(2):
        assert run("fuse", *files, "--out", out, "--seed", 3, "--quiet").exit_code == 0
        record = json.loads((out / "run.json").read_text())
        del record["timing"]
        seen.append(
            (record, (out / "tracks.csv").read_bytes(), (out / "associations.csv").read_bytes())
        )
    assert seen[0] == seen[1]


def test_says_what_it_found_in_lines(run: Run, files: list[Path], tmp_path: Path) -> None:
    done = run("fuse", *files, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.stderr
    assert "estimated from the covariances: process_noise 0.1 m²/s³" in done.stderr
    assert "common objects" not in done.stderr  # a table, for terminals
    last = done.stderr.splitlines()[-1]
    assert re.fullmatch(rf"\d+ objects? from \d+ tracks of 2 sensors, in {tmp_path / 'out'}", last)
    assert run("fuse", *files, "--out", tmp_path / "other", "--quiet").stderr == ""


def test_sensors_are_named_after_files_or_as_asked_for(
    run: Run, files: list[Path], tmp_path: Path
) -> None:
    names = ("--name", f"R={files[0]}", "--name", f"L={files[1]}")
    for place, arguments in enumerate([[*files, *names], list(names)]):
        out = tmp_path / str(place)
        done = run("fuse", *arguments, "--out", out, "--quiet")
        assert done.exit_code == 0, done.stderr
        assert {row["sensor"] for row in rows(out / "associations.csv")} == {"R", "L"}


def test_refuses_equal_names_and_says_how_to_name_them(run: Run, tmp_path: Path) -> None:
    same = [write(tmp_path / folder / "tracks.csv", 1) for folder in ("a", "b")]
    done = run("fuse", *same, "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert f"{same[1]}: sensor tracks, as is {same[0]}" in done.stderr
    assert "--name" in done.stderr
    assert not (tmp_path / "out").exists()


def test_reads_the_table_fusion_of_a_configuration(
    run: Run, files: list[Path], tmp_path: Path
) -> None:
    config = tmp_path / "tracker.toml"
    config.write_text("seed = 5\n[fusion]\nconfirm = '2/3'\nmethod = 'convex'\n")
    done = run(
        "fuse", *files, "--config", config, "--method", "information-matrix", "--out",
        tmp_path / "out", "--quiet",
    )  # fmt: skip
    assert done.exit_code == 0, done.stderr
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    assert record["seed"] == 5
    assert record["configuration"]["method"] == "information-matrix"
    assert record["sources"]["method"] == "given"
    assert (record["configuration"]["confirm"], record["sources"]["confirm"]) == ("2/3", "file")
    config.write_text("[fusion]\nconfrm = '2/3'\n")
    done = run("fuse", *files, "--config", config, "--out", tmp_path / "other")
    assert done.exit_code == 2
    assert f"{config}, fusion.confrm: unknown key; did you mean confirm?" in done.stderr


def test_the_strict_preset_says_which_one_takes_unequal_lists(
    run: Run, files: list[Path], tmp_path: Path
) -> None:
    fewer = write(tmp_path / "sonar.csv", 3, {1: (0.0, 0.0)})
    strict = run("fuse", files[0], fewer, "--preset", "huo-2008", "--out", tmp_path / "out")
    assert strict.exit_code == 2
    assert "the preset huo takes any" in strict.stderr
    usable = run("fuse", files[0], fewer, "--preset", "huo", "--out", tmp_path / "out", "--json")
    assert usable.exit_code == 0, usable.stderr
    assert json.loads(usable.stdout)["common_objects"] == 1
    done = run("fuse", *files, "--preset", "huo-2008", "--out", tmp_path / "letter")
    assert "preset huo-2008 keeps to its document's letter; --preset huo is" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--name", "radar"], "--name: 'radar'; expected NAME=FILE"),
        (["--method", "mean"], 'method: "mean"; expected one of "convex"'),
        (["--preset", "hou"], "did you mean huo"),
        (["--preset", "hillis-1997"], "is one for tracking"),
        (["--confirm", "often"], 'confirm: "often"; expected text of the form "3/4"'),
        (["--false-rejection", "7"], "false_rejection: 7.0"),
        (["--search", "brute"], "brute"),
        (["--register", "--bias", "tilt"], "expected some of translation"),
        (["--bias", "clock"], "--bias clock: expected --register beside it"),
        (["--correlation", "some"], 'correlation: "some"; expected one of "none"'),
        (["--process-noise", "-1"], "process_noise: -1"),
    ],
)
def test_refuses_options_that_it_cannot_use(
    run: Run, files: list[Path], tmp_path: Path, arguments: list[str], message: str
) -> None:
    done = run("fuse", *files, *arguments, "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_refuses_one_file(run: Run, files: list[Path], tmp_path: Path) -> None:
    done = run("fuse", files[0], "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert "expected the tracks of two sensors at least" in done.stderr


def test_names_file_row_and_column_of_what_is_wrong(
    run: Run, files: list[Path], tmp_path: Path
) -> None:
    lines = files[1].read_text().splitlines()
    files[1].write_text("\n".join([*lines[:3], lines[2], *lines[3:]]))
    done = run("fuse", *files, "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert f"{files[1]}, row 3, column track: 2; expected one row of a track" in done.stderr
    done = run("fuse", files[0], tmp_path / "none.csv", "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert "none.csv: no such file" in done.stderr


def test_registers_and_says_what_it_found_or_cannot_tell(
    run: Run, files: list[Path], tmp_path: Path
) -> None:
    many = {
        k: (float(x), float(y))
        for k, (x, y) in enumerate(np.random.default_rng(5).uniform(0, 5e3, (12, 2)))
    }
    more = [write(tmp_path / name, seed, many) for name, seed in (("A.csv", 1), ("B.csv", 2))]
    aim = ("--register", "--bias", "translation")
    done = run("fuse", *more, *aim, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.stderr
    assert "B beside A, from 12 tracks: translation x" in done.stderr
    few = [
        write(tmp_path / name, seed, {1: (0.0, 0.0)})
        for name, seed in (("C.csv", 1), ("D.csv", 2))
    ]
    done = run("fuse", *few, "--register", "--out", tmp_path / "none")
    assert done.exit_code == 2
    assert "registration" in done.stderr


def test_never_replaces_its_inputs(run: Run, tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    pair = [write(tmp_path / "radar.csv", 1), write(tmp_path / "lidar.csv", 2)]
    assert run("fuse", *pair, "--out", first, "--quiet").exit_code == 0
    done = run(
        "fuse", "--name", f"A={first / 'tracks.csv'}", "--name", f"B={pair[1]}", "--out", first
    )
    assert done.exit_code == 2
    assert "input of this run" in done.stderr
    assert not second.exists()
