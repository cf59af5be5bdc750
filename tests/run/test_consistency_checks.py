"""What is told of noise, and what becomes of it where tracks show otherwise."""

from typing import Any

import numpy as np
import polars as pl
import pytest

from trackweave import track

NOISE = 5.0
TRUE_AZIMUTH = 0.05  # degrees


def lines(sigma: Any = NOISE, seed: int = 1) -> pl.DataFrame:
    """Return reports of eight objects on straight ways, seen nine times in ten."""
    rng = np.random.default_rng(seed)
    rows = []
    for time in range(70):
        for number in range(8):
            place = np.array([8.0 * time, 400.0 * number]) + sigma * rng.normal(size=2)
            if rng.random() < 0.9:
                rows.append((float(time), *place.tolist()))
    return pl.DataFrame(rows, schema=["time", "x", "y"], orient="row")


def told(sigma: Any, **more: Any) -> dict[str, Any]:
    """Return all that an engineer would tell of these objects and their sensor."""
    sensor = {
        "sigma": sigma,
        "detection_probability": 0.9,
        "clutter_density": 1e-9,
        "scan_period": 1.0,
        **more,
    }
    return {
        "motion": {"process_noise": 0.01, "max_speed": 20.0},
        "lifecycle": {"new_target_density": 1e-8},
        "sensors": {"default": sensor},
    }


def sigma_in(run: dict[str, Any]) -> Any:
    return run["configuration"]["sensors"]["default"]["sigma"]


def test_uses_the_noise_that_tracks_show_where_half_of_it_is_told() -> None:
    run = track(lines(), told(NOISE / 2)).run
    assert run["told"] == [
        {
            "key": "sensors.default.sigma",
            "told": NOISE / 2,
            "learned": sigma_in(run),
            "used": sigma_in(run),
        }
    ]
    assert sigma_in(run) == pytest.approx(NOISE, rel=0.15)
    assert run["sources"]["sensors.default.sigma"] == "estimated"


@pytest.mark.slow
def test_says_what_was_told_and_seen_once_and_how_to_keep_it() -> None:
    run = track(lines(), told(NOISE / 4)).run
    assert [each["cause"] for each in run["diagnostics"]] == ["sigma"]
    assert sum("sigma" in note for note in run["notes"]) == 1
    sentence = run["notes"][0]
    assert "told as 1.25" in sentence
    assert f"{sigma_in(run)} is used" in sentence
    assert 'trust = ["sigma"] in [sensors.default]' in sentence


def test_a_run_that_learned_is_the_run_that_was_told_so() -> None:
    reports = lines()
    learned = track(reports, told(NOISE / 2), rng=np.random.default_rng(3))
    right = track(reports, told(sigma_in(learned.run)), rng=np.random.default_rng(3))
    assert learned.tracks.equals(right.tracks)
    assert learned.assignments.equals(right.assignments)
    assert learned.run["scans"] == right.run["scans"]


@pytest.mark.parametrize("sigma", [NOISE, 0.8 * NOISE, 2 * NOISE])
def test_keeps_a_noise_that_is_about_right_or_too_large(sigma: float) -> None:
    run = track(lines(), told(sigma)).run
    assert run["told"][0]["used"] == sigma_in(run) == sigma
    assert run["told"][0]["learned"] == pytest.approx(NOISE, rel=0.15)
    assert run["diagnostics"] == []


@pytest.mark.parametrize("trust", [True, ["sigma"]])
def test_keeps_what_is_trusted_and_still_tells_what_is_seen(trust: Any) -> None:
    run = track(lines(), told(NOISE / 2, trust=trust)).run
    assert run["sources"]["sensors.default.sigma"] == "file"
    assert run["told"][0]["used"] == sigma_in(run) == NOISE / 2
    assert run["told"][0]["learned"] > 1.3 * NOISE / 2
    assert [each["cause"] for each in run["diagnostics"]] == ["sigma"]
    assert "it is trusted" in run["notes"][0]


def test_of_ranges_and_azimuths_changes_the_one_that_is_wrong() -> None:
    rng = np.random.default_rng(1)
    reports = lines(0.0)
    east, north = reports["x"].to_numpy() + 3000.0, reports["y"].to_numpy() + 5000.0
    azimuth = np.degrees(np.arctan2(east, north)) + rng.normal(0, TRUE_AZIMUTH, east.size)
    ranges = np.hypot(east, north) + rng.normal(0, NOISE, east.size)
    polar = reports.select("time").with_columns(range_m=ranges, azimuth_deg=azimuth)
    sigma = {"range_m": NOISE, "azimuth_deg": TRUE_AZIMUTH / 2}
    run = track(polar, told(sigma, clutter_density=1e-6)).run
    assert sigma_in(run)["range_m"] == NOISE
    assert sigma_in(run)["azimuth_deg"] == pytest.approx(TRUE_AZIMUTH, rel=0.15)


def test_axes_that_differ_as_told_are_right() -> None:
    sigma = np.array([2.0, 12.0])
    run = track(lines(sigma), told({"x": 2.0, "y": 12.0})).run
    assert sigma_in(run) == {"x": 2.0, "y": 12.0}
    assert run["diagnostics"] == []


def test_noise_that_reports_carry_themselves_is_not_doubted() -> None:
    reports = lines().with_columns(sigma_x=pl.lit(NOISE / 2), sigma_y=pl.lit(NOISE / 2))
    judged = track(reports, told(NOISE)).run["told"]
    assert not any(each["key"].endswith("sigma") for each in judged)


@pytest.mark.slow
def test_noise_that_reports_carry_themselves_is_not_called_told() -> None:
    reports = lines().with_columns(sigma_x=pl.lit(NOISE / 4), sigma_y=pl.lit(NOISE / 4))
    noted = track(reports).run["diagnostics"]
    assert "sigma" not in [each["cause"] for each in noted]


def buses(sigma: float) -> pl.DataFrame:
    """Return what twelve buses report every 30 s, between stops and turns at every corner."""
    rng = np.random.default_rng(1)
    rows = []
    for number in range(12):
        corners, time, heading = [(0.0, 3000.0 * number, 0.0)], 0.0, int(rng.integers(4))
        while time < 3600:
            if rng.random() < 0.4:
                heading += int(rng.choice([-1, 1]))
            way = 400.0 * np.array([(0, 1), (1, 0), (0, -1), (-1, 0)][heading % 4])
            time += 400.0 / rng.uniform(6, 12)
            place = np.array(corners[-1][1:]) + way
            corners.append((time, *place.tolist()))
            time += rng.uniform(5, 40)
            corners.append((time, *place.tolist()))
        known = np.array(corners).T
        for when in np.arange(rng.uniform(0, 30), 3600, 30.0):
            place = [np.interp(when, known[0], axis) for axis in known[1:]]
            rows.append((when, *(place + rng.normal(0, sigma, 2)), f"bus{number}"))
    table = pl.DataFrame(rows, schema=["time", "x", "y", "identity"], orient="row")
    return table.sort("time")


@pytest.mark.slow
def test_stops_and_turns_between_reports_are_not_taken_for_noise() -> None:
    config = {
        "motion": {"process_noise": 2.0, "max_speed": 14.0},
        "sensors": {"default": {"sigma": 8.0, "scans": False}},
    }
    run = track(buses(8.0), config).run
    assert sigma_in(run) == 8.0
    assert "sigma" not in [each["cause"] for each in run["diagnostics"]]


@pytest.mark.parametrize("factor", [1.0, 0.5])
def test_a_steep_elevations_noise_is_not_that_of_slant_ranges(factor: float) -> None:
    rng = np.random.default_rng(1)
    reports = lines(0.0)
    east, north = 20 * reports["x"].to_numpy(), 20 * reports["y"].to_numpy() + 5e3
    up, ground = 15e3, np.hypot(east, north)
    polar = reports.select("time").with_columns(
        range_m=np.hypot(ground, up) + rng.normal(0, 10, east.size),
        azimuth_deg=np.degrees(np.arctan2(east, north)) + rng.normal(0, 0.05, east.size),
        elevation_deg=np.degrees(np.arctan2(up, ground)) + rng.normal(0, 0.2, east.size),
    )
    sigma = {"range_m": 10.0 * factor, "azimuth_deg": 0.05, "elevation_deg": 0.2}
    config = told(sigma, clutter_density=1e-9)
    config["motion"]["max_speed"] = 300.0
    used = sigma_in(track(polar, config).run)["range_m"]
    assert used == (10.0 if factor == 1 else pytest.approx(10.0, rel=0.2))


def test_too_few_reports_overrule_nothing() -> None:
    run = track(lines().head(60), told(NOISE / 2)).run
    assert sigma_in(run) == NOISE / 2
    assert run["told"] == []


def test_a_sensor_that_is_right_keeps_its_noise_beside_one_that_is_not() -> None:
    first = lines().with_columns(sensor=pl.lit("A"))
    second = lines(seed=2).with_columns(
        pl.col("time") + 0.5, pl.col("x") + 4.0, sensor=pl.lit("B")
    )
    config = told(NOISE)
    config["sensors"]["B"] = {"sigma": NOISE / 2}
    run = track(pl.concat([first, second]).sort("time"), config).run
    used = {each["key"]: each["used"] for each in run["told"]}
    assert used["sensors.A.sigma"] == NOISE
    assert used["sensors.B.sigma"] == pytest.approx(NOISE, rel=0.15)
    assert run["sources"]["sensors.A.sigma"] == "file"
