"""Tests of each target's own record."""

import numpy as np
import pytest
from hypothesis import given

from metrics.test_pairing_over_time import moments, on_line, scenes
from oracles import metrics as oracle
from trackweave.domain.truth import TruthTable
from trackweave.metrics.clear_mot import clear_mot
from trackweave.metrics.moments import align
from trackweave.metrics.pairing import pair_over_time
from trackweave.metrics.targets import TargetRecord, target_records

CUTOFF = 10.0


def records(truth: oracle.Rows, tracks: oracle.Rows) -> tuple[TargetRecord, ...]:
    found = moments(truth, tracks)
    return target_records(found, pair_over_time(found, CUTOFF))


@given(scenes())
def test_records_add_up_to_clear_mot(scene: tuple[oracle.Rows, oracle.Rows]) -> None:
    whole, parts = clear_mot(moments(*scene), CUTOFF), records(*scene)
    assert sum(part.switches for part in parts) == whole.switches
    assert sum(part.fragmentations for part in parts) == whole.fragmentations
    assert sum(part.tracked_positions for part in parts) == whole.n_pairs
    assert sum(part.positions for part in parts) == whole.n_pairs + whole.n_missed
    squares = sum((part.rmse or 0.0) ** 2 * part.tracked_positions for part in parts)
    assert squares == pytest.approx((whole.rmse or 0.0) ** 2 * whole.n_pairs)


def test_names_the_tracks_in_the_order_in_which_they_followed() -> None:
    (record,) = records(on_line(*"aaaaaa"), on_line("y", "y", "", "x", "y", "y"))
    assert record.tracks == ("y", "x")
    assert (record.switches, record.fragmentations) == (2, 1)
    assert (record.positions, record.tracked_positions) == (6, 5)
    assert record.covered == pytest.approx(5 / 6)
    assert record.completeness == "mostly tracked"
    assert record.rmse == 0.0


def test_time_counts_where_both_ends_of_an_interval_do() -> None:
    (record,) = records(on_line(*"aaaaaa"), on_line("y", "y", "", "x", "y", "y"))
    assert (record.first_time, record.last_time) == (0.0, 5.0)
    assert (record.time_present, record.time_tracked) == (5.0, 3.0)


def test_time_away_is_neither_present_nor_missed() -> None:
    names = "a", "a", "a", "", "", "a", "a"
    (record,) = records(on_line(*names), on_line(*(name and "x" for name in names)))
    assert (record.first_time, record.last_time) == (0.0, 6.0)
    assert (record.time_present, record.time_tracked) == (3.0, 3.0)
    assert record.covered == 1.0
    assert record.fragmentations == 0


@pytest.mark.parametrize(
    ("n_tracked", "word"),
    [(0, "mostly lost"), (1, "mostly lost"), (2, "partly tracked"), (7, "partly tracked"),
     (8, "mostly tracked"), (10, "mostly tracked")],
)  # fmt: skip
def test_completeness_is_a_word_for_a_share(n_tracked: int, word: str) -> None:
    tracks = on_line(*"x" * n_tracked, *[""] * (10 - n_tracked))
    (record,) = records(on_line(*"a" * 10), tracks)
    assert record.completeness == word
    assert (record.rmse is None) == (n_tracked == 0)


def test_targets_come_in_order_with_their_own_errors() -> None:
    truth = {time: {"b": (0.0, 0.0), "a": (100.0, 0.0)} for time in range(3)}
    tracks = {time: {"x": (3.0, 0.0), "y": (100.0, 4.0)} for time in range(3)}
    first, second = records(truth, tracks)
    assert (first.target, first.rmse, first.tracks) == ("a", 4.0, ("y",))
    assert (second.target, second.rmse, second.tracks) == ("b", 3.0, ("x",))


def test_tracks_of_numbers_keep_their_names() -> None:
    truth = TruthTable.from_columns([0.0, 1.0], [7, 7], np.zeros((2, 2)))
    tracks = TruthTable.from_columns([0.0, 1.0], [31, 31], np.zeros((2, 2)))
    found = align(truth, tracks, None)
    (record,) = target_records(found, pair_over_time(found, CUTOFF))
    assert record.as_dict()["tracks"] == ["31"]
    assert record.as_dict()["target"] == "7"
