"""The command that turns reports into tracks."""

import csv
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from cli.conftest import Run, write_reports

FILES = ["assignments.csv", "history.csv", "run.json", "tracks.csv"]


def rows(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def record(folder: Path) -> dict[str, object]:
    return json.loads((folder / "run.json").read_text())


def test_writes_every_file_with_its_columns(
    run: Run, reports: Path, config: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    done = run("track", reports, "--config", config, "--out", out)
    assert done.exit_code == 0, done.stderr
    assert sorted(path.name for path in out.iterdir()) == FILES
    tracks, assignments = rows(out / "tracks.csv"), rows(out / "assignments.csv")
    assert list(tracks[0])[:5] == ["time", "track", "status", "x", "y"]
    assert list(assignments[0])[:5] == ["report", "time", "sensor", "track", "probability"]
    assert {row["colour"] for row in assignments} == {"red", "grey"}
    assert len(assignments) == len(rows(reports))
    # How probable a row was at its time is amended away in the history.
    *known, last, in_sight = tracks[0]
    assert (last, in_sight) == ("existence", "visible")
    assert list(rows(out / "history.csv")[0]) == known


def test_follows_both_objects(run: Run, reports: Path, config: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run("track", reports, "--config", config, "--out", out)
    taken = rows(out / "assignments.csv")
    of_a = {row["track"] for row in taken if row["target"] == "a"}
    of_b = {row["track"] for row in taken if row["target"] == "b"}
    assert len(of_a) == len(of_b) == 1
    assert of_a != of_b
    assert all(row["track"] == "" for row in taken if row["target"] == "")


def test_same_seed_gives_the_same_bytes(
    run: Run, reports: Path, config: Path, tmp_path: Path
) -> None:
    for name in ("one", "two"):
        run("track", reports, "--config", config, "--seed", 7, "--out", tmp_path / name)
    for file in FILES[:2] + FILES[3:]:
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes()
    first, second = record(tmp_path / "one"), record(tmp_path / "two")
    assert first.pop("timing") is not None
    assert second.pop("timing") is not None
    assert first == second


def test_says_what_it_estimated(run: Run, reports: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = run("track", reports, "--out", out)
    assert done.exit_code == 0, done.stderr
    assert "estimated sensors.default: sigma" in done.stderr
    found = record(out)
    assert found["sources"]["sensors.default.sigma"] == "estimated"
    assert found["configuration"]["sensors"]["default"]["sigma"] > 0


def test_says_first_that_a_sensors_table_is_not_used(
    run: Run, reports: Path, tmp_path: Path
) -> None:
    config = tmp_path / "data_sheet.toml"
    config.write_text("[sensors.radar]\nsigma = 3.0\n")
    done = run("track", reports, "--config", config, "--out", tmp_path / "out")
    assert done.exit_code == 0
    note = "[sensors.radar]: not used, for no report is of a sensor radar; the reports are of "
    said = [line for line in done.stderr.splitlines() if not line.startswith("compiling")]
    assert said[0].startswith(note)
    assert record(tmp_path / "out")["notes"][0].startswith(note)


def test_says_how_many_tracks_came_where_there_is_no_terminal(
    run: Run, config: Path, tmp_path: Path
) -> None:
    lone = tmp_path / "lone.csv"
    lone.write_text("time,x,y\n0,1,2\n")
    done = run("track", lone, "--config", config, "--out", tmp_path / "out")
    assert (
        done.stderr.splitlines()[-1] == f"0 tracks, 0 of 1 report assigned, in {tmp_path / 'out'}"
    )
    assert run("track", lone, "--out", tmp_path / "out", "--quiet").stderr == ""


def test_records_where_each_value_came_from(
    run: Run, reports: Path, config: Path, tmp_path: Path
) -> None:
    run("track", reports, "--config", config, "--out", tmp_path / "out")
    sources = record(tmp_path / "out")["sources"]
    assert sources["sensors.default.sigma"] == "file"
    assert sources["window.depth"] == "default"


def test_prints_one_json_object(run: Run, reports: Path, config: Path, tmp_path: Path) -> None:
    done = run("track", reports, "--config", config, "--out", tmp_path / "out", "--json")
    found = json.loads(done.stdout)
    assert found["reports"] == len(rows(reports))
    assert found["tracks"] == 2
    assert found["notes"] == json.loads((tmp_path / "out" / "run.json").read_text())["notes"]
    assert done.stderr == ""


def test_quiet_says_nothing(run: Run, reports: Path, tmp_path: Path) -> None:
    done = run("track", reports, "--out", tmp_path / "out", "--quiet")
    assert (done.exit_code, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.slow
def test_records_the_file_as_it_was_given(
    run: Run, reports: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(reports.parent)
    assert run("track", reports.name, "--out", tmp_path / "out", "-q").exit_code == 0
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    assert record["input"]["file"] == reports.name
    done = run("plot", tmp_path / "out", "--json")
    assert json.loads(done.stdout)["reports_drawn"] is True


def test_the_seed_of_the_command_comes_before_the_files(
    run: Run, reports: Path, config: Path, tmp_path: Path
) -> None:
    config.write_text("seed = 4\n" + config.read_text())
    run("track", reports, "--config", config, "--out", tmp_path / "file")
    run("track", reports, "--config", config, "--seed", 9, "--out", tmp_path / "command")
    for name, seed, source in (("file", 4, "file"), ("command", 9, "command line")):
        told = record(tmp_path / name)
        assert told["seed"] == told["configuration"]["seed"] == seed
        assert told["sources"]["seed"] == source


@pytest.mark.parametrize(("long", "quiet", "said"), [(1, 0, 1), (0, 0, 0), (1, 1, 0)])
def test_says_that_it_compiles(
    long: int, quiet: int, said: int, run: Run, reports: Path, config: Path, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    @contextmanager
    def compiling_told(tell: Callable[[], None]) -> Iterator[None]:
        if long:
            tell()
        yield

    monkeypatch.setattr("trackweave.run.kernels.compiling_told", compiling_told)
    options = ["--quiet"] if quiet else []
    done = run("track", reports, "--config", config, "--out", tmp_path / "out", *options)
    assert done.exit_code == 0, done.stderr
    assert done.stderr.count("compiling kernels that run here") == said


def test_says_first_and_once_which_preset_is_made_for_use(
    run: Run, reports: Path, config: Path, tmp_path: Path
) -> None:
    options = ["--config", config, "--preset", "wiranto-2018", "--out", tmp_path / "out"]
    done = run("track", reports, *options)
    assert done.exit_code == 0, done.stderr
    assert done.stderr.startswith("preset wiranto-2018 keeps to its document's letter")
    assert done.stderr.count("made for use") == 1
    assert any("made for use" in note for note in record(tmp_path / "out")["notes"])


def test_goes_on_from_an_earlier_runs_tracks(
    run: Run, reports: Path, config: Path, tmp_path: Path
) -> None:
    lines = reports.read_text().splitlines()
    early = [line for line in lines[1:] if float(line.split(",")[0]) < 6]
    late = [line for line in lines[1:] if float(line.split(",")[0]) >= 6]
    first, second = tmp_path / "first.csv", tmp_path / "second.csv"
    first.write_text("\n".join([lines[0], *early]) + "\n")
    second.write_text("\n".join([lines[0], *late]) + "\n")
    run("track", first, "--config", config, "--out", tmp_path / "one")
    tracks = tmp_path / "one" / "tracks.csv"
    done = run("track", second, "--config", config, "--priors", tracks, "--out", tmp_path / "two")
    assert done.exit_code == 0, done.stderr
    confirmed = {row["track"] for row in rows(tracks) if row["status"] == "confirmed"}
    taken = {row["track"] for row in rows(tmp_path / "two" / "assignments.csv") if row["target"]}
    assert taken == confirmed


def test_replaces_its_own_earlier_run_and_nothing_else(
    run: Run, reports: Path, config: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    run("track", reports, "--config", config, "--out", out)
    (out / "notes.txt").write_text("mine")
    assert run("track", reports, "--config", config, "--out", out).exit_code == 0
    assert (out / "notes.txt").read_text() == "mine"


def test_lists_bad_rows_that_it_skips(
    run: Run, reports: Path, config: Path, tmp_path: Path
) -> None:
    lines = reports.read_text().splitlines()
    reports.write_text("\n".join([*lines[:3], "zap,1,2,a,red", *lines[3:]]) + "\n")
    out = tmp_path / "out"
    refused = run("track", reports, "--config", config, "--out", out)
    assert refused.exit_code == 2
    assert "reports.csv, row 3, column time: zap; expected " in refused.stderr
    assert not out.exists()
    done = run("track", reports, "--config", config, "--out", out, "--on-bad-row", "skip")
    assert done.exit_code == 0, done.stderr
    (bad,) = record(out)["skipped_rows"]
    assert (bad["row"], bad["column"], bad["found"]) == (3, "time", "zap")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "reports.csv"),
        (b"time,x,y\n", "expected at least one"),
        (b"time,x\n1,2\n", "y"),
        (b"time|x|y\n1|2|3\n", "separated by commas"),
        (b"time,x,y\n1,2,nan\n", "row 1, column y"),
        (b"time,x,y\n1,2\n", "row 1"),
        (b"time,x,y\n1,2,\xff\n", "UTF-8"),
        (b"time,x,y,sigma_x,sigma_y\n1,2,3,-3.0,1\n", "row 1, column sigma_x: -3.0; expected a"),
    ],
)
def test_refuses_bad_reports_in_one_line(
    content: bytes, said: str, run: Run, tmp_path: Path
) -> None:
    file = tmp_path / "reports.csv"
    file.write_bytes(content)
    done = run("track", file, "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""
    assert not (tmp_path / "out").exists()


def test_refuses_a_directory_of_others_before_any_work(
    run: Run, reports: Path, tmp_path: Path
) -> None:
    (tmp_path / "thesis.tex").write_text("mine")
    done = run("track", reports, "--out", tmp_path)
    assert done.exit_code == 2
    assert "expected a new or empty directory" in done.stderr


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--deadline-ms", "0"], "--deadline-ms: 0.0; expected"),
        (["--deadline-ms", "nan"], "--deadline-ms: nan; expected"),
        (["--preset", "zap"], 'preset: "zap" is not known'),
        (["--config", "none.toml"], "none.toml: no such file"),
        (["--priors", "none.csv"], "none.csv"),
        (["--seed", "-1"], "--seed"),
        (["--on-bad-row", "zap"], "--on-bad-row"),
    ],
)
def test_refuses_options_that_make_no_sense(
    options: list[str], said: str, run: Run, reports: Path, tmp_path: Path
) -> None:
    done = run("track", reports, "--out", tmp_path / "out", *options)
    assert done.exit_code == 2
    assert said in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "rows_of",
    [
        ["0,5,5"],
        ["0,5,5", "0,6,5"],
        ["0,5,5", "9e8,6,5"],
        ["0,5,5"] * 20,
        [f"{time},5,5" for time in range(30)],
        ["5,1,1", "3,2,2", "4,1,2"],
    ],
    ids=["one", "two at once", "years apart", "duplicates", "standing", "unsorted"],
)
def test_odd_reports_are_tracked_all_the_same(
    rows_of: list[str], run: Run, tmp_path: Path
) -> None:
    file = tmp_path / "reports.csv"
    file.write_text("\n".join(["time,x,y", *rows_of]) + "\n")
    done = run("track", file, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.stderr
    assert len(rows(tmp_path / "out" / "assignments.csv")) == len(rows_of)


def test_three_dimensions_and_positions_of_the_earth_come_back(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "reports.csv"
    lines = [f"{10 * k},{47 + 0.01 * k},8.5,{1000 + 10 * k}" for k in range(12)]
    file.write_text("\n".join(["time,lat,lon,alt_m", *lines]) + "\n")
    done = run("track", file, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.stderr
    last = rows(tmp_path / "out" / "tracks.csv")[-1]
    assert float(last["lat"]) == pytest.approx(47.11, abs=0.01)
    assert float(last["alt_m"]) == pytest.approx(1110, abs=30)


def test_a_longer_file_is_no_trouble(run: Run, config: Path, tmp_path: Path) -> None:
    file = write_reports(tmp_path / "long.csv", n_scans=120)
    assert run("track", file, "--config", config, "--out", tmp_path / "out").exit_code == 0
