"""How few reports are in tracks is said, and what to look at."""

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from run.diagnostics.scenes import case_of, positions
from trackweave import track
from trackweave.run.diagnostics.share import few_assigned


@pytest.mark.parametrize(("in_tracks", "is_said"), [(0, True), (40, True), (60, False)])
def test_less_than_half_in_tracks_is_said_with_what_to_look_at(
    in_tracks: int, is_said: bool
) -> None:
    time = np.arange(100.0)
    case = case_of(positions(list(time), np.c_[time, time % 7]))
    found = list(few_assigned(replace(case, track=np.where(time < in_tracks, 1, -1))))
    assert bool(found) == is_said
    for each in found:
        assert each.sentence.startswith(f"only {in_tracks} of 100 reports are in tracks")
        assert "sigma, max_speed, clutter and detection_probability" in each.sentence


@pytest.mark.parametrize(("depth", "is_named"), [(1, True), (2, True), (3, False)])
def test_a_window_of_fewer_scans_than_confirm_a_track_is_named(depth: int, is_named: bool) -> None:
    time = np.arange(100.0)
    case = case_of(positions(list(time), np.c_[time, time % 7]))
    settings = case.settings
    settings = replace(
        settings,
        window=replace(settings.window, depth=depth),
        sources={**settings.sources, "window.depth": "file"},
    )
    (found,) = few_assigned(replace(case, settings=settings))
    said = f"look first at window.depth = {depth}, which holds fewer scans than the 3 reports"
    assert (said in found.sentence) == is_named


def test_false_alarms_explain_it_only_where_they_are_told() -> None:
    time = np.arange(100.0)
    reports = positions(list(time), np.c_[time, time % 7])
    case = case_of(reports, lidar={"clutter_density": 1e-3})
    case = replace(case, track=np.where(time < 40, 1, -1), looks={"lidar": time})
    assert list(few_assigned(case)) == []
    sources = {**case.settings.sources, "sensors.lidar.clutter_density": "estimated"}
    case = replace(case, settings=replace(case.settings, sources=sources))
    assert len(list(few_assigned(case))) == 1


@pytest.mark.slow
@pytest.mark.parametrize(("told", "is_said"), [(0.001, True), (225.0, True), (15.0, False)])
def test_a_noise_of_rows_that_is_far_off_is_told(told: float, is_said: bool) -> None:
    rng, rows = np.random.default_rng(1), []
    start, step = rng.uniform(-2e3, 2e3, (5, 2)), rng.uniform(-12, 12, (5, 2))
    for time in np.arange(0.0, 160.0, 4.0):
        rows += [(time, *at) for at in start + step * time + rng.normal(0, 15.0, (5, 2))]
    table = pl.DataFrame(rows, ["time", "x", "y"], orient="row")
    found = track(table.with_columns(sigma_x=pl.lit(told), sigma_y=pl.lit(told))).run
    said = [each for each in found["notes"] if "correct the columns" in each]
    assert bool(said) == is_said


@pytest.mark.slow
def test_tracks_of_one_report_are_told_with_what_was_told_of_beginnings() -> None:
    rng = np.random.default_rng(2)
    rows = [(float(t), *rng.uniform(0, 100, 2)) for t in range(60) for _ in range(3)]
    table = pl.DataFrame(rows, ["time", "x", "y"], orient="row")
    notes = track(table, {"lifecycle": {"new_target_density": 1e6}}).run["notes"]
    assert any("hold one report each; correct new_target_density = 1e+06" in n for n in notes)
