"""Scans that come late, in parts, or too late."""

from dataclasses import replace

import numpy as np
import pytest

from oracles.scenes import (
    LIFECYCLE,
    WIDE,
    all_assignments,
    groups,
    run,
    scan,
    scene,
    sensor,
    tracker,
)
from trackweave.domain.scans import Scan
from trackweave.models.coverage import FieldOfView
from trackweave.trackers.window import Window


def late_and_in_time(scans, moved, by, sensors, window):
    """Return both trackers and their hypotheses when one scan comes late."""
    delayed = scans.copy()
    delayed.insert(moved + by, delayed.pop(moved))
    options = {"window": window, "limits": WIDE}
    one, other = tracker(*sensors, **options), tracker(*sensors, **options)
    first, second = run(one, scans), run(other, delayed)
    assert not any(hypothesis.late for hypothesis in second)
    return one, first, other, second


def assert_same_end(one, first, other, second):
    """Check that two runs end with the same hypothesis, whatever the tracks are called."""
    assert second[-1].certificate.cost == pytest.approx(first[-1].certificate.cost, abs=1e-6)
    assert groups(all_assignments(one, first)) == groups(all_assignments(other, second))
    mine, theirs = (
        each[-1].tracks.mean[np.lexsort(each[-1].tracks.mean.T)] for each in (first, second)
    )
    np.testing.assert_allclose(mine, theirs, atol=0.5)


PAIR = (sensor("a", detection_probability=0.8), sensor("b", detection_probability=0.6))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("moved", [0, 1, 4])
def test_a_late_scan_gives_what_it_would_have_given_in_time(seed, moved):
    scans = scene(
        seed, objects=2, clutter=1, detection=0.8, area=400.0, names=("a", "b"), times=range(4)
    )
    assert_same_end(*late_and_in_time(scans, moved, 3, PAIR, 30))


@pytest.mark.parametrize("seed", [0, 2, 3, 4, 5])
@pytest.mark.parametrize("moved", [9, 13, 17])
def test_a_late_scan_after_many_slides_gives_what_it_would_have_given_in_time(seed, moved):
    """Far objects and seeds for which what was fixed meanwhile is the same."""
    scans = scene(seed, objects=3, clutter=1, detection=0.6, area=4000.0, names=("a", "b"))
    scans = scans[: moved + 3]
    assert_same_end(*late_and_in_time(scans, moved, 2, PAIR, 5))


def test_the_first_scan_may_come_late():
    scans = scene(3, objects=2, clutter=1)[:4]
    one, other = tracker(limits=WIDE), tracker(limits=WIDE)
    first, second = run(one, scans), run(other, [scans[1], scans[2], scans[3], scans[0]])
    assert second[-1].certificate.cost == pytest.approx(first[-1].certificate.cost, abs=1e-6)


def test_a_scan_in_two_parts_is_one_scan():
    scans = scene(3, objects=3, clutter=2)[:4]
    parts = []
    for each in scans:
        half = len(each) // 2
        for rows in (slice(None, half), slice(half, None)):
            parts.append(
                Scan(each.time, each.sensor, each.measurement[rows], report=each.report[rows])
            )
    one, other = tracker(limits=WIDE), tracker(limits=WIDE)
    first, second = run(one, scans), run(other, parts)
    assert second[-1].certificate.cost == pytest.approx(first[-1].certificate.cost, abs=1e-6)
    assert groups(all_assignments(one, first)) == groups(all_assignments(other, second))


def test_a_scan_too_late_is_counted_and_changes_nothing():
    scans = scene(3)
    one, other = tracker(), tracker()
    first, second = run(one, scans[:9]), run(other, scans[:9])
    (late,) = run(other, [scan(1.0, [(1.0, 1.0), (2.0, 2.0)], report=[900, 901])])
    assert late.late == (900, 901)
    assert late.amendments == ()
    assert len(late.final) == 0
    np.testing.assert_array_equal(late.tracks.mean, second[-1].tracks.mean)
    assert late.certificate == second[-1].certificate
    first += run(one, scans[9:])
    second += run(other, scans[9:])
    assert all_assignments(one, first) == all_assignments(other, second)
    assert 900 not in all_assignments(other, second)


def test_late_scans_forget_no_misses_however_long_ago():
    """A track that its only sensor missed thrice, which then falls silent."""
    views = [FieldOfView((east, 0.0), max_range=1_000.0) for east in (0.0, 50_000.0)]
    pair = [sensor(name, field_of_view=view) for name, view in zip("ab", views, strict=True)]
    lasting = replace(LIFECYCLE, survival=0.999999, hidden_share=1e-3)
    target = tracker(*pair, window=Window(2, 6), lifecycle=lasting)
    rng = np.random.default_rng(0)
    for second in range(26):
        if second < 8:
            seen = [(100.0 + second, 200.0)] if second < 5 else []
            target.step(scan(float(second), seen, "a"), rng=rng)
        before = target.step(scan(second + 0.25, [], "b"), rng=rng)
    assert before.tracks.track.shape == (1,)
    for time in (25.1, 25.2, 25.15):
        after = target.step(scan(time, [], "b"), rng=rng)
        assert not after.late
        assert after.tracks.score == pytest.approx(before.tracks.score, abs=1e-2)
        assert after.certificate.cost == pytest.approx(before.certificate.cost, abs=1e-2)
