"""What the command evaluate says of targets."""

import json
from pathlib import Path

import pytest

from cli.conftest import Run
from cli.test_voice import terminal
from trackweave.cli.edge import Voice
from trackweave.cli.evaluate import MOST_TARGETS, run_evaluate, show_evaluation


def write_scene(folder: Path, n_targets: int) -> tuple[Path, Path]:
    """Targets side by side, the first never tracked, each other a little better than the last."""
    truth, tracks = folder / "truth.csv", folder / "tracks.csv"
    true, found = ["time,target,x,y"], ["time,track,status,x,y"]
    for target in range(n_targets):
        for time in range(n_targets + 1):
            true.append(f"{time},T{target},{1000 * target},0")
            if time < target:
                found.append(f"{time},{10 + target},confirmed,{1000 * target},3")
    truth.write_text("\n".join(true) + "\n")
    tracks.write_text("\n".join(found) + "\n")
    return truth, tracks


class Heard(Voice):
    """Keeps the rows of tables that a terminal would show."""

    def __init__(self) -> None:
        super().__init__(quiet=False)
        self.on_terminal = True
        self.rows: dict[str, str] = {}

    def table(self, title: str, rows: list[tuple[str, str]], elsewhere: str = "") -> None:
        self.rows.update(rows)


def test_lists_each_target_with_its_tracks(tmp_path: Path) -> None:
    voice = Heard()
    run_evaluate(voice, *write_scene(tmp_path, 4), None, window=3)
    assert voice.rows["window"] == "3"
    third = "tracked 2 of 4 s, 60.0 % of positions, rmse 3 m, switches 0, fragmentations 0"
    assert voice.rows["target T3"] == f"{third}, tracks 13"
    assert voice.rows["target T0"].startswith("tracked 0 of 4 s, 0.0 % of positions, rmse –")
    assert "targets" not in voice.rows


def test_json_nests_the_targets(run: Run, tmp_path: Path) -> None:
    truth, tracks = write_scene(tmp_path, 3)
    found = json.loads(run("evaluate", "--truth", truth, "--tracks", tracks, "--json").stdout)
    assert [record["target"] for record in found["targets"]] == ["T0", "T1", "T2"]
    assert found["targets"][2]["tracks"] == ["12"]
    assert found["targets"][0]["rmse"] is None
    assert found["mostly_lost"] == 1


def test_a_terminal_sees_the_worst_of_very_many(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    truth, tracks = write_scene(tmp_path, MOST_TARGETS + 5)
    found = run_evaluate(Voice(quiet=True), truth, tracks, None)
    screen = terminal(monkeypatch)
    show_evaluation(found, Voice(quiet=False))
    said = screen.getvalue()
    assert "The 20 targets that were followed worst" in said
    assert "target T0 " in said
    assert f"target T{MOST_TARGETS + 1} " not in said
    assert "5 more targets: see --json" in said


def test_a_window_without_a_time_is_bad_usage(run: Run, tmp_path: Path) -> None:
    truth, tracks = write_scene(tmp_path, 2)
    done = run("evaluate", "--truth", truth, "--tracks", tracks, "--window", 0)
    assert done.exit_code == 2
    assert "--window" in done.stderr


def test_an_empty_position_says_that_a_target_is_away(run: Run, tmp_path: Path) -> None:
    truth, tracks = tmp_path / "truth.csv", tmp_path / "tracks.csv"
    truth.write_text("time,target,x,y\n0,a,0,0\n1,a,,\n2,a,2,0\n0,b,90,5\n1,b,nan,nan\n")
    tracks.write_text("time,track,x,y\n0,1,0,0\n2,1,2,0\n")
    done = run("evaluate", "--truth", truth, "--tracks", tracks, "--json")
    assert done.exit_code == 0, done.stderr
    first, second = json.loads(done.stdout)["targets"]
    assert (first["positions"], first["covered"], first["fragmentations"]) == (2, 1.0, 0)
    assert (second["positions"], second["time_present"]) == (1, 0.0)


@pytest.mark.parametrize(("cells", "column"), [("1,", "y"), (",1", "x"), ("1,north", "y")])
def test_half_a_position_is_refused(run: Run, tmp_path: Path, cells: str, column: str) -> None:
    truth, tracks = tmp_path / "truth.csv", tmp_path / "tracks.csv"
    truth.write_text(f"time,target,x,y\n0,a,0,0\n1,a,{cells}\n")
    tracks.write_text("time,track,x,y\n0,1,0,0\n8,1,0,0\n")
    done = run("evaluate", "--truth", truth, "--tracks", tracks)
    assert done.exit_code == 2
    assert f"truth.csv, row 2, column {column}: " in done.stderr


def test_tables_of_other_times_are_called_by_their_names(run: Run, tmp_path: Path) -> None:
    truth, tracks = write_scene(tmp_path, 3)
    tracks.write_text("time,track,x,y\n900,1,0,0\n")
    said = run("evaluate", "--truth", truth, "--tracks", tracks).stderr
    assert f"{tracks}: from 900 to 900 s, {truth}: from 0 to 3 s" in said


def test_says_where_targets_have_times_of_their_own(run: Run, tmp_path: Path) -> None:
    truth, tracks = tmp_path / "truth.csv", tmp_path / "tracks.csv"
    rows = [f"{time + 0.25 * target},T{target},0,0" for time in range(9) for target in range(4)]
    truth.write_text("\n".join(["time,target,x,y", *rows]) + "\n")
    tracks.write_text("time,track,x,y\n0,1,0,0\n8,1,0,0\n")
    done = run("evaluate", "--truth", truth, "--tracks", tracks)
    assert "truth: a target is there at 27 % of the times within its life" in done.stderr
    found = json.loads(run("evaluate", "--truth", truth, "--tracks", tracks, "--json").stdout)
    assert len(found["notes"]) == 1


def test_says_that_a_cutoff_is_too_small_for_tracks_that_lie_farther_off(
    run: Run, tmp_path: Path
) -> None:
    truth, tracks = write_scene(tmp_path, 4)
    tracks.write_text(tracks.read_text().replace(",3\n", ",800\n"))
    said = run("evaluate", "--truth", truth, "--tracks", tracks).stderr
    assert "cutoff 50 m: half of the targets have no track nearer than 1.28e+03 m" in said
    said = run("evaluate", "--truth", truth, "--tracks", tracks, "--cutoff", 2000).stderr
    assert "cutoff" not in said


def test_takes_the_directory_of_a_run(run: Run, tmp_path: Path) -> None:
    truth, tracks = write_scene(tmp_path, 4)
    assert tracks.name == "tracks.csv"
    of_file = run("evaluate", "--truth", truth, "--tracks", tracks, "--json").stdout
    assert run("evaluate", "--truth", truth, "--tracks", tmp_path, "--json").stdout == of_file


def test_says_nothing_of_targets_that_come_and_go(run: Run, tmp_path: Path) -> None:
    truth, tracks = write_scene(tmp_path, 4)
    found = json.loads(run("evaluate", "--truth", truth, "--tracks", tracks, "--json").stdout)
    assert found["notes"] == []


def test_judges_reports_alone_where_they_tell_their_targets(run: Run, tmp_path: Path) -> None:
    assignments = tmp_path / "assignments.csv"
    assignments.write_text("report,track,target\n1,7,a\n2,7,a\n3,8,b\n4,7,b\n5,,\n")
    found = json.loads(run("evaluate", "--assignments", assignments, "--json").stdout)
    assert (found["report_switches"], found["report_purity"]) == (1, 0.75)
    assert (found["right_share"], found["report_idf1"]) == (0.8, 0.75)
    assert found["gospa"] is None
    voice = Heard()
    run_evaluate(voice, None, None, assignments)
    assert list(voice.rows) == [name for name in found if name.startswith(("right", "report_"))]


def test_says_how_reports_without_positions_are_judged(run: Run, tmp_path: Path) -> None:
    truth, tracks = tmp_path / "reports.csv", tmp_path / "tracks.csv"
    truth.write_text("time,range_m,azimuth_deg,target\n0,1000,3,a\n")
    tracks.write_text("time,track,x,y\n0,1,0,0\n8,1,0,0\n")
    done = run("evaluate", "--truth", truth, "--tracks", tracks)
    assert done.exit_code == 2
    assert "reports.csv, columns x and y: missing" in done.stderr
    assert "judges assignments alone: leave out truth and tracks" in done.stderr


@pytest.mark.parametrize(("given", "missing"), [("truth", "--tracks"), ("tracks", "--truth")])
def test_a_truth_or_tracks_by_itself_is_bad_usage(
    run: Run, tmp_path: Path, given: str, missing: str
) -> None:
    truth, tracks = write_scene(tmp_path, 2)
    done = run("evaluate", f"--{given}", truth if given == "truth" else tracks)
    assert done.exit_code == 2
    assert f"{missing}: missing; expected --truth and --tracks, or --assignments" in done.stderr


def test_one_line_is_said_where_nobody_looks_at_tables(run: Run, tmp_path: Path) -> None:
    truth, tracks = write_scene(tmp_path, 3)
    done = run("evaluate", "--truth", truth, "--tracks", tracks)
    assert done.stdout == ""
    assert done.stderr.startswith("idf1 0.4, 0 switches, gospa 52.04 m; --json tells")
    assert run("evaluate", "--truth", truth, "--tracks", tracks, "--quiet").stderr == ""


def test_a_truth_of_frames_is_told_its_rate_and_doubted_without(run: Run, tmp_path: Path) -> None:
    """People at ten frames a second, where 25 are usual."""
    truth, tracks = tmp_path / "gt.txt", tmp_path / "tracks.txt"
    boxes = [f"{frame},{who},{100 * who + frame},50,20,40,1,1,1.0"
             for frame in range(1, 41) for who in (1, 2)]  # fmt: skip
    truth.write_text("\n".join(boxes) + "\n")
    tracks.write_text("\n".join(boxes) + "\n")
    assert "idf1 1, 0 switches" in run("evaluate", "--truth", truth, "--tracks", tracks).stderr

    beside = tmp_path / "truth.csv"
    rows = [f"{(frame - 1) / 10},{who},{100 * who + frame + 10},70"
            for frame in range(1, 41) for who in (1, 2)]  # fmt: skip
    beside.write_text("time,target,x,y\n" + "\n".join(rows) + "\n")
    given = "evaluate", "--truth", beside, "--tracks", tracks, "--from", "mot?frame_rate=10"
    assert "idf1 1, 0 switches" in run(*given, "--cutoff", "5").stderr

    times = tmp_path / "tracks.csv"
    times.write_text("time,track,x,y\n" + "\n".join(rows) + "\n")
    given = ["evaluate", "--truth", truth, "--tracks", times, "--cutoff", "5"]
    said = run(*given).stderr
    assert "mot: 25 frames a second" in said
    assert "truth is from 0 to 1.56 s and tracks from 0 to 3.9 s" in said
    right = run(*given, "--from", "mot?frame_rate=10").stderr
    assert "idf1 1, 0 switches" in right
    assert "truth is from" not in right
