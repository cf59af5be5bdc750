"""What tracks of a stretch tell of sensors."""

from dataclasses import replace

import numpy as np
import pytest

from estimation.test_estimate import table
from trackweave.estimation.estimates import Estimates, SensorEstimate
from trackweave.estimation.refine import LEAST_LOOKS, MOST_REPORTS, Followed, refined, stretch_of

LOOKS = np.arange(100.0)
SENSOR = SensorEstimate(1.0, 5.0, 0.9, 1e-7, 1e8, 4.0)
GUESS = Estimates({"near": SENSOR, "far": SENSOR}, 0.01, 20.0, 1e-9, 1e-8)


def learned(*, far_sees: bool) -> dict[str, SensorEstimate]:
    """Return what is said of two sensors, of which one sees nothing in the middle."""
    rng = np.random.default_rng(1)
    time, place, sensor, track = [], [], [], []
    for number in range(6):
        for index in range(2):
            seen = rng.random(LOOKS.size) < 0.9
            if index == 0 or not far_sees:
                seen[30:70] = False
            moments = LOOKS[seen] + 0.5 * index
            time.append(moments)
            place.append(np.stack([10 * moments, np.full(moments.size, 1000.0 * number)], axis=1))
            sensor.append(np.full(moments.size, index))
            track.append(np.full(moments.size, number))
    time, place = np.concatenate(time), np.concatenate(place)
    sensor, track = np.concatenate(sensor), np.concatenate(track)
    place += rng.normal(0, 5, place.shape)
    reports = table(time, place, sensor, ("near", "far"))
    followed = Followed(track[np.lexsort((sensor, time))], {"near": LOOKS, "far": LOOKS + 0.5})
    return dict(refined(GUESS, reports, followed).sensors)


def test_what_another_sensor_saw_meanwhile_was_hidden_from_this_one_alone() -> None:
    found = learned(far_sees=True)
    assert found["near"].detection_probability == pytest.approx(0.9, abs=0.03)
    assert found["near"].hidden_share == pytest.approx(0.4, abs=0.05)
    assert found["near"].mean_silence == pytest.approx(40.0, abs=3.0)
    assert found["far"].detection_probability == pytest.approx(0.9, abs=0.03)
    assert found["far"].hidden_share == 0.0


def test_what_no_sensor_saw_for_long_was_hidden() -> None:
    for each in learned(far_sees=False).values():
        assert each.detection_probability == pytest.approx(0.9, abs=0.03)


@pytest.mark.parametrize(("lasts", "told"), [(15, 1 - 1 / 15), (80, None)])
def test_those_who_come_and_soon_go_again_do_not_survive_for_long(lasts, told) -> None:
    rng = np.random.default_rng(2)
    time, place, track = [], [], []
    for number in range(120 if lasts < 30 else 40):
        begin = rng.integers(1 - lasts, 100)
        looks = LOOKS[max(begin, 0) : max(begin + lasts, 0)]
        looks = looks[rng.random(looks.size) < 0.95]
        time.append(looks)
        place.append(np.stack([10 * looks, np.full(looks.size, 100.0 * number)], axis=1))
        track.append(np.full(looks.size, number))
    time, track = np.concatenate(time), np.concatenate(track)
    places = np.concatenate(place) + rng.normal(0, 5, (time.size, 2))
    guess = replace(GUESS, sensors={"A": replace(SENSOR, covered=1e6, density=1e-7)})
    followed = Followed(track[np.argsort(time, kind="stable")], {"A": LOOKS})
    found = refined(guess, table(time, places), followed).survival
    assert found == (None if told is None else pytest.approx(told, abs=0.03))


def process_noise(*, is_wild: bool) -> float:
    """Return that of objects that go straight, of which three in twenty have bad transponders."""
    rng = np.random.default_rng(4)
    looks, number = np.arange(40.0), np.arange(20)
    start, velocity = rng.uniform(-2e4, 2e4, (20, 2)), rng.uniform(-15.0, 15.0, (20, 2))
    place = start + looks[:, None, None] * velocity
    noise = np.where(number < 3, 75.0, 5.0)
    place = place + noise[:, None] * rng.normal(size=place.shape)
    reports = table(np.repeat(looks, 20), place.reshape(-1, 2), names=("near",))
    followed = Followed(np.tile(number, 40), {"near": looks}, is_wild=is_wild)
    guess = Estimates({"near": SENSOR}, 0.01, 20.0, 1e-9, 1e-8)
    return refined(guess, reports, followed).process_noise


@pytest.mark.parametrize("is_wild", [True, False])
def test_bad_transponders_are_no_turns(is_wild: bool) -> None:
    assert process_noise(is_wild=is_wild) < 0.1


def test_a_stretch_holds_many_looks_of_each_of_many_sensors() -> None:
    rng = np.random.default_rng(1)
    n_looks, n_sensors, n_objects = 60, 5, 100
    shape = (n_looks, n_sensors, n_objects)
    look, sensor, number = (axis.ravel() for axis in np.indices(shape))
    start = rng.uniform(0, 1e5, (n_objects, 2))
    place = start[number] + 10.0 * look[:, None]
    reports = table(look + 0.1 * sensor, place, sensor, tuple("abcde"))
    stretch = stretch_of(reports)
    assert len(stretch) <= 1.1 * MOST_REPORTS
    for index in range(n_sensors):
        assert np.unique(stretch.time[stretch.sensor == index]).size >= LEAST_LOOKS - 2
    # It is a part of the plane, of whose objects all reports of its time are there.
    assert np.ptp(stretch.measurement[:, 0]) < 0.8 * np.ptp(reports.measurement[:, 0])


def test_few_looks_in_all_keep_a_part_of_the_objects() -> None:
    rng = np.random.default_rng(2)
    place = rng.uniform(0, 1e5, (6 * 2000, 2))
    stretch = stretch_of(table(np.repeat(np.arange(6.0), 2000), place))
    assert 0 < len(stretch) <= MOST_REPORTS
