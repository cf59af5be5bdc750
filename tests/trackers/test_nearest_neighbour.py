"""The nearest-neighbour tracker: one decision per scan, by distance and then by Kalman filter."""

import numpy as np
import pytest
from scipy.stats import chi2

from oracles import kalman
from oracles.scenes import LIFECYCLE, MOTION, run, scan, scene, sensor
from trackweave.association.problem import Status
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import COASTING, CONFIRMED, TENTATIVE, TrackTable
from trackweave.errors import InvalidInputError
from trackweave.models.coverage import FieldOfView
from trackweave.models.motion import ConstantVelocity
from trackweave.solvers import Exact
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker

RNG = np.random.default_rng(1)


def tracker(*sensors, **changed):
    options = {"motion": MOTION, "sensors": sensors or (sensor(),), "lifecycle": LIFECYCLE}
    return NearestNeighbourTracker(**(options | changed))


def known(*states, spread=(100.0, 100.0, 4.0, 4.0), time=0.0):
    """Return confirmed tracks of the given states, named from 1."""
    count = len(states)
    return TrackTable(
        np.full(count, time), 1 + np.arange(count), np.full(count, CONFIRMED),
        np.array(states, dtype=float), np.tile(np.diag(spread), (count, 1, 1)),
        np.zeros(count), np.ones(count, dtype=np.int64), np.full(count, time),
    )  # fmt: skip


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("pairing", ["one-to-one", "nearest"])
def test_a_lone_object_is_followed_as_by_the_textbook_filter(dim, pairing):
    rng = np.random.default_rng(dim)
    times = np.array([0.0, 1.0, 2.5, 3.0, 4.0, 7.0, 7.5])
    places = np.outer(times, np.arange(1, dim + 1)) * 3.0 + rng.normal(size=(7, dim)) * 10.0
    target = tracker(sensor(clutter_density=1e-9), pairing=pairing)
    hypotheses = run(
        target, [Scan(t, "radar", [place]) for t, place in zip(times, places, strict=True)]
    )
    mean = np.concatenate([places[0], np.zeros(dim)])
    covariance = np.diag([100.0] * dim + [30.0**2 / (dim + 2)] * dim)
    score = -np.log(0.9 * 1e-6 / 1e-9)
    for index in range(1, 7):
        interval = times[index] - times[index - 1]
        mean, covariance = kalman.predict(mean, covariance, interval, 0.05)
        score -= kalman.log_likelihood(mean, covariance, places[index], [10.0] * dim)
        score += np.log(1e-9) - np.log(0.9) - interval * np.log(0.999)
        mean, covariance = kalman.update(mean, covariance, places[index], [10.0] * dim)
        tracks = hypotheses[index].tracks
        np.testing.assert_allclose(tracks.mean, [mean], rtol=0, atol=1e-9)
        np.testing.assert_allclose(tracks.covariance, [covariance], rtol=0, atol=1e-9)
        np.testing.assert_allclose(tracks.score, [score], rtol=0, atol=1e-9)
    assert tracks.hits.tolist() == [7]


@pytest.mark.parametrize("seed", range(4))
def test_in_its_first_scan_it_decides_as_the_best_hypothesis_of_that_scan(seed):
    """Beside known tracks, what it minimises is what a window of one scan costs at best."""
    rng = np.random.default_rng(seed)
    states = np.column_stack([rng.uniform(0, 120, (6, 2)), np.zeros((6, 2))])
    seen = scan(1.0, np.concatenate([states[:5, :2] + rng.normal(size=(5, 2)) * 12.0,
                                     rng.uniform(0, 120, (3, 2))]))  # fmt: skip
    heavy = sensor(clutter_density=2e-4)
    options = {"motion": MOTION, "sensors": [heavy], "priors": known(*states)}
    one = NearestNeighbourTracker(**options).step(seen, rng=RNG)
    other = MultiHypothesisTracker(**options, window=1, search=Exact(), estimate="best")
    best = other.step(seen, rng=RNG)
    assert one.certificate.status is Status.OPTIMAL
    assert one.certificate.cost == pytest.approx(best.certificate.cost, abs=1e-9)
    theirs = dict(zip(other.pending().report, other.pending().track, strict=True))
    mine = dict(zip(one.final.report, one.final.track, strict=True))
    assert {r: t for r, t in mine.items() if t <= 6} == {r: t for r, t in theirs.items() if t > 0}


def test_under_nearest_two_tracks_share_a_report_and_the_closer_is_said_to_have_it():
    priors = known((0.0, 0.0, 0.0, 0.0), (30.0, 0.0, 0.0, 0.0))
    seen = scan(1.0, [(12.0, 0.0)])
    shared = tracker(priors=priors, pairing="nearest").step(seen, rng=RNG)
    assert shared.tracks.hits.tolist() == [2, 2]
    assert np.all(np.diff(shared.tracks.mean[:, 0]) < 30.0)
    assert shared.final.track.tolist() == [1]
    certificate = shared.certificate
    spread = np.diag([100.0 + 4.0 + 0.05 / 3 + 100.0] * 2)
    first, second = 0.5 * 12.0**2 / spread[0, 0], 0.5 * 18.0**2 / spread[0, 0]
    assert certificate.status is Status.FEASIBLE
    assert certificate.cost == pytest.approx(first + 0.5 * chi2.ppf(0.9999, 2), abs=1e-9)
    assert certificate.lower_bound == pytest.approx(first + second, abs=1e-9)
    alone = tracker(priors=priors).step(seen, rng=RNG)
    assert alone.tracks.hits.tolist() == [2, 1]
    assert alone.tracks.status.tolist() == [CONFIRMED, COASTING]


def test_a_track_that_knows_its_place_keeps_its_report_from_one_that_does_not():
    """By distance alone the vague track would be the nearer: 12² / 1.1e4 against 8² / 204."""
    priors = known((0.0, 0.0, 0.0, 0.0), (20.0, 0.0, 0.0, 0.0))
    priors.covariance[1, :2, :2] = np.eye(2) * 1e4
    hypothesis = tracker(priors=priors).step(scan(1.0, [(8.0, 0.0)]), rng=RNG)
    assert hypothesis.final.track.tolist() == [1]
    vague = tracker(priors=priors, pairing="nearest").step(scan(1.0, [(8.0, 0.0)]), rng=RNG)
    assert vague.final.track.tolist() == [2]


@pytest.mark.parametrize(("gate", "taken"), [(None, True), (4.1, True), (3.9, False)])
def test_the_gate_is_a_squared_distance(gate, taken):
    spread = 100.0 + 4.0 + 0.05 / 3 + 100.0
    at = [(np.sqrt(4.0 * spread), 0.0)]
    target = tracker(priors=known((0.0, 0.0, 0.0, 0.0)), gate=gate)
    assert (target.step(scan(1.0, at), rng=RNG).final.track[0] == 1) == taken


@pytest.mark.parametrize("wrong", [{"pairing": "best"}, {"pairing": None}, {"gate": 0},
                                   {"gate": -1.0}, {"gate": np.inf}, {"gate": "9"},
                                   {"gate": True}], ids=str)  # fmt: skip
def test_refuses_another_pairing_and_no_gate(wrong):
    with pytest.raises(InvalidInputError, match=rf"^{next(iter(wrong))}.*; expected"):
        tracker(**wrong)


@pytest.mark.parametrize(
    ("seen", "lives"),
    [("11", True), ("101", True), ("1001", False), ("100", False), ("1010", False)],
)
def test_a_tentative_track_ends_when_three_of_its_first_four_chances_are_out_of_reach(seen, lives):
    scans = [
        scan(time, [(2.0 * time, 0.0)] if hit == "1" else []) for time, hit in enumerate(seen)
    ]
    last = run(tracker(), scans)[-1].tracks
    assert (1 in last.track) == lives
    assert np.all(last.status == TENTATIVE)


def test_another_sensor_of_the_instant_may_still_save_a_tentative_track():
    target = tracker(sensor("a"), sensor("b"))
    plan = [(0, "a", 1), (1, "a", 0), (2, "a", 0), (2, "b", 1), (3, "a", 1), (4, "a", 0)]
    hypotheses = run(target, [scan(t, [(t, 0.0)] * hit, name) for t, name, hit in plan])
    assert [each.tracks.track.tolist() for each in hypotheses] == [[1]] * 6
    assert hypotheses[3].tracks.status.tolist() == [TENTATIVE]
    assert hypotheses[4].tracks.status.tolist() == [CONFIRMED]


def test_a_track_of_little_credit_is_confirmed_by_hits_only_where_that_is_asked_for():
    heavy = sensor(clutter_density=1e-3)
    scans = [scan(time, [(3.0 * time, 0.0)]) for time in range(4)]
    states = {
        chance: run(tracker(heavy, pairing="nearest", lifecycle=Lifecycle(
            confirm_probability=chance)), scans)[-1].tracks.status.tolist()
        for chance in (0.0, 0.9)
    }  # fmt: skip
    assert states == {0.0: [CONFIRMED], 0.9: [TENTATIVE]}


def test_two_scans_of_one_look_give_no_track_two_reports_and_charge_no_miss_twice():
    priors = known((0.0, 0.0, 0.0, 0.0), (500.0, 0.0, 0.0, 0.0))
    target = tracker(priors=priors)
    parts = [scan(1.0, [(3.0, 0.0)]), scan(1.0, [(4.0, 0.0), (900.0, 900.0)]), scan(2.0, [])]
    hypotheses = run(target, parts)
    assert sorted(hypotheses[1].final.track.tolist()) == [3, 4]
    assert hypotheses[1].tracks.hits.tolist() == [2, 1, 1, 1]
    assert target._tree.nodes.misses[: target._tree.n_nodes].max() == 2.0


@pytest.mark.parametrize("pairing", ["one-to-one", "nearest"])
def test_objects_that_cross_keep_their_tracks(pairing):
    rng = np.random.default_rng(3)
    scans = []
    for time in range(20):
        places = np.array([[20.0 * time, 10.0 * time - 95.0], [20.0 * time, 95.0 - 10.0 * time]])
        scans.append(scan(time, places + rng.normal(size=(2, 2)) * 3.0))
    exact = sensor(sigma=3.0, clutter_density=1e-8)
    hypotheses = run(tracker(exact, pairing=pairing), scans)
    first, last = hypotheses[0].tracks, hypotheses[-1].tracks
    # Shared reports leave others over, which begin tracks of their own.
    assert last.track[:2].tolist() == [1, 2]
    assert last.mean[:2, 1].round(-2).tolist() == (-first.mean[:, 1]).round(-2).tolist()
    assert last.hits[:2].tolist() == [20, 20]


def test_ranges_and_azimuths_are_followed_and_bearings_refine_but_start_nothing():
    radar = sensor(
        sigma=(5.0, 0.02), measurement=Kind.RANGE_AZIMUTH, position=(0.0, 0.0),
        clutter_density=1e-6,
    )  # fmt: skip
    camera = sensor(
        "camera", sigma=0.002, measurement=Kind.BEARING, position=(0.0, 0.0), clutter_density=1e-3
    )
    spread = {}
    for name, sensors in {"radar": (radar,), "both": (radar, camera)}.items():
        target, rng = tracker(*sensors), np.random.default_rng(5)
        for time in range(10):
            east, north = 300.0 + 8.0 * time, 400.0
            distance, azimuth = np.hypot(east, north), np.arctan2(east, north)
            noise = rng.normal(size=3)
            seen = [[distance + 5.0 * noise[0], azimuth + 0.02 * noise[1]]]
            last = target.step(Scan(time, "radar", seen), rng=RNG)
            if name == "both":
                sight = [[azimuth + 0.002 * noise[2]], [azimuth + 2.0]]
                last = target.step(Scan(time, "camera", sight), rng=RNG)
                assert last.final.track.tolist() == [1, -1]
        assert last.tracks.track.tolist() == [1]
        off = last.tracks.mean[0, :2] - (east, north)
        assert off @ np.linalg.solve(last.tracks.covariance[0, :2, :2], off) < chi2.ppf(0.999, 2)
        spread[name] = np.trace(last.tracks.covariance[0, :2, :2])
    assert spread["both"] < 0.5 * spread["radar"]


def test_a_track_misses_nothing_where_no_sensor_looks():
    disc = FieldOfView(max_range=100.0)
    target = tracker(sensor(position=(0.0, 0.0), field_of_view=disc))
    seen = [scan(time, [(18.0 * time, 0.0)]) for time in range(5)]
    hypotheses = run(target, seen + [scan(time, []) for time in range(9, 20)])
    assert hypotheses[-1].tracks.track.tolist() == [1]
    assert hypotheses[-1].tracks.status.tolist() == [CONFIRMED]


def test_the_covariance_of_a_report_is_respected():
    across = np.array([[100.0, 90.0], [90.0, 100.0]])
    target = tracker(priors=known((0.0, 0.0, 0.0, 0.0)))
    seen = Scan(1.0, "radar", [[10.0, -5.0]], covariance=[across])
    tracks = target.step(seen, rng=RNG).tracks
    before = np.eye(2) * (104.0 + 0.05 / 3)
    gain = before @ np.linalg.inv(before + across)
    np.testing.assert_allclose(tracks.mean[0, :2], gain @ (10.0, -5.0), atol=1e-9)
    np.testing.assert_allclose(tracks.covariance[0, :2, :2], before - gain @ before, rtol=1e-9)


def test_a_report_counts_at_its_own_moment():
    """A beam has passed a fast object 1 s before the turn's end, where it is 25 m further on."""
    radar = sensor(scan_period=4.0, sigma=2.0)
    priors = known((100.0, 0.0, 25.0, 0.0), spread=(4.0, 4.0, 0.01, 0.01))
    slow = ConstantVelocity(process_noise=0.0, max_speed=60.0)
    target = tracker(radar, priors=priors, motion=slow)
    seen = Scan(4.0, "radar", [[175.0, 0.0]], moments=[3.0])
    tracks = target.step(seen, rng=RNG).tracks
    assert tracks.last_update.tolist() == [3.0]
    np.testing.assert_allclose(tracks.mean[0], [200.0, 0.0, 25.0, 0.0], atol=1e-9)


def test_an_empty_world_stays_empty():
    hypotheses = run(tracker(), [scan(time, []) for time in range(4)])
    assert [len(each.tracks) for each in hypotheses] == [0] * 4
    assert len(tracker().pending()) == 0
    assert all(each.certificate.cost == 0.0 for each in hypotheses)


def test_a_scan_behind_the_last_one_is_late_and_one_beside_it_is_not():
    target = tracker(sensor("a"), sensor("b"))
    rng = np.random.default_rng(1)
    target.step(scan(5.0, [(0.0, 0.0)], "a"), rng=rng)
    assert target.step(scan(5.0, [(0.0, 0.0)], "b"), rng=rng).late == ()
    assert len(target.step(scan(4.9, [(0.0, 0.0)], "b"), rng=rng).late) == 1


def test_scenes_of_clutter_are_followed():
    last = run(tracker(), scene(7, times=range(25)))[-1].tracks
    assert (
        np.count_nonzero(last.status == CONFIRMED) + np.count_nonzero(last.status == COASTING) >= 3
    )
