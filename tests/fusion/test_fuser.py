"""System tracks from several sensors, one update at a time."""

from collections.abc import Mapping

import numpy as np
import pytest

from trackweave.domain.tracks import COASTING, CONFIRMED
from trackweave.errors import InvalidInputError
from trackweave.filters.kalman import predicted
from trackweave.fusion.associator import TrackAssociator
from trackweave.fusion.bias import BiasModel
from trackweave.fusion.combine import COMBINATIONS, combine
from trackweave.fusion.fuser import FusedPicture, TrackFuser
from trackweave.fusion.pictures import LocalPicture
from trackweave.fusion.registration import Registration

SPREAD = np.diag([4.0, 4.0, 0.25, 0.25])


def picture(
    sensor: str, time: float, tracks: Mapping[int, float], error: float = 0.0
) -> LocalPicture:
    """Objects that go east at 10 m/s, each on its own parallel."""
    mean = np.array([[10.0 * time + error, north, 10.0, 0.0] for north in tracks.values()])
    return LocalPicture(
        sensor, time, np.array(list(tracks)), mean.reshape(-1, 4),
        np.tile(SPREAD, (len(tracks), 1, 1)),
    )  # fmt: skip


def fuser(**options: object) -> TrackFuser:
    associator = TrackAssociator(process_noise=0.1)
    return TrackFuser(associator, **options)  # type: ignore[arg-type]


def rng() -> np.random.Generator:
    return np.random.default_rng(1)


def step(tracker: TrackFuser, time: float, *pictures: LocalPicture) -> FusedPicture:
    return tracker.step(time, {each.sensor: each for each in pictures}, rng=rng())


def test_one_object_of_two_sensors_is_their_combination() -> None:
    tracker = fuser(combination="convex")
    first, second = picture("A", 0.0, {1: 0.0}, 1.0), picture("B", 0.0, {5: 0.0}, -1.0)
    found = step(tracker, 0.0, first, second)
    mean, covariance = combine(
        np.concatenate([first.mean, second.mean]), np.tile(SPREAD, (2, 1, 1)), "convex"
    )
    assert found.tracks.track.tolist() == [1]
    assert found.tracks.mean[0] == pytest.approx(mean)
    assert found.tracks.covariance[0] == pytest.approx(covariance)
    assert found.tracks.hits.tolist() == [2]
    assert found.tracks.score[0] < 0.0
    assert found.association.of("A") == {1: 1}
    assert found.association.of("B") == {5: 1}


def test_estimates_of_before_are_brought_to_the_time() -> None:
    tracker = fuser(combination="convex")
    old = picture("A", 0.0, {1: 0.0, 2: 500.0})
    step(tracker, 0.0, old, picture("B", 0.0, {5: 0.0}))
    found = step(tracker, 2.0, picture("B", 2.0, {5: 0.0}))
    assert len(found.tracks) == 2
    lone = found.tracks.track.tolist().index(found.association.of("A")[2])
    mean, covariance = predicted(old.mean[1:], old.covariance[1:], np.array([2.0]), 0.1)
    assert found.tracks.mean[lone] == pytest.approx(mean[0])
    assert found.tracks.covariance[lone] == pytest.approx(covariance[0])
    assert found.tracks.status[lone] == COASTING
    assert found.tracks.last_update[lone] == 0.0
    assert found.tracks.status[1 - lone] == CONFIRMED


def test_a_sensor_appears_vanishes_and_returns_and_objects_keep_their_numbers() -> None:
    tracker = fuser()
    numbers = []
    for time in range(30):
        pictures = [picture("A", float(time), {1: 0.0, 2: 500.0})]
        if 3 <= time < 10 or time >= 20:
            pictures.append(picture("B", float(time), {8: 500.0, 9: 0.0}))
        found = step(tracker, float(time), *pictures)
        numbers.append(sorted(found.tracks.track.tolist()))
        if time in {9, 29}:
            assert found.association.of("A") == {1: 1, 2: 2}
            assert found.association.of("B") == {9: 1, 8: 2}
        if time == 19:
            assert found.association.of("B") == {}
    assert numbers[0] == numbers[9] == numbers[19] == numbers[-1] == [1, 2]


def test_an_object_that_splits_without_news_goes_on() -> None:
    tracker = fuser()
    for time in range(4):
        apart = 40.0 * max(0, time - 1)
        found = step(
            tracker, float(time), picture("A", float(time), {1: 0.0}),
            picture("B", float(time), {5: apart}),
        )  # fmt: skip
    assert found.tracks.track.tolist() == [1, 2]
    lone = step(tracker, 5.0, picture("A", 5.0, {1: 0.0}))
    assert lone.tracks.last_update.tolist() == [5.0, 3.0]
    assert lone.tracks.status.tolist() == [CONFIRMED, COASTING]


def test_no_tracks_are_no_objects() -> None:
    tracker = fuser()
    found = step(tracker, 0.0, LocalPicture.empty("A", 0.0, 2), LocalPicture.empty("B", 0.0, 2))
    assert len(found.tracks) == 0
    assert found.tracks.dim == 2


@pytest.mark.parametrize("method", COMBINATIONS)
def test_every_combination_follows_the_object(method: str) -> None:
    tracker = fuser(combination=method)
    for time in range(12):
        pictures = [picture(name, float(time), {1: 0.0}) for name in ("A", "B")]
        found = step(tracker, float(time), *pictures)
    assert found.tracks.mean[0] == pytest.approx([110.0, 0.0, 10.0, 0.0], abs=1e-3)
    assert np.linalg.eigvalsh(found.tracks.covariance[0])[0] > 0.0


def test_information_matrix_is_what_one_filter_with_all_reports_says() -> None:
    # Two filters from one prior; each takes its own reports; a third takes all of them.
    draw = np.random.default_rng(2)
    tracker = fuser(combination="information-matrix")
    state = [(np.zeros(4), 1e4 * np.eye(4)) for _ in range(3)]
    noise = 9.0 * np.eye(2)
    pick = np.eye(2, 4)
    for time in range(1, 25):
        reports = [draw.normal([10.0 * time, 0.0], 3.0) for _ in range(2)]
        for place, taken in enumerate([[0], [1], [0, 1]]):
            mean, spread = predicted(state[place][0][None], state[place][1][None], np.ones(1), 0.1)
            mean, spread = mean[0], spread[0]
            for report in taken:
                gain = spread @ pick.T @ np.linalg.inv(pick @ spread @ pick.T + noise)
                mean = mean + gain @ (reports[report] - pick @ mean)
                spread = (np.eye(4) - gain @ pick) @ spread
            state[place] = mean, (spread + spread.T) / 2.0
        pictures = [
            LocalPicture(name, float(time), [1], state[place][0][None], state[place][1][None])
            for place, name in enumerate("AB")
        ]
        found = step(tracker, float(time), *pictures)
    # The first estimates were combined as if they shared no prior, which is forgotten by now.
    assert found.tracks.mean[0] == pytest.approx(state[2][0], abs=0.05)
    assert found.tracks.covariance[0] == pytest.approx(state[2][1], rel=0.02, abs=1e-3)


def test_information_matrix_counts_no_news_twice() -> None:
    tracker = fuser(combination="information-matrix")
    first = picture("A", 0.0, {1: 0.0})
    step(tracker, 0.0, first)
    found = step(tracker, 1.0)
    later = first.predicted(1.0, 0.1)
    assert found.tracks.covariance[0] == pytest.approx(later.covariance[0], rel=1e-4)
    assert found.tracks.mean[0] == pytest.approx(later.mean[0], rel=1e-4)


def test_a_registered_sensor_is_put_right_first() -> None:
    bias = np.array([100.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    shift = Registration(
        "A", "B", BiasModel(("translation",)), bias, 1e-4 * np.diag([1.0, 1, 0, 0, 0, 0]),
        np.empty((0, 2), dtype=np.int64), np.empty(0), 1.0,
    )  # fmt: skip
    pictures = [picture("A", 0.0, {1: 0.0}), picture("B", 0.0, {5: 0.0}, 100.0)]
    assert len(step(fuser(), 0.0, *pictures).tracks) == 2
    together = step(fuser(registrations={"B": shift}), 0.0, *pictures)
    assert len(together.tracks) == 1
    assert together.tracks.mean[0, 0] == pytest.approx(0.0, abs=1e-6)


def test_refuses_what_it_cannot_use_and_stays_as_it_was() -> None:
    with pytest.raises(InvalidInputError, match="combination"):
        TrackFuser(combination=3)  # type: ignore[arg-type]
    with pytest.raises(InvalidInputError, match="method"):
        TrackFuser(combination="mean")
    with pytest.raises(InvalidInputError, match="associator"):
        TrackFuser(associator=3)  # type: ignore[arg-type]
    with pytest.raises(InvalidInputError, match=r"registrations: .*C.*; expected"):
        TrackFuser(registrations={"C": 3})  # type: ignore[dict-item]
    tracker = fuser()
    step(tracker, 5.0, picture("A", 5.0, {1: 0.0}))
    with pytest.raises(InvalidInputError, match="go back"):
        step(tracker, 4.0, picture("A", 4.0, {1: 0.0}))
    with pytest.raises(InvalidInputError, match="pictures"):
        tracker.step(6.0, {"A": 3}, rng=rng())  # type: ignore[dict-item]
    assert step(tracker, 6.0, picture("A", 6.0, {1: 0.0})).tracks.hits.tolist() == [2]
