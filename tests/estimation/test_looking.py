"""Whether a sensor looks is told by its objects' rhythm."""

import numpy as np
import pytest

from trackweave.estimation.looking import (
    are_even_steps,
    is_filled_evenly,
    line_up,
    looking,
    shun_successive,
)
from trackweave.estimation.threads import threads_of


def judged(rows):
    """Return the judgement of rows of time, x, y."""
    table = np.array(sorted(rows), dtype=float)
    threads = threads_of(table[:, 0], table[:, 1:])
    return looking(table[:, 0], threads.rows)


def scans(seed, n_objects, detection, *, clutter=0.0, jitter=0.0, n_scans=200):
    """Return rows of a sensor that looks once a second."""
    rng = np.random.default_rng(seed)
    place, speed = rng.uniform(0, 3000, (n_objects, 2)), rng.normal(0, 8, (n_objects, 2))
    rows = []
    for number in range(n_scans):
        time = number + rng.normal(0, jitter) if jitter else float(number)
        seen = rng.random(n_objects) < detection
        spots = (place + speed * time + rng.normal(0, 8, place.shape))[seen]
        false = rng.uniform(-500, 3500, (rng.poisson(clutter), 2))
        rows += [(time, *spot) for spot in np.concatenate([spots, false])]
    return rows


def lone(seed, n_objects, grain):
    """Return rows of objects that report each at its own pace, stamps in whole grains."""
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(n_objects):
        place, speed = rng.uniform(-4000, 4000, 2), rng.normal(0, 4, 2)
        pause = rng.uniform(3, 20)
        time = rng.uniform(0, pause)
        while time < 600:
            stamp = np.floor(time / grain) * grain
            rows.append((stamp, *(place + speed * time + rng.normal(0, 6, 2))))
            time += pause * rng.uniform(0.8, 1.2)
    return rows


@pytest.mark.parametrize(
    ("n_objects", "detection", "clutter", "jitter"),
    [
        (20, 0.5, 20, 0.0),
        (20, 0.3, 5, 0.0),
        (5, 0.2, 0, 0.0),
        (10, 0.9, 10, 0.1),
        (3, 0.97, 5, 0.3),
    ],
)
def test_a_sensor_that_looks_is_never_taken_for_one_that_does_not(
    n_objects, detection, clutter, jitter
):
    found = judged(scans(1, n_objects, detection, clutter=clutter, jitter=jitter))
    assert found.scans is not False


@pytest.mark.parametrize("n_objects", [1, 2])
def test_one_or_two_objects_seen_half_of_the_time_do_not_speak_against_scans(n_objects):
    assert judged(scans(1, n_objects, 0.5)).scans is not False


def test_low_detection_in_many_scans_says_that_the_sensor_looks():
    found = judged(scans(2, 5, 0.2, n_scans=600))
    assert found.scans is True
    assert found.doubt < 0.1


@pytest.mark.parametrize("grain", [1.0, 0.5, 1e-3])
def test_lone_reports_are_seen_through_whatever_the_grain_of_their_stamps(grain):
    found = judged(lone(1, 30, grain))
    assert found.scans is False
    assert found.doubt < 0.3


def test_stamps_that_three_objects_always_share_do_not_make_scans():
    rng = np.random.default_rng(1)
    rows, time = [], 0.0
    for number in range(300):
        time += rng.uniform(1, 5)
        for place in ((5000, 0), (0, 5000), (5000, 5000)):
            rows.append((time, *(place + rng.normal(0, 5, 2))))
        if number % 6 == 3:
            rows.append((time + 0.5, *rng.normal(0, 5, 2)))
    assert judged(rows).scans is False


def test_two_streams_under_one_name_are_no_scans():
    rng = np.random.default_rng(3)
    rows = []
    for shift, step, count in ((0.0, 0.1, 3), (0.05, 1.43, 4)):
        place, speed = rng.uniform(-300, 300, (count, 2)), rng.normal(0, 3, (count, 2))
        for time in np.arange(shift, 120, step):
            for spot in (place + speed * time)[rng.random(count) < 0.7]:
                rows.append((time, *(spot + rng.normal(0, 2, 2))))
    assert judged(rows).scans is False


def test_too_few_reports_tell_nothing():
    found = judged([(0.0, 0.0, 0.0), (1.0, 5.0, 5.0)])
    assert found.scans is None
    assert found.doubt == 1.0


def bursts(seed, n_objects=20, seconds=1200.0):
    """Return rows of objects that report by themselves in bursts, each at any moment."""
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(n_objects):
        place, speed, time = rng.uniform(0, 3000, 2), rng.normal(0, 2, 2), rng.uniform(0, 10)
        while time < seconds:
            rows.append((time, *(place + speed * time + rng.normal(0, 5, 2))))
            time += rng.exponential(2.0) if rng.random() < 0.6 else rng.exponential(15.0)
    return rows


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_who_reports_in_bursts_but_hardly_ever_with_another_reports_by_itself(seed):
    found = judged(bursts(seed))
    assert found.is_single
    assert found.by_chance > found.by_themselves
    assert found.scans is False
    assert found.doubt > 0.5


def test_a_sensor_that_sees_one_object_at_a_time_at_regular_times_looks():
    found = judged(scans(3, 6, 0.08, n_scans=1500))
    assert not found.is_single
    assert found.scans is not False


@pytest.mark.parametrize("seed", range(4))
def test_two_that_are_never_together_report_by_themselves(seed):
    rng, rows = np.random.default_rng(seed), []
    for place in ((-500.0, 0.0), (400.0, 300.0)):
        time = np.arange(rng.uniform(0.0, 10.0), 400.0, 10.0)
        time = time + rng.uniform(-1.0, 1.0, time.size)
        rows += [(now, *(place + rng.normal(0.0, 5.0, 2))) for now in time]
    seen = judged(rows)
    assert seen.take_turns
    assert seen.scans is False


@pytest.mark.parametrize("seed", range(4))
def test_false_alarms_one_at_a_time_are_no_objects_that_take_turns(seed):
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.exponential(1.0, 200))
    rows = np.column_stack([time, rng.uniform(0.0, 1e4, (200, 2))]).tolist()
    assert not judged(rows).take_turns


@pytest.mark.parametrize("seed", range(4))
def test_a_single_object_takes_no_turns(seed):
    assert not judged(scans(seed, 1, 0.8)).take_turns


def test_objects_of_one_pause_seem_to_be_seen_by_turns():
    # Of five, one is alone in every second burst.
    number = np.repeat(np.arange(40), np.where(np.arange(40) % 2, 4, 1))
    odd = np.flatnonzero(number % 2 == 1).reshape(-1, 4)
    threads = [np.flatnonzero(number % 2 == 0), *odd.T]
    assert shun_successive(number, threads)
    assert not shun_successive(np.repeat(np.arange(40), 5), list(np.arange(200).reshape(-1, 5).T))
    # Seen at every second look by chance, some are seen at two in a row.
    rng = np.random.default_rng(1)
    by_chance = [np.flatnonzero(rng.random(400) < 0.5) for _ in range(3)]
    assert not shun_successive(np.arange(400), by_chance)


def test_a_circle_is_one_object_at_which_a_sensor_looks():
    """Its places come back after nine looks, as nine objects at rest would report in turn."""
    rng = np.random.default_rng(5)
    time = np.arange(100.0)
    time = time[rng.random(time.size) < 0.95]
    place = 30.0 * np.stack([np.cos(0.7 * time), np.sin(0.7 * time)], axis=1)
    place += rng.normal(0.0, 1.0, place.shape)
    assert is_filled_evenly(time)
    assert are_even_steps(time, place)


def test_objects_with_slots_of_their_own_report_by_themselves():
    rng = np.random.default_rng(5)
    time = np.arange(200.0)
    home, velocity = rng.uniform(-500.0, 500.0, (20, 2)), rng.uniform(-2.0, 2.0, (20, 2))
    whose = np.arange(200) % 20
    place = home[whose] + velocity[whose] * time[:, None]
    assert is_filled_evenly(time)
    assert not are_even_steps(time, place)
    # Two by turns are always as far apart.
    whose = np.arange(200) % 2
    assert not are_even_steps(time, home[whose] + rng.normal(0.0, 1.0, (200, 2)))


def test_what_comes_as_it_likes_fills_no_instants_evenly():
    rng = np.random.default_rng(5)
    assert not is_filled_evenly(np.sort(rng.integers(0, 100, 300)).astype(float))
    assert not is_filled_evenly(np.sort(rng.uniform(0.0, 100.0, 300)))


def test_traffic_that_swells_and_ebbs_fills_looks_evenly():
    rng = np.random.default_rng(6)
    here = 8.0 + 5.0 * np.sin(np.arange(120) / 9.0)
    count = rng.binomial(np.round(here).astype(int), 0.93)
    assert is_filled_evenly(np.repeat(2.0 * np.arange(120), count))


def lane(rng, each):
    """Return times and places of cars that one looks at, or of tags that report in turn."""
    time, place = [], []
    start = np.cumsum(rng.uniform(40.0, 110.0, 60))
    for instant in range(60):
        here = start + 27.0 * 2.0 * instant - 3300.0
        here = here[(here > 0.0) & (here < 600.0)]
        if each == "tags":
            # Other tags at each instant, which come again in their own slots.
            here = np.random.default_rng(instant % 5).uniform(0.0, 600.0, here.size)
        time += [2.0 * instant] * here.size
        place += [(x + rng.normal(0.0, 1.5), rng.normal(0.0, 0.5)) for x in here]
    return np.array(time), np.array(place)


@pytest.mark.parametrize(("each", "lines_up"), [("cars", True), ("tags", False)])
def test_who_is_looked_at_lines_up_however_far_it_goes_and_who_has_slots_does_not(each, lines_up):
    time, place = lane(np.random.default_rng(7), each)
    found = line_up(time, place)
    assert (found is not None) == lines_up
    if found is not None:
        # Cars go 54 m, to 1.5 m along and 0.5 m across.
        assert found == (pytest.approx(54.0, abs=4.0), pytest.approx(0.9, rel=0.6))
