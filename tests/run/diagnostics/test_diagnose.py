"""What is wrong with a scene is the first thing that a run says of it; of a right one, nothing."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from run.diagnostics.scenes import contradictions
from trackweave import track
from trackweave.run.diagnostics.across import Sample, _of_units
from trackweave.run.diagnostics.case import Path

pytestmark = pytest.mark.slow

SCENES = contradictions()
# All of them, and more seeds, are `python benchmarks/contradictions.py`.
SOME = (
    "one radar's x and y exchanged",
    "all in kilometres", "one radar's azimuths in radians", "sigma ÷ 100", "P_D ÷ 10",
    "clutter ÷ 10", "max_speed ÷ 10", "process noise ÷ 30", "a field of view too short",
    "one radar mirrored", "one radar's reports copied", "max_speed × 30",
)  # fmt: skip


def record_of(made: Any, config: Any) -> dict[str, Any]:
    return track(made.reports.drop("target"), config, rng=np.random.default_rng(1)).run


@pytest.mark.parametrize("name", SOME)
def test_names_what_is_wrong_first(name: str) -> None:
    wrong = SCENES.CONTRADICTIONS[name]
    made = wrong.spoil(SCENES.scene(1, polar=wrong.polar))
    run = record_of(made, made.told)
    assert run["diagnostics"][0]["cause"] in wrong.causes
    assert run["notes"][0] == run["diagnostics"][0]["sentence"]


@pytest.mark.parametrize(
    ("name", "key", "wrong"),
    [
        ("one clock 10 s ahead", "clock_offset", 10.0),
        ("one radar 500 m off", "translation", 500.0),
    ],
)
def test_takes_out_what_is_wrong_with_one_sensor_alone(name: str, key: str, wrong: float) -> None:
    made = SCENES.CONTRADICTIONS[name].spoil(SCENES.scene(1))
    run = record_of(made, made.told)
    sensors = run["registration"]["sensors"]
    used = {each: np.linalg.norm(own[key]["used"]) for each, own in sensors.items()}
    assert sorted(used.values()) == [0.0, 0.0, pytest.approx(wrong, rel=0.05)]
    assert key in run["notes"][0]


@pytest.mark.parametrize("polar", [False, True])
@pytest.mark.parametrize("is_told", [False, True])
def test_says_nothing_of_a_scene_in_which_nothing_is_wrong(polar: bool, is_told: bool) -> None:
    made = SCENES.scene(1, polar=polar)
    places = {name: {"position": list(place)} for name, place in SCENES.PLACES.items()}
    run = record_of(made, made.told if is_told else {"sensors": places})
    assert run["diagnostics"] == []


def test_tells_the_number_told_and_the_number_seen() -> None:
    made = SCENES.CONTRADICTIONS["P_D ÷ 10"].spoil(SCENES.scene(1))
    found = record_of(made, made.told)["diagnostics"][0]
    assert found["told"] == pytest.approx(made.truth["detection"] / 10)
    assert found["seen"] == pytest.approx(made.truth["detection"], abs=0.08)
    assert f"told as {found['told']:g}" in found["sentence"]


def test_says_loudly_that_hardly_any_report_is_in_a_track() -> None:
    rng = np.random.default_rng(1)
    made = SCENES.scene(1)
    scattered = made.reports.with_columns(
        x=rng.uniform(0, 1e5, len(made.reports)), y=rng.uniform(0, 1e5, len(made.reports))
    )
    found = record_of(SCENES.Scene(scattered, made.told), None)["diagnostics"]
    assert any(each["sentence"].startswith("only ") for each in found)


def test_tracks_by_a_documents_letter_judge_no_sensor() -> None:
    wrong = SCENES.CONTRADICTIONS["sigma ÷ 100"]
    made = wrong.spoil(SCENES.scene(1, polar=wrong.polar))
    run = track(made.reports.drop("target"), made.told, preset="wiranto-2018").run
    assert run["diagnostics"] == []


@pytest.mark.parametrize(("far", "is_said"), [(1_800.0, False), (20_000.0, True)])
def test_what_all_lies_in_one_place_in_another_unit_is_not_in_that(far: float, is_said: bool):
    """Animals on a few kilometres, beside a camera that sees some near one place."""
    rng, time = np.random.default_rng(2), np.arange(0.0, 100.0)
    there = rng.normal(0.0, 2.0, (100, 2))
    path = Path(time, there, np.ones(100), np.arange(100))
    place = rng.normal(0.0, far, (100, 2))
    sample = Sample(0, time, place, np.zeros((100, 2)), [path], near=1.6, extent=80.0)
    kind = SimpleNamespace(has_range=False)
    case = SimpleNamespace(reports=SimpleNamespace(kind_of=lambda index: kind))
    units = {cause.word for cause in _of_units(sample, case)}
    assert ("millimetres" in units) is is_said
