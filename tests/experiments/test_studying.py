"""Whole studies: the same bytes however they ran, gone on with, told where they fail."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from oracles.hostile import HOSTILE, outcome
from oracles.small_study import SCENE, STUDY, TOLD, changed
from trackweave.errors import InvalidInputError, OutputError
from trackweave.experiments.running import LOG
from trackweave.io.encoding import encode_table
from trackweave.io.frames_out import reports_frame, truth_frame
from trackweave.simulation import scenario_of, simulate

pytestmark = pytest.mark.slow

SAME = ("runs.parquet", "summary.csv", "differences.csv")
"""What has nothing of the clock in it."""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the directory of a study that nobody stopped, by one worker."""
    out = tmp_path_factory.mktemp("whole") / "out"
    tw.study(STUDY, out, workers=1)
    return out


def test_writes_tables_report_figures_and_record(whole: Path) -> None:
    runs = pl.read_parquet(whole / "runs.parquet")
    assert runs["run"].to_list() == list(range(8))
    assert runs["error"].null_count() == 8
    assert runs["gospa"].null_count() == 0
    assert runs["log_likelihood"].is_finite().all()
    record = json.loads((whole / "run.json").read_text())
    assert record["complete"] is True
    assert record["files"] == sorted(path.name for path in whole.iterdir())
    report = (whole / "report.md").read_text()
    for name in ("by-scenario-sensors-clutter-per-scan.png", "quality-by-cpu.png"):
        assert f"]({name})" in report
        assert (whole / name).stat().st_size > 1000
    assert "Failed" not in report
    assert pl.read_csv(whole / "timing.csv")["cpu_s"].min() > 0


def test_a_run_is_what_track_and_evaluate_make_of_the_same_seed(whole: Path) -> None:
    rows = pl.read_parquet(whole / "runs.parquet").filter(configuration="nearest", seed=1)
    row = rows.filter(**{"scenario.sensors.clutter_per_scan": 6.0}).row(0, named=True)
    sensors = [{**SCENE["sensors"][0], "clutter_per_scan": 6}]
    scene = simulate(scenario_of({**SCENE, "sensors": sensors}, "scene"), 1)
    told = {"radar": {"sigma": 5.0, "detection_probability": 0.9, "scan_period": 2.0,
                      "position": [0.0, 0.0], "clutter_density": 6 / 600**2}}  # fmt: skip
    config = {**TOLD, "tracker": {"kind": "nearest-neighbour"}, "sensors": told}
    result = tw.track(scene.reports, config, rng=1)
    found = tw.evaluate(scene.truth, result)
    assert (row["gospa"], row["idf1"], row["switches"]) == (
        found.gospa, found.idf1, found.switches,
    )  # fmt: skip
    assert row["right_share"] == found.right_share
    assert row["reports"] == len(scene.reports)


def test_more_workers_give_the_same_bytes(whole: Path, tmp_path: Path) -> None:
    tw.study(STUDY, tmp_path / "out", workers=2)
    for name in SAME:
        assert (tmp_path / "out" / name).read_bytes() == (whole / name).read_bytes()


def begun(whole: Path, out: Path, content: bytes) -> Path:
    """Return a directory as a kill leaves it."""
    out.mkdir()
    record = json.loads((whole / "run.json").read_text())
    (out / "run.json").write_text(
        json.dumps({**record, "complete": False, "files": [LOG, "run.json"]})
    )
    (out / LOG).write_bytes(content)
    return out


def test_a_killed_study_goes_on_and_ends_with_the_same_bytes(whole: Path, tmp_path: Path) -> None:
    lines = (whole / LOG).read_bytes().splitlines(keepends=True)
    lost = json.dumps({"run": 0, "error": "its worker", "is_lost": True}).encode() + b"\n"
    kept = b"".join([lost, *lines[3:]]) + lines[1][:-20]
    out = begun(whole, tmp_path / "out", kept)
    told: list[tuple[int, int]] = []
    tw.study(STUDY, out, workers=1, progress=lambda done, of: told.append((done, of)))
    assert told == [(1, 3), (2, 3), (3, 3)]
    for name in SAME:
        assert (out / name).read_bytes() == (whole / name).read_bytes()
    again = (out / LOG).read_bytes().splitlines(keepends=True)
    assert again[: len(lines) - 2] == [lost, *lines[3:]]
    assert len(again) == len(lines) + 1


def test_a_study_that_is_done_is_only_written_up_anew(whole: Path, tmp_path: Path) -> None:
    out = begun(whole, tmp_path / "out", (whole / LOG).read_bytes())
    told: list[tuple[int, int]] = []
    given = changed("study.metrics", ["mota"])
    found = tw.study(given, out, progress=lambda done, of: told.append((done, of)))
    assert told == []
    assert "| mota |" in found.report
    assert (out / "runs.parquet").read_bytes() == (whole / "runs.parquet").read_bytes()


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("study.seeds", 3, "differs in study; expected this study as it was begun, or another"),
        ("configurations.nearest.set", TOLD, "differs in configurations"),
    ],
)
def test_the_directory_of_another_study_is_refused(
    path: str, value: object, message: str, whole: Path
) -> None:
    before = {file.name: file.read_bytes() for file in whole.iterdir()}
    with pytest.raises(OutputError, match=f"holds another study, which {message}"):
        tw.study(changed(path, value), whole)
    assert {file.name: file.read_bytes() for file in whole.iterdir()} == before


def test_a_directory_begun_by_another_version_is_refused(whole: Path, tmp_path: Path) -> None:
    out = begun(whole, tmp_path / "out", b"")
    record = json.loads((out / "run.json").read_text())
    (out / "run.json").write_text(json.dumps({**record, "trackweave": "0.0.1"}))
    with pytest.raises(OutputError, match=r"begun by trackweave 0\.0\.1, this is .*same version"):
        tw.study(STUDY, out)


def test_a_study_that_was_broken_off_goes_on_in_the_same_process(
    whole: Path, tmp_path: Path
) -> None:
    def stop(done: int, _: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    out = begun(whole, tmp_path / "out", (whole / LOG).read_bytes()[:200])
    with pytest.raises(KeyboardInterrupt):
        tw.study(STUDY, out, workers=1, progress=stop)
    assert (out / LOG).read_bytes().count(b"\n") == 2
    tw.study(STUDY, out, workers=1)
    for name in SAME:
        assert (out / name).read_bytes() == (whole / name).read_bytes()


def test_two_processes_do_not_work_on_one_directory(whole: Path, tmp_path: Path) -> None:
    out = begun(whole, tmp_path / "out", (whole / LOG).read_bytes())
    code = (
        "import fcntl, os, sys; h = os.open(sys.argv[1], os.O_RDWR); "
        "fcntl.flock(h, fcntl.LOCK_EX); print('held', flush=True); sys.stdin.read()"
    )
    with subprocess.Popen([sys.executable, "-c", code, out / LOG], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE) as other:  # fmt: skip
        assert other.stdout is not None
        assert other.stdout.readline() == b"held\n"
        with pytest.raises(OutputError, match="another process works on it; expected to be alone"):
            tw.study(STUDY, out)
        other.communicate()
    tw.study(STUDY, out)


def test_a_log_that_was_changed_is_told_with_its_row(whole: Path, tmp_path: Path) -> None:
    out = begun(whole, tmp_path / "out", b'{"run": 0}\nnonsense\n')
    with pytest.raises(
        InvalidInputError, match=r"runs\.jsonl, row 2: b'nonsense'; expected a run"
    ):
        tw.study(STUDY, out)


@pytest.fixture
def recording(tmp_path: Path) -> dict[str, str]:
    """Return the paths of a recording's reports and truth; its middle is silent."""
    scene = simulate(scenario_of(SCENE, "scene"), 0)
    for name, table in (("r", reports_frame(scene.reports)), ("t", truth_frame(scene.truth))):
        own = table.filter((pl.col("time") < 7) | (pl.col("time") > 16))
        (tmp_path / f"{name}.csv").write_bytes(encode_table(own, f"{name}.csv"))
    return {"reports": str(tmp_path / "r.csv"), "truth": str(tmp_path / "t.csv")}


def test_a_run_that_fails_is_a_row_with_its_error(recording: dict[str, str]) -> None:
    told = {**TOLD, "sensors": {"radar": {"sigma": 5.0, "clutter_density": 1e-5,
                                          "detection_probability": 0.9,
                                          "scan_period": 2.0}}}  # fmt: skip
    given = {
        "study": {"seeds": 1},
        "scenarios": {"rec": {**recording, "pieces": 3}},
        "configurations": {"window": {"set": told}},
    }
    found = tw.study(given, workers=1)
    assert found.runs["piece"].to_list() == [0, 1, 2]
    assert found.runs["gospa"].is_null().to_list() == [False, True, False]
    assert found.runs["error"][1].endswith("expected some in each of 3 pieces")
    assert "1 of 3 runs failed" in found.report
    assert repr(found) == "StudyResult: 3 runs, 1 of them failed"


def test_a_recording_without_truth_is_judged_by_what_it_foresees(
    recording: dict[str, str],
) -> None:
    given = {
        "study": {"seeds": 1, "metrics": ["log_likelihood", "tracks"]},
        "scenarios": {"rec": {"reports": recording["reports"]}},
        "configurations": {"plain": {"set": TOLD}},
    }
    found = tw.study(given, workers=1)
    assert found.runs["gospa"].null_count() == 1
    assert np.isfinite(found.runs["log_likelihood"][0])
    assert set(found.summary["metric"]) == {"reports", "tracks", "mean_gap", "log_likelihood"}


def test_noise_that_a_configuration_tells_comes_before_that_of_simulated_reports() -> None:
    given = changed("configurations", {"plain": {"set": TOLD}})
    given = changed(
        "configurations.plain.sweep", {"sensors": {"radar": {"sigma": [5, 50]}}}, given
    )
    given = changed("scenarios.sea.sweep", None, changed("study.seeds", 1, given))
    right, wrong = tw.study(given, workers=1).runs["log_likelihood"]
    assert right > wrong


@pytest.mark.parametrize("function", [tw.study, tw.tune])
@pytest.mark.parametrize("argument", ["source", "out", "engine", "workers"])
def test_only_our_own_errors_come_out(
    argument: str, function: Callable[..., object], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def call(source: object, out: object, engine: object, workers: object) -> None:
        function(source, out, engine=engine, workers=workers)

    # Nothing is to run: whatever can be used is as good as refused.
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("trackweave.experiments.studying.run_jobs", refuse)
    monkeypatch.setattr("trackweave.experiments.tuning.run_jobs", refuse)
    source = changed("configurations.window.sweep", {"window": {"depth": [2, 3]}})
    given = {"source": source, "out": None, "engine": "local", "workers": 1}
    for label, value in HOSTILE.items():
        error = outcome(call, {**given, argument: value})
        assert error is None, f"{argument} = {label}: {error!r}"


def refuse(*_: object) -> None:
    raise InvalidInputError("as if nothing had run")
