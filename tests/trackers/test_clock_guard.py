"""A stamp that cannot be right blinds nobody, and an outage of any length ends."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from oracles.scenes import MOTION, run, scan, scene, sensor
from trackweave.association.plots_rule import PlotsRule
from trackweave.errors import InvalidInputError
from trackweave.models.sensors import Sensor
from trackweave.solvers import Greedy
from trackweave.trackers import clock_guard
from trackweave.trackers.clock_guard import Arrival, ClockGuard
from trackweave.trackers.fused_plots import FusedPlotsTracker
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.live import HELD, LATE
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker
from trackweave.trackers.plot_fusion import PlotFuser

DAY = 86_400.0
RNG = np.random.default_rng(1)
MAKERS = {
    "multi-hypothesis": lambda *sensors, **given: MultiHypothesisTracker(
        motion=MOTION, sensors=sensors or [sensor()], window=4, search=Greedy(), **given
    ),
    "nearest-neighbour": lambda *sensors, **given: NearestNeighbourTracker(
        motion=MOTION, sensors=sensors or [sensor()], **given
    ),
}


@pytest.fixture(params=MAKERS)
def make(request):
    return MAKERS[request.param]


def seen(time, name="radar", report=()):
    """Return a scan of one object that moves, and another that does not."""
    return scan(time, [(10.0 * (time % 1000.0), 0.0), (500.0, 500.0)], name, report)


def states(hypothesis):
    return hypothesis.tracks.mean.tobytes(), hypothesis.tracks.covariance.tobytes()


def held_times(hypothesis):
    return [each.time for each in hypothesis.held]


def test_of_scans_that_come_together_only_those_too_far_ahead_are_held():
    plain, target = MAKERS["multi-hypothesis"](), MAKERS["multi-hypothesis"]()
    run(plain, [seen(float(time)) for time in range(5)])
    run(target, [seen(float(time)) for time in range(4)])
    last = target.step(
        [seen(4.0), seen(4.0 + DAY, report=[700, 701])], rng=np.random.default_rng(1)
    )
    assert (last.time, last.stop_reason, held_times(last)) == (4.0, HELD, [4.0 + DAY])
    assert last.tracks.mean.tobytes() == plain.tracks().mean.tobytes()
    after = target.step([seen(5.0), seen(6.0)], rng=np.random.default_rng(1))
    assert (after.time, held_times(after)) == (6.0, [])


@pytest.mark.parametrize("ahead", [61.0, 3600.0, DAY])
def test_a_scan_ahead_of_all_others_is_held_and_told_and_blinds_nobody(make, ahead):
    times = [float(time) for time in range(12)]
    plain = run(make(), [seen(time) for time in times])
    target = make()
    before = run(target, [seen(time) for time in times[:6]])
    (stray,) = run(target, [scan(5.0 + ahead, [(0.0, 0.0)], report=[700])])
    assert (stray.stop_reason, stray.late, stray.time) == (HELD, (), 5.0)
    assert [(each.time, each.sensor, each.report) for each in stray.held] == [
        (5.0 + ahead, "radar", (700,))
    ]
    assert states(stray) == states(before[-1])
    after = run(target, [seen(time) for time in times[6:]])
    assert [states(each) for each in after] == [states(each) for each in plain[6:]]
    # The sensor went on before that time: its stamp was wrong.
    assert [each.report for each in after[0].set_aside] == [(700,)]
    assert not any(each.held or each.set_aside for each in after[1:])


@pytest.mark.parametrize("length", [61.0, 3600.0, 400 * DAY])
def test_an_outage_ends_with_the_third_scan_that_takes_all_three_in(make, length):
    target = make()
    run(target, [seen(float(time)) for time in range(6)])
    start = 5.0 + length
    first, second, third = run(target, [seen(start + step) for step in range(3)])
    assert held_times(first) == [start]
    assert held_times(second) == [start, start + 1.0]
    assert third.held == third.set_aside == third.late == third.amendments == ()
    assert third.time == start + 2.0
    assert third.tracks.hits.max() >= 3
    fourth = run(target, [seen(start + 3.0)])[0]
    assert fourth.time == start + 3.0


def test_every_report_has_a_final_word_or_is_still_open(make):
    target = make()
    scans = [seen(float(time)) for time in range(5)]
    scans += [seen(5000.0), seen(5.0), seen(-400.0), seen(6.0)]
    scans += [seen(9000.0 + step) for step in range(5)]
    scans = [
        scan(each.time, each.measurement, report=[2 * number, 2 * number + 1])
        for number, each in enumerate(scans)
    ]
    hypotheses = run(target, scans)
    final = [number for each in hypotheses for number in each.final.report.tolist()]
    late = [number for each in hypotheses for number in each.late]
    aside = [n for each in hypotheses for gone in each.set_aside for n in gone.report]
    pending = target.pending().report.tolist()
    waiting = [n for each in hypotheses[-1].held for n in each.report]
    assert sorted(final + late + aside + pending + waiting) == list(range(2 * len(scans)))
    assert (aside, late, waiting) == ([10, 11], [14, 15], [])


@pytest.mark.parametrize("wrong", [DAY, -DAY, 500.0])
def test_a_first_scan_that_is_wrong_gives_way_to_three_that_agree(make, wrong):
    times = [float(time) for time in range(9)]
    plain = run(make(), [seen(time) for time in times])
    target = make()
    (first,) = run(target, [scan(wrong, [(100.0, 100.0), (0.0, 0.0)])])
    assert first.time == wrong
    after = run(target, [seen(time) for time in times])
    assert [each.stop_reason == HELD for each in after[:3]] == [True, True, False]
    final = [each.final.report.tolist() for each in (first, *after[:3])]
    assert {0, 1} <= {number for numbers in final for number in numbers}
    assert [states(each) for each in after[2:]] == [states(each) for each in plain[2:]]


def test_wrong_first_scans_by_turns_with_right_ones_give_way_too(make):
    target, times = make(), [float(time) for time in range(12)]
    scans = []
    for time in times[:3]:
        scans += [seen(DAY * (5.0 - time)), seen(time)]
    hypotheses = run(target, [*scans, *(seen(time) for time in times[3:])])
    assert hypotheses[-1].time == 11.0
    assert hypotheses[-1].tracks.hits.max() >= 9


def test_a_clock_that_was_wrong_for_long_is_set_back_by_three_scans_of_its_only_sensor(make):
    target = make()
    run(target, [seen(float(time)) for time in range(6)])
    run(target, [seen(DAY + time) for time in range(50)])
    late = run(target, [seen(60.0), seen(61.0)])
    assert [each.stop_reason for each in late] == [LATE, LATE]
    (back,) = run(target, [seen(62.0)])
    assert back.time == 62.0
    after = run(target, [seen(63.0 + time) for time in range(4)])
    assert 5 in after[-1].tracks.hits.tolist()


def test_a_name_never_comes_back_after_a_clock_was_set_back(make):
    target = make()
    before = run(target, [seen(DAY + time) for time in range(8)])
    after = run(target, [seen(float(time)) for time in range(8)])
    old = {name for each in before for name in each.tracks.track.tolist()}
    new = {name for each in after[2:] for name in each.tracks.track.tolist()}
    assert old
    assert new
    assert not old & new


def test_what_a_sensor_had_stored_sets_no_clock_back(make):
    target = make(sensor("a"), sensor("b"))
    both = [seen(float(time), name) for time in range(200) for name in "ab"]
    run(target, both)
    stored = run(target, [seen(100.0 + time, "b") for time in range(40)])
    assert {each.stop_reason for each in stored} == {LATE}
    assert run(target, [seen(200.0, "a")])[0].time == 200.0


def test_a_sensor_that_is_ahead_of_the_others_is_taken_in_when_time_gets_there(make):
    target = make(sensor("a"), sensor("b", scan_period=20.0))
    scans = [seen(float(time), "a") for time in range(10)]
    scans.insert(5, seen(75.0, "b"))
    *_, last = run(target, scans)
    assert held_times(last) == [75.0]
    hypotheses = run(target, [seen(10.0 + time, "a") for time in range(66)])
    assert held_times(hypotheses[-2]) == [75.0]
    assert hypotheses[-1].held == hypotheses[-1].set_aside == ()
    assert hypotheses[-1].time == 75.0


@pytest.mark.parametrize(
    "strays",
    [
        [(DAY, "a"), (DAY, "a"), (DAY, "a"), (DAY, "a")],
        [(DAY, "a"), (DAY + 500.0, "a"), (DAY + 900.0, "a"), (3 * DAY, "a")],
        [(DAY, "a"), (DAY + 90.0, "b"), (DAY + 180.0, "a"), (DAY + 270.0, "b")],
    ],
    ids=["a clock that stands", "leaps", "leaps of two"],
)
def test_scans_ahead_that_do_not_agree_are_not_believed(make, strays):
    target = make(sensor("a"), sensor("b"))
    run(target, [seen(float(time), "a") for time in range(6)])
    hypotheses = run(target, [seen(time, name) for time, name in strays])
    assert {each.time for each in hypotheses} == {5.0}
    assert len(hypotheses[-1].held) == 4


def test_scans_of_several_sensors_end_an_outage_together(make):
    target = make(sensor("a"), sensor("b"), sensor("c"))
    run(target, [seen(float(time), name) for time in range(6) for name in "abc"])
    # They need not come in order.
    hypotheses = run(target, [seen(900.0, "a"), seen(900.4, "c"), seen(900.2, "b")])
    assert [each.time for each in hypotheses] == [5.0, 5.0, 900.4]


def test_sensors_without_a_period_may_be_rare_once_they_have_shown_it(make):
    target = make(sensor(scan_period=None))
    hypotheses = run(target, [seen(200.0 * time) for time in range(12)])
    assert [each.stop_reason == HELD for each in hypotheses] == [False, True, True] + [False] * 9
    assert hypotheses[-1].time == 2200.0


def test_a_slow_sensor_is_not_ahead_of_itself(make):
    target = make(sensor(scan_period=600.0))
    hypotheses = run(target, [seen(600.0 * time) for time in range(5)])
    assert not any(each.held for each in hypotheses)


def test_without_max_ahead_every_time_is_believed(make):
    target = make(max_ahead=None)
    hypotheses = run(target, [seen(0.0), seen(1.0), seen(DAY)])
    assert hypotheses[-1].time == DAY


@pytest.mark.parametrize("wrong", [0.0, -1.0, float("nan"), "soon", True])
def test_refuses_another_max_ahead(make, wrong):
    with pytest.raises(InvalidInputError, match="max_ahead"):
        make(max_ahead=wrong)


def test_known_tracks_count_again_after_a_first_scan_that_was_wrong(make):
    from trackers.test_contract import known

    lasting = Lifecycle(hidden_share=0.0, survival=0.999999)
    target = make(priors=known((7,)), lifecycle=lasting)
    (first,) = run(target, [scan(DAY, [])])
    assert first.time == DAY
    after = run(target, [scan(1.0 + time, []) for time in range(3)])
    assert after[-1].tracks.track.tolist() == [7]


def test_no_more_scans_wait_than_there_is_room_for(make, monkeypatch):
    monkeypatch.setattr(clock_guard, "MOST_HELD", 3)
    target = make(sensor("a"), sensor("b"))
    run(target, [seen(float(time), "a") for time in range(5)])
    hypotheses = run(target, [seen(1000.0 * 3**k, "b") for k in range(5)])
    assert [len(each.held) for each in hypotheses] == [1, 2, 3, 3, 3]
    assert [len(each.set_aside) for each in hypotheses] == [0, 0, 0, 1, 1]


@pytest.mark.parametrize("inside", [MultiHypothesisTracker, NearestNeighbourTracker])
def test_instants_are_judged_like_scans(inside):
    def make():
        rule = PlotsRule(object_density=1e-6, negative_only=True, lone_plots=True)
        fuser = PlotFuser([sensor(name) for name in "ab"], rule, Greedy(), motion=MOTION)
        return FusedPlotsTracker(fuser, inside(motion=MOTION, sensors=fuser.fused_sensors(1.0)))

    def instant(time):
        return [seen(time, name) for name in "ab"]

    times = [float(time) for time in range(9)]
    plain, target = run(make(), [instant(time) for time in times]), make()
    run(target, [instant(time) for time in times[:5]])
    (stray,) = run(target, [instant(DAY)])
    assert [(each.sensor, len(each.report)) for each in stray.held] == [("a", 2), ("b", 2)]
    after = run(target, [instant(time) for time in times[5:]])
    assert [states(each) for each in after] == [states(each) for each in plain[5:]]
    assert len(after[0].set_aside) == 2
    back = run(target, [instant(DAY + time) for time in times])
    assert [each.time for each in back[:3]] == [8.0, 8.0, DAY + 2.0]
    again = run(target, [instant(time) for time in times])
    assert again[-1].time == 8.0


STRAYS = st.dictionaries(
    st.integers(0, 14),
    st.floats(200.0, 1e7) | st.floats(-1e7, -200.0),
    max_size=7,
)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(STRAYS, st.sampled_from(sorted(MAKERS)), st.sampled_from([1, 2]))
def test_lone_strays_change_no_track(strays, kind, n_sensors):
    names = "ab"[:n_sensors]
    regular = scene(3, names=names, times=range(15))
    # Two that are ahead by as much agree with one another, and are no lone strays.
    shifts = list(strays.values())
    lone = {
        place: shift
        for place, shift in strays.items()
        if place - 1 not in strays and shifts.count(shift) == 1
    }
    disturbed = []
    for place, each in enumerate(regular):
        if place in lone:
            disturbed.append(scan(each.time + lone[place], each.measurement + 3.0, each.sensor))
        disturbed.append(scan(each.time, each.measurement, each.sensor))
    sensors = [sensor(name) for name in names]
    plain = run(MAKERS[kind](*sensors), regular)[-1]
    found = run(MAKERS[kind](*sensors), disturbed)[-1]
    assert found.time == plain.time
    assert states(found) == states(plain)
    assert found.tracks.status.tolist() == plain.tracks.status.tolist()


@settings(max_examples=60, deadline=None)
@given(
    st.floats(0.5, 1e9),
    st.lists(st.sampled_from("abc"), min_size=3, max_size=3, unique=True)
    | st.just(["a", "a", "a"]),
)
def test_an_outage_of_any_length_ends_within_three_scans(length, order):
    sensors = [Sensor(name, clutter_density=1e-6, scan_period=2.0) for name in "abc"]
    guard = ClockGuard.of(60.0, sensors)
    for time in range(0, 20, 2):
        for name in "abc":
            guard = guard.judge(Arrival((seen(float(time), name),))).guard
    start = 18.0 + length
    step = 2.0 if len(set(order)) == 1 else 0.1
    for count, name in enumerate(order):
        verdict = guard.judge(Arrival((seen(start + step * count, name),)))
        guard = verdict.guard
    assert guard.latest == start + step * 2
    assert not guard.held
