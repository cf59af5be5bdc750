"""What a track learned: the reports themselves, where a Kalman filter made it."""

import numpy as np
import pytest

from trackweave.filters.kalman import predicted, updated
from trackweave.fusion.learning import learned
from trackweave.fusion.pictures import LocalPicture

SIGMA, NOISE = 10.0, 0.5


def followed(n_times: int, *, seen: tuple[int, ...] = ()) -> tuple[list[LocalPicture], np.ndarray]:
    rng = np.random.default_rng(1)
    reports = rng.normal(size=(n_times, 1, 2)) * 100.0
    track = np.zeros((1, 4)), np.diag([1e4, 1e4, 1e2, 1e2])[None]
    pictures = []
    for k, report in enumerate(reports):
        track = predicted(*track, np.full(1, 2.0), NOISE)
        if not seen or k in seen:
            track = updated(*track, report, np.full((1, 2), SIGMA))
        mean, spread = track
        pictures.append(
            LocalPicture("A", 2.0 * k, [7], mean, (spread + spread.swapaxes(1, 2)) / 2)
        )
    return pictures, reports


def test_what_a_filter_learned_is_the_report_it_took() -> None:
    pictures, reports = followed(6)
    facts = learned(pictures, NOISE)
    assert facts.picture.tolist() == list(range(6))
    assert facts.mean[1:, :2] == pytest.approx(reports[1:, 0], abs=1e-6)
    wanted = np.zeros((5, 4, 4))
    wanted[:, [0, 1], [0, 1]] = SIGMA**-2
    assert facts.information[1:] == pytest.approx(wanted, abs=1e-9)


def test_a_track_that_coasts_learns_nothing() -> None:
    pictures, _ = followed(6, seen=(0, 1, 2, 5))
    information = learned(pictures, NOISE).information
    assert np.abs(information[3:5]).max() == 0.0
    assert np.abs(information[5]).max() == pytest.approx(SIGMA**-2)


def test_a_track_that_begins_brings_all_that_it_knows() -> None:
    pictures, _ = followed(2)
    facts = learned(pictures, NOISE)
    assert facts.mean[0] == pytest.approx(pictures[0].mean[0])
    assert facts.information[0] @ pictures[0].covariance[0] == pytest.approx(np.eye(4))


def test_a_track_that_was_away_learned_since_it_was_last_there() -> None:
    pictures, _ = followed(4)
    without = [pictures[0], LocalPicture.empty("A", 2.0, 2), *pictures[2:]]
    facts = learned(without, NOISE)
    # Two reports between pictures 0 and 2, one of them two seconds old.
    assert facts.picture.tolist() == [0, 2, 3]
    assert 1.0 < facts.information[1, 0, 0] * SIGMA**2 < 2.0


def test_a_wrong_process_noise_does_not_shift_what_was_learned() -> None:
    rng = np.random.default_rng(2)
    ends = []
    for _ in range(200):
        track = np.array([[0.0, 0.0, 10.0, 0.0]]), np.diag([100.0, 100.0, 25.0, 25.0])[None]
        pictures = [LocalPicture("A", 0.0, [1], *track)]
        for k in range(1, 4):
            track = predicted(*track, np.ones(1), NOISE)
            report = np.array([[10.0 * k, 0.0]]) + 10.0 * rng.normal(size=(1, 2))
            track = updated(*track, report, np.full((1, 2), SIGMA))
            pictures.append(LocalPicture("A", float(k), [1], *track))
        ends.append(learned(pictures, 10.0 * NOISE).mean[-1, :2])
    assert np.mean(ends, axis=0) == pytest.approx([30.0, 0.0], abs=3.0)


def test_units_worlds_apart_do_no_harm() -> None:
    spread = np.diag([1e12, 1e12, 1e-6, 1e-6])[None]
    spread[0, 0, 1] = spread[0, 1, 0] = 1e12 * (1.0 - 1e-12)
    state = np.zeros((1, 4))
    pictures = [LocalPicture("A", time, [1], state, spread) for time in (0.0, 1.0)]
    assert np.isfinite(learned(pictures, NOISE).information).all()
