"""Estimates are near the truth where it is known, and finite where nothing makes sense."""

import csv
from dataclasses import asdict
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

import trackweave as tw
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimate import estimate
from trackweave.estimation.estimates import Estimates
from trackweave.estimation.frames import scan_period


def table(time, position, sensor=None, names=("A",), sigma=np.nan) -> ReportTable:
    time, position = np.asarray(time, float), np.asarray(position, float)
    sensor = np.zeros(time.size, np.int64) if sensor is None else np.asarray(sensor, np.int64)
    order = np.lexsort((sensor, time))
    return ReportTable(
        time=time[order],
        sensor=sensor[order],
        sensors=tuple(names),
        measurement=position[order],
        sigma=np.full(position.shape, sigma),
        report=np.arange(time.size).astype(str).astype(object),
    )


def scene(n_targets=15, n_scans=40, sigma=10.0, detection=0.9, clutter=15.0, period=2.0, dim=2):
    """Straight movers in a cube of 2 km, with misses and false alarms."""
    rng = np.random.default_rng(3)
    start = rng.uniform(0, 2000, (n_targets, dim))
    velocity = rng.normal(0, 6, (n_targets, dim))
    times, places = [], []
    for scan in range(n_scans):
        seen = rng.random(n_targets) < detection
        at = start[seen] + velocity[seen] * scan * period
        noise = rng.uniform(0, 2000, (rng.poisson(clutter), dim))
        both = np.concatenate([at + rng.normal(0, sigma, at.shape), noise])
        times += [scan * period] * len(both)
        places.append(both)
    return table(times, np.concatenate(places))


MAY_BE_NOTHING = (
    "disagreement", "tail_share", "tail_scale", "tail_persistence", "sigma_of_most", "strength",
    "hidden_share", "mean_silence", "echoes", "clutter_persistence", "sigma_at", "across",
    "height_offset",
)  # fmt: skip


def numbers(estimates: Estimates) -> list[float]:
    found = [estimates.process_noise, estimates.max_speed, estimates.new_target_density]
    found.append(estimates.initial_target_density)
    for sensor in estimates.sensors.values():
        # Heavy tails there need not be.
        assert 0.0 <= sensor.tail_share <= 0.5
        values = {k: v for k, v in asdict(sensor).items() if k not in MAY_BE_NOTHING}
        found += [value for value in values.values() if value is not None]
        assert sensor.disagreement >= 0
    return found


@pytest.mark.parametrize("dim", [2, 3])
def test_finds_what_a_simulated_scene_was_made_with(dim: int) -> None:
    found = estimate(scene(dim=dim))
    sensor = found.sensors["A"]
    assert sensor.scan_period == 2.0
    assert 8 < sensor.sigma < 12.5
    assert 0.8 < sensor.detection_probability < 0.98
    # Objects leave the cube, and their reports widen what seems covered.
    assert 0.6 < sensor.clutter_density * 2000**dim / 15 < 1.3
    assert 8 < found.max_speed < 60
    assert found.process_noise < 1.0


def test_estimates_are_of_any_unit_of_time() -> None:
    """What moves a metre a year is tracked as well as what moves a metre a second."""
    fast, year = scene(), 3.2e7
    found = estimate(fast)
    slow = estimate(table(fast.time * year, fast.measurement))
    assert slow.max_speed * year == pytest.approx(found.max_speed, rel=1e-3)
    assert slow.process_noise * year**3 == pytest.approx(found.process_noise, rel=1e-2)
    assert slow.sensors["A"].sigma == pytest.approx(found.sensors["A"].sigma, rel=1e-3)


@pytest.mark.parametrize("heading", [0.0, 0.7])
def test_reports_on_a_line_tell_as_much_as_those_of_a_plane(heading: float) -> None:
    rng, times, places = np.random.default_rng(4), [], []
    start, speed = rng.uniform(0, 4000, 15), rng.choice([-1, 1], 15) * rng.uniform(20, 35, 15)
    for scan in range(60):
        seen = rng.random(15) < 0.9
        along = start[seen] + speed[seen] * scan + rng.normal(0, 4, np.count_nonzero(seen))
        both = np.concatenate([along, rng.uniform(-2000, 6000, rng.poisson(5))])
        times += [float(scan)] * both.size
        places.append(both)
    along = np.concatenate(places)
    way = np.array([np.cos(heading), np.sin(heading)])
    found = estimate(table(times, along[:, None] * way + [500.0, -300.0]))
    sensor = found.sensors["A"]
    assert 2.5 < sensor.sigma < 6.0
    assert 0.8 < sensor.detection_probability < 0.98
    assert 30 < found.max_speed < 60
    assert 2.0 < sensor.clutter_density * sensor.covered < 10.0
    assert "lie on a line" in found.notes[0]


@pytest.mark.slow
def test_says_when_an_estimate_is_doubtful() -> None:
    assert estimate(scene()).doubts == {}
    crowd = estimate(scene(n_targets=100, clutter=300.0, period=20.0))
    assert crowd.doubts["A"].startswith("a crowd, in which ")
    rng = np.random.default_rng(1)
    noise = estimate(table(np.arange(30.0), rng.uniform(0, 1e5, (30, 2))))
    assert "usual values stand in" in noise.doubts["A"]


@pytest.mark.slow
def test_tells_noise_in_a_crowd_whose_neighbours_are_near() -> None:
    found = estimate(scene(n_targets=100, clutter=100.0, period=12.0))
    assert 9.0 < found.sensors["A"].sigma < 11.0


def test_takes_no_chain_of_false_alarms_that_gather_for_an_object() -> None:
    rng = np.random.default_rng(5)
    objects, period = scene(clutter=0.0, n_scans=120), 2.0
    times, places = [objects.time], [objects.measurement]
    for scan in range(120):
        # As the sea about a radar: the nearer, the denser.
        reach, way = rng.exponential(300.0, 25), rng.uniform(0, 2 * np.pi, 25)
        times.append(np.full(25, scan * period))
        places.append(1000.0 + np.stack([reach * np.sin(way), reach * np.cos(way)], axis=1))
    found = estimate(table(np.concatenate(times), np.concatenate(places)))
    assert found.max_speed < 40.0
    assert found.speed_of_few < 30.0
    assert 8.0 < found.sensors["A"].sigma < 15.0


def test_takes_a_known_sigma_as_it_is() -> None:
    assert estimate(scene(), {"A": 7.5}).sensors["A"].sigma == 7.5


def test_takes_the_noise_that_reports_carry() -> None:
    reports = scene()
    reports.sigma[:] = 4.0
    assert estimate(reports).sensors["A"].sigma == 4.0


def test_sensors_are_estimated_apart() -> None:
    one = scene()
    n = len(one)
    both = table(
        np.concatenate([one.time, one.time * 2]),
        np.concatenate([one.measurement, one.measurement]),
        np.repeat([0, 1], n),
        ("A", "B"),
    )
    found = estimate(both).sensors
    assert (found["A"].scan_period, found["B"].scan_period) == (2.0, 4.0)


@pytest.mark.parametrize(
    ("gaps", "period"),
    [
        ([4.0] * 10, 4.0),
        ([4.0, 8.0, 4.0, 4.0, 12.0, 4.0, 4.0], 4.0),
        # Of 7/3 s, by a clock of whole seconds; and by no such clock.
        ([2.0, 3.0, 2.0] * 4, 28.0 / 12.0),
        ([2.0, 3.0, 5.0] * 4, None),
        ([0.1, 7.0, 2.3, 0.9, 31.0, 5.2], None),
        ([], None),
    ],
)
def test_scan_period_is_the_common_gap(gaps: list[float], period: float | None) -> None:
    assert scan_period(np.cumsum([0.0, *gaps])) == period


YEAR = 365 * 86400.0
ODD = {
    "one report": ([0.0], [[5.0, 5.0]]),
    "two reports at once": ([0.0, 0.0], [[5.0, 5.0], [6.0, 5.0]]),
    "all in one place": (np.arange(30.0), np.zeros((30, 2))),
    "all in one place and time": (np.zeros(30), np.ones((30, 2))),
    "one scan": (np.zeros(50), np.random.default_rng(1).uniform(0, 9, (50, 2))),
    "on a line": (np.arange(40.0), np.outer(np.arange(40.0), [3.0, 4.0])),
    "a gap of years": (
        np.r_[np.arange(20.0), 3 * YEAR + np.arange(20.0)],
        np.outer(np.arange(40.0), [3.0, 4.0]),
    ),
    "years between reports": (np.arange(10) * YEAR, np.random.default_rng(2).normal(size=(10, 2))),
    "huge coordinates": (np.arange(20.0), np.random.default_rng(2).normal(size=(20, 3)) * 1e8),
    "tiny coordinates": (np.arange(20.0), np.random.default_rng(2).normal(size=(20, 3)) * 1e-9),
    "irregular times": (
        np.cumsum(np.random.default_rng(4).exponential(1, 200)),
        np.random.default_rng(5).uniform(0, 1e4, (200, 2)),
    ),
    "duplicates": (np.repeat(np.arange(10.0), 6), np.repeat(np.arange(20.0), 6).reshape(60, 2)),
}


@pytest.mark.parametrize("name", ODD)
def test_odd_reports_give_finite_positive_values(name: str) -> None:
    found = numbers(estimate(table(*ODD[name])))
    assert np.all(np.isfinite(found))
    assert min(found) > 0


coordinate = st.one_of(st.just(0.0), st.floats(-1e9, 1e9), st.integers(-3, 3).map(float))


@given(
    st.lists(
        st.tuples(st.one_of(st.integers(0, 5), st.floats(-1e9, 1e9)), coordinate, coordinate),
        min_size=1,
        max_size=40,
    )
)
def test_any_reports_give_finite_positive_values(rows: list[tuple[float, float, float]]) -> None:
    columns = np.array(rows, float)
    found = numbers(estimate(table(columns[:, 0], columns[:, 1:])))
    assert np.all(np.isfinite(found))
    assert min(found) > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["T5_S1_r1", "T20_S1_r1", "T50_S1_r1", "T100_S1_r1"])
def test_is_near_the_truth_of_the_benchmark_scenes(shared: Path, name: str) -> None:
    with (shared / "bench" / "data" / name / "detections.csv").open() as file:
        rows = list(csv.DictReader(file))
    found = estimate(
        table([row["time"] for row in rows], [[float(row["x"]), float(row["y"])] for row in rows])
    )
    sensor = found.sensors["A"]
    n_targets = int(name[1:].split("_")[0])
    assert sensor.scan_period == 1.0
    assert 8 < sensor.sigma < 12.5
    assert 0.8 < sensor.detection_probability <= 0.98
    assert 0.75 < sensor.clutter_density * 1.44e6 / n_targets < 1.25
    with (shared / "bench" / "data" / name / "truth.csv").open() as file:
        fastest = max(np.hypot(float(row["vx"]), float(row["vy"])) for row in csv.DictReader(file))
    assert fastest < found.max_speed < 45


def test_a_gate_of_which_nothing_is_told_charges_nobody_with_misses_beside_cameras() -> None:
    rng, rows = np.random.default_rng(4), []
    for look in range(150):
        for each in range(6):
            way = 0.5 * look + 14.0 * each
            at = rng.normal([way % 84.0, 3.0 * each], 0.05)
            if rng.random() < 0.95:
                rows.append((0.4 * look, "camera", *at))
            if 42.0 <= way % 84.0 < 42.5:
                rows.append((0.4 * look + 0.1, "gate", 42.0, 7.5))
    reports = tw.read_reports(pl.DataFrame(rows, ["time", "sensor", "x", "y"], orient="row"))
    found = estimate(reports)
    assert found.sensors["gate"].scans is False
    assert found.sensors["gate"].sigma == found.sensors["camera"].sigma
    (note,) = (each for each in found.notes if "sensor gate" in each)
    assert "no silence of it counts as a miss" in note
    # What is told to look does.
    assert estimate(reports, None, {"gate": True}).sensors["gate"].scans is not False
