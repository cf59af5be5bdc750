"""Rows of tracks: of scans that end together the last word, and no more often than asked."""

import numpy as np
import pytest

from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.run.record import IN_A_BLOCK, Assigned, Rows


def rows(time: float, n_tracks: int) -> TrackTable:
    return TrackTable(
        time=np.full(n_tracks, time),
        track=np.arange(n_tracks),
        status=np.full(n_tracks, CONFIRMED),
        mean=np.zeros((n_tracks, 4)),
        covariance=np.zeros((n_tracks, 4, 4)),
        score=np.zeros(n_tracks),
        hits=np.ones(n_tracks, np.int64),
        last_update=np.full(n_tracks, time),
    )


def test_scans_that_end_together_give_one_row_per_track() -> None:
    collected = Rows()
    for time, n_tracks in [(0.0, 1), (1.0, 1), (1.0, 2), (2.0, 3)]:
        collected.add(rows(time, n_tracks), time)
    assert collected.table(2).time.tolist() == [0.0, 1.0, 1.0, 2.0, 2.0, 2.0]


@pytest.mark.parametrize(
    ("period", "times"),
    [
        (None, [0.0, 0.1, 0.2, 0.3, 0.4]),
        (0.2, [0.0, 0.2, 0.4]),
        (0.25, [0.0, 0.3, 0.4]),
        (9.0, [0.0, 0.4]),
    ],
)
def test_a_period_thins_the_rows(period: float | None, times: list[float]) -> None:
    collected = Rows(period)
    for step in range(5):
        collected.add(rows(step * 0.1, 1), step * 0.1)
    assert collected.table(2).time.tolist() == pytest.approx(times)


@pytest.mark.parametrize("period", [None, 0.25, 9.0])
def test_asks_for_the_rows_that_it_writes(period: float | None) -> None:
    collected, asked = Rows(period), []
    for step in range(5):
        wanted = collected.wants(step * 0.1, None if step == 4 else (step + 1) * 0.1)
        asked += [step * 0.1] * wanted
        collected.add(rows(step * 0.1, int(wanted)), step * 0.1)
    assert collected.table(2).time.tolist() == asked
    assert asked[-1] == pytest.approx(0.4)


def test_a_run_without_tracks_has_an_empty_table() -> None:
    assert len(Rows().table(3)) == 0


def test_reports_of_tracks_that_nobody_knows_become_false_alarms() -> None:
    assigned = Assigned(np.array([3, -1, 7, 3]), np.array([0.9, np.nan, 0.8, 0.7]))
    assigned.drop_all_but({3})
    assert assigned.track.tolist() == [3, -1, -1, 3]
    assert np.isnan(assigned.probability[2])


def test_rows_of_a_long_run_are_held_in_few_tables() -> None:
    collected, n_scans = Rows(), 2 * IN_A_BLOCK + 10
    for step in range(n_scans):
        collected.add(rows(float(step), 1), float(step))
    assert len(collected._blocks) + len(collected._parts) < IN_A_BLOCK
    assert collected.table(2).time.tolist() == list(range(n_scans))
