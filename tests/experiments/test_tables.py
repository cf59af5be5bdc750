"""Means and differences, against SciPy's own intervals over plain loops."""

from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from oracles.small_study import STUDY, changed
from trackweave.experiments.cases import Case, cases_of
from trackweave.experiments.report import figures_of, report_of, unmeasured
from trackweave.experiments.study_file import MEASURES, StudyPlan, read_study
from trackweave.experiments.tables import differences_of, runs_table, summary_of
from trackweave.io.encoding import encode_table
from trackweave.studies.writing import text_table


def measured(study: StudyPlan, fail: int | None = None) -> tuple[list[Case], dict[int, dict]]:
    """Return made-up measures in which reports matter more than configurations."""
    rng = np.random.default_rng(4)
    luck = {seed: rng.normal(0, 10.0) for seed in range(100)}
    cases, found = list(cases_of(study)), {}
    for number, case in enumerate(cases):
        gospa = 20.0 + luck[case.seed] + 3.0 * (case.configuration == "nearest") + rng.normal()
        measures = {**dict.fromkeys(MEASURES), "gospa": gospa, "tracks": 2}
        found[number] = {"measures": measures, "timing": {"cpu_s": 0.5}}
    if fail is not None:
        found[fail] = {"error": "boom", "is_lost": False}
    return cases, found


def test_means_have_students_intervals() -> None:
    study = read_study(changed("study.seeds", 12))
    cases, found = measured(study)
    table = summary_of(runs_table(study, cases, found)[0], study)
    assert set(table["metric"]) == {"gospa", "tracks"}
    for clutter in (1.0, 6.0):
        for name in ("window", "nearest"):
            values = [
                found[number]["measures"]["gospa"]
                for number, case in enumerate(cases)
                if case.configuration == name
                and case.scene["sensors", "clutter_per_scan"] == clutter
            ]
            own = table.filter(
                metric="gospa",
                configuration=name,
                **{"scenario.sensors.clutter_per_scan": clutter},
            ).row(0, named=True)
            ends = stats.ttest_1samp(values, 0.0).confidence_interval(0.95)
            assert (own["low"], own["high"]) == pytest.approx(ends)
            assert own["mean"] == pytest.approx(np.mean(values))
            assert (own["draws"], own["failed"]) == (12, 0)


def test_differences_are_taken_draw_by_draw() -> None:
    study = read_study(changed("study.seeds", 12))
    cases, found = measured(study)
    runs, _ = runs_table(study, cases, found)
    table = differences_of(runs, study)
    assert set(table["configuration"]) == {"nearest"}
    by_name = {
        (case.configuration, case.scene["sensors", "clutter_per_scan"], case.seed):
        found[number]["measures"]["gospa"]
        for number, case in enumerate(cases)
    }  # fmt: skip
    for clutter in (1.0, 6.0):
        apart = [by_name["nearest", clutter, s] - by_name["window", clutter, s] for s in range(12)]
        own = table.filter(
            metric="gospa", **{"scenario.sensors.clutter_per_scan": clutter}
        ).row(0, named=True)  # fmt: skip
        ends = stats.ttest_1samp(apart, 0.0).confidence_interval(0.95)
        assert (own["low"], own["high"]) == pytest.approx(ends)
        # What seeds have in common cancels out: means alone could not tell the two apart.
        whole = (
            summary_of(runs, study)
            .filter(metric="gospa", configuration="nearest")
            .row(0, named=True)
        )
        assert own["high"] - own["low"] < 0.5 * (whole["high"] - whole["low"])
        assert own["low"] > 0.0


def test_the_baseline_is_the_first_point_of_the_one_that_is_named() -> None:
    given = changed("study.baseline", "nearest")
    given = changed("configurations.window.sweep", {"window": {"depth": [2, 3]}}, given)
    study = read_study(given)
    cases, found = measured(study)
    table = differences_of(runs_table(study, cases, found)[0], study)
    assert set(table["configuration"]) == {"window"}
    assert set(table["configuration.window.depth"]) == {2.0, 3.0}
    swept = read_study({**given, "study": {**given["study"], "baseline": "window"}})
    cases, found = measured(swept)
    table = differences_of(runs_table(swept, cases, found)[0], swept)
    points = set(table.select("configuration", "configuration.window.depth").rows())
    assert points == {("window", 3.0), ("nearest", None)}


def test_a_failed_run_is_a_row_with_its_error_and_in_no_mean() -> None:
    study = read_study(changed("study.seeds", 5))
    cases, found = measured(study, fail=1)
    runs, timing = runs_table(study, cases, found)
    row = runs.row(1, named=True)
    assert (row["error"], row["gospa"], row["seed"]) == ("boom", None, 1)
    assert timing["cpu_s"].null_count() == 1
    own = summary_of(runs, study).filter(metric="gospa").row(0, named=True)
    values = [found[number]["measures"]["gospa"] for number in (0, 2, 3, 4)]
    assert own["mean"] == pytest.approx(np.mean(values))
    assert (own["draws"], own["failed"]) == (4, 1)
    apart = differences_of(runs, study).filter(metric="gospa").row(0, named=True)
    assert apart["draws"] == 4


def test_pieces_of_a_recording_are_the_draws_each_averaged_over_its_seeds(tmp_path) -> None:
    file = tmp_path / "r.csv"
    file.write_text("time,x,y\n0,1,2\n")
    scenarios = {"rec": {"reports": str(file), "pieces": 3}}
    study = read_study(changed("scenarios", scenarios))
    cases, found = measured(study)
    own = summary_of(runs_table(study, cases, found)[0], study).filter(
        metric="gospa", configuration="window"
    )
    pieces = [
        np.mean([found[number]["measures"]["gospa"] for number, case in enumerate(cases)
                 if case.piece == piece and case.configuration == "window"])
        for piece in range(3)
    ]  # fmt: skip
    assert own["draws"].to_list() == [3]
    assert own["mean"][0] == pytest.approx(np.mean(pieces))
    assert (own["low"][0], own["high"][0]) == pytest.approx(
        stats.ttest_1samp(pieces, 0.0).confidence_interval(0.95)
    )


def recorded(tmp_path: Path, seeds: int = 4) -> StudyPlan:
    """Return a study over a recording in one piece."""
    file = tmp_path / "r.csv"
    file.write_text("time,x,y\n0,1,2\n")
    given = changed("scenarios", {"rec": {"reports": str(file)}})
    return read_study(changed("study.seeds", seeds, given))


def test_seeds_that_change_nothing_of_a_recording_are_one_draw(tmp_path: Path) -> None:
    study = recorded(tmp_path)
    cases, found = measured(study)
    for number, case in enumerate(cases):
        found[number]["measures"]["gospa"] = 20.1 if case.configuration == "window" else 20.4
    runs, timing = runs_table(study, cases, found)
    for table in (summary_of(runs, study), differences_of(runs, study)):
        own = table.filter(metric="gospa")
        assert own["draws"].unique().to_list() == [1]
        assert own["low"].null_count() == own["high"].null_count() == len(own)
        assert encode_table(own, "t.csv").endswith((b",,,1\n", b",,,1,0\n"))
    tables = {"runs": runs, "timing": timing, "summary": summary_of(runs, study),
              "differences": differences_of(runs, study)}  # fmt: skip
    report = report_of(study, tables, [])
    assert "One draw has none: of a recording in one piece each seed tracks the same" in report
    assert "| 20.4 | – |" in report
    assert set(figures_of(study, runs, timing)) == {"quality-by-cpu.png"}


def test_seeds_that_a_search_draws_by_keep_their_interval(tmp_path: Path) -> None:
    study = recorded(tmp_path)
    cases, found = measured(study)
    for number, case in enumerate(cases):
        if case.configuration == "window":
            found[number]["measures"]["gospa"] = 20.1
    runs, _ = runs_table(study, cases, found)
    draws = {
        row["configuration"]: (row["draws"], row["low"] is None)
        for row in summary_of(runs, study).filter(metric="tracks").iter_rows(named=True)
    }
    assert draws == {"window": (1, True), "nearest": (4, False)}
    # Two searches that differ by chance in step are draws of a difference all the same.
    for number, case in enumerate(cases):
        found[number]["measures"]["gospa"] = float(case.seed)
    runs, _ = runs_table(study, cases, found)
    assert differences_of(runs, study).filter(metric="gospa")["draws"].to_list() == [4]


def test_simulated_draws_that_come_out_alike_stay_draws() -> None:
    study = read_study(changed("study.seeds", 5))
    cases, found = measured(study)
    for run in found.values():
        run["measures"]["gospa"] = 0.0
    own = summary_of(runs_table(study, cases, found)[0], study).filter(metric="gospa")
    assert own["draws"].unique().to_list() == [5]
    assert own["low"].to_list() == own["high"].to_list() == [0.0] * 4


def test_what_needs_a_truth_that_is_not_there_is_told(tmp_path: Path) -> None:
    study = recorded(tmp_path)
    cases, found = measured(study)
    for run in found.values():
        run["measures"]["gospa"] = None
    runs, _ = runs_table(study, cases, found)
    (note,) = unmeasured(study, runs)
    assert note.startswith("gospa, idf1: not measured in any run of scenario rec, which has no tr")
    assert note.endswith("`metrics` that need none: reports, tracks, mean_gap, log_likelihood.")


def test_a_name_with_a_bar_stays_one_cell() -> None:
    text = text_table(["a|b", "c"], [["x|y", 1.0]])
    assert text.splitlines()[0] == r"| a\|b | c |"
    assert text.splitlines()[2] == r"| x\|y | 1 |"


def test_a_swept_key_of_several_kinds_is_text() -> None:
    sweep = {
        "search": {"method": ["auto", "exact"]},
        "sensors": {"default": {"sigma": [5, {"x": 5.0, "y": 6.0}]}},
    }
    study = read_study(changed("configurations.window.sweep", sweep))
    cases, found = measured(study)
    runs, _ = runs_table(study, cases, found)
    assert set(runs["configuration.search.method"]) == {"auto", "exact", None}
    assert set(runs["configuration.sensors.default.sigma"]) == {"5", '{"x": 5.0, "y": 6.0}', None}


def test_the_small_study_is_what_the_tests_think() -> None:
    assert read_study(STUDY).runs() == 8
