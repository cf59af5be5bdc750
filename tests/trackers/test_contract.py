"""What holds of every tracker, so that one can be put in the other's place."""

import numpy as np
import pytest

from oracles.scenes import MOTION, all_assignments, run, scan, scene, sensor
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import CONFIRMED, TENTATIVE, TrackTable
from trackweave.errors import InvalidInputError
from trackweave.models.motion import (
    ConstantAcceleration,
    ConstantVelocity,
    CoordinatedTurn,
    Imm,
)
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker

TRACKERS = {
    "multi-hypothesis": lambda **given: MultiHypothesisTracker(**given),
    "one-to-one": lambda **given: NearestNeighbourTracker(**given),
    "nearest": lambda **given: NearestNeighbourTracker(**given, pairing="nearest"),
}


@pytest.fixture(params=TRACKERS)
def make(request):
    """Return what makes a tracker of ordinary sensors."""

    def made(*sensors, **changed):
        options = {"motion": MOTION, "sensors": sensors or (sensor(),)}
        return TRACKERS[request.param](**(options | changed))

    return made


def known(names=(7,), time=0.0, dim=2):
    count, size = len(names), 2 * dim
    return TrackTable(
        np.full(count, time), np.array(names), np.full(count, CONFIRMED),
        np.zeros((count, size)), np.tile(np.eye(size) * 100.0, (count, 1, 1)),
        np.zeros(count), np.ones(count, dtype=np.int64), np.full(count, time),
    )  # fmt: skip


@pytest.mark.parametrize("names", [("a",), ("a", "b")])
@pytest.mark.parametrize("seed", [1, 2])
def test_every_report_is_accounted_for_once_and_rows_are_sound(make, names, seed):
    scans = scene(seed, names=names)
    target = make(*(sensor(name) for name in names))
    hypotheses = run(target, scans)
    assignment = all_assignments(target, hypotheses)
    assert sorted(assignment) == sorted(n for each in scans for n in each.report.tolist())
    for each in scans:
        own = [assignment[n] for n in each.report.tolist() if assignment[n] >= 0]
        assert len(set(own)) == len(own)
    for each, hypothesis in zip(scans, hypotheses, strict=True):
        tracks = hypothesis.tracks
        assert hypothesis.time == each.time
        assert tracks.track.tolist() == sorted(set(tracks.track.tolist()))
        assert np.all(np.isfinite(tracks.mean))
        assert np.all(np.linalg.eigvalsh(tracks.covariance) > 0.0)
        assert hypothesis.certificate.lower_bound <= hypothesis.certificate.cost + 1e-6
    assert np.count_nonzero(hypotheses[-1].tracks.status != TENTATIVE) >= 3


def test_leaves_out_tracks_where_they_are_not_asked_for(make):
    given = scene(5)
    shown, silent = make(), make()
    assert len(silent.tracks()) == 0
    for each in given:
        (mine,), (other,) = run(shown, [each]), run(silent, [each], tracks=False)
        assert len(other.tracks) == 0
        assert other.n_tracks == len(mine.tracks) == len(silent.tracks())
        for name in ("track", "mean", "status", "time"):
            np.testing.assert_array_equal(
                getattr(silent.tracks(), name), getattr(mine.tracks, name)
            )
    assert other.n_tracks >= 3


def test_the_same_seed_gives_the_same_hypotheses(make):
    scans = scene(3)
    first, second = (run(make(), scans) for _ in range(2))
    for one, other in zip(first, second, strict=True):
        for name in TrackTable.__dataclass_fields__:
            np.testing.assert_array_equal(getattr(one.tracks, name), getattr(other.tracks, name))
        np.testing.assert_array_equal(one.final.track, other.final.track)
        assert one.certificate == other.certificate


def test_what_comes_in_is_left_as_it_is(make):
    priors, scans = known(), scene(1)
    before = [array.copy() for each in scans for array in (each.measurement, each.report)]
    states = [priors.mean.copy(), priors.covariance.copy(), priors.track.copy()]
    run(make(priors=priors), scans)
    after = [array for each in scans for array in (each.measurement, each.report)]
    for one, other in zip(
        [*before, *states], [*after, priors.mean, priors.covariance, priors.track], strict=True
    ):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    "wrong",
    [
        {"motion": None}, {"sensors": sensor()}, {"sensors": ["radar"]}, {"sensors": []},
        {"sensors": [sensor(), sensor()]}, {"lifecycle": Lifecycle}, {"priors": [1]},
        {"priors": known((7, 7))}, {"priors": known((-1,))}, {"dim": 4}, {"dim": 3.5},
        {"dim": 3, "priors": known()},
    ],
    ids=lambda wrong: "-".join(f"{key}" for key in wrong),
)  # fmt: skip
def test_refuses_a_part_of_another_kind(make, wrong):
    options = {"motion": MOTION, "sensors": [sensor()]} | wrong
    with pytest.raises(InvalidInputError, match="expected"):
        make(*[], **options)


@pytest.mark.parametrize(
    "wrong",
    [
        {"rng": None},
        {"rng": True},
        {"rng": -1},
        {"rng": np.random.RandomState(1)},
        {"scan": [[1.0, 2.0]]},
        {"scan": scan(6.0, [(0, 0)], "sonar")},
        {"scan": Scan(6.0, "radar", np.zeros((1, 3)))},
        {"scan": scan(6.0, [(0, 0), (1, 1)], report=[900, 900])},
        {"scan": scan(6.0, [(0, 0)], report=[0])},
        {"deadline": 0},
        {"deadline": "soon"},
    ],
    ids=lambda wrong: next(iter(wrong)),
)
def test_a_refused_step_changes_nothing(make, wrong):
    scans = scene(1, times=range(9))
    target, rng = make(), np.random.default_rng(1)
    for each in scans[:4]:
        target.step(each, rng=rng)
    given = {"scan": scans[4], "rng": rng} | wrong
    with pytest.raises(InvalidInputError, match="expected"):
        target.step(given.pop("scan"), **given)
    after = [target.step(each, rng=rng) for each in scans[4:]]
    for mine, theirs in zip(after, run(make(), scans)[4:], strict=True):
        np.testing.assert_array_equal(mine.tracks.mean, theirs.tracks.mean)
        np.testing.assert_array_equal(mine.final.report, theirs.final.report)
        assert mine.certificate == theirs.certificate


def test_steps_without_a_generator_are_steps_with_the_same_seed(make):
    scans, bare, seeded = scene(1, times=range(9)), make(), make()
    for each in scans:
        mine, theirs = bare.step(each), seeded.step(each, rng=np.random.default_rng(0))
        np.testing.assert_array_equal(mine.tracks.mean, theirs.tracks.mean)
        assert (mine.certificate, mine.evaluations) == (theirs.certificate, theirs.evaluations)


def test_a_scan_far_too_late_is_counted_and_changes_nothing(make):
    target, rng = make(), np.random.default_rng(1)
    last = run(target, scene(1, times=range(20)))[-1]
    late = target.step(scan(-50.0, [(0.0, 0.0)], report=[5000]), rng=rng)
    assert late.late == (5000,)
    assert late.stop_reason == "late scan"
    assert len(late.final) == len(late.amendments) == 0
    np.testing.assert_array_equal(late.tracks.mean, last.tracks.mean)
    before = make(priors=known(time=10.0)).step(scan(9.0, [(0.0, 0.0)]), rng=rng)
    assert (before.late, len(before.tracks)) == ((0,), 0)


def test_reports_without_numbers_are_counted_from_zero(make):
    target = make()
    hypotheses = run(target, [scan(0.0, [(0, 0), (9, 9)]), scan(1.0, [(0, 0)])])
    assert sorted(all_assignments(target, hypotheses)) == [0, 1, 2]


@pytest.mark.parametrize("dim", [2, 3])
def test_empty_lists_fit_whatever_comes_after(make, dim):
    target, rng = make(), np.random.default_rng(1)
    for time in range(3):
        assert len(target.step(Scan(float(time), "radar", []), rng=rng).tracks) == 0
    place = np.full(dim, 50.0)
    for time in range(3, 8):
        hypothesis = target.step(Scan(float(time), "radar", [place + 2.0 * time]), rng=rng)
    assert hypothesis.tracks.dim == dim
    assert hypothesis.tracks.hits.tolist() == [5]


def test_known_tracks_are_there_from_the_first_scan_and_new_names_go_on_behind(make):
    target = make(priors=known((7, 3)), lifecycle=Lifecycle(hidden_share=0.0, survival=0.999999))
    target.step(scan(0.5, []), rng=np.random.default_rng(1))
    hypothesis = run(target, [scan(time, [(900.0, 900.0)]) for time in (1.0, 2.0, 3.0)])[-1]
    assert {3, 7} <= set(hypothesis.tracks.track.tolist())
    assert hypothesis.tracks.track.max() == 8


@pytest.mark.parametrize("misses", [2, 4])
def test_a_confirmed_track_coasts_and_ends_after_so_many_misses(make, misses):
    lasting = Lifecycle(delete_after_misses=misses, hidden_share=0.0, survival=0.999999)
    target = make(lifecycle=lasting)
    seen = [scan(time, [(5.0 * time, 0.0)]) for time in range(6)]
    hypotheses = run(target, seen + [scan(6 + time, []) for time in range(misses)])
    assert hypotheses[5].tracks.status.tolist() == [CONFIRMED]
    assert [len(each.tracks) for each in hypotheses[6:]] == [1] * (misses - 1) + [0]


def test_nobody_is_given_up_while_no_sensor_looks(make):
    # Bursts of ten looks, and pauses longer than objects are followed that nobody looks at; the
    # first look after each misses.
    target = make(motion=ConstantVelocity(1e-6, 30.0), lifecycle=Lifecycle(survival=0.999999))
    times = [600.0 * burst + look for burst in range(4) for look in range(10)]
    seen = [scan(time, [] if time % 600 == 0 and time else [(0.1 * time, 0.0)]) for time in times]
    hypotheses = run(target, seen)[5:]
    assert [len(each.tracks) for each in hypotheses] == [1] * 35
    assert len({int(each.tracks.track[0]) for each in hypotheses}) == 1
    # What is missed look by look ends as ever.
    gone = run(target, [scan(times[-1] + 1.0 + late, []) for late in range(30)])
    assert len(gone[-1].tracks) == 0


def test_several_sensors_at_one_instant_are_one_chance(make):
    lifecycle = Lifecycle(certain_probability=1.0)
    target = make(sensor("a"), sensor("b"), sensor("c"), lifecycle=lifecycle)
    hypotheses = run(
        target, [scan(time, [(time, 0.0)], name) for time in range(3) for name in "abc"]
    )
    status = [each.tracks.status.tolist() for each in hypotheses if len(each.tracks)]
    assert all(TENTATIVE in each for each in status[:-3])
    assert status[-1] == [CONFIRMED]
    assert hypotheses[-1].tracks.hits.tolist() == [9]


@pytest.mark.slow
@pytest.mark.parametrize(
    "motion",
    [
        Imm((MOTION, ConstantAcceleration(0.5, 30.0, 5.0)), (20.0, 10.0)),
        Imm((MOTION, CoordinatedTurn(0.1, 1e-3, 30.0, 0.5)), (20.0, 10.0)),
    ],
    ids=["acceleration", "turn"],
)
def test_objects_that_change_how_they_move_keep_their_tracks(make, motion):
    angle = np.concatenate([np.zeros(8), np.cumsum(np.full(10, 0.25))])
    path = np.cumsum(20.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1), axis=0)
    noise = np.random.default_rng(4).normal(size=path.shape) * 3.0
    target = make(sensor(sigma=3.0), motion=motion)
    hypothesis = run(target, [scan(time, [at]) for time, at in enumerate(path + noise)])[-1]
    assert hypothesis.tracks.hits.tolist() == [18]
    assert np.linalg.norm(hypothesis.tracks.mean[0, :2] - path[-1]) < 8.0
