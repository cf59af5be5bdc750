"""STUDY.toml: what it says, and how each mistake in it is told."""

from pathlib import Path
from typing import Any

import pytest

from oracles.small_study import SCENE, STUDY, changed
from trackweave.errors import InvalidInputError
from trackweave.experiments.cases import cases_of, jobs_of
from trackweave.experiments.study_file import StudyPlan, read_study
from trackweave.experiments.studying import MANY, require_few


def test_runs_are_all_points_with_all_seeds_each_once() -> None:
    study = read_study(changed("configurations.window.sweep", {"window": {"depth": [2, 3, 5]}}))
    cases = list(cases_of(study))
    assert len(cases) == study.runs() == 2 * (3 + 1) * 2
    named = {
        (one.scene["sensors", "clutter_per_scan"], one.configuration,
         one.point.get(("window", "depth")), one.seed)
        for one in cases
    }  # fmt: skip
    wanted = {
        (clutter, *way, seed)
        for clutter in (1, 6)
        for way in (("window", 2), ("window", 3), ("window", 5), ("nearest", None))
        for seed in (0, 1)
    }
    assert named == wanted


def test_points_are_laid_over_what_is_set() -> None:
    given = changed("scenarios.sea.sweep", {"sensors": {"radar": {"sigma": [3.0, 4.0]}}})
    given = changed("configurations.window.sweep", {"window": {"depth": [4]}}, given)
    study = read_study(given)
    jobs = jobs_of(study, list(cases_of(study)))
    assert [job.reports["sensors"][0]["sigma"] for job in jobs] == [3.0] * 4 + [4.0] * 4
    assert jobs[0].values["window"] == {"depth": 4}
    assert jobs[0].values["motion"]["max_speed"] == 30.0
    assert "window" not in jobs[2].values


def test_sensors_are_told_as_the_scenario_has_them_where_configurations_are_silent() -> None:
    own = {"sensors": {"default": {"clutter_per_scan": 9.0}, "radar": {"sigma": 7.0}}}
    study = read_study(changed("configurations.window.set", own))
    jobs = jobs_of(study, list(cases_of(study)))
    assert jobs[0].values["sensors"]["radar"] == {
        "sigma": 7.0, "detection_probability": 0.9, "scan_period": 2.0, "position": [0.0, 0.0],
    }  # fmt: skip
    assert jobs[2].values["sensors"]["radar"]["clutter_density"] == pytest.approx(1 / 600**2)
    assert jobs[-1].values["sensors"]["radar"]["clutter_density"] == pytest.approx(6 / 600**2)


def test_paths_count_from_the_study_files_folder(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(
        "duration = 9.0\n[area]\nlow = [0, 0]\nhigh = [9, 9]\n"
        '[[sensors]]\nname = "a"\nsigma = 1.0\nscan_period = 1.0\n'
    )
    (tmp_path / "tracker.toml").write_text("[window]\ndepth = 3\n")
    file = tmp_path / "study.toml"
    file.write_text(
        '[scenarios.one]\nfile = "scene.toml"\n[configurations.one]\nfile = "tracker.toml"\n'
        "[configurations.one.set]\nwindow.max_scans = 20\n"
    )
    study = read_study(file)
    assert study.scenes["one"].table["duration"] == 9.0
    assert study.configurations["one"].values == {"window": {"depth": 3, "max_scans": 20}}


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("study.seeds", 0, "study, study.seeds: 0; expected a whole number from 1 to 1000000"),
        ("study.seed", 3, "study, study.seed: unknown key; did you mean seeds?"),
        ("study.metrics", ["gosp"], r"study.metrics: \[\"gosp\"\]; expected .*gospa"),
        ("study.metrics", ["gospa", "gospa"], "study.metrics: a measure twice"),
        ("study.baseline", "windw", "study.baseline: 'windw'; did you mean window?"),
        ("tune.configuration", "x", "tune.configuration: 'x'; expected one of window, nearest"),
        ("scenarios", None, r"study, .*expected at least one table \[scenarios.NAME\]"),
        ("configurations", {}, r"expected at least one table \[configurations.NAME\]"),
        ("scenarios.sea.file", "x.toml", "scenarios.sea: .*expected one of file"),
        ("scenarios.sea.truth", "t.csv", "expected truth and pieces beside reports alone"),
        ("scenarios.more", {"reports": "no.csv"}, "scenarios.more: no.csv: no such file"),
        ("configurations.window.preset", "hilis", 'window.preset: "hilis" is not known; did you'),
        ("scenarios.sea.scene.duration", -1.0, r"sea \(sensors.clutter_per_scan = 1\), d"),
        ("scenarios.sea.sweep.sensors", {"sigm": [1.0]}, "sensors.sigm: no sensor of the sce"),
        ("scenarios.sea.sweep.sensors", {"radar": {"x": [1]}}, "expected one of the keys name, s"),
        ("configurations.window.set.window", {"dept": 3}, "window, window.dept: unknown key; did"),
        ("configurations.window.sweep", {"window": {"depth": [3, 0]}},
         r"study, configurations.window \(window.depth = 0\), window.depth: 0; expected a whole"),
    ],
)  # fmt: skip
def test_a_wrong_key_is_told_before_anything_runs(path: str, value: Any, message: str) -> None:
    def check(study: StudyPlan) -> None:
        jobs_of(study, list(cases_of(study)))

    with pytest.raises(InvalidInputError, match=message):
        check(read_study(changed(path, value)))


@pytest.mark.parametrize("source", [None, 3, ["study.toml"]])
def test_a_study_is_a_file_or_a_mapping(source: Any) -> None:
    with pytest.raises(InvalidInputError, match="expected the path of a TOML file, or a mapping"):
        read_study(source)


def test_more_runs_than_meant_are_told_with_their_number() -> None:
    study = read_study(changed("study.seeds", 1_000_000))
    assert study.runs() == 4_000_000
    with pytest.raises(InvalidInputError, match=r"4,000,000 runs; expected .*10,000, or --yes"):
        require_few(study.runs(), study.name, yes=False)
    require_few(study.runs(), study.name, yes=True)
    require_few(MANY, study.name, yes=False)
    with pytest.raises(InvalidInputError, match=r"expected at most 10,000,000$"):
        require_few(10**9, study.name, yes=True)


def test_what_makes_runs_differ_makes_studies_differ() -> None:
    parts = read_study(STUDY).parts
    for path, value, part in (
        ("study.seeds", 3, "study"),
        ("study.cutoff", 20.0, "study"),
        ("scenarios.sea.scene", {**SCENE, "duration": 24.0}, "scenarios"),
        ("configurations.window.sweep", {"window": {"depth": [3]}}, "configurations"),
    ):
        other = read_study(changed(path, value)).parts
        assert [name for name in parts if parts[name] != other[name]] == [part]
    assert read_study(changed("study.metrics", ["mota"])).parts == parts


def test_the_order_of_configurations_makes_studies_differ() -> None:
    ways = STUDY["configurations"]
    turned = {**STUDY, "configurations": dict(reversed(ways.items()))}
    assert read_study(turned).parts["configurations"] != read_study(STUDY).parts["configurations"]


def test_a_recording_that_changed_makes_studies_differ(tmp_path: Path) -> None:
    file = tmp_path / "r.csv"
    given = changed("scenarios", {"rec": {"reports": str(file)}})
    digests = []
    for text in ("time,x,y\n0,1,2\n", "time,x,y\n0,1,3\n"):
        file.write_text(text)
        digests.append(read_study(given).parts["scenarios"])
    assert digests[0] != digests[1]


@pytest.mark.parametrize(
    "sweep",
    [
        {"radar": {"clutter_per_scan": [1]}, "clutter_per_scan": [2, 3]},
        {"clutter_per_scan": [2, 3], "radar": {"clutter_per_scan": [1]}},
    ],
)
def test_a_key_swept_of_all_sensors_and_of_one_is_refused(sweep: dict) -> None:
    with pytest.raises(
        InvalidInputError,
        match=r"sea\.sweep\.sensors\.radar\.clutter_per_scan: swept, and so is "
        r"sensors\.clutter_per_scan of all sensors; expected one of the two",
    ):
        read_study(changed("scenarios.sea.sweep", {"sensors": sweep}))


def test_keys_of_all_sensors_and_others_of_one_may_be_swept() -> None:
    sweep = {"sensors": {"radar": {"clutter_per_scan": [1]}, "sigma": [2, 3]}}
    assert read_study(changed("scenarios.sea.sweep", sweep)).runs() == 8
