"""A region takes the scans that look there, and no others change what is found in it."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.domain.measurements import MeasurementKind
from trackweave.models.rotation import Rotation
from trackweave.run.regions import cutting, running
from trackweave.run.regions.cutting import Region
from trackweave.run.regions.sight import Looks

TURN, RADARS = 4.0, {"south": (0.0, -60e3), "north": (5e3, 130e3), "west": (-70e3, 40e3)}


def sensor(name: str, reach: float = np.inf, direction: int = 1) -> tw.Sensor:
    place = RADARS[name]
    view = tw.FieldOfView(place, max_range=reach) if np.isfinite(reach) else None
    return tw.Sensor(
        name, (50.0, 0.001), 0.9, 1e-9, scan_period=TURN, field_of_view=view, position=place,
        measurement=MeasurementKind.RANGE_AZIMUTH, rotation=Rotation(TURN, 0.7, direction),
    )  # fmt: skip


def sectors(name: str) -> list[tw.Scan]:
    """A turn and a half of empty sectors."""
    nothing = np.empty((0, 2))
    return [tw.Scan(each / 2, name, nothing, moments=np.empty(0)) for each in range(1, 13)]


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("reach", [90e3, np.inf])
def test_what_a_beam_swept_in_a_region_is_seen(direction, reach):
    # Places at random, and when the beam is there, by the turn's own definition.
    rng = np.random.default_rng(5)
    told = sensor("south", reach, direction)
    scans = sectors("south")
    looks = Looks.of(scans, [sensor("north"), told])
    n_aside = 0
    for _ in range(300):
        low = rng.uniform(-150e3, 150e3, 2)
        region = Region(low, low + rng.uniform(1e3, 120e3, 2))
        seen = looks.into(region)
        place = rng.uniform(region.low, region.high, (200, 2)) - RADARS["south"]
        azimuth = np.arctan2(place[:, 0], place[:, 1])
        is_near = np.hypot(*place.T) < reach
        for number in range(1, len(scans)):
            start, width = told.rotation.sector(scans[number - 1].time, scans[number].time)
            swept = is_near & ((azimuth - start) % (2 * np.pi) <= width)
            assert seen[number] or not swept.any()
        n_aside += int((~seen[1:]).sum())
    assert n_aside > 300 * 11 / 3


def test_a_region_without_borders_is_seen_from_everywhere():
    looks = Looks.of(sectors("south")[1:], [sensor("south", 50e3), sensor("north")])
    assert looks.into(Region(np.full(2, -np.inf), np.full(2, np.inf))).all()


def test_scans_that_the_window_counts_are_taken_wherever_they_look():
    told = [sensor("south", 50e3), sensor("north", 50e3)]
    scans = sorted(sectors("south") + sectors("north"), key=lambda each: (each.time, each.sensor))
    far = Region(np.array([400e3, 400e3]), np.array([500e3, 500e3]))
    taken = Looks.of(scans, told).into(far)
    # … and the first, from which on new objects are counted.
    assert taken.tolist() == [number == 0 or scan.sensor == "south"
                              for number, scan in enumerate(scans)]  # fmt: skip


def test_passing_over_is_as_empty_scans_where_nothing_is():
    trackers = [
        tw.MultiHypothesisTracker(
            motion=tw.ConstantVelocity(1.0, 300.0), sensors=[sensor("south")], window=3
        )
        for _ in range(2)
    ]
    costs = []
    rng = np.random.default_rng(2)
    for turn in range(6):
        for part in range(8):
            time = TURN * turn + (part + 1) / 2
            moments, report = np.empty(0), np.empty((0, 2))
            if part == 1:
                moments = np.array([time - 0.2])
                azimuth = Rotation(TURN, 0.7).azimuth(time - 0.2)
                report = np.array([[30e3 + rng.normal(0.0, 50.0), azimuth]])
            scan = tw.Scan(time, "south", report, moments=moments)
            last = trackers[0].step(scan)
            if turn == part == 0:
                trackers[1].step(scan)
            elif part == 1:
                costs.append((last.certificate.cost, trackers[1].step(scan).certificate.cost))
                tables = [each.tracks() for each in trackers]
            else:
                trackers[1].pass_over("south", time)
    one, two = np.array(costs).T
    np.testing.assert_allclose(one, two, rtol=1e-9)
    np.testing.assert_allclose(tables[0].mean, tables[1].mean, rtol=1e-9)


def radar_evening(n: int, turns: int) -> tuple[pl.DataFrame, dict]:
    """Aircraft over three turning radars of a short reach, and what is known of these."""
    rng = np.random.default_rng(9)
    at = np.column_stack([rng.uniform(-100e3, 100e3, n), rng.uniform(-90e3, 170e3, n)])
    way, rows = rng.uniform(-150.0, 150.0, (n, 2)), []
    for name, place in RADARS.items():
        for turn in range(turns):
            when = np.full(n, TURN * turn)
            for _ in range(3):
                apart = at + way * when[:, None] - place
                azimuth = np.arctan2(apart[:, 0], apart[:, 1]) % (2 * np.pi)
                when = TURN * turn + ((azimuth - 0.7) % (2 * np.pi)) / (2 * np.pi) * TURN
            away = np.hypot(*apart.T)
            for each in np.flatnonzero((away < 90e3) & (rng.random(n) < 0.9)):
                told = np.degrees(azimuth[each] + rng.normal(0.0, 0.001)) % 360
                rows.append((when[each], name, away[each] + rng.normal(0.0, 50.0), told))
    sensors = {
        name: {
            "position": list(place), "scan_period": TURN, "rotation": "clockwise",
            "phase_deg": float(np.degrees(0.7)), "detection_probability": 0.9,
            "clutter_density": 1e-9, "sigma": {"range_m": 50.0, "azimuth_deg": 0.0573},
            "field_of_view": {"max_range_m": 90e3}, "trust": True,
        }
        for name, place in RADARS.items()
    }  # fmt: skip
    names = ["time", "sensor", "range_m", "azimuth_deg"]
    config = {
        "motion": {"model": "constant-velocity", "process_noise": 1.0, "max_speed": 220.0,
                   "trust": True},
        "sensors": sensors, "window": {"depth": 3},
        "lifecycle": {"new_target_density": 1e-12, "initial_target_density": 1e-9},
    }  # fmt: skip
    return pl.DataFrame(sorted(rows), names, orient="row"), config


@pytest.mark.slow
def test_regions_under_turning_radars_are_as_one_process(monkeypatch):
    monkeypatch.setattr(cutting, "LEAST", 300)
    monkeypatch.setattr(cutting, "CROWD", 0)
    taken = []

    def part(*arguments):
        found = made(*arguments)
        taken.append([len(scans) for scans in found.course.steps])
        return found

    made = running._part
    monkeypatch.setattr(running, "_part", part)
    reports, config = radar_evening(120, 10)
    alone, apart = tw.track(reports, config), tw.track(reports, config, engine="local", workers=2)
    assert apart.run["regions"]["count"] > 1
    # Many sectors look elsewhere.
    n_scans = sum(each["sensor"].count("+") + 1 for each in alone.run["scans"])
    assert min(map(sum, taken)) < 0.95 * n_scans
    assert apart.assignments["track"].is_null().sum() == alone.assignments["track"].is_null().sum()
    assert apart.history.height == alone.history.height
    columns = ["time", "x", "y", "vx", "vy"]
    one, two = (each.history.select(columns).sort("time", "x") for each in (alone, apart))
    np.testing.assert_allclose(one, two, rtol=1e-6, atol=1e-6)
    whole = 0
    for one, two in zip(alone.run["scans"], apart.run["scans"], strict=True):
        assert {*one} | {"cut_reports"} == {*two}
        if not two["cut_reports"]:
            whole += 1
            # Where 64 sectors have looked and more, they count as turns.
            assert two["cost"] == pytest.approx(one["cost"], rel=1e-4)
    assert whole > len(alone.run["scans"]) / 2
