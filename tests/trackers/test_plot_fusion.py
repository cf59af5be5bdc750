"""Plots of several sensors at one instant become reports, each of one object."""

import itertools

import numpy as np
import pytest

from oracles.scenes import MOTION, scan, sensor
from trackweave.association.plots_rule import PlotsRule
from trackweave.association.problem import Status
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.scans import Scan
from trackweave.errors import InvalidInputError
from trackweave.models.coverage import FieldOfView
from trackweave.models.sensors import Sensor
from trackweave.solvers import AntSystem, Exact
from trackweave.trackers.plot_fusion import PlotFuser

NAMES = ("A", "B", "C")
DENSITY = 1e-6


def evidence(**changed):
    values = {"object_density": DENSITY, "negative_only": True, "lone_plots": True}
    return PlotsRule(**(values | changed))


def fuser(names=NAMES, rule=None, **changed):
    sensors = [each if isinstance(each, Sensor) else sensor(each) for each in names]
    return PlotFuser(sensors, rule or evidence(), **({"search": Exact()} | changed))


def rng():
    return np.random.default_rng(1)


def instant(objects, seed=1, names=NAMES, sigma=10.0):
    """Return a scan per sensor of noisy plots of all objects, numbered across them."""
    source, scans, number = np.random.default_rng(seed), [], 0
    for name in names:
        places = np.asarray(objects, dtype=float)
        noisy = places + source.normal(0, sigma, places.shape)
        scans.append(scan(0.0, noisy, name, report=number + np.arange(len(places))))
        number += len(places)
    return scans


def bearings(name, place):
    return sensor(
        name, sigma=0.01, clutter_density=0.3, measurement=MeasurementKind.BEARING, position=place
    )


def looks(name, place, objects, time=0.0, report=()):
    away = np.asarray(objects, dtype=float).reshape(-1, 2) - place
    return Scan(time, name, np.arctan2(away[:, 0], away[:, 1])[:, None], report=report)


def test_fused_reports_are_weighted_means_of_their_plots():
    scans = instant([[0.0, 0.0], [500.0, 300.0]])
    fused = fuser()(scans, rng=rng(), first_report=7)
    assert fused.scan.report.tolist() == [7, 8]
    assert fused.scan.sensor == "A+B+C"
    assert sorted(sorted(held.tolist()) for held in fused.members) == [[0, 2, 4], [1, 3, 5]]
    assert fused.alone.size == 0
    for held, place, spread in zip(
        fused.members, fused.scan.measurement, fused.scan.covariance, strict=True
    ):
        own = [
            each.measurement[each.report == n] for each in scans for n in held if n in each.report
        ]
        assert place == pytest.approx(np.mean(own, axis=(0, 1)))
        assert spread == pytest.approx(100.0 / 3 * np.eye(2))
    assert fused.certificate.status is Status.OPTIMAL


@pytest.mark.parametrize("seed", range(3))
def test_the_choice_is_the_best_of_all(seed):
    """Every way to share out the tuples, tried one by one."""
    source = np.random.default_rng(seed)
    scans = instant(source.uniform(0, 60, (2, 2)), seed)
    rule = evidence(object_density=1e-4)
    fused = fuser(rule=rule)(scans, rng=rng())
    tuples = rule([each for each in _plots(scans)])
    best = 0.0
    for size in range(1, 4):
        for chosen in itertools.combinations(range(len(tuples)), size):
            columns = tuples.tuples[list(chosen)].T
            taken = [column[column > 0].tolist() for column in columns]
            if all(len(set(numbers)) == len(numbers) for numbers in taken):
                best = min(best, float(tuples.costs[list(chosen)].sum()))
    assert fused.certificate.cost == pytest.approx(best)


def _plots(scans):
    from trackweave.association.scan_plots import plots_of

    return [plots_of(each, sensor(each.sensor), 2) for each in scans]


def test_a_plot_far_from_all_others_is_a_false_alarm_by_evidence_in_clutter():
    scans = instant([[0.0, 0.0]])
    scans[1] = scan(0.0, [*scans[1].measurement, [800.0, 800.0]], "B", report=[1, 9])
    fused = fuser()(scans, rng=rng())
    assert len(fused) == 1
    assert fused.alone.tolist() == [9]


def test_a_lone_plot_stands_where_only_its_sensor_looks_and_false_alarms_are_rare():
    quiet = {"clutter_density": 2e-7}
    near = FieldOfView(max_range=200.0)
    sensors = [sensor("A", **quiet), sensor("B", field_of_view=near, **quiet)]
    scans = [scan(0.0, [[900.0, 0.0]], "A", report=[4]), scan(0.0, [], "B")]
    fused = fuser(sensors)(scans, rng=rng())
    assert [held.tolist() for held in fused.members] == [[4]]
    assert fused.scan.measurement.tolist() == [[900.0, 0.0]]
    # Where the other looks too and sees nothing, it is a false alarm.
    both = fuser([sensor("A", **quiet), sensor("B", **quiet)])(scans, rng=rng())
    assert len(both) == 0
    assert both.alone.tolist() == [4]


def test_a_sensor_that_did_not_look_missed_nothing():
    quiet = [sensor(name, clutter_density=2e-7) for name in "AB"]
    seen = scan(0.0, [[900.0, 0.0]], "A", report=[4])
    assert len(fuser(quiet)([seen], rng=rng())) == 1
    assert len(fuser(quiet)([seen, scan(0.0, [], "B")], rng=rng())) == 0


def test_by_equation_one_a_lone_plot_is_never_an_object_but_has_its_price():
    rule = PlotsRule(cost="equation-1", lone_plots=True)
    volumes = dict.fromkeys("AB", 1e6)
    one = fuser("AB", rule, volumes=volumes)
    alone = one([scan(0.0, [[0.0, 0.0]], "A", report=[3]), scan(0.0, [], "B")], rng=rng())
    assert len(alone) == 0
    assert alone.alone.tolist() == [3]
    # ln(2πσ² / (P_D Ψ)) − ln(1 − P_D)
    price = np.log(2 * np.pi * 100 / (0.9 * 1e6)) - np.log(0.1)
    assert alone.certificate.cost == pytest.approx(price)


def test_by_equation_one_bearings_alone_have_their_price_too():
    rule = PlotsRule(cost="equation-1", lone_plots=True)
    sensors = [bearings("A", (0.0, 0.0)), bearings("B", (1000.0, 0.0))]
    scans = [looks("A", (0, 0), [[500, 500]]), looks("B", (1000, 0), np.empty((0, 2)))]
    answer = fuser(sensors, rule)(scans, rng=rng())
    price = np.log(np.sqrt(2 * np.pi) * 0.01 / (0.9 * 2 * np.pi)) - np.log(0.1)
    assert answer.certificate.cost == pytest.approx(price)
    assert len(answer) == 0


def test_the_documents_ants_find_the_best_of_a_small_instant():
    rule = PlotsRule(cost="equation-1", lone_plots=True)
    volumes = dict.fromkeys(NAMES, 1e6)
    scans = instant([[0.0, 0.0], [60.0, 0.0], [400.0, 300.0]])
    exact = fuser(rule=rule, volumes=volumes)(scans, rng=rng())
    ants = fuser(rule=rule, volumes=volumes, search=AntSystem(decompose=False))(scans, rng=rng())
    assert ants.certificate.cost == pytest.approx(exact.certificate.cost)
    assert ants.stop_reason == "converged"


def test_sensors_of_every_kind_make_one_report():
    radar = sensor(
        "R", sigma=(10.0, 0.01), clutter_density=1e-3, measurement=MeasurementKind.RANGE_AZIMUTH
    )
    sensors = [sensor("A"), radar, bearings("B", (1000.0, 0.0))]
    place = np.array([300.0, 400.0])
    scans = [
        scan(0.0, [[308.0, 395.0]], "A", report=[0]),
        Scan(0.0, "R", [[500.0, np.arctan2(3.0, 4.0)]], report=[1]),
        looks("B", (1000.0, 0.0), [place], report=[2]),
    ]
    fused = fuser(sensors)(scans, rng=rng())
    assert [held.tolist() for held in fused.members] == [[0, 1, 2]]
    assert np.linalg.norm(fused.scan.measurement[0] - place) < 6.0
    assert abs(fused.scan.covariance[0, 0, 1]) > 0.0


def test_plots_of_another_time_are_less_sure_by_what_an_object_may_have_moved():
    late = [scan(0.0, [[0.0, 0.0]], "A", report=[0]), scan(0.4, [[0.0, 0.0]], "B", report=[1])]
    still = fuser("AB")(late, rng=rng()).scan
    moving = fuser("AB", motion=MOTION)(late, rng=rng()).scan
    assert still.covariance[0] == pytest.approx(50.0 * np.eye(2))
    wide = 100.0 + MOTION.velocity_variance(2) * 0.16
    assert moving.covariance[0] == pytest.approx(1.0 / (1.0 / 100.0 + 1.0 / wide) * np.eye(2))
    assert moving.time == 0.4


def test_noise_of_clocks_changes_nothing():
    exact = [scan(0.3, [[3.0, 4.0]], "A", report=[0]), scan(0.3, [[0.0, 0.0]], "B", report=[1])]
    noisy = [scan(0.1 + 0.2, [[3.0, 4.0]], "A", report=[0]), exact[1]]
    one, other = (fuser("AB", motion=MOTION)(each, rng=rng()).scan for each in (exact, noisy))
    assert one.measurement.tobytes() == other.measurement.tobytes()
    assert one.covariance.tobytes() == other.covariance.tobytes()


def test_identities_are_told_where_the_plots_do_not_contradict_each_other():
    place = [[0.0, 0.0]]
    for told, whom in [((5, -1), 5), ((5, 5), 5), ((5, 6), -1), ((-1, -1), -1)]:
        scans = [
            Scan(0.0, name, np.array(place), identity=[one])
            for name, one in zip("AB", told, strict=True)
        ]
        assert fuser("AB")(scans, rng=rng()).scan.identity.tolist() == [whom]
    assert fuser("AB")(instant(place, names="AB"), rng=rng()).scan.identity is None


def test_nothing_seen_is_an_empty_scan():
    fused = fuser()([scan(2.0, [], name) for name in NAMES], rng=rng())
    assert len(fused.scan) == len(fused) == fused.n_tuples == 0
    assert fused.certificate.cost == 0.0
    unknown = [Scan(2.0, name, np.empty((0, 0))) for name in NAMES]
    assert fuser()(unknown, rng=rng()).scan.measurement.shape == (0, 0)


def test_two_sensors_of_bearings_at_one_place_make_no_object():
    sensors = [bearings("A", (0.0, 0.0)), bearings("B", (0.0, 0.0))]
    scans = [looks(name, (0.0, 0.0), [[300.0, 400.0]]) for name in "AB"]
    assert len(fuser(sensors)(scans, rng=rng())) == 0


def test_parallel_bearings_make_no_object():
    sensors = [bearings("A", (0.0, 0.0)), bearings("B", (1000.0, 0.0))]
    scans = [Scan(0.0, name, np.zeros((2, 1))) for name in "AB"]
    assert len(fuser(sensors)(scans, rng=rng())) == 0


def test_the_same_seed_gives_the_same_bytes_in_any_order_of_scans():
    scans = instant(np.random.default_rng(3).uniform(0, 300, (6, 2)))
    ants = fuser(search=AntSystem())
    one, other = (ants(each, rng=rng()) for each in (scans, scans[::-1]))
    assert one.scan.measurement.tobytes() == other.scan.measurement.tobytes()
    assert [held.tolist() for held in one.members] == [held.tolist() for held in other.members]


@pytest.mark.parametrize(
    ("scans", "message"),
    [
        ([], "at least one"),
        (scan(0.0, [], "A"), "a sequence of Scan"),
        ([scan(0.0, [], "A")] * 2, "each of another sensor"),
        ([scan(0.0, [], "Z")], "scan of sensor 'Z'; expected one of A, B, C"),
        ([scan(0.0, [[0, 0]], "A"), Scan(0.0, "B", np.zeros((1, 3)))], "dimensions"),
        (["no scan"], "scans"),
    ],
)
def test_refuses_what_is_no_instant(scans, message):
    with pytest.raises(InvalidInputError, match=message):
        fuser()(scans, rng=rng())


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"rule": "evidence"}, "rule"),
        ({"search": Exact}, "search"),
        ({"motion": 3}, "motion"),
        ({"volumes": {"Z": 1.0}}, "volumes: sensor 'Z'"),
        ({"ignored_widths": {"Z": 1.0}}, "ignored_widths"),
        ({"dim": 4}, "dim"),
    ],
)
def test_refuses_arguments_of_another_kind(changed, message):
    with pytest.raises(InvalidInputError, match=message):
        fuser(**changed)


def test_a_fused_sensor_for_every_set_that_may_look_together():
    found = fuser().fused_sensors(2.0)
    assert [each.name for each in found] == ["A+B+C", "A+B", "A+C", "B+C", "A", "B", "C"]
    assert found[0].scan_period == 2.0
    # In this clutter a lone plot is no object: an instant of one sensor is no chance to miss.
    assert found[-1].field_of_view is not None
    assert found[0].field_of_view is None
    assert found[0].detection_probability > found[1].detection_probability > 0.7
    assert len(fuser([str(n) for n in range(7)]).fused_sensors(1.0)) == 1
    one = fuser().fused_sensors(1.0, combinations=[("C", "A")])
    assert [each.name for each in one] == ["A+C"]
    with pytest.raises(InvalidInputError, match="combinations"):
        fuser().fused_sensors(1.0, combinations=[("Z",)])
    with pytest.raises(InvalidInputError, match="reads like several"):
        fuser(["A", "B", "A+B"]).fused_sensors(1.0)


def test_reports_without_numbers_are_counted_by_sensor() -> None:
    sensors = [Sensor(name, sigma=10.0, clutter_density=1e-7, scan_period=1.0) for name in "AB"]
    rule = PlotsRule(object_density=1e-6, negative_only=True)
    fused = PlotFuser(sensors, rule)(
        [Scan(0.0, "B", [[5.0, 0.0]]), Scan(0.0, "A", [[0.0, 0.0], [9e3, 9e3]])],
        rng=np.random.default_rng(1),
    )
    assert [members.tolist() for members in fused.members] == [[0, 2]]
    assert fused.alone.tolist() == [1]


class TestLonePlots:
    def fused(self, views, places, *, keep_lone: bool = True):
        sensors = [
            Sensor(name, 10.0, clutter_density=1e-6, scan_period=1.0, field_of_view=view)
            for name, view in views.items()
        ]
        rule = PlotsRule(object_density=1e-7, negative_only=True, lone_plots=True)
        scans = [
            Scan(time, name, places[name]) for name, time in zip(views, (0.0, 3.0), strict=False)
        ]
        fuser = PlotFuser(sensors, rule, keep_lone=keep_lone)
        return fuser(scans, rng=rng()), fuser.fused_sensors(1.0)[0]

    def test_a_plot_where_only_its_sensor_looks_is_a_report_at_its_own_moment(self) -> None:
        near = FieldOfView(max_range=100.0)
        places = {"A": [[500.0, 0.0], [50.0, 0.0]], "B": [[51.0, 0.0]]}
        found, _ = self.fused({"A": None, "B": near}, places)
        assert [held.tolist() for held in found.members] == [[1, 2], [0]]
        assert found.scan.moments.tolist() == [3.0, 0.0]
        assert found.scan.measurement[1] == pytest.approx([500.0, 0.0])
        assert found.scan.covariance[1] == pytest.approx(100.0 * np.eye(2))
        assert found.alone.tolist() == []

    def test_a_plot_where_another_sensor_looks_and_sees_nothing_is_a_false_alarm(self) -> None:
        found, _ = self.fused({"A": None, "B": None}, {"A": [[500.0, 0.0]], "B": [[0.0, 0.0]]})
        assert len(found) == 0
        assert found.alone.tolist() == [0, 1]

    def test_one_sensor_alone_has_its_own_chance_and_false_alarms(self) -> None:
        found, fused = self.fused({"A": None}, {"A": [[500.0, 0.0]]})
        assert len(found) == 1
        assert fused.detection_probability == pytest.approx(0.9)
        assert fused.clutter_density == pytest.approx(1e-6)
        left, blind = self.fused({"A": None}, {"A": [[500.0, 0.0]]}, keep_lone=False)
        assert len(left) == 0
        assert blind.detection_probability < 1e-6

    def test_by_equation_1_they_are_false_alarms_always(self) -> None:
        with pytest.raises(InvalidInputError, match=r"keep_lone: True; expected False"):
            PlotFuser([Sensor("A", 1.0)], PlotsRule(cost="equation-1"), keep_lone=True)
