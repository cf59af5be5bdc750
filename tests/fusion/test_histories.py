"""Sensors at periods of their own, that appear, vanish and return; correlated errors."""

import numpy as np
import pytest

from oracles.track_scenes import picture
from trackweave.errors import InvalidInputError
from trackweave.fusion.histories import Histories
from trackweave.fusion.pictures import LocalPicture
from trackweave.fusion.statistic import Statistic

HERE = (0.0, 0.0)


def histories(**parts: object) -> Histories:
    return Histories(Statistic(**parts), 0.1, 3.0, [])  # type: ignore[arg-type]


def fresh(held: Histories) -> list[int]:
    """Return how many tracks have an estimate in each slot, from the oldest on."""
    assert held.rings is not None
    return held.rings.is_fresh.sum(axis=0)[held.slots].tolist()


def test_a_slow_sensor_makes_slots_of_its_own_period() -> None:
    held = histories(length=9)
    for time in range(9):
        news = {"fast": picture("fast", float(time), {1: HERE})}
        if time % 4 == 0:
            news["slow"] = picture("slow", float(time), {1: HERE})
        held.take(float(time), news)
    # Complete at 0, 4 and 8 s; between them the fast one waits.
    assert fresh(held) == [2, 2, 2]
    assert [held.slot_time[slot] for slot in held.slots] == [0.0, 4.0, 8.0]


def test_sensors_that_take_turns_are_compared_once_both_have_reported() -> None:
    held = histories(length=9)
    for time in range(8):
        name = "AB"[time % 2]
        live = held.take(float(time), {name: picture(name, float(time), {1: HERE})})
    assert len(live.row) == 2
    # Until the second reports, the first makes a slot of its own.
    assert fresh(held) == [1, 2, 2, 2, 1]


def test_an_estimate_counts_once() -> None:
    held = histories()
    once = picture("A", 0.0, {1: HERE})
    held.take(0.0, {"A": once, "B": picture("B", 0.0, {1: HERE})})
    held.take(1.0, {"A": once, "B": picture("B", 1.0, {1: HERE})})
    assert fresh(held) == [2, 1]


def test_a_silent_sensor_keeps_its_tracks_for_some_of_its_periods() -> None:
    held = histories()
    for time in range(10):
        news = {"A": picture("A", float(time), {1: HERE})}
        if time < 3:
            # Every second, so it is missed after three more.
            news["B"] = picture("B", float(time), {5: HERE})
        live = held.take(float(time), news)
        assert len(live.row) == (2 if time <= 5 else 1), time
    held.take(9.5, {"B": picture("B", 9.5, {5: HERE})})
    assert held.sources["B"].row.shape == (1,)


def test_rows_are_made_as_they_are_needed_and_given_back() -> None:
    held = histories()
    for time in range(4):
        tracks = {k: (30.0 * k, 0.0) for k in range(100 * time, 100 * time + 150)}
        live = held.take(float(time), {"A": picture("A", float(time), tracks)})
        assert sorted(held.tracks(live).tolist()) == sorted(tracks)
        assert len(set(live.row.tolist())) == 150
    assert held.held.shape[0] == 256
    assert len(held.free) == 256 - 150


def test_a_full_memory_grows() -> None:
    held = histories(memory="full")
    for time in range(40):
        held.take(float(time), {"A": picture("A", float(time), {1: HERE})})
    assert fresh(held) == [1] * 40


def test_a_track_that_is_tracked_on_goes_on_in_its_row() -> None:
    held = histories()
    before = held.take(0.0, {"A": picture("A", 0.0, {1: HERE, 2: HERE})})
    after = held.take(1.0, {"A": picture("A", 1.0, {2: HERE, 3: HERE})})
    assert before.row[1] == after.row[0]
    assert held.owner[before.row[0]] == 1


@pytest.mark.parametrize(
    ("time", "news", "message"),
    [
        (-1.0, {}, "time: -1 s after 0 s; expected times that do not go back"),
        (1.0, {"A": picture("A", 2.0, {})}, "sensor A: tracks of 2 s at 1 s; expected none from"),
        (1.0, {"A": picture("A", -1.0, {})}, "sensor A: tracks of -1 s after those of 0 s"),
        (1.0, {"B": picture("C", 0.0, {})}, "pictures: 'B': .*; expected that sensor's Local"),
        (1.0, {"A": LocalPicture.empty("A", 1.0, 3)}, "tracks in 2 and in 3 dimensions"),
    ],
)
def test_refuses_times_that_go_back_and_pictures_that_do_not_fit(
    time: float, news: dict[str, LocalPicture], message: str
) -> None:
    held = histories()
    held.take(0.0, {"A": picture("A", 0.0, {1: HERE})})
    with pytest.raises(InvalidInputError, match=message):
        held.take(time, news)
    assert fresh(held) == [1]


def steady(noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a Kalman filter's covariances, predicted and updated, once they change no more."""
    moving = np.kron(np.array([[1.0, 1.0], [0.0, 1.0]]), np.eye(2))
    q = noise * np.kron(np.array([[1 / 3, 1 / 2], [1 / 2, 1.0]]), np.eye(2))
    after = np.eye(4)
    for _ in range(300):
        before = moving @ after @ moving.T + q
        gain = before[:, :2] @ np.linalg.inv(before[:2, :2] + 25.0 * np.eye(2))
        after = before - gain @ before[:2]
        after = (after + after.T) / 2.0
    return before, after


def test_common_noise_is_what_the_cross_covariance_of_equal_sensors_is() -> None:
    # The oracle: the recursion P_ij⁺ = (I − K H)(F P_ij Fᵀ + Q)(I − K H)ᵀ with the known gain.
    noise = 0.1
    before, after = steady(noise)
    moving = np.kron(np.array([[1.0, 1.0], [0.0, 1.0]]), np.eye(2))
    q = noise * np.kron(np.array([[1 / 3, 1 / 2], [1 / 2, 1.0]]), np.eye(2))
    keep = np.eye(4)
    keep[:, :2] -= before[:, :2] @ np.linalg.inv(before[:2, :2] + 25.0 * np.eye(2))
    cross = np.zeros((4, 4))
    held = histories(correlation="both")
    for time in range(30):
        state = LocalPicture("A", float(time), [1], np.zeros((1, 4)), after[None])
        held.take(float(time), {"A": state})
        assert held.sources["A"].common[0] == pytest.approx(cross, rel=1e-6, abs=1e-9)
        cross = keep @ (moving @ cross @ moving.T + q) @ keep.T
    # And the likeness is the mean squared correlation of successive independent errors.
    carried = keep @ moving
    apart = after - held.sources["A"].common[0]
    share = np.trace(np.linalg.inv(apart) @ carried @ apart @ carried.T) / 4.0
    assert held.rings is not None
    row = held.sources["A"].row[0]
    assert held.rings.likeness[row, held.slots[-1]] == pytest.approx(share, rel=1e-3)
