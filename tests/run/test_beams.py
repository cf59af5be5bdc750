"""Reports of a turning radar are timed by its beam where their stamps are loose."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from run.turning_radar import TURN, on_a_plane, radar
from trackweave.config import load_configuration
from trackweave.domain.frames import LocalFrame
from trackweave.metrics import assignment_quality
from trackweave.run.beams import with_beam_places, with_beam_times

LOOSE = {
    "off by 0.2 s": lambda time, rng: time + rng.normal(0, 0.2, time.size),
    "late by 0.3 s": lambda time, rng: time + rng.exponential(0.3, time.size),
    "to whole seconds": lambda time, rng: np.floor(time),
    "to eight sectors": lambda time, rng: np.ceil(time * 8 / TURN) * TURN / 8,
    "sent each second": lambda time, rng: np.ceil(time) + rng.uniform(0, 0.03, time.size),
}


def stamped(table, stamp):
    """Return the reports under other stamps, in the order of those, with when they were."""
    time = table["time"].to_numpy()
    told = pl.Series(stamp(time, np.random.default_rng(7)))
    return table.with_columns(pl.col("time").alias("was"), time=told).sort("time")


@pytest.mark.slow
@pytest.mark.parametrize("stamp", LOOSE.values(), ids=LOOSE)
def test_reports_count_as_of_when_the_beam_was_there(stamp):
    table = stamped(radar(), stamp)
    result = tw.track(table.drop("target"))
    (note,) = [note for note in result.run["notes"] if "its beam turns clockwise in" in note]
    assert "each report counts as of when the beam was at its azimuth" in note
    assert result.assignments["time"].equals(table["time"])
    # What is late for all alike is not known.
    counted = with_beam_times(tw.read_reports(table), load_configuration({}))
    late = counted.time - np.asarray(counted.carried["was"])
    late -= TURN * np.round((late - np.median(late)) / TURN)
    assert np.ptp(np.quantile(late, [0.02, 0.98])) < 0.1
    quality = assignment_quality(
        table["target"].to_list(), result.reports["track"].fill_null(-1).to_numpy()
    )
    assert quality.idf1 > 0.97
    assert result.reports.drop("track", "probability").equals(table.drop("target"))


def unchanged(table, **said):
    reports = tw.read_reports(table)
    return with_beam_times(reports, load_configuration({"sensors": {"default": said}})) is reports


def test_exact_stamps_stay():
    assert unchanged(radar().sort("time"))


@pytest.mark.parametrize("said", [{"rotation": "none"}, {"scans": False}])
def test_who_is_told_not_to_turn_keeps_its_times(said):
    assert unchanged(stamped(radar(), LOOSE["off by 0.2 s"]), **said)


def test_one_object_that_circles_before_a_camera_is_no_beam():
    time = np.repeat(np.arange(300) * 0.5, 3)
    rng = np.random.default_rng(1)
    azimuth = np.degrees(2 * np.pi * time / 8.0 + rng.normal(0, 0.01, time.size)) % 360
    table = {"time": time, "range_m": 100 + rng.normal(0, 1, time.size), "azimuth_deg": azimuth}
    assert unchanged(pl.DataFrame(table))


def test_walkers_around_a_lidar_are_no_beam():
    rng = np.random.default_rng(2)
    time = np.repeat(np.arange(200) * 1.0, 10)
    angle = np.tile(rng.uniform(0, 2 * np.pi, 10), 200) + 0.01 * time
    place = 20 * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    table = {"time": time, "x": place[:, 0], "y": place[:, 1]}
    assert unchanged(pl.DataFrame(table))


@pytest.mark.slow
@pytest.mark.parametrize("stamp", [None, LOOSE["late by 0.3 s"]], ids=["exact", "loose"])
def test_a_radar_that_nobody_placed_stands_where_its_beam_turns(stamp):
    table = radar() if stamp is None else stamped(radar(), stamp)
    table = on_a_plane(table).sort("time")
    result = tw.track(table.drop("target"))
    place = result.run["configuration"]["sensors"]["default"]["position"]
    assert np.hypot(place[0] - 4e5, place[1] - 5.2e6) < 1500
    assert result.run["sources"]["sensors.default.position"] == "estimated"
    assert any("where it is taken to stand" in note for note in result.run["notes"])
    quality = assignment_quality(
        table["target"].to_list(), result.reports["track"].fill_null(-1).to_numpy()
    )
    assert quality.idf1 > 0.97


@pytest.mark.parametrize("said", [{"position": [0.0, 0.0]}, {"rotation": "none"}])
def test_a_place_that_is_told_is_kept(said):
    reports = tw.read_reports(on_a_plane(radar()).sort("time"))
    told = load_configuration({"sensors": {"default": said}})
    assert with_beam_places(reports, told) == (reports, told, ())


@pytest.mark.slow
@pytest.mark.parametrize(("pause", "jitter"), [(0.1, 0.01), (0.5, 0.05)])
def test_one_object_that_circles_a_camera_whose_frames_jitter_is_no_beam(pause, jitter):
    rng = np.random.default_rng(1)
    time = pause * np.arange(600) + rng.normal(0, jitter, 600)
    kept = np.sort(time)[rng.random(600) < 0.95]
    azimuth = np.degrees(2 * np.pi * kept / 11.0 + rng.normal(0, 0.01, kept.size)) % 360
    away = 100 + rng.normal(0, 1, kept.size)
    table = pl.DataFrame({"time": kept, "range_m": away, "azimuth_deg": azimuth})
    result = tw.track(table)
    assert result.run["configuration"]["sensors"]["default"]["rotation"] == "none"
    assert result.run["totals"]["tracks"] == 1


def test_reports_that_came_twice_do_not_hide_a_turn():
    table = stamped(radar(), LOOSE["late by 0.3 s"])
    once = with_beam_times(tw.read_reports(table), load_configuration({}))
    twice = pl.concat([table, table]).sort("time")
    found = with_beam_times(tw.read_reports(twice), load_configuration({}))
    np.testing.assert_allclose(np.unique(found.time), np.unique(once.time))


def test_objects_that_report_once_a_second_are_no_beam_elsewhere():
    rng, rows = np.random.default_rng(4), []
    for number in range(12):
        begin, way, phase = rng.uniform(-2000, 2000, 2), rng.uniform(-15, 15, 2), rng.random()
        time = np.arange(120) + phase + rng.normal(0, 0.01, 120)
        place = begin + time[:, None] * way + rng.normal(0, 2, (120, 2))
        rows += [
            (moment, *at, str(number)) for moment, at in zip(time, place.tolist(), strict=True)
        ]
    table = pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row").sort("time")
    reports, told = tw.read_reports(table), load_configuration({})
    assert with_beam_places(reports, told)[2] == ()
    assert with_beam_times(reports, told) is reports


def test_a_radar_near_the_middle_is_placed_and_its_exact_stamps_stay():
    reports = tw.read_reports(on_a_plane(radar(), 12e3, -7e3).sort("time"))
    placed, told, names = with_beam_places(reports, load_configuration({}))
    assert names == ("default",)
    place = told.sensor("default")["position"]
    assert np.hypot(place[0] - 12e3, place[1] + 7e3) < 20.0
    assert with_beam_times(placed, told) is placed


@pytest.mark.slow
def test_a_place_told_in_degrees_is_where_a_radar_of_positions_stands():
    table = on_a_plane(radar(), 0.0, 0.0).sort("time")
    lat, lon, _ = LocalFrame(60.0, 10.0).to_geodetic(table.select("x", "y").to_numpy())
    table = table.select("time", lat=pl.Series(lat), lon=pl.Series(lon))
    result = tw.track(table, {"sensors": {"default": {"place": [60.0, 10.0]}}})
    assert not [note for note in result.run["notes"] if "its beam" in note]
    assert result.run["configuration"]["sensors"]["default"]["rotation"] == "clockwise"
