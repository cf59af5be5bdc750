"""Tracks from before the first report."""

import numpy as np
import pytest

from trackweave.domain.frames import LocalFrame
from trackweave.domain.tracks import COASTING, CONFIRMED, TrackTable
from trackweave.errors import DataFormatError
from trackweave.io.frames_out import tracks_frame
from trackweave.io.tracks_in import covariance_names, read_priors, state_names


def tracks(dim: int = 2, n: int = 4) -> TrackTable:
    rng = np.random.default_rng(3)
    root = rng.normal(size=(n, 2 * dim, 2 * dim))
    return TrackTable(
        time=np.array([1.0, 2.0, 1.0, 2.0]),
        track=np.array([4, 4, 9, 9]),
        status=np.array([0, CONFIRMED, CONFIRMED, COASTING]),
        mean=rng.normal(size=(n, 2 * dim)) * 1e3,
        covariance=root @ root.transpose(0, 2, 1) + np.eye(2 * dim),
        score=rng.normal(size=n),
        hits=np.array([1, 2, 3, 3]),
        last_update=np.array([0.0, 1.0, 1.0, 1.0]),
    )


def rows(time: list[float], track: list[int], status: list[int]) -> TrackTable:
    n = len(time)
    return TrackTable(
        time=np.array(time),
        track=np.array(track),
        status=np.array(status),
        mean=np.zeros((n, 4)),
        covariance=np.tile(np.eye(4), (n, 1, 1)),
        score=np.zeros(n),
        hits=np.ones(n, dtype=int),
        last_update=np.array(time),
    )


def test_tracks_that_ended_do_not_come_back():
    # Track 1 ends three scans before the end, track 2 one scan before, track 3 lives.
    written = rows([0, 0, 0, 1, 1, 2, 3], [1, 2, 3, 2, 3, 3, 3], [CONFIRMED] * 7)
    assert read_priors(tracks_frame(written)).track.tolist() == [3]
    until_last = rows([0, 0, 1, 1, 2], [2, 3, 2, 3, 3], [CONFIRMED] * 5)
    assert read_priors(tracks_frame(until_last)).track.tolist() == [3]


def test_tracks_seen_at_different_times_of_the_last_turn_live():
    written = rows([0.0, 0.7, 4.0, 4.7, 8.0, 8.7], [1, 2] * 3, [CONFIRMED] * 6)
    assert read_priors(tracks_frame(written)).track.tolist() == [1, 2]


def test_one_row_for_each_track_keeps_all():
    written = rows([0.0, 5.0, 90.0], [1, 2, 3], [CONFIRMED, COASTING, CONFIRMED])
    assert read_priors(tracks_frame(written)).track.tolist() == [1, 2, 3]


def test_tentative_tracks_come_only_where_there_are_no_others():
    written = rows([0, 0, 1, 1], [1, 2, 1, 2], [0, 0, CONFIRMED, 0])
    assert read_priors(tracks_frame(written)).track.tolist() == [1]
    assert read_priors(tracks_frame(written).drop("status")).track.tolist() == [1, 2]
    unsure = rows([0, 0, 1, 1], [1, 2, 1, 2], [0, 0, 0, 0])
    assert read_priors(tracks_frame(unsure)).track.tolist() == [1, 2]


@pytest.mark.parametrize("dim", [2, 3])
def test_takes_the_last_row_of_each_track_as_it_was_written(dim):
    written = tracks(dim)
    priors = read_priors(tracks_frame(written).reverse())
    for name in TrackTable.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(priors, name), getattr(written, name)[[1, 3]])


def test_the_state_and_its_covariance_have_the_files_names():
    assert state_names(3) == ("x", "y", "z", "vx", "vy", "vz")
    assert covariance_names(2) == (
        "p_x_x", "p_x_y", "p_x_vx", "p_x_vy", "p_y_y", "p_y_vx", "p_y_vy", "p_vx_vx", "p_vx_vy",
        "p_vy_vy",
    )  # fmt: skip


def test_fills_what_a_table_need_not_have():
    table = tracks_frame(tracks()).drop("status", "score", "hits", "last_update")
    priors = read_priors(table)
    assert priors.status.tolist() == [CONFIRMED] * 2
    assert priors.score.tolist() == [0.0, 0.0]
    assert priors.hits.tolist() == [0, 0]
    assert priors.last_update.tolist() == priors.time.tolist()


def test_a_table_may_have_no_rows():
    assert len(read_priors(tracks_frame(tracks()).clear())) == 0


def test_tracks_of_another_plane_are_refused():
    here, there = LocalFrame(47.0, 8.0), LocalFrame(47.5, 8.0)
    table = tracks_frame(tracks(), here)
    assert len(read_priors(table, here)) == 2
    with pytest.raises(DataFormatError, match="on another plane than the reports"):
        read_priors(table, there)


@pytest.mark.parametrize(
    ("column", "value", "message"),
    [
        ("p_x_x", -1.0, r"row 2, column p_x_x: -1.0; expected the start of a positive definite"),
        ("p_x_y", 1e6, r"row 2, column p_x_x: .*; expected the start of a positive definite"),
        ("p_x_y", None, r"row 2, column p_x_y: \(empty\); expected a finite number"),
        ("vx", None, r"row 2, column vx: \(empty\); expected a finite number"),
        ("track", -1, r"row 2, column track: -1; expected a number from 0"),
        ("hits", -1, r"row 2, column hits: -1; expected a number from 0"),
        ("status", "lost", r"row 2, column status: lost; expected tentative, confirmed or"),
    ],
)
def test_says_what_is_wrong_with_a_row(column, value, message):
    table = tracks_frame(tracks())
    table = table.with_columns(table[column].scatter(1, value))
    with pytest.raises(DataFormatError, match=message):
        read_priors(table)


def test_needs_covariances():
    with pytest.raises(DataFormatError, match="column p_y_vx: missing; expected a tracks table"):
        read_priors(tracks_frame(tracks()).drop("p_y_vx"))
