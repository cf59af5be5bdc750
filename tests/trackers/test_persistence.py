"""False alarms that come again at their place, and tracks that are proven against them."""

from dataclasses import replace

import numpy as np
import pytest

import trackweave as tw
from trackweave.association.window_rule import Context, scan_input
from trackweave.trackers.persistence import last_scans, repeats

MOTION = tw.ConstantVelocity(process_noise=0.01, max_speed=20.0)
RADAR = tw.Sensor(
    "radar", sigma=5.0, detection_probability=0.9, clutter_density=1e-6, scan_period=2.0,
    clutter_persistence=0.5,
)  # fmt: skip
LIFECYCLE = tw.Lifecycle(new_target_density=1e-10, initial_target_density=1e-10)


def data(sensor, time, places):
    scan = tw.Scan(time, sensor.name, places)
    context = Context(MOTION, 2, 0, -1, 1, None, 2.0)
    return scan_input(scan, sensor, 0.0, context)[0]


def test_repeats_are_what_the_scan_before_adds_to_the_density():
    before = data(RADAR, 0.0, [[0.0, 0.0], [7.0, 3.0], [900.0, 0.0]])
    now = data(RADAR, 2.0, [[2.0, 1.0], [400.0, 400.0], [903.0, -4.0]])
    told = repeats(now, [before], RADAR)
    for place, value in zip(now.position, told, strict=True):
        aside = np.sum((before.position - place) ** 2, axis=1)
        bells = np.exp(-aside / (4 * 5.0**2)) / (4 * np.pi * 5.0**2)
        assert value == pytest.approx(np.log1p(0.5 * bells.sum() / 1e-6), rel=1e-6, abs=1e-9)


def test_what_is_strong_again_proves_nothing_by_it():
    model = tw.StrengthModel(20.0, 3.0, 10.0, 3.0)
    loud = replace(RADAR, strength=model)

    def seen(time, strength):
        scan = tw.Scan(time, "radar", [[0.0, 0.0]], strength=[strength])
        return scan_input(scan, loud, 0.0, Context(MOTION, 2, 0, -1, 1, None, 2.0))[0]

    weak, strong = (repeats(seen(2.0, each), [seen(0.0, each)], loud)[0] for each in (5.0, 20.0))
    evidence = float(model.evidence(np.array([20.0]))[0])
    assert weak == repeats(data(RADAR, 2.0, [[0.0, 0.0]]), [data(RADAR, 0.0, [[0.0, 0.0]])], RADAR)
    assert strong == pytest.approx(weak + evidence, rel=1e-3)


def test_only_the_scan_before_counts():
    places = [[0.0, 0.0]]
    now = data(RADAR, 2.0, places)
    for time in (-4.0, 1.9):
        assert repeats(now, last_scans(2.0, [data(RADAR, time, places)], 2.0), RADAR) == [0.0]
    free = replace(RADAR, scan_period=None)
    told = last_scans(2.0, [data(free, time, places) for time in (-9.0, -5.0)], None)
    assert [each.time for each in told] == [-5.0]
    assert repeats(now, told, free) > 5.0
    assert repeats(now, [], RADAR) == [0.0]
    assert repeats(data(RADAR, 2.0, np.empty((0, 2))), [data(RADAR, 0.0, places)], RADAR).size == 0


def followed(sensor, hits, place=lambda scan: (100.0, 50.0)):
    """Track one thing that is reported at some scans; return what is doubted, and all rows."""
    rng = np.random.default_rng(3)
    tracker = tw.MultiHypothesisTracker(motion=MOTION, sensors=[sensor], lifecycle=LIFECYCLE)
    shown, doubts = [], {}
    for scan, is_hit in enumerate(hits):
        at = np.array([place(scan)]) + rng.normal(0, 5.0, (1, 2))
        at = at if is_hit else np.empty((0, 2))
        shown.append(tracker.step(tw.Scan(2.0 * scan, "radar", at)).tracks)
        doubts |= tracker.doubts
    return doubts, shown


def ever_confirmed(shown):
    return any(np.any(rows.status >= 1) for rows in shown)


def test_a_false_alarm_that_comes_some_times_is_no_confirmed_track():
    burst = [True] * 5 + [False] * 5
    doubts, shown = followed(RADAR, burst)
    assert not ever_confirmed(shown)
    assert any(doubts.values())
    # Who counts each false alarm for itself takes the five for an object.
    doubts, shown = followed(replace(RADAR, clutter_persistence=0.0), burst)
    assert ever_confirmed(shown)
    assert not any(doubts.values())


def test_what_stands_for_long_is_proven_in_the_end():
    doubts, shown = followed(RADAR, [True] * 40)
    assert ever_confirmed(shown)
    assert not any(doubts.values())
    assert shown[-1].existence[-1] > 0.9


def test_what_moves_is_confirmed_as_soon_as_ever():
    def away(scan):
        return 36.0 * scan, 0.0

    _, shown = followed(RADAR, [True] * 6, away)
    _, other = followed(replace(RADAR, clutter_persistence=0.0), [True] * 6, away)
    first = [next(n for n, rows in enumerate(each) if np.any(rows.status >= 1))
             for each in (shown, other)]  # fmt: skip
    assert first[0] <= first[1] + 1


def test_a_late_scan_is_told_as_if_it_had_come_in_time():
    scans = [tw.Scan(2.0 * n, "radar", [[100.0 + n % 3, 50.0]]) for n in range(9)]
    late = [*scans[:4], scans[5], scans[4], *scans[6:]]
    told = []
    for order in (scans, late):
        tracker = tw.MultiHypothesisTracker(motion=MOTION, sensors=[RADAR], lifecycle=LIFECYCLE)
        for scan in order:
            rows = tracker.step(scan).tracks
        told.append((rows.existence, tracker.doubts))
    np.testing.assert_allclose(told[0][0], told[1][0], rtol=1e-9)
    assert told[0][1] == told[1][1]


@pytest.mark.slow
def test_what_is_over_is_not_remembered_for_ever():
    tracker = tw.MultiHypothesisTracker(motion=MOTION, sensors=[RADAR], lifecycle=LIFECYCLE)
    doubts, most = {}, 0
    for scan in range(1200):
        # Each ten scans another false alarm comes five times.
        at = [[1000.0 * (scan // 10), 0.0]] if scan % 10 < 5 else np.empty((0, 2))
        tracker.step(tw.Scan(2.0 * scan, "radar", at))
        doubts |= tracker.doubts
        most = max(most, len(tracker.doubts))
    assert sum(doubts.values()) >= 100
    assert most <= 60
