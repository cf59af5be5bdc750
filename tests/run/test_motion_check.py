"""What is told of the process noise, and what becomes of it where tracks break off."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import polars as pl
import pytest

from trackweave import track
from trackweave.config import Configuration
from trackweave.metrics import assignment_quality
from trackweave.run import motion_check
from trackweave.run.diagnostics import Case
from trackweave.simulation import demo_scenario, simulate

SIGMA, SCANS, N_OBJECTS = 3.0, 60, 8
TURN_EVERY, TURN = 12, np.radians(50.0)


def reports(*, turning: bool, seed: int = 1) -> pl.DataFrame:
    """Return reports of eight objects, which turn sharply every twelve scans or never."""
    rng = np.random.default_rng(seed)
    heading = rng.uniform(0.0, 2.0 * np.pi, N_OBJECTS)
    place = 600.0 * np.stack(np.divmod(np.arange(N_OBJECTS), 3), axis=1)
    rows = []
    for time in range(SCANS):
        if turning:
            turns = (time + np.arange(N_OBJECTS)) % TURN_EVERY == 0
            heading = heading + TURN * turns * rng.choice([-1.0, 1.0], N_OBJECTS)
        place = place + 10.0 * np.stack([np.cos(heading), np.sin(heading)], axis=1)
        seen = place + SIGMA * rng.normal(size=place.shape)
        rows += [(float(time), *at.tolist()) for at in seen[rng.random(N_OBJECTS) < 0.95]]
    return pl.DataFrame(rows, schema=["time", "x", "y"], orient="row")


def told(process: float, **more: Any) -> dict[str, Any]:
    """Return all that an engineer would tell of these objects and their sensor."""
    sensor = {
        "sigma": SIGMA,
        "detection_probability": 0.95,
        "clutter_density": 1e-8,
        "scan_period": 1.0,
    }
    return {
        "motion": {"process_noise": process, "max_speed": 15.0, **more},
        "lifecycle": {"new_target_density": 1e-8},
        "sensors": {"default": sensor},
    }


def process_in(run: dict[str, Any]) -> float:
    return run["configuration"]["motion"]["process_noise"]


@pytest.mark.slow
def test_replaces_a_process_noise_under_which_tracks_break_in_turns() -> None:
    result = track(reports(turning=True), told(0.005))
    run = result.run
    judged = {each["key"]: each for each in run["told"]}["motion.process_noise"]
    assert judged["told"] == 0.005
    assert judged["used"] == judged["learned"] == process_in(run) > 0.1
    assert run["sources"]["motion.process_noise"] == "estimated"
    assert run["diagnostics"][0]["cause"] == "process_noise"
    assert 'trust = ["process_noise"] in [motion]' in run["notes"][0]
    assert result.history["track"].n_unique() <= N_OBJECTS + 2


@pytest.mark.parametrize("trust", [True, ["process_noise"]])
def test_keeps_a_process_noise_that_is_trusted(trust: Any) -> None:
    run = track(reports(turning=True), told(0.005, trust=trust)).run
    assert process_in(run) == 0.005
    assert run["sources"]["motion.process_noise"] == "file"


@pytest.mark.parametrize("process", [1e-4, 0.01, 1.0])
def test_keeps_a_process_noise_under_which_no_track_breaks(process: float) -> None:
    run = track(reports(turning=False), told(process)).run
    assert process_in(run) == process
    assert "motion.process_noise" not in {each["key"] for each in run["told"]}


@pytest.mark.slow
def test_a_run_that_learned_its_process_noise_is_the_run_that_was_told_none() -> None:
    table, untold = reports(turning=True), told(0.005)
    del untold["motion"]["process_noise"]
    learned, free = track(table, told(0.005)), track(table, untold)
    assert learned.assignments.equals(free.assignments)


def few_turning(seed: int) -> pl.DataFrame:
    """Return reports of twelve objects that go straight and of one that turns hard."""
    rng = np.random.default_rng(seed)
    heading = rng.uniform(0.0, 2.0 * np.pi, 13)
    place = 3000.0 * np.stack(np.divmod(np.arange(13), 4), axis=1)
    rows = []
    for time in range(80):
        heading[-1] += 1.2 * (time % 12 < 2)
        place = place + 10.0 * np.stack([np.cos(heading), np.sin(heading)], axis=1)
        seen = place + rng.normal(size=place.shape)
        rows += [(float(time), *at.tolist()) for at in seen[rng.random(13) < 0.95]]
    return pl.DataFrame(rows, schema=["time", "x", "y"], orient="row")


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_objects_manoeuvre_where_what_was_learned_of_the_others_breaks_tracks(seed: int) -> None:
    result = track(few_turning(seed))
    motion = result.run["configuration"]["motion"]
    assert result.history["track"].n_unique() == 13
    assert motion["model"] == "imm"
    quiet, manoeuvring = (motion["imm"][way] for way in motion["imm"]["models"])
    assert quiet["process_noise"] < 0.01 < 10.0 < manoeuvring["process_noise"]
    assert result.run["sources"]["motion.model"] == "estimated"
    assert result.run["told"] == []


@pytest.mark.slow
def test_what_is_told_too_small_for_one_that_turns_stays_that_of_the_others() -> None:
    """Untold, the others' process noise would be no more, so that it is tried beside a second."""
    values = told(0.001) | {"sensors": {"default": {"sigma": 1.0, "scan_period": 1.0}}}
    run = track(few_turning(1), values).run
    motion = run["configuration"]["motion"]
    quiet, manoeuvring = (motion["imm"][way] for way in motion["imm"]["models"])
    assert quiet["process_noise"] == 0.001
    assert manoeuvring["process_noise"] > 10.0
    assert run["sources"]["motion.model"] == "estimated"
    assert "changes between that and" in run["notes"][0]
    assert {each["key"]: each["told"] for each in run["told"]}["motion.process_noise"] == 0.001


@pytest.mark.parametrize(("n_left", "is_used"), [(8, True), (30, False)])
def test_a_trial_counts_pieces_too_short_to_show_a_break(
    monkeypatch: pytest.MonkeyPatch, n_left: int, is_used: bool
) -> None:
    values = track(reports(turning=False)).values
    table, settings, doubts = values.reports, values.settings, motion_check.MotionDoubts()
    found = [motion_check._Breaks(number, 3.0, 50.0, 1.0) for number in (8, 5)]
    monkeypatch.setattr(motion_check, "_breaks", lambda _, are_both_sure: found.pop(0))
    # Every object is five pieces at first.
    pieces = np.arange(len(table)) * 40 // len(table)
    assert doubts.contradict(table, settings, pieces, at_end=True)
    assert "imm" in doubts.applied(Configuration({})).table("motion")
    quick = replace(settings, motion=replace(settings.motion, process_noise=50.0))
    left = np.arange(len(table)) * n_left // len(table)
    # Five breaks of eight are more than half.
    assert doubts.contradict(table, quick, left, at_end=True) == (not is_used)
    assert ("imm" in doubts.applied(Configuration({})).table("motion")) == is_used


def lift(seed: int) -> pl.DataFrame:
    """Return cabins 45 m apart, up and down, of a lift that stops twice."""
    rng, rows, moved, speed = np.random.default_rng(seed), [], 0.0, 6.0
    for time in np.arange(0.0, 260.0, 2.0):
        for _ in range(20):
            stands = 100 < time < 130 or 200 < time < 216
            speed += float(np.clip((0.0 if stands else 6.0) - speed, -0.12, 0.08))
            moved += 0.1 * speed
        cabins = np.arange(np.floor(-moved / 45.0), (800.0 - moved) / 45.0)
        for side in (1, -1):
            along = moved + 45.0 * cabins + 5.0 * (1 - side)
            here = (along >= 0) & (along <= 800) & (rng.random(along.size) < 0.9)
            for x, cabin in zip(along[here], cabins[here], strict=True):
                place = rng.normal([x if side > 0 else 800.0 - x, 3.0 * side], 0.8)
                rows.append((time, *place, f"{side * (cabin + 1000):.0f}"))
        rows += [(time, *at, None) for at in rng.uniform((0, -20), (800, 20), (rng.poisson(1), 2))]
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row")


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2])
def test_a_trial_that_failed_is_made_again_where_all_stop_later(seed: int) -> None:
    table = lift(seed)
    found = track(table.drop("target")).assignments["track"].fill_null(-1).to_numpy()
    quality = assignment_quality(table["target"].to_list(), found)
    assert quality.idf1 is not None
    assert quality.idf1 > 0.9


def test_a_model_that_is_told_stays() -> None:
    told = {"motion": {"model": "constant-velocity"}}
    motion = track(few_turning(1), told).run["configuration"]["motion"]
    assert motion["model"] == "constant-velocity"
    assert "imm" not in motion


@pytest.mark.slow
@pytest.mark.parametrize("far", [1.0, 40.0])
def test_no_process_noise_at_all_may_be_told(far: float) -> None:
    moved = reports(turning=True).with_columns(pl.col("x") * far, pl.col("y") * far)
    run = track(moved, told(0.0, trust=True)).run
    assert process_in(run) == 0.0


def test_no_process_noise_at_all_may_be_told_of_what_turns() -> None:
    told = {"motion": {"process_noise": 0.0, "trust": True}}
    assert process_in(track(simulate(demo_scenario(), rng=1).reports, told).run) == 0.0


def crowd(n_false: int) -> float:
    """Return how crowded eight objects are with so many false alarms in each scan."""
    rng = np.random.default_rng(2)
    false = [
        (float(t), *rng.uniform(-200.0, 1600.0, 2)) for t in range(60) for _ in range(n_false)
    ]
    own = reports(turning=False)
    table = own if n_false == 0 else own.vstack(pl.DataFrame(false, own.schema, orient="row"))
    sensor = told(1.0)["sensors"]["default"] | {"clutter_density": max(n_false, 0.1) / 3e6}
    values = track(table, told(1.0) | {"sensors": {"default": sensor}}).values
    track_of = np.full(len(values.reports), -1)
    track_of[list(values.assignment)] = list(values.assignment.values())
    return motion_check._crowd(Case(values.reports, values.settings, track_of, None))


@pytest.mark.slow
def test_others_in_a_gate_are_counted() -> None:
    # In a crowd breaks speak of neighbours: what is told is not put to the trial.
    gate, room = np.pi * (motion_check.GATE * SIGMA) ** 2, 1800.0**2
    others = 300 + 0.95 * N_OBJECTS - 1
    assert crowd(300) == pytest.approx(others * gate / room, rel=0.4)
    assert crowd(30) < crowd(300) / 7.0


def reversing(seed: int) -> pl.DataFrame:
    """Return reports of bacteria that glide, turn back at random, and come and go."""
    rng, side, count = np.random.default_rng(seed), 250.0, 70
    place = rng.uniform(-30.0, side + 30.0, (count, 2))
    heading, step = rng.uniform(0.0, 2.0 * np.pi, count), rng.uniform(1.5, 4.5, count)
    rows = []
    for time in range(0, 7200, 60):
        turn = np.where(rng.random(count) < 1 / 8, np.pi, 0.0)
        heading = heading + turn + rng.normal(0.0, 0.12, count)
        place = place + step[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1)
        place = (place + 40.0) % (side + 80.0) - 40.0
        is_seen = ((place > 0) & (place < side)).all(axis=1) & (rng.random(count) < 0.93)
        seen = place[is_seen] + rng.normal(0.0, 0.3, (is_seen.sum(), 2))
        rows += zip([float(time)] * len(seen), *seen.T, np.flatnonzero(is_seen), strict=True)
    return pl.DataFrame(rows, schema=["time", "x", "y", "target"], orient="row")


@pytest.mark.slow
def test_breaks_that_are_left_speak_of_faster_manoeuvres() -> None:
    table = reversing(3)
    result = track(table.drop("target"))
    ways = result.run["configuration"]["motion"]["imm"]
    # A step of 3 turned round in 60 s changes the velocity by 0.1.
    assert 6e-5 < ways["manoeuvring"]["process_noise"] < 2e-3
    assert ways["quiet"]["process_noise"] < 2e-6
    found = assignment_quality(table["target"], result.assignments["track"].fill_null(-1)).idf1
    assert found is not None
    assert found > 0.9


@pytest.mark.parametrize(
    ("left", "groups", "is_better"), [(31, 89, True), (31, 105, False), (45, 103, False)]
)
def test_many_that_are_mended_count_though_others_come_and_go(
    left: int, groups: int, is_better: bool
) -> None:
    # Cars come onto a road near where others leave it: half of the breaks never go.
    broken = motion_check._Breaks(55, 4.0, 500.0, 0.2)
    trial = motion_check._Trial(0.006, 500.0, broken, tracks=113, pieces=118)
    case: Any = SimpleNamespace(groups=[None] * groups, track=np.arange(groups + 3))
    doubts = motion_check.MotionDoubts()
    assert doubts._is_better(trial, case, broken._replace(number=left)) is is_better


def circuits(seed: int) -> pl.DataFrame:
    """Return what a radar sees of four that fly straight, and of one that turns at times."""
    rng, rows = np.random.default_rng(seed), []
    for one in range(5):
        place, heading = rng.uniform(-2.5e4, 2.5e4, 2), rng.uniform(0.0, 2.0 * np.pi)
        speed, rate, wait = (105.0 if one == 4 else rng.uniform(150.0, 250.0)), 0.0, 100.0
        ways = np.empty((610, 2))
        for second in range(610):
            wait -= 1.0
            if one == 4 and wait < 0.0:
                rate = 0.0 if rate else np.radians(rng.uniform(1.5, 3.0))
                wait = np.pi / 2.0 / rate if rate else rng.uniform(20.0, 90.0)
            heading += rate
            place = place + speed * np.array([np.sin(heading), np.cos(heading)])
            ways[second] = place
        for turn in np.flatnonzero(rng.random(150) < 0.97):
            time = 4.0 * turn
            for _ in range(3):
                east, north = (np.interp(time, np.arange(610), axis) for axis in ways.T)
                azimuth = np.degrees(np.arctan2(east, north)) % 360.0
                time = 4.0 * (turn + azimuth / 360.0)
            seen = np.hypot(east, north) + rng.normal(0.0, 15.0), azimuth + rng.normal(0.0, 0.03)
            rows.append((round(time, 3), seen[0], seen[1] % 360.0, str(one)))
    columns = ["time", "range_m", "azimuth_deg", "target"]
    return pl.DataFrame(sorted(rows), columns, orient="row")


@pytest.mark.slow
def test_one_that_turns_among_few_that_do_not_keeps_its_name() -> None:
    """Its pieces in a turn are too short to be sure tracks, and none of the others bends."""
    frame = circuits(4)
    radar = {"position": [0.0, 0.0], "scan_period": 4.0}
    result = track(frame.drop("target"), {"sensors": {"default": radar}})
    found = result.assignments["track"].fill_null(-1).to_numpy()
    assert assignment_quality(frame["target"].to_list(), found).idf1 > 0.99
    assert result.run["configuration"]["motion"]["model"] == "imm"


def test_a_trial_that_leaves_faster_breaks_is_stepped_up_twice_at_most() -> None:
    doubts, left = motion_check.MotionDoubts(), motion_check._Breaks(4, 0.0, 30.0, 4.0)
    trial = motion_check._Trial(0.001, 4.0, left._replace(process=4.0), tracks=8, pieces=16)
    doubts._trial = trial
    levels = []
    while doubts._is_stepped_up(doubts._trial, left):
        levels.append(doubts._trial.level)
        left = left._replace(process=10.0 * left.process)
    assert levels == [30.0, 300.0]
    doubts._trial = trial
    assert not doubts._is_stepped_up(trial, left._replace(process=7.0))
    assert not doubts._is_stepped_up(trial, left._replace(number=1))
