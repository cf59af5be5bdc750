"""Times that come in bursts are frames; those of turning beams and of tags are not."""

import numpy as np
import pytest

from trackweave.estimation.bursts import bursts_of, slices_of


def frames(period, spread, *, n_frames=100, each=4.0, seed=1):
    rng = np.random.default_rng(seed)
    frame = np.repeat(np.arange(n_frames), rng.poisson(each, n_frames))
    time = period * frame + rng.uniform(0, spread, frame.size)
    order = np.argsort(time)
    return time[order], frame[order]


@pytest.mark.parametrize(("period", "spread"), [(1.0, 0.01), (1.0, 0.2), (0.04, 0.004)])
@pytest.mark.parametrize("each", [1.5, 20.0])
def test_each_frame_is_a_burst(period, spread, each):
    time, frame = frames(period, spread, each=each)
    number, lasting = bursts_of(time)
    _, expected = np.unique(frame, return_inverse=True)
    np.testing.assert_array_equal(number, expected)
    assert lasting <= spread


def test_frames_may_be_lost():
    time, frame = frames(1.0, 0.05)
    kept = (frame < 30) | (frame > 47)
    number, _ = bursts_of(time[kept])
    assert number.max() + 1 == np.unique(frame[kept]).size


def test_times_that_are_all_alike_in_a_frame_are_none():
    assert bursts_of(np.repeat(np.arange(50.0), 5)) is None


@pytest.mark.parametrize("seed", range(5))
def test_reports_at_any_time_are_none(seed):
    assert bursts_of(np.sort(np.random.default_rng(seed).uniform(0, 100, 600))) is None


@pytest.mark.parametrize("seed", range(5))
def test_objects_that_report_each_at_its_own_second_are_none(seed):
    rng = np.random.default_rng(seed)
    time = np.arange(80.0)[:, None] + rng.uniform(0, 1, 12) + rng.normal(0, 0.01, (80, 12))
    assert bursts_of(np.sort(time.reshape(-1))) is None


def test_frames_come_at_any_time():
    rng = np.random.default_rng(1)
    frame = np.repeat(np.arange(100), rng.binomial(12, 0.9, 100))
    time = np.cumsum(rng.uniform(0.1, 0.9, 100))[frame] + rng.uniform(0, 0.02, frame.size)
    number, _ = bursts_of(np.sort(time))
    assert number.max() == 99


def test_what_is_late_now_and_then_is_of_its_frame():
    rng = np.random.default_rng(1)
    frame = np.repeat(np.arange(100), 12)
    time = 0.4 * frame + rng.exponential(0.015, frame.size)
    number, _ = bursts_of(np.sort(time))
    assert number.max() == 99


def test_passes_in_which_objects_report_again_and_again_are_none():
    rng = np.random.default_rng(1)
    count = np.maximum(rng.geometric(0.05, 100), 2)
    time = np.repeat(np.cumsum(rng.exponential(1e4, 100)), count)
    assert bursts_of(np.sort(time + rng.uniform(0, 100, time.size))) is None


def test_stragglers_between_bursts_are_of_the_burst_before():
    time, frame = frames(3600.0, 150.0, each=17.0, n_frames=200)
    rng = np.random.default_rng(2)
    late = rng.random(time.size) < 0.02
    time = np.where(late, time + rng.uniform(300, 3000, time.size), time)
    order = np.argsort(time)
    number, lasting = bursts_of(time[order])
    assert np.mean(number == frame[order] - frame.min()) > 0.999
    assert lasting < 200.0


def passes(rng, *, by_place):
    """Return times and places of reports of thirty passes, each of three times 25 s apart."""
    begins = np.cumsum(rng.uniform(3e4, 2e5, 30))
    place = rng.uniform(0.0, 3e5, (30, 40, 2))
    slice_of = np.floor(place[:, :, 1] / 1e5) if by_place else rng.integers(0, 3, (30, 40))
    time = (begins[:, None] + 25.0 * slice_of).ravel()
    order = np.argsort(time, kind="stable")
    return time[order], place.reshape(-1, 2)[order]


def test_slices_along_a_pass_are_of_one_look():
    time, place = passes(np.random.default_rng(1), by_place=True)
    number, lasting = slices_of(time, place)
    assert lasting == 50.0
    assert np.unique(number).size == 30
    assert np.all(np.diff(number) >= 0)


def test_what_is_everywhere_at_each_time_is_no_slice():
    time, place = passes(np.random.default_rng(2), by_place=False)
    assert slices_of(time, place) is None


def test_pictures_of_one_thing_in_series_are_no_slices():
    rng = np.random.default_rng(3)
    place = np.tile(rng.uniform(0.0, 3e5, (20, 2)), (90, 1))
    time = np.repeat((1e5 * np.arange(30)[:, None] + 25.0 * np.arange(3)).ravel(), 20)
    assert slices_of(time, place + rng.normal(0.0, 100.0, place.shape)) is None


def test_times_without_long_pauses_have_no_slices():
    rng = np.random.default_rng(4)
    assert slices_of(np.arange(300.0), rng.uniform(0.0, 3e5, (300, 2))) is None
    assert slices_of(np.zeros(5), rng.uniform(0.0, 3e5, (5, 2))) is None
