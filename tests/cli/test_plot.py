"""The command plot."""

import json
from pathlib import Path
from typing import Any

import pytest

from cli.conftest import Run
from cli.run_directory import write_run


@pytest.fixture
def directory(tmp_path: Path) -> Path:
    return write_run(tmp_path / "run")


def test_draws_a_run_from_its_files(run: Run, directory: Path, tmp_path: Path) -> None:
    out = tmp_path / "picture.png"
    reports = tmp_path / "reports.csv"
    done = run("plot", directory, "--out", out, "--reports", reports, "--json")
    assert done.exit_code == 0, done.stderr
    assert out.read_bytes().startswith(b"\x89PNG")
    assert json.loads(done.stdout) == {
        "out": str(out),
        "tracks": 2,
        "reports": 12,
        "reports_drawn": True,
        "targets": None,
        "scans": 6,
        "proven_scans": 3,
    }
    assert done.stderr == ""


def test_says_that_reports_are_not_drawn_where_they_are_elsewhere(
    run: Run, directory: Path
) -> None:
    done = run("plot", directory)
    assert done.exit_code == 0, done.stderr
    assert "see --reports" in done.stderr
    assert (directory / "plot.png").exists()
    assert run("plot", directory, "--quiet").stderr == ""


def test_draws_the_reports_that_stand_in_the_directory(
    run: Run, directory: Path, tmp_path: Path
) -> None:
    (tmp_path / "reports.csv").rename(directory / "reports.csv")
    assert json.loads(run("plot", directory, "--json").stdout)["reports_drawn"] is True


def of_file(directory: Path, name: object) -> Path:
    """Let a run's record name the file of its reports."""
    record = json.loads((directory / "run.json").read_text())
    record["input"]["file"] = name
    (directory / "run.json").write_text(json.dumps(record))
    return directory


@pytest.mark.parametrize("place", ["reports.csv", "data/reports.csv"])
def test_finds_the_reports_that_the_run_names_from_where_it_was_run(
    run: Run, directory: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "reports.csv").rename(tmp_path / place)
    monkeypatch.chdir(tmp_path)
    done = run("plot", of_file(directory, place), "--json")
    assert json.loads(done.stdout)["reports_drawn"] is True
    assert done.stderr == ""


@pytest.mark.parametrize("named", ["reports.csv", "data/reports.csv"])
def test_finds_the_reports_beside_the_run_from_elsewhere(
    run: Run, directory: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: str
) -> None:
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    done = run("plot", of_file(directory, named), "--json")
    assert json.loads(done.stdout)["reports_drawn"] is True


@pytest.mark.parametrize("named", ["gone.csv", "", None, 7, ["reports.csv"]])
def test_goes_without_reports_that_are_nowhere(run: Run, directory: Path, named: object) -> None:
    done = run("plot", of_file(directory, named))
    assert done.exit_code == 0, done.stderr
    assert "see --reports" in done.stderr


def test_leaves_out_reports_that_have_changed_since(
    run: Run, directory: Path, tmp_path: Path
) -> None:
    (tmp_path / "reports.csv").write_text("report,time,x,y\nelse,2,1,1\n")
    done = run("plot", of_file(directory, "reports.csv"))
    assert done.exit_code == 0, done.stderr
    assert "1 of 1 reports are not in" in done.stderr
    assert "so they are left out" in done.stderr


@pytest.mark.parametrize(("ending", "start"), [("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_draws_other_formats_with_the_same_bytes_each_time(
    run: Run, directory: Path, tmp_path: Path, ending: str, start: bytes
) -> None:
    out = tmp_path / f"picture.{ending}"
    pictures = []
    for _ in range(2):
        assert run("plot", directory, "-o", out, "--quiet").exit_code == 0
        pictures.append(out.read_bytes())
    assert pictures[0].startswith(start)
    assert pictures[0] == pictures[1]


def test_names_where_the_plane_of_latitudes_lies(run: Run, tmp_path: Path) -> None:
    directory = write_run(tmp_path / "run", geodetic=True)
    out = tmp_path / "picture.svg"
    truth = tmp_path / "truth.csv"
    truth.write_text("time,target,lat,lon\n0,a,51.5,-0.25\n5,a,51.5005,-0.25\n")
    done = run("plot", directory, "--out", out, "--truth", truth, "--json")
    assert done.exit_code == 0, done.stderr
    assert json.loads(done.stdout)["targets"] == 1
    assert "<!-- x, east of 0.25° W [m] -->" in out.read_text()
    assert "<!-- y, north of 51.5° N [m] -->" in out.read_text()


def test_an_images_y_runs_downwards(run: Run, directory: Path, tmp_path: Path) -> None:
    out = tmp_path / "picture.svg"
    assert run("plot", directory, "--out", out, "--pixels", "--history").exit_code == 0
    assert "<!-- y, downwards [px] -->" in out.read_text()


def test_a_run_without_timing_is_drawn_without_it(run: Run, tmp_path: Path) -> None:
    directory = write_run(tmp_path / "run", timing=None)
    out = tmp_path / "picture.svg"
    assert run("plot", directory, "--out", out).exit_code == 0
    assert "gap to the bound" in out.read_text()
    assert "CPU per scan" not in out.read_text()


def test_drawing_again_replaces_the_picture_alone(run: Run, directory: Path) -> None:
    assert run("plot", directory).exit_code == 0
    names = sorted(path.name for path in directory.iterdir())
    assert run("plot", directory).exit_code == 0
    assert sorted(path.name for path in directory.iterdir()) == names


def complaint(run: Run, *arguments: object) -> str:
    done = run("plot", *arguments)
    assert done.exit_code == 2
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""
    return str(done.stderr)


def test_refuses_what_is_no_run(run: Run, directory: Path, tmp_path: Path) -> None:
    assert "no such directory; expected" in complaint(run, tmp_path / "nowhere")
    assert "a file; expected" in complaint(run, directory / "tracks.csv")
    (tmp_path / "empty").mkdir()
    assert "no run.json in it; expected" in complaint(run, tmp_path / "empty")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("{", "not JSON"),
        ("[]", "not the record of a run"),
        ('{"trackweave": "0.1.0", "command": "simulate"}', "a run of `trackweave simulate`"),
        ('{"trackweave": "9.0.0"}', "key input: not as expected; written by trackweave 9.0.0"),
    ],
)
def test_refuses_a_strange_record(run: Run, directory: Path, content: str, words: str) -> None:
    (directory / "run.json").write_text(content)
    assert words in complaint(run, directory)


@pytest.mark.parametrize("scans", [3, [{"time": 0.0}], [{"time": "x", "reports": 1, "gap": 0}]])
def test_refuses_scans_of_another_kind(run: Run, tmp_path: Path, scans: Any) -> None:
    directory = write_run(tmp_path / "run", scans=scans)
    assert "not as expected; written by trackweave 0.1.0" in complaint(run, directory)


def test_refuses_half_a_run(run: Run, directory: Path) -> None:
    (directory / "history.csv").unlink()
    assert "history.csv: missing; expected all files of a run" in complaint(run, directory)


def test_refuses_a_damaged_table_by_its_row(run: Run, directory: Path) -> None:
    table = directory / "tracks.csv"
    table.write_text(table.read_text().replace("0,1,confirmed,0,", "0,1,sure,0,", 1))
    assert "tracks.csv, row 1, column status: sure; expected" in complaint(run, directory)


def test_refuses_other_reports_than_those_tracked(
    run: Run, directory: Path, tmp_path: Path
) -> None:
    other = tmp_path / "other.csv"
    other.write_text("report,time,x,y\nr0,0,1,1\nr1,9,1,1\nelse,2,1,1\n")
    said = complaint(run, directory, "--reports", other)
    assert "2 of 3 reports are not in" in said


def test_refuses_a_truth_on_the_earth_for_a_run_on_a_plane(
    run: Run, directory: Path, tmp_path: Path
) -> None:
    truth = tmp_path / "truth.csv"
    truth.write_text("time,target,lat,lon\n0,a,51.5,-0.25\n")
    assert "latitudes and longitudes" in complaint(run, directory, "--truth", truth)


@pytest.mark.parametrize(("later", "is_said"), [(0.0, False), (1e6, True)])
def test_a_truth_of_another_time_is_told(
    run: Run, directory: Path, tmp_path: Path, later: float, is_said: bool
) -> None:
    truth = tmp_path / "other.csv"
    truth.write_text(f"time,target,x,y\n{1.0 + later},a,1,2\n")
    drawn = run("plot", directory, "--truth", truth)
    assert drawn.exit_code == 0
    assert ("another recording" in drawn.stderr) == is_said


@pytest.mark.parametrize("name", ["picture.jpg", "picture", "run/tracks.csv"])
def test_refuses_a_picture_of_another_kind(
    run: Run, directory: Path, tmp_path: Path, name: str
) -> None:
    assert "expected a name that ends in .png, .svg, .pdf or .html" in complaint(
        run, directory, "--out", tmp_path / name
    )
