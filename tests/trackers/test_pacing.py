"""Deadlines: what a step takes is learned, and the tree kept as small as it must be."""

import numpy as np
import pytest

from oracles.scenes import all_assignments, run, scan, scene, sensor, tracker
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.problem import Answer, Certificate, Status
from trackweave.domain.tracks import TrackTable
from trackweave.errors import InvalidInputError
from trackweave.solvers import Annealing, Auto
from trackweave.trackers import pacing
from trackweave.trackers.pacing import BASE, FEWEST, SEARCH, Pacer

USUAL = GrowthLimits()


class Clock:
    """A clock that others set."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


class Tree:
    """As much of a tree as a pace asks for."""

    def __init__(self, n_nodes=1_000, n_families=10):
        self.n_nodes, self.n_families, self.n_given_way = n_nodes, n_families, 7
        self.limits, self.most = USUAL, None

    def limit(self, most):
        self.most = most


@pytest.fixture
def clock(monkeypatch):
    fake = Clock()
    monkeypatch.setattr(pacing, "perf_counter", fake)
    return fake


def taught(clock, seconds=(0.010, 0.008, 0.004), n=9_000, steps=15):
    """Return a pacer of steps whose parts took so long for so many sequences."""
    pacer = Pacer()
    for _ in range(steps):
        pace = pacer.start(None, None)
        tree = Tree(n)
        with pace.growth(tree, 0):
            clock.now += seconds[0]
        clock.now += seconds[1]
        pace.searched(n)
        clock.now += seconds[2]
        pace.done(n)
    return pacer


def cap(pacer, deadline, n_nodes=1_000, n_reports=10):
    tree = Tree(n_nodes)
    with pacer.start(deadline, None).growth(tree, n_reports):
        pass
    return tree.most


def answered(reason, cost=-10.0, bound=-12.0):
    certificate = Certificate(cost, bound, Status.FEASIBLE)
    return Answer(np.empty(0, dtype=np.int64), certificate, 1, reason, np.empty(0))


def test_without_a_deadline_nothing_is_bounded(clock):
    pacer, tree = taught(clock), Tree()
    pace = pacer.start(None, None)
    with pace.growth(tree, 10):
        clock.now += 50.0
    assert tree.most == USUAL.max_nodes
    assert pace.alarm(10) is None
    assert pace.gap_of(answered("stopped")) is None


def test_a_tree_is_as_large_as_its_steps_fit_the_deadline(clock):
    pacer = taught(clock)
    fits = cap(pacer, 0.1, n_nodes=10_000)
    after = (SEARCH * 0.008 + 0.004) / 10_000
    took = 0.010 / 19_000 * (10_000 + fits + 2 * BASE) + after * (fits + BASE)
    assert 0.08 < took < 0.1
    assert cap(pacer, 0.05) < fits < cap(pacer, 0.2) < USUAL.max_nodes
    assert cap(pacer, 1e3) == cap(pacer, 1e308) == USUAL.max_nodes


def test_some_sequences_stay_for_each_beginning_however_short_the_deadline(clock):
    assert cap(taught(clock), 1e-9, n_reports=20) == FEWEST * 30


def test_a_single_slow_step_teaches_little(clock):
    pacer = taught(clock)
    before = cap(pacer, 0.05)
    with pacer.start(None, None).growth(Tree(9_000), 0):
        clock.now += 60.0
    assert cap(pacer, 0.05) == pytest.approx(before, rel=0.01)


def test_the_search_is_told_to_stop_early_enough_for_what_follows(clock):
    pace = taught(clock).start(0.1, None)
    alarm = pace.alarm(9_000)
    begin = clock.now
    while not alarm():
        clock.now += 1e-4
    assert 0.05 < clock.now - begin <= 0.1 - 0.004


def test_a_stop_ends_the_search_with_a_deadline_and_without(clock):
    pacer, asked = taught(clock), []

    def stop():
        asked.append(clock.now)
        return len(asked) > 1

    for deadline in (None, 10.0):
        asked.clear()
        alarm = pacer.start(deadline, stop).alarm(9_000)
        assert [alarm(), alarm()] == [False, True]


def test_a_late_stop_makes_the_next_one_earlier(clock):
    pacer = taught(clock)

    def stopped_after(pacer):
        pace = pacer.start(0.1, None)
        alarm, begin = pace.alarm(9_000), clock.now
        while not alarm():
            clock.now += 1e-4
        waited = clock.now - begin
        clock.now += 0.02
        pace.searched(9_000)
        return waited

    first = stopped_after(pacer)
    stopped_after(pacer)
    assert stopped_after(pacer) < first - 0.01


def test_a_stop_long_before_the_deadline_says_nothing_of_late_stops(clock):
    pacer, before = taught(clock), cap(taught(clock), 0.05)
    for _ in range(20):
        pace = pacer.start(5.0, lambda: True)
        assert pace.alarm(9_000)()
        clock.now += 1e-5
        pace.searched(9_000)
    assert 0.0 <= pacer.overrun.usual < 1e-4
    assert cap(pacer, 0.05) == pytest.approx(before, rel=0.2)


def test_a_gap_counts_as_the_deadlines_only_where_the_search_was_stopped(clock):
    pace = Pacer().start(1.0, None)
    assert pace.gap_of(answered("stopped")) == pytest.approx(0.2)
    assert pace.gap_of(answered("budget spent")) == 0.0


def dense(n_scans=8):
    return scene(3, objects=12, clutter=12, area=250.0, times=range(n_scans))


@pytest.mark.slow
def test_a_long_deadline_changes_nothing():
    scans = dense()
    free, timed = (
        run(tracker(search=Auto()), scans),
        run(tracker(search=Auto()), scans, deadline=1e4),
    )
    for one, other in zip(free, timed, strict=True):
        for name in TrackTable.__dataclass_fields__:
            np.testing.assert_array_equal(getattr(one.tracks, name), getattr(other.tracks, name))
        assert one.certificate == other.certificate
        assert one.n_pruned == other.n_pruned
        assert (one.deadline_gap, other.deadline_gap) == (None, 0.0)


def test_the_shortest_deadline_keeps_the_tree_small_and_every_report_once():
    scans = dense()
    target, free = tracker(search=Auto()), run(tracker(search=Auto()), scans)
    short = run(target, scans, deadline=1e-9)
    assignment = all_assignments(target, short)
    assert sorted(assignment) == sorted(n for each in scans for n in each.report.tolist())
    assert sum(each.n_pruned_by_deadline for each in short) > 0
    assert sum(each.n_sequences for each in short) < sum(each.n_sequences for each in free)
    assert all(each.deadline_gap >= 0.0 for each in short)
    for each in short:
        assert np.all(np.isfinite(each.tracks.mean))
        assert each.n_pruned_by_deadline <= each.n_pruned


def test_the_shortest_deadline_loses_no_tracks_and_is_no_crowd():
    # Reports are so dense, and speeds so little known, that gates hold dozens of them.
    scans = scene(5, objects=40, clutter=40, area=350.0, times=range(12))
    short = run(tracker(search=Auto()), scans, deadline=1e-9)
    assert min(len(each.tracks) for each in short[1:]) >= 40
    assert not any(each.is_crowded for each in short)
    assert all(each.n_pruned_by_deadline > 0 for each in short[2:])


def test_a_deadline_once_leaves_the_next_scan_its_usual_tree():
    scans = dense()
    target, rng = tracker(search=Auto()), np.random.default_rng(1)
    cut = [target.step(each, rng=rng, deadline=1e-9) for each in scans[:4]]
    after = target.step(scans[4], rng=rng)
    assert after.n_pruned_by_deadline == 0
    assert after.n_sequences > cut[-1].n_sequences


def test_the_next_scans_arrival_ends_the_search():
    target, rng = (
        tracker(search=Annealing(evaluations=10**9, seeded=False)),
        np.random.default_rng(1),
    )
    asked = []

    def arrived():
        asked.append(True)
        return len(asked) % 5 == 0

    for each in dense(4):
        hypothesis = target.step(each, rng=rng, stop=arrived)
    assert hypothesis.stop_reason == "stopped"
    assert hypothesis.deadline_gap is None


def test_refuses_a_stop_that_cannot_be_asked():
    target = tracker(sensor())
    with pytest.raises(InvalidInputError, match="stop: 1; expected a function"):
        target.step(scan(0.0, [(0, 0)]), rng=np.random.default_rng(1), stop=1)
