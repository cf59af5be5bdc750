"""Successive halving, against made-up measures whose best is known, and on real runs."""

import json
import math
import tomllib
from pathlib import Path
from typing import Any

import pytest

import trackweave as tw
from oracles.small_study import SCENE, STUDY, TOLD, changed
from trackweave.errors import InvalidInputError
from trackweave.experiments import tuning

SWEPT = changed("configurations.window.sweep", {"window": {"depth": [1, 2, 3, 4, 5, 6, 7, 8, 9]}})


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int | None, int]]:
    """Have measures made up, best at a depth of 4; return what ran: depth and seed."""
    ran: list[tuple[int | None, int]] = []

    def made_up(jobs: Any, wanted: Any, log: Any, *_: object) -> None:
        for number in wanted:
            if number in log.found:
                continue
            job = jobs[number]
            depth = job.values.get("window", {}).get("depth")
            ran.append((depth, job.seed))
            far = 10.0 if depth is None else abs(depth - 4.0)
            # The luck of a draw is the same for all.
            luck = 100.0 * math.sin(job.seed)
            found = {"log_likelihood": luck - far, "gospa": luck + far, "idf1": None}
            log.add(number, {"measures": found, "timing": {}})

    monkeypatch.setattr(tuning, "run_jobs", made_up)
    return ran


def tuned(runs: list, given: dict, **table: Any) -> tw.TuningResult:
    runs.clear()
    return tw.tune({**given, "tune": table}, workers=1)


@pytest.mark.parametrize("objective", ["log_likelihood", "gospa"])
def test_finds_the_best_with_fewer_runs_than_all(runs: list, objective: str) -> None:
    given = changed("study.seeds", 9, SWEPT)
    found = tuned(runs, given, objective=objective)
    assert found.best["window"] == {"depth": 4}
    assert found.best["motion"] == TOLD["motion"]
    # Two clutters and nine seeds are 18 draws: of 9 candidates 1 draw, 3 on 3, the best on 9; the
    # configuration as it is on all of these.
    assert len(runs) == (9 * 1) + (3 * 2) + (1 * 6) + 9
    assert len(set(runs)) <= len(runs)


def test_says_so_where_no_candidate_is_better_than_none(runs: list) -> None:
    worse = {"window": {"depth": [15, 16, 17]}}
    found = tuned(runs, changed("configurations.window.sweep", worse), objective="gospa")
    assert "window" not in found.best
    assert found.trials["candidate"][0] == 0
    assert "No candidate is better than candidate 0; the last that was left is 1." in found.report


def test_every_round_has_the_best_of_the_one_before_on_the_same_draws(runs: list) -> None:
    found = tuned(runs, changed("study.seeds", 9, SWEPT), keep=2, first=2)
    ran = dict(zip(found.trials["window.depth"], found.trials["runs"], strict=True))
    # 9 on 2 draws, 5 on 4, 3 on 8, 2 on 16, and the best on all 18.
    assert sorted(ran.values()) == [2, 2, 2, 2, 4, 4, 8, 16, 18, 18]
    assert ran[""] == ran["4"] == 18
    assert sorted(depth for depth, number in ran.items() if number == 2) == ["1", "7", "8", "9"]
    assert found.trials["window.depth"][0] == "4"
    seeds = {depth: [s for d, s in runs if d == depth] for depth in (4, None)}
    assert seeds[4] == seeds[None]


def test_more_points_than_candidates_are_drawn_from_the_same_seed(runs: list) -> None:
    first = tuned(runs, SWEPT, candidates=4).trials["window.depth"].to_list()
    again = tuned(runs, SWEPT, candidates=4).trials["window.depth"].to_list()
    assert first == again
    assert len(set(first) - {""}) == 4


def test_points_may_be_proposed_and_a_search_goes_on_where_it_was(
    runs: list, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("optuna")
    swept = {"window": {"depth": list(range(1, 101))}}
    table = {"sampler": "tpe", "candidates": 32}
    given = changed("configurations.window.sweep", swept, changed("study.seeds", 9))
    whole = tuned(runs, given, **table)
    n_runs = len(runs)
    tried = [int(depth) for depth in whole.trials["window.depth"] if depth]
    assert len(set(tried)) == 32
    assert abs(whole.best["window"]["depth"] - 4) <= 3

    made_up, left = tuning.run_jobs, [5]

    def stopping(*given: object) -> None:
        if not left[0]:
            raise KeyboardInterrupt
        left[0] -= 1
        made_up(*given)

    monkeypatch.setattr(tuning, "run_jobs", stopping)
    with pytest.raises(KeyboardInterrupt):
        tw.tune({**given, "tune": table}, tmp_path / "out")
    left[0] = 100
    runs.clear()
    again = tw.tune({**given, "tune": table}, tmp_path / "out")
    assert again.trials.equals(whole.trials)
    assert again.report == whole.report
    assert 0 < len(runs) < n_runs


def test_every_value_that_may_be_proposed_is_checked_before_anything_runs(runs: list) -> None:
    pytest.importorskip("optuna")
    given = changed("configurations.window.sweep", {"window": {"depth": [*range(1, 60), 999]}})
    with pytest.raises(InvalidInputError, match=r"window.depth: 999"):
        tuned(runs, given, sampler="tpe", candidates=5)
    assert runs == []


def test_a_candidate_that_fails_is_behind_all_others(
    runs: list, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = tuning.run_jobs

    def failing(jobs: Any, wanted: Any, log: Any, *rest: object) -> None:
        good(jobs, wanted, log, *rest)
        for number in wanted:
            if jobs[number].values.get("window", {}).get("depth") == 4:
                log.add(number, {"error": "boom", "is_lost": False})

    monkeypatch.setattr(tuning, "run_jobs", failing)
    assert tuned(runs, SWEPT).best["window"]["depth"] in (3, 5)


def test_nobody_having_the_objective_is_told(runs: list) -> None:
    with pytest.raises(
        InvalidInputError, match=r"no candidate has idf1 \(reports or truth do not"
    ):
        tuned(runs, SWEPT, objective="idf1")


@pytest.mark.parametrize(
    ("given", "table", "message"),
    [
        (STUDY, {}, "tune.configuration: left out; expected .* with a sweep: there is none"),
        (SWEPT, {"configuration": "nearest"}, "tune.configuration: nearest; .*: window$"),
        (SWEPT, {"objective": "tracks"}, "tune.objective: tracks, of which neither more nor less"),
        (SWEPT, {"objective": "speed"}, "tune.objective: .*expected one of"),
        (SWEPT, {"sampler": "grid"}, "tune.sampler: .*; expected random or tpe"),
        (SWEPT, {"keep": 1}, "tune.keep: 1; expected a whole number from 2 to 10"),
    ],
)
def test_what_cannot_be_searched_is_refused(given: dict, table: dict, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        tw.tune({**given, "tune": table})


def test_writes_a_configuration_that_track_reads(runs: list, tmp_path: Path) -> None:
    own = {
        "sensors": {"radar 1": {"sigma": {"x": 5.0, "y": 6.0}}},
        "lifecycle": {"confirm": "2/3"},
    }
    given = changed("configurations.window.set", own, SWEPT)
    out = tmp_path / "out"
    found = tw.tune({**given, "tune": {}}, out)
    assert tomllib.loads((out / "tuned.toml").read_text()) == found.best
    record = json.loads((out / "run.json").read_text())
    assert (record["command"], record["complete"]) == ("tune", True)
    assert record["files"] == sorted(path.name for path in out.iterdir())
    ran = len(runs)
    # What is in the log counts no earlier than it did.
    again = tw.tune({**given, "tune": {}}, out)
    assert len(runs) == ran
    assert again.trials.equals(found.trials)
    assert again.report == found.report
    assert "The best is candidate 4." in found.report


def test_what_sensors_were_told_in_the_search_is_said(runs: list) -> None:
    given = changed("scenarios.sea.sweep", {"sensors": {"clutter_per_scan": [1, 6]}}, SWEPT)
    found = tw.tune({**given, "tune": {}})
    assert found.told["sensors.radar.scan_period"] == ("2.0",)
    assert len(found.told["sensors.radar.clutter_density"]) == 2
    text = found.files()["tuned.toml"].decode()
    assert "\n# sensors.radar.sigma = 5.0\n" in text
    assert tomllib.loads(text) == found.best
    silent = tw.tune({**changed("study.tell_sensors", False, SWEPT), "tune": {}})
    assert silent.told == {}
    assert "tell_sensors" not in silent.files()["tuned.toml"].decode()


def test_noise_is_found_from_reports_alone() -> None:
    told = {"sensors": {"default": {"clutter_density": 8e-6, "detection_probability": 0.9,
                                    "trust": True}}}  # fmt: skip
    given = {
        "study": {"seeds": 2},
        "scenarios": {"sea": {"scene": SCENE}},
        "configurations": {"one": {
            "set": {**TOLD, **told}, "sweep": {"sensors": {"default": {"sigma": [1, 5, 40]}}},
        }},
    }  # fmt: skip
    found = tw.tune(given, workers=1)
    assert found.best["sensors"]["default"]["sigma"] == 5.0
