"""The process noise that a tracker must have assumed."""

import numpy as np
import pytest

from trackweave.domain.tracks import TrackTable
from trackweave.filters.kalman import predicted
from trackweave.fusion.aging import assumed_process_noise


def filtered(noise: float, gaps: list[float], *, seen: float = 1.0, dim: int = 2) -> TrackTable:
    """Return the covariances of a Kalman filter of positions, at times so far apart."""
    rng = np.random.default_rng(4)
    pick = np.eye(dim, 2 * dim)
    spread = np.diag([100.0] * dim + [25.0] * dim)
    rows, mean = [spread], np.zeros((1, 2 * dim))
    for gap in gaps:
        spread = predicted(mean, spread[None], np.array([gap]), noise)[1][0]
        if rng.random() < seen:
            gain = spread @ pick.T @ np.linalg.inv(pick @ spread @ pick.T + 25.0 * np.eye(dim))
            spread = (np.eye(2 * dim) - gain @ pick) @ spread
        rows.append(spread)
    n = len(rows)
    time = np.concatenate([[0.0], np.cumsum(gaps)])
    return TrackTable(
        time, np.full(n, 7), np.ones(n, dtype=np.int64), np.zeros((n, 2 * dim)),
        np.array(rows), np.zeros(n), np.zeros(n, dtype=np.int64), time,
    )  # fmt: skip


@pytest.mark.parametrize("noise", [1e-3, 0.3, 40.0])
@pytest.mark.parametrize("dim", [2, 3])
def test_finds_what_a_kalman_filter_assumed(noise: float, dim: int) -> None:
    gaps = [1.0, 0.5, 2.0, 1.5] * 5
    assert assumed_process_noise(filtered(noise, gaps, dim=dim)) == pytest.approx(noise, rel=1e-3)


def test_misses_tell_it_too() -> None:
    tracks = filtered(0.3, [1.0] * 20, seen=0.5)
    assert assumed_process_noise(tracks) == pytest.approx(0.3, rel=1e-3)


def test_one_row_tells_nothing() -> None:
    assert assumed_process_noise(filtered(0.3, [])) is None
    assert assumed_process_noise(TrackTable.empty(2)) is None
