"""Plots of an instant to fused reports to tracks, told of the plots."""

import numpy as np
import pytest

from oracles.scenes import MOTION, all_assignments, scan, scene, sensor
from trackweave.association.plots_rule import PlotsRule
from trackweave.association.problem import Status
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import CONFIRMED, TENTATIVE
from trackweave.errors import InvalidInputError
from trackweave.solvers import Exact
from trackweave.trackers.fused_plots import FusedPlotsTracker
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker
from trackweave.trackers.plot_fusion import PlotFuser

NAMES = ("A", "B", "C")
INSIDE = {"multi-hypothesis": MultiHypothesisTracker, "nearest-neighbour": NearestNeighbourTracker}


@pytest.fixture(params=INSIDE)
def inside(request):
    return INSIDE[request.param]


def tracker(inside, names=NAMES, rule=None, **changed):
    rule = rule or PlotsRule(object_density=1e-6, negative_only=True, lone_plots=True)
    own = [sensor(name) for name in names]
    fuser = PlotFuser(own, rule, Exact(), motion=MOTION)
    return FusedPlotsTracker(
        fuser, inside(motion=MOTION, sensors=fuser.fused_sensors(1.0), **changed)
    )


def instants(seed=1, *, names=NAMES, **changed):
    scans = scene(seed, names=names, **changed)
    return [scans[k : k + len(names)] for k in range(0, len(scans), len(names))]


def run(target, steps, seed=1, **options):
    rng = np.random.default_rng(seed)
    return [target.step(each, rng=rng, **options) for each in steps]


def test_every_plot_has_one_word_said_of_it(inside):
    steps = instants()
    target = tracker(inside)
    assignment = all_assignments(target, run(target, steps))
    assert sorted(assignment) == sorted(int(n) for step in steps for s in step for n in s.report)


def test_an_object_has_the_plots_of_all_its_sensors(inside):
    steps = instants(2, clutter=1, times=range(10))
    target = tracker(inside)
    hypotheses = run(target, steps)
    assignment = all_assignments(target, hypotheses)
    tracks = hypotheses[-1].tracks
    assert np.count_nonzero(tracks.status != TENTATIVE) == 3
    for track, hits in zip(tracks.track.tolist(), tracks.hits.tolist(), strict=True):
        own = {number for number, name in assignment.items() if name == track}
        # 27 of 30 plots are there on average.
        assert len(own) >= 20
        assert hits == len(own)
        for step in steps:
            for each in step:
                assert len(own & set(each.report.tolist())) <= 1


def test_what_the_tracker_inside_says_is_said_of_each_plot():
    """The wrapper against the same steps taken by hand."""
    steps = instants(4, objects=4)
    target = tracker(MultiHypothesisTracker, window=3)
    fuser = PlotFuser(
        [sensor(name) for name in NAMES],
        PlotsRule(object_density=1e-6, negative_only=True, lone_plots=True),
        Exact(),
        motion=MOTION,
    )
    plain = MultiHypothesisTracker(motion=MOTION, sensors=fuser.fused_sensors(1.0), window=3)
    rng, other, first, members = np.random.default_rng(1), np.random.default_rng(1), 0, {}
    said, tracks = {}, None
    for step in steps:
        found = target.step(step, rng=rng)
        fused = fuser(step, rng=other, tracks=tracks, first_report=first)
        first += len(fused)
        members |= dict(zip(fused.scan.report.tolist(), fused.members, strict=True))
        expected = plain.step(fused.scan, rng=other)
        tracks = expected.tracks
        assert found.tracks.mean.tobytes() == tracks.mean.tobytes()
        both = fused.certificate.cost + expected.certificate.cost
        assert found.certificate.cost == pytest.approx(both)
        assert found.certificate.lower_bound <= found.certificate.cost + 1e-9
        told = [(a.report, a.before, a.after) for a in found.amendments]
        assert told == [
            (n, a.before, a.after) for a in expected.amendments for n in members[a.report].tolist()
        ]
        said |= dict(zip(found.final.report.tolist(), found.final.track.tolist(), strict=True))
        for number in fused.alone.tolist():
            assert said[number] == -1
    pending = target.pending()
    for number, track in zip(plain.pending().report, plain.pending().track, strict=True):
        assert np.all(pending.track[np.isin(pending.report, members[number])] == track)


def test_the_certificate_is_that_of_the_plots_where_no_window_is_chosen():
    steps = instants(3)
    target = tracker(NearestNeighbourTracker)
    fuser = target._fuser
    for step, found in zip(steps, run(target, steps), strict=True):
        alone = fuser(step, rng=np.random.default_rng(1))
        assert found.certificate == alone.certificate
        assert found.certificate.status is Status.OPTIMAL


def test_a_sensor_that_saw_nothing_missed(inside):
    steps = instants(5, objects=1, clutter=0, detection=1.0, times=range(6))
    steps += [[scan(6.0, [], name) for name in NAMES]]
    hypotheses = run(tracker(inside), steps)
    assert hypotheses[-1].tracks.hits.tolist() == [18]
    last = [steps[5][0], scan(5.0, [], "B"), steps[5][2]]
    assert run(tracker(inside), [*steps[:5], last])[-1].tracks.hits.tolist() == [17]


def test_instants_of_one_sensor_make_no_track_miss_its_chance(inside):
    steps = instants(5, objects=1, clutter=0, detection=1.0, times=range(6))
    alone = [[scan(6.0 + k, [], "A")] for k in range(8)]
    tracks = run(tracker(inside), steps + alone)[-1].tracks
    assert tracks.status.tolist() == [CONFIRMED]


def test_a_clock_that_is_late_moves_its_plots_along_the_tracks(inside):
    """Sensor B scans 0.4 s later: known speeds make its plots as good as simultaneous ones."""
    speed, rng, steps = np.array([25.0, 0.0]), np.random.default_rng(8), []
    for time in range(12):
        own = []
        for name, lag in (("A", 0.0), ("B", 0.4)):
            place = speed * (time + lag) + rng.normal(0, 3.0, 2)
            own.append(scan(time + lag, [place], name))
        steps.append(own)
    rule = PlotsRule(object_density=1e-6, negative_only=True, lone_plots=True)
    sensors = [sensor(name, sigma=3.0) for name in "AB"]
    spreads = []
    for motion in (MOTION, None):
        fuser = PlotFuser(sensors, rule, Exact(), motion=motion)
        inner = inside(motion=MOTION, sensors=fuser.fused_sensors(1.0))
        hypotheses = run(FusedPlotsTracker(fuser, inner), steps)
        off = [h.tracks.mean[0, 0] - 25.0 * h.time for h in hypotheses[4:]]
        spreads.append(abs(np.mean(off)))
    # Taken as if simultaneous, the average lags by half of the ten metres between the two scans.
    assert spreads[0] < 1.5
    assert spreads[1] > 3.0


def test_unnumbered_plots_are_counted_in_the_order_of_the_sensors(inside):
    steps = [
        [scan(float(time), [[10.0 * time, 0.0]], name) for name in "CAB"] for time in range(4)
    ]
    target = tracker(inside)
    hypotheses = run(target, steps)
    assert sorted(all_assignments(target, hypotheses)) == list(range(12))


def test_late_instants_change_nothing(inside):
    steps = instants(6, times=range(8))
    target = tracker(inside)
    before = run(target, steps)[-1]
    late = [scan(-50.0, [[0.0, 0.0]], name, report=[900 + k]) for k, name in enumerate(NAMES)]
    after = run(target, [late])[-1]
    assert sorted(after.late) == [900, 901, 902]
    assert after.tracks.mean.tobytes() == before.tracks.mean.tobytes()
    assert after.tracks.hits.tolist() == before.tracks.hits.tolist()
    assert not set(after.late) & set(target.pending().report.tolist())


def test_a_refused_instant_leaves_the_tracker_as_it_was(inside):
    steps = instants(7)
    one, other = tracker(inside), tracker(inside)
    rng, same = np.random.default_rng(1), np.random.default_rng(1)
    one.step(steps[0], rng=rng)
    other.step(steps[0], rng=same)
    for step in steps[1:]:
        for wrong in (
            [scan(0.0, [], "Z")],
            [Scan(step[0].time, name, np.zeros((1, 3))) for name in "AB"],
            [scan(step[0].time, [[0.0, 0.0]] * 2, "A", report=[7777, 7777])],
            [],
        ):
            with pytest.raises(InvalidInputError):
                one.step(wrong, rng=np.random.default_rng(1))
        left, right = one.step(step, rng=rng), other.step(step, rng=same)
        assert left.tracks.mean.tobytes() == right.tracks.mean.tobytes()


@pytest.mark.parametrize(
    ("options", "message"),
    [({"rng": 1.5}, "rng"), ({"deadline": 0.0}, "deadline"), ({"deadline": "soon"}, "deadline")],
)
def test_refuses_arguments_of_another_kind(options, message):
    target = tracker(NearestNeighbourTracker)
    with pytest.raises(InvalidInputError, match=message):
        target.step(instants()[0], **({"rng": np.random.default_rng(1)} | options))
    with pytest.raises(InvalidInputError, match="tracker"):
        FusedPlotsTracker(target._fuser, NearestNeighbourTracker)
    with pytest.raises(InvalidInputError, match="fuser"):
        FusedPlotsTracker(target, target._tracker)


def test_the_same_seed_gives_the_same_bytes(inside):
    steps = instants(9)
    one, other = (run(tracker(inside), steps)[-1] for _ in range(2))
    assert one.tracks.mean.tobytes() == other.tracks.mean.tobytes()


def test_a_deadline_is_kept_and_any_answer_is_sound(inside):
    steps = instants(9, objects=6)
    target = tracker(inside)
    assignment = all_assignments(target, run(target, steps, deadline=1e-4))
    assert len(assignment) == sum(len(each) for step in steps for each in step)
