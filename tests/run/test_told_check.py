"""What is told of sensors and objects gives way where a whole run contradicts it."""

from typing import Any

import numpy as np
import polars as pl
import pytest

from trackweave import track
from trackweave.metrics import assignment_quality

SIZE, N_BOATS, N_FALSE, SIGMA, SEEN = 2000.0, 10, 8, 6.0, 0.7


def boats(seed: int = 5, sensors: tuple[str, ...] = ("default",)) -> pl.DataFrame:
    """Return what sensors see of boats that cross a square, in turn, and of nobody."""
    rng = np.random.default_rng(seed)
    place = rng.uniform(0.15 * SIZE, 0.85 * SIZE, (N_BOATS, 2))
    course, speed = rng.uniform(0, 2 * np.pi, N_BOATS), rng.uniform(2.0, 9.0, N_BOATS)
    rows = []
    for look in range(90):
        time, name = 2.0 * look, sensors[look % len(sensors)]
        there = place + (time - 90.0) * (speed * [np.sin(course), np.cos(course)]).T
        inside = np.flatnonzero(((there > 0) & (there < SIZE)).all(axis=1))
        for one in inside[rng.random(inside.size) < SEEN]:
            x, y = there[one] + rng.normal(0.0, SIGMA, 2)
            rows.append((time, name, x, y, f"b{one}"))
        for x, y in rng.uniform(0.0, SIZE, (rng.poisson(N_FALSE), 2)):
            rows.append((time, name, x, y, ""))
    schema = ["time", "sensor", "x", "y", "target"]
    return pl.DataFrame(rows, schema=schema, orient="row")


def told(motion: dict[str, Any] | None = None, **sensor: Any) -> dict[str, Any]:
    """Return what an engineer would tell, some of it otherwise."""
    right = {
        "sigma": SIGMA, "detection_probability": SEEN, "clutter_per_scan": N_FALSE,
        "scan_period": 2.0, "field_of_view": square(0.0),
    }  # fmt: skip
    motion = {"process_noise": 0.01, "max_speed": 12.0, **(motion or {})}
    return {"motion": motion, "sensors": {"default": right | sensor}}


def square(edge: float) -> dict[str, Any]:
    low, high = edge, SIZE - edge
    return {"polygon": [[low, low], [high, low], [high, high], [low, high]]}


def quality(reports: pl.DataFrame, result: Any) -> float:
    tracks = result.assignments.with_columns(pl.col("track").cast(pl.String).fill_null(""))
    return assignment_quality(reports["target"].to_list(), tracks["track"].to_list()).idf1


WRONG = {
    "field_of_view": told(field_of_view=square(400.0)),
    "detection_probability": told(detection_probability=0.99),
    "clutter_per_scan": told(clutter_per_scan=0.4),
    "max_speed": told({"max_speed": 3.0}),
}


@pytest.mark.parametrize("key", WRONG)
def test_what_is_told_wrongly_gives_way_and_is_said(key: str) -> None:
    reports = boats()
    right, wrong = (track(reports.drop("target", "sensor"), each) for each in (told(), WRONG[key]))
    assert right.run["told"][1:] == []
    (judged,) = wrong.run["told"][1:]
    assert judged["key"].endswith(key)
    assert judged["used"] == judged["learned"] != judged["told"]
    sentence = wrong.run["notes"][0]
    assert f'trust = ["{key}"]' in sentence
    assert "used" in sentence
    assert quality(reports, wrong) > quality(reports, right) - 0.02


@pytest.mark.parametrize("key", ["field_of_view", "max_speed"])
def test_what_is_trusted_is_kept(key: str) -> None:
    wrong = {name: dict(table) for name, table in WRONG[key].items()}
    owner = wrong["motion"] if key == "max_speed" else wrong["sensors"]["default"]
    owner["trust"] = [key]
    run = track(boats().drop("target", "sensor"), wrong).run
    assert all(not each["key"].endswith(key) for each in run["told"])
    assert run["configuration"]["motion"]["max_speed"] == wrong["motion"]["max_speed"]
    assert any("told as 3" in note or "outside its own" in note for note in run["notes"])


def test_what_is_told_of_all_sensors_gives_way_of_each() -> None:
    reports = boats(sensors=("east", "west"))
    wrong = told(detection_probability=0.99, scan_period=4.0)
    run = track(reports.drop("target"), wrong).run
    keys = {each["key"] for each in run["told"] if "detection" in each["key"]}
    assert keys == {f"sensors.{name}.detection_probability" for name in ("east", "west")}
    for name in ("east", "west"):
        own = run["configuration"]["sensors"][name]
        assert own["detection_probability"] == pytest.approx(SEEN, abs=0.1)
        assert own["sigma"] == SIGMA
        assert own["field_of_view"] == square(0.0)
    assert sum("detection_probability is told" in note for note in run["notes"]) == 1


@pytest.mark.parametrize("careful", [{"detection_probability": 0.3}, {"clutter_per_scan": 80.0}])
def test_who_tells_more_misses_and_false_alarms_than_there_are_is_heard(
    careful: dict[str, float],
) -> None:
    run = track(boats().drop("target", "sensor"), told(**careful)).run
    ((key, value),) = careful.items()
    assert run["configuration"]["sensors"]["default"][key] == value
    assert any(f"{key} " in note and "correct it" in note for note in run["notes"])
