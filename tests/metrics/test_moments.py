"""Tests of laying tracks beside the truth."""

import numpy as np
import pytest

from trackweave.arrays import FloatArray
from trackweave.domain.tracks import TrackTable
from trackweave.domain.truth import TruthTable
from trackweave.errors import InvalidInputError
from trackweave.metrics.moments import Moments, align


def lone_truth(times: list[float]) -> TruthTable:
    return TruthTable.from_columns(times, ["a"] * len(times), [[0.0, 0.0]] * len(times))


def moving_track(times: list[float], name: str = "t") -> TruthTable:
    return TruthTable.from_columns(times, [name] * len(times), [[10.0 * t, 1.0] for t in times])


def track_table(times: list[float], statuses: list[int]) -> TrackTable:
    n = len(times)
    mean = np.array([[10.0 * time, 1.0, 10.0, 0.0] for time in times])
    same, ones = np.zeros(n), np.ones(n, dtype=np.int64)
    covariance = np.tile(np.eye(4), (n, 1, 1))
    return TrackTable(
        np.array(times), 7 * ones, np.array(statuses), mean, covariance, same, ones, same
    )


def seen(moments: Moments) -> dict[float, list[float]]:
    """Return the track's x at each time at which it is there."""
    first, places = moments.tracks.first, moments.tracks.position
    return {
        float(time): places[first[k] : first[k + 1], 0].tolist()
        for k, time in enumerate(moments.time)
        if first[k] < first[k + 1]
    }


def test_interpolates_linearly_between_rows() -> None:
    found = seen(align(lone_truth([0.0, 0.5, 1.0, 1.25]), moving_track([0.0, 1.0, 2.0]), None))
    assert found == {0.0: [0.0], 0.5: [5.0], 1.0: [10.0], 1.25: [12.5]}


def test_extrapolates_nothing() -> None:
    found = seen(align(lone_truth([0.0, 1.0, 2.0, 3.0, 4.0]), moving_track([1.0, 2.0, 3.0]), None))
    assert list(found) == [1.0, 2.0, 3.0]


def test_a_gap_longer_than_a_period_and_a_half_counts_as_missed() -> None:
    track = moving_track([0.0, 1.0, 2.0, 4.0, 5.0])
    found = seen(align(lone_truth([0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), track, None))
    assert list(found) == [0.0, 1.0, 2.0, 4.0, 5.0]


def test_bridges_as_long_a_gap_as_it_is_told() -> None:
    truth, track = lone_truth([0.0, 3.0, 6.0]), moving_track([0.0, 6.0])
    assert seen(align(truth, track, 6.0)) == {0.0: [0.0], 3.0: [30.0], 6.0: [60.0]}
    assert list(seen(align(truth, track, 5.9))) == [0.0, 6.0]
    assert list(seen(align(truth, track, 0.0))) == [0.0, 6.0]


def test_sensors_in_quick_turns_do_not_hide_the_period() -> None:
    times = sorted(4.0 * turn + offset for turn in range(4) for offset in (0.0, 0.1, 0.2))
    found = seen(align(lone_truth([0.0, 2.0, 6.0, 10.0]), moving_track(times), None))
    assert list(found) == [0.0, 2.0, 6.0, 10.0]


def two_tracks(first: list[float], second: list[float]) -> TruthTable:
    times = [*first, *second]
    names = ["t"] * len(first) + ["u"] * len(second)
    return TruthTable.from_columns(times, names, [[10.0 * t, 1.0] for t in times])


def irregular_times() -> list[float]:
    """Sectors of radars that are not in step end at gaps as of chance, the longest 0.5 s."""
    gaps = np.random.default_rng(1).exponential(0.1, 400).clip(0.02, 0.5)
    return [0.0, *np.cumsum(gaps).tolist()]


def n_seen(tracks: TruthTable, times: FloatArray) -> list[int]:
    """Return at how many of the times each track is there."""
    moments = align(lone_truth(times.tolist()), tracks, None)
    counts = np.bincount(moments.tracks.identity, minlength=moments.n_tracks)
    return [int(count) for count in counts]


def test_the_longer_gaps_of_sensors_out_of_step_are_bridged_where_no_track_has_a_row() -> None:
    rows = irregular_times()
    times = np.arange(0.0, rows[-1], 0.01)
    alone = n_seen(moving_track(rows), times)
    assert alone[0] < 0.9 * times.size  # which the next line is there to mend
    assert n_seen(two_tracks(rows, rows), times) == [times.size, times.size]


def test_a_dropout_of_one_track_counts_as_missed_however_irregular_the_rows() -> None:
    rows = irregular_times()
    lost = [time for time in rows if not 10.0 < time < 10.7]
    begin, end = max(t for t in rows if t <= 10.0), min(t for t in rows if t >= 10.7)
    times = np.arange(0.0, rows[-1], 0.01)
    inside = int(np.sum((times > begin) & (times < end)))
    assert n_seen(two_tracks(rows, lost), times) == [times.size, times.size - inside]


def test_a_lone_long_silence_of_all_tracks_counts_as_missed() -> None:
    rows = [*np.arange(0.0, 400.0), *np.arange(700.0, 1100.0)]
    found = align(lone_truth([10.5, 600.0, 1000.5]), two_tracks(rows, rows), None)
    assert np.diff(found.tracks.first).tolist() == [2, 0, 2]


def test_a_gap_of_the_only_track_that_lives_is_no_pause_of_the_file() -> None:
    rows = [0.0, 1.0, 2.0, 3.0, 4.0, 7.0, 8.0, 11.0, 12.0, 15.0, 16.0]
    found = align(lone_truth([3.5, 5.5, 9.5]), two_tracks(rows, [0.0, 1.0, 2.0, 3.0, 4.0]), None)
    assert np.diff(found.tracks.first).tolist() == [2, 0, 0]


def test_takes_times_as_equal_that_differ_in_the_last_digits() -> None:
    found = seen(align(lone_truth([0.3, 3 * 0.1]), moving_track([0.1 * 3]), None))
    assert found
    shifted = seen(align(lone_truth([1.0]), moving_track([0.0, 1.0 - 1e-9]), None))
    assert shifted[1.0] == pytest.approx([10.0])


def test_tentative_rows_do_not_count() -> None:
    table = track_table([0.0, 1.0, 2.0, 3.0], [0, 1, 2, 0])
    moments = align(lone_truth([0.0, 1.0, 2.0, 3.0]), table, None)
    assert list(seen(moments)) == [1.0, 2.0]
    assert moments.n_tracks == 1


def test_identifiers_may_be_numbers_or_text() -> None:
    truth = lone_truth([0.0, 1.0])
    by_number = align(truth, track_table([0.0, 1.0], [1, 1]), None)
    by_text = align(truth, moving_track([0.0, 1.0], "seven"), None)
    assert np.array_equal(by_number.tracks.position, by_text.tracks.position)
    assert np.array_equal(by_number.tracks.identity, by_text.tracks.identity)


def test_of_two_rows_at_one_time_the_last_counts() -> None:
    table = track_table([0.0, 1.0, 1.0], [1, 1, 1])
    table.mean[2, 0] = 77.0
    assert seen(align(lone_truth([0.0, 1.0]), table, None)) == {0.0: [0.0], 1.0: [77.0]}


def test_works_without_tracks() -> None:
    moments = align(lone_truth([0.0, 1.0]), TrackTable.empty(2), None)
    assert (len(moments), moments.n_tracks) == (2, 0)
    assert [moment.distance.shape for moment in moments] == [(1, 0), (1, 0)]


def test_refuses_other_dimensions_and_negative_gaps() -> None:
    space = TruthTable.from_columns([0.0], ["t"], [[0, 0, 0]])
    with pytest.raises(InvalidInputError, match="tracks: 3 dimensions"):
        align(lone_truth([0.0]), space, None)
    for gap in (-1.0, np.nan):
        with pytest.raises(InvalidInputError, match="max_gap"):
            align(lone_truth([0.0]), moving_track([0.0]), gap)
