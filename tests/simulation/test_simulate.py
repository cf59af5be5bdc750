"""Tests of the simulation itself."""

from dataclasses import replace

import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.simulation.demo import demo_scenario
from trackweave.simulation.scenario import Area, RandomTargets, Scenario, SimulatedSensor
from trackweave.simulation.simulate import Simulation, simulate
from trackweave.simulation.targets import Crossing, Target

BOX = Area((0, 0), (1000, 1000))
RADAR = SimulatedSensor("radar", 10.0, 1.0, detection_probability=0.8, clutter_per_scan=6.0)


def run(scenario: Scenario, seed: int = 1) -> Simulation:
    return simulate(scenario, np.random.default_rng(seed))


def columns(simulation: Simulation) -> list[np.ndarray]:
    reports, truth = simulation.reports, simulation.truth
    assert truth.velocity is not None
    return [
        reports.time,
        reports.sensor,
        reports.measurement,
        reports.sigma,
        reports.report,
        reports.carried["target"],
        truth.time,
        truth.target,
        truth.position,
        truth.velocity,
    ]


def same(first: Simulation, second: Simulation) -> bool:
    pairs = zip(columns(first), columns(second), strict=True)
    return all(np.array_equal(one, other) for one, other in pairs)


def test_the_same_seed_gives_the_same_and_another_another() -> None:
    scenario = replace(demo_scenario(), random=RandomTargets(3, (1, 5), 0.05, 0.99))
    assert same(run(scenario, 4), run(scenario, 4))
    assert not same(run(scenario, 4), run(scenario, 5))
    assert same(simulate(scenario, 4), run(scenario, 4))
    assert same(simulate(scenario), run(scenario, 0))


def test_rates_noise_and_clutter_are_as_asked() -> None:
    still = RandomTargets(40, (0, 0))
    scenario = Scenario(BOX, 499.0, (RADAR,), random=still)
    made = run(scenario)
    target = made.reports.carried["target"]
    real = target != ""
    assert real.sum() / (500 * 40) == pytest.approx(0.8, abs=0.01)
    assert (~real).sum() / 500 == pytest.approx(6.0, abs=0.4)
    home = dict(zip(made.truth.target, made.truth.position, strict=True))
    errors = made.reports.measurement[real] - np.array([home[name] for name in target[real]])
    assert errors.std(axis=0) == pytest.approx([10.0, 10.0], rel=0.03)
    assert errors.mean(axis=0) == pytest.approx([0.0, 0.0], abs=0.4)
    false = made.reports.measurement[~real]
    assert false.mean(axis=0) == pytest.approx([500, 500], abs=25)
    assert false.min() >= 0
    assert false.max() <= 1000


def test_reports_are_sorted_and_numbered_and_carry_their_noise() -> None:
    slow = SimulatedSensor("slow", (3.0, 4.0), 2.5, start_offset=0.5, clutter_per_scan=2.0)
    reports = run(Scenario(BOX, 10.0, (RADAR, slow), random=RandomTargets(5, (1, 9)))).reports
    assert np.array_equal(np.lexsort((reports.sensor, reports.time)), np.arange(len(reports)))
    assert reports.report.tolist() == [str(number) for number in range(1, len(reports) + 1)]
    assert reports.sensors == ("radar", "slow")
    assert np.unique(reports.sigma[reports.sensor == 1], axis=0).tolist() == [[3.0, 4.0]]
    assert set(reports.time[reports.sensor == 1]) <= {0.5, 3.0, 5.5, 8.0}


def test_truth_has_every_living_target_at_every_time_of_a_scan() -> None:
    other = SimulatedSensor("other", 1.0, 1.0, start_offset=0.25)
    targets = (Target((1, 1), (1, 0), start=1.0, end=2.25), Target((9, 9), (0, 1)))
    truth = run(Scenario(BOX, 3.0, (RADAR, other), targets)).truth
    times = [0.0, 0.25, 1.0, 1.25, 2.0, 2.25, 3.0]
    assert truth.time[truth.target == "2"].tolist() == times
    assert truth.time[truth.target == "1"].tolist() == [1.0, 1.25, 2.0, 2.25]


def test_the_last_scan_is_at_the_end_despite_rounding() -> None:
    sensor = SimulatedSensor("r", 1.0, 0.1)
    truth = run(Scenario(BOX, 0.3, (sensor,), (Target((1, 1), (1, 0)),))).truth
    assert truth.time == pytest.approx([0.0, 0.1, 0.2, 0.3])


def test_a_sensor_sees_nothing_beyond_its_range_or_the_area() -> None:
    near = SimulatedSensor(
        "near", 0.001, 1.0, 1.0, clutter_per_scan=30.0, position=(100, 100), max_range=150.0
    )
    targets = (
        Target((110, 110), (0, 0), name="near"),
        Target((500, 500), (0, 0), name="far"),
        Target((-10, 100), (0, 0), name="outside"),
    )
    reports = run(Scenario(BOX, 50.0, (near,), targets)).reports
    distance = np.linalg.norm(reports.measurement - [100, 100], axis=1)
    assert set(reports.carried["target"]) == {"near", ""}
    assert distance.max() <= 150.0
    assert distance[reports.carried["target"] == ""].max() > 140.0
    assert reports.measurement.min() >= 0.0


def test_the_margin_is_watched_too() -> None:
    wide = Area((0, 0), (1000, 1000), margin=200.0)
    places = run(Scenario(wide, 200.0, (RADAR,))).reports.measurement
    assert -200 <= places.min() < -150
    assert 1150 < places.max() <= 1200


def test_a_crossing_crosses_despite_process_noise() -> None:
    crossing = Crossing((500, 500), time=20.0, speed=10.0, count=4)
    truth = run(Scenario(BOX, 40.0, (RADAR,), crossings=(crossing,), process_noise=0.5)).truth
    there = truth.position[truth.time == 20.0]
    assert there == pytest.approx(np.full((4, 2), 500.0))
    assert np.ptp(truth.position[truth.time == 0.0], axis=0).max() > 20


def test_process_noise_makes_velocity_vary_as_asked() -> None:
    still = RandomTargets(300, (0, 0))
    truth = run(Scenario(BOX, 25.0, (RADAR,), random=still, process_noise=0.04)).truth
    assert truth.velocity is not None
    last = truth.velocity[truth.time == 25.0]
    assert last.std(axis=0) == pytest.approx(np.full(2, np.sqrt(0.04 * 25)), rel=0.12)


def test_targets_are_born_and_die_at_the_rates_asked() -> None:
    wanted = RandomTargets(200, (0, 0), birth_rate=2.0, survival=0.99)
    truth = run(Scenario(BOX, 100.0, (RADAR,), random=wanted)).truth
    counts = [int((truth.time == time).sum()) for time in (0.0, 100.0)]
    assert counts[0] == 200
    # Births 2 a second and a mean life of some 99.5 s balance at 199 targets.
    assert counts[1] == pytest.approx(199, abs=45)
    survivors = np.isin(truth.target[truth.time == 100.0], truth.target[truth.time == 0.0]).sum()
    assert survivors == pytest.approx(200 * 0.99**100, abs=25)


def test_random_targets_stay_inside_or_end_at_the_border() -> None:
    fast = RandomTargets(50, (5, 20))
    truth = run(Scenario(BOX, 40.0, (RADAR,), random=fast)).truth
    assert truth.position.min() >= 0
    assert truth.position.max() <= 1000
    assert (truth.time == 40.0).sum() == 50
    leaving = replace(fast, speed=(10, 30), stay_inside=False)
    truth = run(Scenario(BOX, 40.0, (RADAR,), random=leaving)).truth
    assert truth.position.min() >= 0
    assert truth.position.max() <= 1000
    assert 0 < (truth.time == 40.0).sum() < 50


def test_random_speeds_lie_in_their_range() -> None:
    truth = run(Scenario(BOX, 1.0, (RADAR,), random=RandomTargets(300, (5, 20)))).truth
    assert truth.velocity is not None
    speeds = np.linalg.norm(truth.velocity, axis=1)
    assert 5 <= speeds.min() < 6
    assert 19 < speeds.max() <= 20


def test_works_in_three_dimensions() -> None:
    space = Area((0, 0, 0), (1000, 1000, 500))
    sensor = SimulatedSensor("r", (5, 5, 20), 1.0, clutter_per_scan=3.0)
    made = run(Scenario(space, 20.0, (sensor,), random=RandomTargets(4, (1, 9))))
    assert (made.reports.dim, made.truth.dim) == (3, 3)
    assert made.reports.measurement[:, 2].max() > 100


def test_a_scene_without_targets_or_scans_is_empty_not_an_error() -> None:
    late = SimulatedSensor("late", 1.0, 1.0, start_offset=99.0)
    made = run(Scenario(BOX, 3.0, (late,)))
    assert (len(made.reports), len(made.truth)) == (0, 0)
    assert made.reports.measurement.shape == (0, 2)
    made = run(Scenario(BOX, 3.0, (RADAR,)))
    assert len(made.truth) == 0
    assert set(made.reports.carried["target"]) == {""}


def test_refuses_targets_too_fast_to_stay() -> None:
    with pytest.raises(InvalidInputError, match=r"random.speed: .*stay_inside = false"):
        run(Scenario(BOX, 100.0, (RADAR,), random=RandomTargets(1, (500, 500))))


def test_refuses_a_sensor_that_watches_nothing() -> None:
    blind = SimulatedSensor(
        "blind", 1.0, 1.0, clutter_per_scan=9.0, position=(9000, 0), max_range=10.0
    )
    with pytest.raises(InvalidInputError, match=r"sensor 'blind', max_range: 10"):
        run(Scenario(BOX, 9.0, (blind,)))


def test_refuses_a_name_that_a_random_target_needs() -> None:
    named = Target((1, 1), (0, 0), name="2")
    with pytest.raises(InvalidInputError, match="random target's number"):
        run(Scenario(BOX, 9.0, (RADAR,), (named,), random=RandomTargets(1, (0, 1))))


def test_the_demo_is_sixty_scans_of_three_radars() -> None:
    made = run(demo_scenario())
    assert sum(1 for _ in made.reports.scans()) == 60
    assert len(made.reports.sensors) == 3
    assert len(set(made.truth.target)) == 9
    assert 0.3 < np.mean(made.reports.carried["target"] == "") < 0.7
