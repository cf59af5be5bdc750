"""Tests of the share of reports assigned rightly."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackweave.errors import InvalidInputError
from trackweave.metrics.assignments import assignment_quality

PAIRS = st.lists(
    st.tuples(st.sampled_from(["", "a", "b", "c"]), st.sampled_from([None, 1, 2, 3])), max_size=12
)


@given(PAIRS)
def test_agrees_with_all_namings(pairs: list[tuple[str, int | None]]) -> None:
    found = assignment_quality([pair[0] for pair in pairs], [pair[1] for pair in pairs])
    best = 0
    for named in itertools.permutations([1, 2, 3]):
        track_of = dict(zip("abc", named, strict=True))
        best = max(best, sum(track_of.get(target) == track for target, track in pairs if target))
    n_empty = pairs.count(("", None))
    assert found.right_share == (pytest.approx((best + n_empty) / len(pairs)) if pairs else None)


def test_values_computed_by_hand() -> None:
    targets = ["a", "a", "a", "b", "b", "", "", "b"]
    tracks = [1, 1, 2, 2, 2, None, 2, None]
    found = assignment_quality(targets, tracks)
    assert found.n_reports == 8
    assert found.right_share == pytest.approx(5 / 8)
    assert found.idf1 == pytest.approx(2 * 4 / (6 + 6))
    assert found.purity == pytest.approx((2 + 2) / 6)


def test_mota_of_reports_counts_misses_false_alarms_and_switches() -> None:
    targets = ["a", "b", "a", "", "b", "a", "", "a"]
    tracks = [1, 2, 1, 2, None, 3, None, 1]
    found = assignment_quality(targets, tracks)
    # Target a goes from 1 to 3 and back; b is missed once; one false alarm is on a track.
    assert found.switches == 2
    assert found.mota == pytest.approx(1 - (1 + 1 + 2) / 6)


def test_a_false_alarm_between_is_no_switch() -> None:
    found = assignment_quality(["a", "", "a", "a"], [5, 6, None, 5])
    assert found.switches == 0


def test_mota_without_targets_is_none() -> None:
    assert assignment_quality(["", ""], [1, None]).mota is None


def test_two_tracks_cannot_both_be_a_targets_own() -> None:
    found = assignment_quality(["a", "a", "a", "a"], [1, 1, 2, 2])
    assert found.right_share == pytest.approx(1 / 2)
    assert found.purity == pytest.approx(1.0)


def test_knows_every_way_to_say_nobody() -> None:
    nobody = [None, "", np.nan, -1]
    found = assignment_quality(nobody, [-1, np.nan, "", None])
    assert (found.right_share, found.idf1, found.purity) == (1.0, None, None)


def test_takes_arrays_of_numbers_and_of_text() -> None:
    found = assignment_quality(np.array([4, 4, -1]), np.array(["x", "x", ""], dtype=object))
    assert found.right_share == pytest.approx(1.0)


def test_nothing_is_none() -> None:
    assert assignment_quality([], []).right_share is None


def test_refuses_columns_of_different_length() -> None:
    with pytest.raises(InvalidInputError, match="tracks: 1 values; expected 2"):
        assignment_quality(["a", "b"], [1])
