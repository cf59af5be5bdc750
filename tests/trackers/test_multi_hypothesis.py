"""The tracker as a whole: every report once, names once, late scans, odd input."""

import tracemalloc

import numpy as np
import pytest

from oracles.scenes import (
    MOTION,
    all_assignments,
    run,
    scan,
    scene,
    sensor,
    tracker,
)
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.errors import InvalidInputError
from trackweave.models.motion import ConstantVelocity
from trackweave.solvers import Dual, Exact, Genetic, Greedy, MBest
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.window import Window

SOLVERS = {
    "greedy": Greedy(),
    "dual": Dual(),
    "exact": Exact(),
    "m-best": MBest(hypotheses=20),
    "permutation": Genetic(population=20, generations=10),
    "association-list": Genetic(population=20, generations=10, genotype="association-list"),
}


def numbers(scans):
    return sorted(int(number) for each in scans for number in each.report)


def assert_sound(target, scans, hypotheses):
    """Check what must hold of any run: reports once, no scan twice in a track, sound rows."""
    assignment = all_assignments(target, hypotheses)
    late = [number for hypothesis in hypotheses for number in hypothesis.late]
    assert sorted([*assignment, *late]) == numbers(scans)
    for each in scans:
        own = [assignment[n] for n in each.report.tolist() if assignment.get(n, -1) >= 0]
        assert len(set(own)) == len(own)
    for hypothesis in hypotheses:
        tracks = hypothesis.tracks
        assert len(set(tracks.track.tolist())) == len(tracks)
        assert np.all(np.isfinite(tracks.mean))
        for covariance in tracks.covariance:
            assert np.linalg.eigvalsh(covariance).min() > 0.0
        assert hypothesis.certificate.lower_bound <= hypothesis.certificate.cost + 1e-6
    return assignment


@pytest.mark.parametrize("name", SOLVERS)
def test_any_solver_covers_every_report_once(name):
    scans = scene(1)
    target = tracker(search=SOLVERS[name])
    hypotheses = run(target, scans)
    assert_sound(target, scans, hypotheses)
    assert len(hypotheses[-1].tracks) == 3


@pytest.mark.parametrize("depth", [1, 2, 5, 30])
@pytest.mark.parametrize("estimate", ["average", "best"])
def test_any_depth_covers_every_report_once(depth, estimate):
    scans = scene(2, names=("a", "b"))
    target = tracker(sensor("a"), sensor("b"), window=Window(depth, 60), estimate=estimate)
    assert_sound(target, scans, run(target, scans))


def test_a_short_window_of_many_scans_covers_every_report_once():
    scans = scene(2, names=("a", "b", "c"))
    target = tracker(*(sensor(name) for name in "abc"), window=Window(depth=5, max_scans=2))
    assert_sound(target, scans, run(target, scans))


def test_a_deadline_that_is_over_still_gives_a_sound_hypothesis():
    scans = scene(3, objects=6, clutter=6, area=400.0)
    target = tracker(search=Genetic())
    assert_sound(target, scans, run(target, scans, deadline=1e-9))


@pytest.mark.parametrize("name", SOLVERS)
def test_the_same_seed_gives_the_same_hypotheses(name):
    scans = scene(4, objects=5, clutter=5, area=300.0)
    runs = [run(tracker(search=SOLVERS[name]), scans, seed=7) for _ in range(2)]
    for mine, theirs in zip(*runs, strict=True):
        np.testing.assert_array_equal(mine.tracks.mean, theirs.tracks.mean)
        np.testing.assert_array_equal(mine.tracks.track, theirs.tracks.track)
        assert mine.amendments == theirs.amendments
        assert mine.certificate == theirs.certificate


def test_amendments_are_what_changed_between_successive_assignments():
    scans = scene(5, objects=6, clutter=8, area=300.0, detection=0.7, times=range(20))
    target, before, count = tracker(sensor(detection_probability=0.7)), {}, 0
    for each in scans:
        (hypothesis,) = run(target, [each])
        pending = target.pending()
        after = dict(zip(pending.report.tolist(), pending.track.tolist(), strict=True))
        expected = {
            (report, before[report], track)
            for report, track in after.items()
            if report in before and before[report] != track
        }
        told = {
            (a.report, -1 if a.before is None else a.before, -1 if a.after is None else a.after)
            for a in hypothesis.amendments
        }
        assert told == expected
        for report, track in zip(
            hypothesis.final.report.tolist(), hypothesis.final.track.tolist(), strict=True
        ):
            assert before[report] == track
        before, count = after, count + len(told)
    assert count > 0


def test_a_name_never_comes_back():
    scans = scene(6, objects=5, clutter=8, area=300.0, detection=0.5, times=range(40))
    life = Lifecycle(delete_after_misses=2)
    target = tracker(sensor(detection_probability=0.5), lifecycle=life)
    gone, live = set(), set()
    for each in scans:
        run(target, [each])
        pending = target.pending()
        held = set(target._tree.track.tolist()) | set(pending.track.tolist())
        named = (held | set(target._manager._records)) - {-1}
        assert not named & gone
        gone |= live - named
        live = named
    assert len(gone) > 3


def test_empty_scans_are_scans():
    target = tracker()
    hypotheses = run(target, [scan(float(time), []) for time in range(10)])
    assert all(len(hypothesis.tracks) == 0 for hypothesis in hypotheses)
    assert hypotheses[-1].time == 9.0
    assert hypotheses[-1].certificate.cost == 0.0


def test_reports_may_come_alone_at_any_time():
    rng = np.random.default_rng(1)
    target = tracker(
        sensor(scan_period=None, detection_probability=0.5, clutter_density=1e-7), window=8
    )
    times = np.cumsum(rng.uniform(0.05, 2.0, size=30))
    scans = [
        scan(time, [(5.0 * time + rng.normal() * 5.0, 3.0)], report=[number])
        for number, time in enumerate(times)
    ]
    hypotheses = run(target, scans)
    assert_sound(target, scans, hypotheses)
    assert hypotheses[-1].tracks.hits.tolist() == [30]


def test_sensors_of_unequal_pace_feed_one_track():
    target = tracker(sensor("slow", scan_period=4.0), sensor("fast", scan_period=1.0))
    rng, scans, number = np.random.default_rng(1), [], 0
    for time in np.arange(0.0, 20.0, 0.5):
        for name, period in (("slow", 4.0), ("fast", 1.0)):
            if time % period == (0.5 if name == "fast" else 0.0):
                place = [(8.0 * time + rng.normal() * 10.0, rng.normal() * 10.0)]
                scans.append(scan(time, place, name, [number]))
                number += 1
    hypotheses = run(target, scans)
    assignment = assert_sound(target, scans, hypotheses)
    assert len(set(assignment.values())) == 1


def priors(dim=2, track=(7,), time=0.0):
    n = len(track)
    none = np.zeros(n)
    return TrackTable(
        time=np.full(n, time),
        track=np.array(track),
        status=np.full(n, CONFIRMED),
        mean=np.tile([0.0] * dim + [10.0] + [0.0] * (dim - 1), (n, 1)),
        covariance=np.tile(np.diag([100.0] * dim + [4.0] * dim), (n, 1, 1)),
        score=none,
        hits=np.full(n, 5),
        last_update=np.full(n, time),
    )


def test_a_track_known_beforehand_is_there_from_the_first_scan():
    target = tracker(priors=priors())
    hypotheses = run(target, [scan(float(time), [(10.0 * time, 0.0)]) for time in range(1, 7)])
    for hypothesis in hypotheses:
        assert hypothesis.tracks.track.tolist() == [7]
        assert hypothesis.tracks.status.tolist() == [CONFIRMED]
    assert hypotheses[-1].tracks.hits.tolist() == [11]
    assert set(all_assignments(target, hypotheses).values()) == {7}


def test_a_scan_before_the_known_tracks_is_late():
    target = tracker(priors=priors(time=10.0))
    (early,) = run(target, [scan(9.0, [(1.0, 1.0)], report=[4])])
    assert early.late == (4,)
    (first,) = run(target, [scan(10.0, [(0.0, 0.0)], report=[5])])
    assert first.late == ()
    assert first.tracks.track.tolist() == [7]


def test_new_names_go_on_behind_the_known_ones():
    target = tracker(priors=priors())
    scans = [scan(float(t), [(10.0 * t, 0.0), (5.0 * t, 500.0)]) for t in range(1, 7)]
    assert run(target, scans)[-1].tracks.track.tolist() == [7, 8]


@pytest.mark.parametrize("track", [(7, 7), (-1,)])
def test_refuses_known_tracks_without_names_of_their_own(track):
    with pytest.raises(InvalidInputError, match="priors"):
        tracker(priors=priors(track=track))


def test_the_states_given_in_are_left_as_they_are():
    known = priors()
    before = known.mean.copy(), known.covariance.copy()
    scans = scene(1, objects=2)
    copies = [each.measurement.copy() for each in scans]
    run(tracker(priors=known), scans)
    np.testing.assert_array_equal(known.mean, before[0])
    np.testing.assert_array_equal(known.covariance, before[1])
    for each, copy in zip(scans, copies, strict=True):
        np.testing.assert_array_equal(each.measurement, copy)


def test_tracks_in_three_dimensions():
    scans = scene(2, dim=3, clutter=1)
    target = tracker(sensor(clutter_density=1e-9), lifecycle=Lifecycle(new_target_density=1e-9))
    hypotheses = run(target, scans)
    assert_sound(target, scans, hypotheses)
    assert hypotheses[-1].tracks.dim == 3
    assert len(hypotheses[-1].tracks) == 3


def test_refuses_an_unknown_sensor_by_name():
    with pytest.raises(InvalidInputError, match="'sonar'; expected one of a, b"):
        run(tracker(sensor("a"), sensor("b")), [scan(0.0, [], "sonar")])


@pytest.mark.parametrize("dim", [1, 4])
def test_refuses_worlds_of_other_dimensions(dim):
    with pytest.raises(InvalidInputError, match=f"{dim} dimensions; expected 2 or 3"):
        run(tracker(), [Scan(0.0, "radar", np.zeros((1, dim)))])


def test_refuses_a_change_of_dimensions_and_goes_on():
    target = tracker()
    run(target, [scan(0.0, [(0, 0)])])
    with pytest.raises(InvalidInputError, match="3 dimensions; expected 2"):
        run(target, [Scan(1.0, "radar", np.zeros((1, 3)))])
    assert len(run(target, [scan(1.0, [(1, 0)])])) == 1


def test_refuses_a_number_that_was_used_before():
    target = tracker()
    run(target, [scan(0.0, [(0, 0)], report=[3])])
    with pytest.raises(InvalidInputError, match="used before"):
        run(target, [scan(1.0, [(0, 0)], report=[3])])
    with pytest.raises(InvalidInputError, match="used before"):
        run(target, [scan(1.0, [(0, 0), (9, 9)], report=[4, 4])])


def test_reports_without_numbers_get_free_ones():
    target = tracker()
    run(target, [scan(0.0, [(0, 0), (500, 500)]), scan(1.0, [(1, 1), (400, 0)], report=[2, -1])])
    assert sorted(target.pending().report.tolist()) == [0, 1, 2, 3]


@pytest.mark.parametrize("sensors", [(), (sensor("a"), sensor("a"))])
def test_refuses_sensors_without_names_of_their_own(sensors):
    with pytest.raises(InvalidInputError, match=r"sensors: (none; expected|two called)"):
        MultiHypothesisTracker(motion=MOTION, sensors=sensors)


def test_refuses_an_unknown_estimate():
    with pytest.raises(InvalidInputError, match="'median'; expected one of average, best"):
        tracker(estimate="median")


def test_years_between_scans_end_the_tracks_and_nothing_else():
    target = tracker()
    scans = [scan(float(time), [(10.0 * time, 0.0)], report=[time]) for time in range(6)]
    later = 3.0e8
    scans += [
        scan(later + time, [(10.0 * time, 0.0)], report=[10 + int(time)]) for time in range(6)
    ]
    hypotheses = run(target, scans)
    assignment = assert_sound(target, scans, hypotheses)
    assert assignment[15] != assignment[5]
    assert hypotheses[-1].tracks.hits.tolist() == [6]


def test_the_same_report_twice_gives_a_track_and_a_false_alarm():
    target = tracker()
    scans = [
        scan(float(time), [(10.0 * time, 0.0)] * 2, report=[2 * time, 2 * time + 1])
        for time in range(8)
    ]
    hypotheses = run(target, scans)
    assert_sound(target, scans, hypotheses)
    assert len(hypotheses[-1].tracks) in (1, 2)


def test_coordinates_of_a_hundred_million_metres_are_no_trouble():
    scans = [scan(float(time), [(1e8 + 10.0 * time, -1e8)]) for time in range(8)]
    tracks = run(tracker(), scans)[-1].tracks
    np.testing.assert_allclose(tracks.mean, [[1e8 + 70.0, -1e8, 10.0, 0.0]], atol=3.0)


@pytest.mark.slow
def test_memory_stays_flat_over_a_long_run():
    target = tracker(sensor(detection_probability=0.8), search=Greedy())
    scans = scene(3, clutter=3, detection=0.8, times=range(330))
    for each in scans[:30]:
        run(target, [each])
    tracemalloc.start()
    try:
        held = []
        for place, each in enumerate(scans[30:]):
            run(target, [each])
            if place % 30 == 29:
                held.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    assert max(held[5:]) < 1.3 * max(held[:5]) + 50_000
    assert len(target._manager._records) < 40
    assert target._report_index.end - target._report_index.origin < 600


def test_no_assignment_is_more_probable_than_certain():
    place, n = np.random.default_rng(0).uniform(0.0, 20_000.0, (12, 2)), 12
    priors = TrackTable(
        time=np.zeros(n),
        track=np.arange(n),
        status=np.full(n, CONFIRMED),
        mean=np.hstack([place, np.zeros((n, 2))]),
        covariance=np.stack([np.diag([25.0, 25.0, 1.0, 1.0])] * n),
        score=np.zeros(n),
        hits=np.full(n, 5),
        last_update=np.zeros(n),
    )
    sure = sensor(clutter_density=1e-12, detection_probability=0.99)
    target, rng = tracker(sure, search=Greedy(), priors=priors), np.random.default_rng(0)
    for time in range(1, 9):
        run(target, [scan(time, place + rng.normal(size=place.shape) * 5.0)])
        probability = target.pending().probability
        assert probability.max() > 0.999
        assert np.all((probability >= 0.0) & (probability <= 1.0))


def test_the_cheapest_hypotheses_give_their_probabilities_to_the_assignments():
    scans = scene(5, objects=4, clutter=3, area=150.0)
    weights = {}
    for name, search in {"believed": Dual(), "ranked": MBest()}.items():
        target = tracker(search=search)
        final = [hypothesis.final for hypothesis in run(target, scans)]
        weights[name] = np.concatenate([each.probability for each in [*final, target.pending()]])
    given = {name: np.isfinite(each) for name, each in weights.items()}
    assert (given["believed"] == given["ranked"]).all()
    ranked, believed = (weights[name][given[name]] for name in ("ranked", "believed"))
    assert ((ranked >= 0.0) & (ranked <= 1.0)).all()
    # Where nothing competes both are sure; where objects are near, beliefs are approximate.
    assert np.median(np.abs(ranked - believed)) < 0.1
    assert np.abs(ranked - believed).max() > 1e-6


@pytest.mark.parametrize("seed", range(6))
def test_a_track_outlives_its_misses_beside_a_neighbour_that_is_seen(seed):
    """Two objects 110 m apart, each in the other's gate, are seen less often than is told."""
    rng = np.random.default_rng(seed)
    scans, owner = [], []
    for index in range(100):
        seen = np.flatnonzero((rng.random(2) < 0.8) | (index < 5))
        places = np.array([[0.0, 0.0], [110.0, 0.0]])[seen]
        number = len(owner) + np.arange(len(seen))
        owner += seen.tolist()
        places += 6.0 * rng.normal(size=places.shape)
        scans.append(scan(4.0 * index, places, report=number))
    target = tracker(
        sensor(sigma=6.0, detection_probability=0.95, clutter_density=1e-9, scan_period=4.0),
        motion=ConstantVelocity(process_noise=20.0, max_speed=350.0),
        window=5,
        lifecycle=Lifecycle(new_target_density=1e-12, delete_after_misses=12),
    )
    given = all_assignments(target, run(target, scans))
    track = np.array([given[number] for number in range(len(owner))])
    names, count = np.unique(track[track >= 0], return_counts=True)
    # Where both are missed for long names may be swapped, but neither track ends.
    assert names.shape[0] == 2
    assert count.sum() >= 0.98 * len(owner)
