import numpy as np
import pytest

from oracles.scenes import run, scan, sensor, tracker
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import COASTING, CONFIRMED, TENTATIVE
from trackweave.errors import InvalidInputError
from trackweave.models.coverage import FieldOfView
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker

PATIENT = Lifecycle(certain_probability=1.0, confirm_probability=0.0, new_target_density=1e-5)


def statuses(hypotheses):
    return [hypothesis.tracks.status.tolist() for hypothesis in hypotheses]


def at(time, name="radar"):
    return scan(time, [(10.0 * time, 0.0)], name)


@pytest.mark.parametrize(
    ("hits", "expected"),
    [
        ([1.0, 2.0, 3.0], True),
        ([1.0, 2.0, 4.0], True),
        ([1.0, 2.0, 5.0], False),
        ([1.0, 2.0], False),
        ([], False),
        ([1.0, 1.0, 1.0, 2.0], False),
        ([1.0, 5.0, 6.0, 8.0], True),
        ([1.0, 1.6, 2.4], True),
    ],
)
def test_three_of_four_chances_confirm(hits, expected):
    assert Lifecycle(confirm_hits=3, confirm_opportunities=4).is_confirmed_by(hits) is expected


def test_one_of_one_confirms_at_once():
    assert Lifecycle(confirm_hits=1, confirm_opportunities=1).is_confirmed_by([7.0])


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"confirm_hits": 0}, "1 ≤ M ≤ N"),
        ({"confirm_hits": 5}, "1 ≤ M ≤ N"),
        ({"delete_after_misses": 0}, "a whole number from 1 to 1000 or None"),
        ({"survival": 1.0}, "survival"),
        ({"survival": 0.0}, "survival"),
        ({"new_target_density": 0.0}, "new_target_density"),
        ({"new_target_density": np.nan}, "new_target_density"),
        ({"initial_target_density": -1.0}, "initial_target_density"),
        ({"confirm_probability": 1.0}, "confirm_probability"),
        ({"certain_probability": 0.0}, "certain_probability"),
    ],
)
def test_refuses_a_life_that_is_none(changed, message):
    with pytest.raises(InvalidInputError, match=message):
        Lifecycle(**changed)


def test_a_track_is_confirmed_by_its_third_hit():
    hypotheses = run(tracker(lifecycle=PATIENT), [at(float(time)) for time in range(4)])
    assert statuses(hypotheses)[-3:] == [[TENTATIVE], [CONFIRMED], [CONFIRMED]]


@pytest.mark.parametrize("depth", [1, 2, 4])
def test_several_sensors_at_one_instant_are_one_chance(depth):
    names = ("a", "b", "c")
    target = tracker(*(sensor(name) for name in names), lifecycle=PATIENT, window=depth)
    scans = [at(float(time), name) for time in range(3) for name in names]
    hypotheses = run(target, scans)
    assert statuses(hypotheses)[5] == [TENTATIVE]
    assert statuses(hypotheses)[6] == [CONFIRMED]


def test_a_track_seen_by_one_of_two_simultaneous_sensors_has_missed_nothing():
    target = tracker(sensor("a"), sensor("b"), lifecycle=PATIENT)
    scans = []
    for time in range(10):
        scans += [at(float(time), "a"), scan(float(time), [], "b")]
    hypotheses = run(target, scans)
    assert statuses(hypotheses)[-1] == [CONFIRMED]
    assert hypotheses[-1].tracks.hits.tolist() == [10]


@pytest.mark.parametrize("misses", [2, 3])
def test_a_track_coasts_and_then_ends_after_so_many_misses(misses):
    life = Lifecycle(
        delete_after_misses=misses, survival=0.9999, new_target_density=1e-5,
    )  # fmt: skip
    target = tracker(sensor(detection_probability=0.6), lifecycle=life)
    scans = [at(float(time)) for time in range(6)]
    scans += [scan(float(time), []) for time in range(6, 14)]
    after = [s for s in statuses(run(target, scans))[6:]]
    assert after[: misses - 1] == [[COASTING]] * (misses - 1)
    assert after[misses:] == [[]] * (8 - misses)


def test_a_track_that_comes_back_in_time_keeps_its_name():
    scans = [at(float(time)) for time in range(6)]
    scans += [scan(6.0, []), scan(7.0, [])]
    scans += [at(float(time)) for time in range(8, 11)]
    hypotheses = run(tracker(), scans)
    assert len({name for each in hypotheses[3:] for name in each.tracks.track.tolist()}) == 1


def back_after(missed, **life):
    """Return the tracks before an object's silence of so many scans, in it, and behind it."""
    end = 8 + missed
    scans = [at(float(time)) for time in range(8)]
    scans += [scan(float(time), []) for time in range(8, end)]
    scans += [at(float(time)) for time in range(end, end + 8)]
    lifecycle = Lifecycle(new_target_density=1e-9, **life)
    hypotheses = run(tracker(lifecycle=lifecycle), scans)
    return [each.tracks for each in (hypotheses[7], hypotheses[end - 1], hypotheses[-1])]


def test_a_silence_hides_a_track_and_its_name_stays_open():
    before, silent, after = back_after(30)
    assert [len(before), len(silent), len(after)] == [1, 0, 1]
    assert after.track.tolist() == before.track.tolist()
    assert after.hits.tolist() == [16]


@pytest.mark.parametrize("life", [{"delete_after_misses": 5}, {"rejoin": 20.0}])
def test_a_name_is_closed_when_it_was_told_to_be(life):
    before, silent, after = back_after(30, **life)
    assert [len(before), len(silent), len(after)] == [1, 0, 1]
    assert after.track[0] > before.track[0]


def test_the_name_of_an_object_that_is_surely_gone_is_closed():
    target = tracker(lifecycle=Lifecycle(mean_silence=5.0))
    run(target, [at(float(time)) for time in range(8)])
    (silent,) = run(target, [scan(8.0, [])])
    assert silent.n_sequences > 0
    last = run(target, [scan(float(time), []) for time in range(9, 120)])[-1]
    assert last.n_sequences == 0


@pytest.mark.parametrize("estimate", ["average", "best"])
def test_a_track_is_shown_while_its_object_more_probably_lives_in_sight(estimate):
    """By the forward recursion of the chain, here by hand: alive, and in sight, or over."""
    life = Lifecycle(hidden_share=0.05, mean_silence=10.0)
    target = MultiHypothesisTracker(
        motion=ConstantVelocity(0.1, 20.0),
        sensors=[Sensor("radar", 5.0, 0.9, 1e-7, scan_period=1.0)],
        lifecycle=life,
        estimate=estimate,
    )
    rng = np.random.default_rng(2)
    for time in range(12):
        place = np.array([[10.0 * time, 0.0]]) + rng.normal(0, 5.0, (1, 2))
        target.step(Scan(float(time), "radar", place), rng=rng)
    hiding, showing = life.hiding(1.0)
    sight, hidden, shown, expected = 1.0, 0.0, [], []
    for time in range(12, 18):
        tracks = target.step(Scan(float(time), "radar", np.empty((0, 2))), rng=rng).tracks
        shown.append(tracks.status.tolist())
        sight, hidden = (
            0.1 * (sight * (1 - hiding) + hidden * showing),
            hidden * (1 - showing) + sight * hiding,
        )
        sight, hidden = 0.999 * sight, 0.999 * hidden
        expected.append([COASTING] if sight >= 0.5 * (sight + hidden + 0.001) else [])
    assert shown == expected
    assert [] in expected
    assert [COASTING] in expected


@pytest.mark.parametrize(("share", "silence"), [(0.01, 60.0), (0.3, 5.0), (0.0, 1.0)])
def test_hiding_over_two_steps_is_that_over_both(share, silence):
    life = Lifecycle(hidden_share=share, mean_silence=silence)

    def step(waited):
        hiding, showing = life.hiding(waited)
        return np.array([[1 - hiding, hiding], [showing, 1 - showing]])

    np.testing.assert_allclose(step(1.5) @ step(7.0), step(8.5))
    assert life.hiding(1e9) == pytest.approx((share, 1.0 - share if share else 0.0))


def test_out_of_sight_a_track_coasts_but_not_for_ever():
    view = FieldOfView(polygon=[(-500.0, -500.0), (55.0, -500.0), (55.0, 500.0), (-500.0, 500.0)])
    life = Lifecycle(delete_after_misses=5, survival=0.99999, new_target_density=1e-5)
    target = tracker(sensor(field_of_view=view), lifecycle=life)
    scans = [at(float(time)) for time in range(6)]
    scans += [scan(float(time), []) for time in range(6, 80)]
    after = statuses(run(target, scans))
    # Ten scans unseen are no misses where nobody looks.
    assert after[16] == [COASTING] or after[16] == [CONFIRMED]
    assert after[-1] == []


def test_a_lone_false_alarm_is_no_track():
    scans = [scan(0.0, [(5.0, 5.0)]), *(scan(float(time), []) for time in range(1, 9))]
    hypotheses = run(tracker(), scans)
    assert len(hypotheses[-1].tracks) == 0


@pytest.mark.parametrize("share", [-0.1, 0.95, 1.0])
def test_refuses_objects_hidden_more_than_files_may_say(share):
    assert Lifecycle(hidden_share=0.9).hidden_share == 0.9
    with pytest.raises(
        InvalidInputError, match=r"hidden_share: .*; expected a number from 0 to 0\.9"
    ):
        Lifecycle(hidden_share=share)
