"""From Python: tables in, the same kind of tables out."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

import trackweave
from trackweave.errors import InvalidInputError

CONFIG = {
    "motion": {"process_noise": 0.1, "max_speed": 30.0},
    "sensors": {
        "default": {
            "sigma": 3.0,
            "detection_probability": 0.9,
            "clutter_density": 2e-6,
            "scan_period": 1.0,
        }
    },
    "lifecycle": {"new_target_density": 1e-6},
}


def columns() -> dict[str, Any]:
    rng = np.random.default_rng(2)
    time = np.repeat(np.arange(10.0), 2)
    truth = np.stack([10 * time, np.tile([0.0, 300.0], 10)], axis=1)
    place = truth + rng.normal(0, 3, truth.shape)
    return {"time": time, "x": place[:, 0], "y": place[:, 1], "note": ["n"] * 20}


def tracked(reports: Any, config: Any = CONFIG, **options: Any) -> trackweave.TrackingResult:
    return trackweave.track(reports, config, rng=np.random.default_rng(1), **options)


@pytest.mark.parametrize(
    ("make", "kind"),
    [(pd.DataFrame, pd.DataFrame), (pl.DataFrame, pl.DataFrame), (pa.table, pa.Table)],
)
def test_the_same_kind_of_table_comes_out(make: Callable[[Any], Any], kind: type) -> None:
    result = tracked(make(columns()))
    for table in (result.tracks, result.assignments, result.history):
        assert isinstance(table, kind)
    assert len(result.assignments) == 20


def test_two_objects_give_two_tracks_with_all_their_reports() -> None:
    result = tracked(pl.DataFrame(columns()))
    assert result.assignments["track"].to_list() == [
        *([result.assignments["track"][0], result.assignments["track"][1]] * 10)
    ]
    assert result.run["totals"]["tracks"] == 2
    assert len(result.history) == 20


def test_an_empty_scan_between_is_a_scan() -> None:
    table = pl.DataFrame(columns()).filter(pl.col("time") != 5.0)
    result = tracked(table)
    assert result.run["totals"]["empty_scans"] == 1
    assert 5.0 in result.tracks["time"].to_list()


def test_rows_keep_their_distance_when_asked() -> None:
    result = tracked(pl.DataFrame(columns()), {**CONFIG, "output": {"period": 3.0}})
    assert sorted(set(result.tracks["time"].to_list())) == [3.0, 6.0, 9.0]


def test_progress_is_told_scan_by_scan() -> None:
    told: list[tuple[int, int]] = []
    tracked(pl.DataFrame(columns()), progress=lambda done, total: told.append((done, total)))
    assert told == [(k, 10) for k in range(1, 11)]


def test_the_caller_s_table_is_left_as_it_is() -> None:
    table = pd.DataFrame(columns())
    before = table.copy()
    tracked(table)
    pd.testing.assert_frame_equal(table, before)


def test_same_generator_same_result() -> None:
    one, two = tracked(pl.DataFrame(columns())), tracked(pl.DataFrame(columns()))
    assert one.tracks.equals(two.tracks)
    assert one.run["scans"] == two.run["scans"]


@pytest.mark.parametrize("deadline", [0.0, -1.0, float("nan"), float("inf"), "soon"])
def test_refuses_a_deadline_that_is_none(deadline: Any) -> None:
    with pytest.raises(InvalidInputError, match="deadline"):
        tracked(pl.DataFrame(columns()), deadline=deadline)


@pytest.mark.slow
def test_a_deadline_still_gives_an_answer_and_says_what_it_cost() -> None:
    result = tracked(pl.DataFrame(columns()), deadline=1e-6)
    assert len(result.assignments) == 20
    gaps = [scan["deadline_gap"] for scan in result.run["scans"]]
    totals = result.run["totals"]
    assert totals["scans_cut_short"] == sum(gap > 0.0 for gap in gaps)
    assert totals["worst_deadline_gap"] == max(gaps)
    assert totals["mean_deadline_gap"] == pytest.approx(np.mean(gaps))
    pruned = [scan["pruned_by_deadline"] for scan in result.run["scans"]]
    assert totals["pruned_by_deadline"] == sum(pruned)


def test_without_a_deadline_none_costs_anything() -> None:
    run = tracked(pl.DataFrame(columns())).run
    assert {scan["deadline_gap"] for scan in run["scans"]} == {None}
    assert run["totals"]["worst_deadline_gap"] is None
    assert run["totals"]["scans_cut_short"] == run["totals"]["pruned_by_deadline"] == 0


def test_what_is_best_of_too_little_is_not_called_optimal() -> None:
    """Two objects beside each other, and room for one sequence of each track."""
    near = columns()
    near["y"] = np.where(near["y"] > 150.0, near["y"] - 295.0, near["y"])
    narrow = {**CONFIG, "growth": {"keep": 1, "new_keep": 1}}
    result = tracked(pl.DataFrame(near), narrow)
    scans, totals = result.run["scans"], result.run["totals"]
    worst = [scan["pruned_probability"]["worst"] for scan in scans]
    assert totals["worst_pruned_probability"] == max(worst) > 0.01
    for scan, share in zip(scans, worst, strict=True):
        assert (scan["status"] == "optimal") == (share <= 0.01)
        assert scan["status"] in {"optimal", "optimal among kept"}
        assert share <= scan["pruned_probability"]["sum"]
    assert totals["scans_optimal_among_kept"] == len(scans) - totals["proven_scans"] > 0
    assert f"{totals['scans_optimal_among_kept']} among what was kept" in repr(result)


def test_of_the_best_hypothesis_alone_nobody_knows_what_was_pruned() -> None:
    best = {**CONFIG, "growth": {"new_ceiling": 0.01}, "output": {"estimate": "best"}}
    scans = tracked(pl.DataFrame(columns()), best).run["scans"]
    assert scans[0]["pruned_probability"] == {"worst": 0.0, "sum": 0.0}
    assert any(scan["pruned_probability"] is None for scan in scans)
    for scan in scans:
        assert (scan["pruned_probability"] is None) == (scan["status"] == "optimal among kept")


def test_reports_beyond_number_at_one_place_are_told_in_a_note() -> None:
    count = 400
    # Equal ones would be copies of one report.
    values = {"time": np.repeat([0.0, 1.0, 2.0], count), "x": 5.0 + 1e-6 * np.arange(3 * count)}
    config = {
        "sensors": {"default": {"sigma": 10.0, "scan_period": 1.0, "extent": 0.0}},
        "growth": {"max_nodes": 3_000},
        "search": {"evaluations": 100, "branches": 0},
    }
    table = pl.DataFrame({**values, "y": values["x"]})
    run = tracked(table, config).run
    assert any("more reports lie in a gate" in note for note in run["notes"])


def rotating(n_scans: int = 10) -> dict[str, Any]:
    """Two objects seen by a radar that turns in 4 s, each plot at its own time."""
    rng = np.random.default_rng(4)
    turn = np.repeat(np.arange(n_scans), 2)
    time = 4.0 * turn + np.tile([0.3, 1.1], n_scans) + rng.uniform(0, 0.2, 2 * n_scans)
    place = np.stack([5 * time, np.tile([0.0, 300.0], n_scans)], axis=1)
    return {"time": time, "x": place[:, 0], "y": place[:, 1], "turn": turn}


def turning_not(period: float | None) -> dict[str, Any]:
    """Return a configuration of a sensor that is told not to turn."""
    sensor = {**CONFIG["sensors"]["default"], "scan_period": period, "rotation": "none"}
    return {**CONFIG, "sensors": {"default": {k: v for k, v in sensor.items() if v}}}


@pytest.mark.parametrize(
    ("period", "said"),
    [
        (4.0, "sensor default: 20 of 20 scans hold one report although its scan period is 4 s"),
        (None, "sensor default: taken for one that does not scan: objects report by themselves"),
    ],
)
def test_says_that_turns_are_not_grouped(period: float | None, said: str) -> None:
    config = turning_not(period)
    table = rotating()
    # At any moment of a turn: no beam shows that could be told instead.
    table["time"] = 4.0 * table["turn"] + np.random.default_rng(5).uniform(0, 3.9, 20)
    table = pl.DataFrame({**table, "x": 5 * table["time"]})
    notes = [note for note in tracked(table, config).run["notes"] if note.startswith(said)]
    assert len(notes) == 1
    otherwise = "for a rotating sensor give its rotation and scan_period, or a `scan`"
    assert (otherwise if period else "if it looks, give scans = true") in notes[0]
    with_scans = tracked(table.rename({"turn": "scan"}), config)
    assert not any("turn" in note for note in with_scans.run["notes"])


@pytest.mark.parametrize("period", [4.0, None])
def test_says_that_a_beam_turns_which_is_told_not_to(period: float | None) -> None:
    config, table = turning_not(period), pl.DataFrame(rotating())
    (note,) = (each for each in tracked(table, config).run["notes"] if "turns" in each)
    assert "its reports come as from a beam that turns counter-clockwise in 4.0" in note
    assert 'leave rotation = "none" out' in note
    with_scans = tracked(table.rename({"turn": "scan"}), config)
    assert not any("turn" in note for note in with_scans.run["notes"])


@pytest.mark.parametrize(
    ("period", "detection", "said"), [(0.4, 0.9, 1), (1.0, 0.9, 0), (0.4, 0.3, 0)]
)
def test_says_that_most_scans_are_missing(period: float, detection: float, said: int) -> None:
    changed = {"scan_period": period, "detection_probability": detection}
    config = {**CONFIG, "sensors": {"default": {**CONFIG["sensors"]["default"], **changed}}}
    notes = [n for n in tracked(pl.DataFrame(columns()), config).run["notes"] if "every" in n]
    assert len(notes) == said
    assert all("come every 1 s, although its scan period is 0.4 s" in note for note in notes)


def test_turns_that_show_are_scans() -> None:
    run = tracked(pl.DataFrame(rotating()), {**CONFIG, "sensors": {}}).run
    assert run["configuration"]["sensors"]["default"]["rotation"] == "counter-clockwise"
    assert not any("hold one report" in note for note in run["notes"])


def test_says_nothing_of_turns_where_a_scan_has_its_reports_at_one_time() -> None:
    assert tracked(pl.DataFrame(columns())).run["notes"] == []


def test_says_nothing_of_turns_where_one_object_is_seen_by_the_clock() -> None:
    one = pl.DataFrame(columns()).filter(pl.col("y") < 150)
    result = tracked(one, {"motion": CONFIG["motion"]})
    assert not any("turn" in note for note in result.run["notes"])


def priors_at(time: float) -> trackweave.TrackTable:
    return trackweave.TrackTable(
        time=np.array([time]), track=np.array([1]), status=np.array([1]), mean=np.zeros((1, 4)),
        covariance=np.eye(4)[None], score=np.zeros(1), hits=np.ones(1, dtype=int),
        last_update=np.array([time]),
    )  # fmt: skip


def test_refuses_priors_of_after_all_reports() -> None:
    with pytest.raises(InvalidInputError, match=r"priors: newest at 9.5 s, after the last report"):
        tracked(pl.DataFrame(columns()), priors=priors_at(9.5))


def test_says_how_many_reports_are_of_before_the_priors() -> None:
    run = tracked(pl.DataFrame(columns()), priors=priors_at(7.0)).run
    assert run["totals"]["late_reports"] == 14
    said = "priors: newest at 7 s; 14 of 20 reports are of before and count as late"
    assert run["notes"] == [said]
    assert tracked(pl.DataFrame(columns()), priors=priors_at(-1.0)).run["notes"] == []


def test_a_history_has_one_row_for_each_track_and_scan() -> None:
    table = columns()
    # A rotating radar: each report has its own time, and the scan ends with the last.
    table["scan"] = table["time"].astype(int)
    table["time"] = table["time"] + np.tile([0.2, 0.6], 10)
    result = tracked(pl.DataFrame(table))
    assert result.history["time"].unique().to_list() == [k + 0.6 for k in range(10)]
    assert result.history.group_by("track").len()["len"].to_list() == [10, 10]
    assert set(result.history["status"].to_list()) == {"confirmed"}


def test_says_that_priors_hold_no_tracks() -> None:
    notes = tracked(pl.DataFrame(columns()), priors=trackweave.TrackTable.empty(2)).run["notes"]
    assert notes == ["priors: no tracks in them; the run began as without priors"]


def test_refuses_priors_of_another_dimension() -> None:
    priors = trackweave.TrackTable(
        time=np.zeros(1),
        track=np.ones(1, np.int64),
        status=np.ones(1, np.int64),
        mean=np.zeros((1, 6)),
        covariance=np.eye(6)[None],
        score=np.zeros(1),
        hits=np.ones(1, np.int64),
        last_update=np.zeros(1),
    )
    with pytest.raises(InvalidInputError, match="3 dimensions; expected 2"):
        tracked(pl.DataFrame(columns()), priors=priors)


def mixed_scene() -> pl.DataFrame:
    """Two boats, seen by a lidar, by a radar of ranges and by a camera that moves."""
    rng = np.random.default_rng(4)
    rows: list[dict[str, Any]] = []
    for step in range(24):
        own = np.array([2.0 * step, -80.0])
        for number, start in enumerate([(-60.0, 60.0), (90.0, 160.0)]):
            place = np.array(start) + np.array([3.0 - 5.0 * number, 1.0]) * step
            east, north = place + rng.normal(0, 1.0, 2)
            common = {"time": float(step), "target": str(number)}
            rows.append({**common, "sensor": "lidar", "x": east, "y": north})
            east, north = place - [10.0, 5.0]
            rows.append(
                {
                    **common,
                    "sensor": "radar",
                    "range_m": np.hypot(east, north) + rng.normal(0, 2.0),
                    "azimuth_deg": np.degrees(np.arctan2(east, north) + rng.normal(0, 0.01)),
                }
            )
            east, north = place - own
            bearing = np.degrees(np.arctan2(east, north)) + rng.normal(0, 0.5)
            camera = {"bearing_deg": bearing, "sensor_x": own[0], "sensor_y": own[1]}
            rows.append({**common, "sensor": "camera", **camera})
    names = ["time", "sensor", "x", "y", "range_m", "azimuth_deg", "bearing_deg"]
    return pl.DataFrame(rows).select(*names, "sensor_x", "sensor_y", "target")


MIXED = {
    "motion": {"process_noise": 0.05, "max_speed": 12.0},
    "lifecycle": {"new_target_density": 1e-6},
    "sensors": {
        "default": {"detection_probability": 0.9, "scan_period": 1.0},
        "lidar": {"sigma": 1.0, "clutter_density": 1e-6},
        "radar": {
            "sigma": {"range_m": 2.0, "azimuth_deg": 0.6},
            "clutter_density": 1e-4,
            "position": [10.0, 5.0],
        },
        "camera": {"sigma": {"bearing_deg": 0.5}, "clutter_density": 0.01},
    },
}


@pytest.mark.parametrize("motion", [{}, {"model": "imm", "filter": "unscented"}])
def test_sensors_of_every_kind_share_their_tracks(motion: dict[str, str]) -> None:
    result = tracked(mixed_scene(), {**MIXED, "motion": {**MIXED["motion"], **motion}})
    pairs = result.assignments.group_by("target", "sensor").agg(pl.col("track").mode().first())
    by_target = pairs.group_by("target").agg(pl.col("track").n_unique())
    assert by_target["track"].to_list() == [1, 1]
    found = result.assignments["track"].is_not_null().mean()
    assert found is not None
    assert found > 0.95
    assert result.run["totals"]["tracks"] == 2
    assert any("no height_m" in note for note in result.run["notes"])


def test_bearings_in_the_wrong_sense_are_noted() -> None:
    mirrored = mixed_scene().with_columns(-pl.col("bearing_deg"))
    notes = tracked(mirrored, MIXED).run["notes"]
    assert any(
        "camera: its bearings fit" in note and "counter-clockwise" in note for note in notes
    )


def test_a_sensor_of_ranges_beside_others_needs_a_position() -> None:
    sensors = {**MIXED["sensors"], "radar": {**MIXED["sensors"]["radar"]}}
    del sensors["radar"]["position"]
    with pytest.raises(InvalidInputError, match=r"sensors\.radar\.position: left out; expected"):
        tracked(mixed_scene(), {**MIXED, "sensors": sensors})


def test_a_sensor_that_falls_silent_for_an_hour_ends_its_tracks() -> None:
    early = pl.DataFrame(columns())
    late = early.with_columns(pl.col("time") + 3600.0)
    result = tracked(pl.concat([early, late]))
    assert result.run["totals"]["empty_scans"] == 100
    assert result.run["totals"]["tracks"] == 4
    first = result.tracks.filter(pl.col("time") < 1000.0)["track"].unique()
    last = result.tracks.filter(pl.col("time") > 3600.0)["track"].unique()
    assert set(first.to_list()).isdisjoint(last.to_list())


def test_a_presets_search_is_changed_by_one_key_where_all_else_is_estimated() -> None:
    config = {"search": {"ants": 7}}
    result = tracked(pl.DataFrame(columns()), config, preset="wiranto-2018")
    assert result.run["configuration"]["search"]["ants"] == 7
    assert result.run["configuration"]["search"]["persistence"] == 0.8


@pytest.mark.parametrize("is_own", [True, False])
def test_says_that_a_told_sigma_is_not_used_where_rows_have_their_own(is_own: bool) -> None:
    table = pl.DataFrame(columns())
    if is_own:
        table = table.with_columns(sigma_x=pl.lit(3.0), sigma_y=pl.lit(3.0))
    said = [note for note in tracked(table).run["notes"] if "sigma: not used" in note]
    assert len(said) == int(is_own)
