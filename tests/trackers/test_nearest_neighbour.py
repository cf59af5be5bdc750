"""The nearest-neighbour tracker: one decision per scan, by distance and then by Kalman filter."""

import numpy as np
import pytest
from scipy.stats import chi2

from oracles import kalman
from oracles.scenes import MOTION, run, scan, sensor
from trackweave.association.problem import Status
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import COASTING, CONFIRMED, TrackTable
from trackweave.errors import InvalidInputError
from trackweave.solvers import Exact
from trackweave.trackers.multiscan import MultiScanTracker
from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker

RNG = np.random.default_rng(1)


def tracker(*sensors, **changed):
    options = {"motion": MOTION, "sensors": sensors or (sensor(),)}
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
    other = MultiScanTracker(**options, window=1, search=Exact(), estimate="best")
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
