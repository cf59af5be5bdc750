"""True positions, tracks and assignments as ``evaluate`` reads them."""

import numpy as np
import polars as pl
import pytest

from trackweave.domain.frames import LocalFrame
from trackweave.errors import DataFormatError
from trackweave.io.truth import (
    read_assignments,
    read_tracks,
    read_truth,
    read_truth_on_plane,
)

TRUTH = {"time": [1.0, 0.0, 1.0], "target": ["b", "a", "a"], "x": [1.0, 2.0, 3.0], "y": [0.0] * 3}
TRACKS = {
    "time": [0.0, 1.0, 2.0],
    "track": [5, 5, 5],
    "status": ["tentative", "confirmed", "coasting"],
    "x": [0.0, 1.0, 2.0],
    "y": [0.0, 1.0, 2.0],
}


def test_reads_truth_sorted_by_time_then_target():
    truth = read_truth(pl.DataFrame(TRUTH))
    assert truth.time.tolist() == [0.0, 1.0, 1.0]
    assert truth.target.tolist() == ["a", "a", "b"]
    assert truth.position[:, 0].tolist() == [2.0, 3.0, 1.0]
    assert truth.velocity is None


def test_reads_velocities_when_every_row_has_them():
    truth = read_truth(pl.DataFrame({**TRUTH, "vx": [1.0, 2.0, 3.0], "vy": [4, 5, 6]}))
    assert truth.velocity.tolist() == [[2.0, 5.0], [3.0, 6.0], [1.0, 4.0]]
    assert read_truth(pl.DataFrame({**TRUTH, "vx": [1.0, 2.0, 3.0]})).velocity is None


def test_iso_times_become_seconds_from_1970():
    days = ["1970-01-03", "1970-01-02", "1970-01-03"]
    assert read_truth(pl.DataFrame({**TRUTH, "time": days})).time[0] == 86_400.0


def test_truth_in_latitudes_is_laid_on_the_plane_of_the_tracks():
    geodetic = {"lat": [47.0, 47.1, 47.2], "lon": [8.0] * 3}
    truth = {**{name: TRUTH[name] for name in ("time", "target")}, **geodetic}
    frame = read_truth_on_plane(pl.DataFrame(truth))[1]
    assert frame == LocalFrame(47.1, 8.0)
    assert read_truth_on_plane(pl.DataFrame(TRUTH))[1] is None
    there = read_truth(pl.DataFrame(truth), frame)
    tracks = read_tracks(pl.DataFrame({**TRACKS, **geodetic}), frame)
    np.testing.assert_allclose(there.position[0], [0.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(tracks.position[0], [0.0, 0.0], atol=1e-6)
    with pytest.raises(DataFormatError, match="column lat: missing; expected latitudes, because"):
        read_tracks(pl.DataFrame(TRACKS), frame)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"target": ["a", "a", "a"]},
            "row 3, column target: a; expected one row of a target",
        ),
        ({"target": ["a", "", "a"]}, r"row 2, column target: \(empty\); expected an identifier"),
        ({"x": [0.0, 1.0, None]}, r"row 3, column x: \(empty\); expected a finite number"),
        ({"vx": [1.0, 2.0, "q"], "vy": ["1"] * 3}, "row 3, column vx: q; expected a finite"),
    ],
)
def test_says_what_is_wrong_with_truth(change, message):
    with pytest.raises(DataFormatError, match=f"table, {message}"):
        read_truth(pl.DataFrame({**TRUTH, **change}, strict=False))


def test_truth_must_have_rows_and_its_columns():
    with pytest.raises(DataFormatError, match="no data rows"):
        read_truth(pl.DataFrame(TRUTH).clear())
    with pytest.raises(DataFormatError, match="column target: missing; expected identifiers"):
        read_truth(pl.DataFrame(TRUTH).drop("target"))


def test_tentative_rows_claim_nothing():
    tracks = read_tracks(pl.DataFrame(TRACKS))
    assert tracks.time.tolist() == [1.0, 2.0]
    assert tracks.target.tolist() == ["5", "5"]


def test_every_row_counts_where_there_is_no_status():
    assert len(read_tracks(pl.DataFrame(TRACKS).drop("status"))) == 3


def test_a_tentative_row_may_stand_beside_a_confirmed_one():
    tracks = pl.DataFrame({**TRACKS, "time": [1.0, 1.0, 2.0]})
    assert len(read_tracks(tracks)) == 2


def test_tracks_may_have_no_rows():
    assert len(read_tracks(pl.DataFrame(TRACKS).clear())) == 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"status": ["x"] * 3}, "row 1, column status: x; expected tentative, confirmed or"),
        (
            {"time": [0.0, 1.0, 1.0]},
            "row 3, column track: 5; expected one row of a track",
        ),
    ],
)
def test_says_what_is_wrong_with_tracks(change, message):
    with pytest.raises(DataFormatError, match=f"table, {message}"):
        read_tracks(pl.DataFrame({**TRACKS, **change}))


def test_reads_assignments_with_and_without_targets():
    table = {"report": [1, 2], "track": [7, None], "target": ["a", None]}
    assignments = read_assignments(pl.DataFrame(table))
    assert assignments.report.tolist() == ["1", "2"]
    assert assignments.track.tolist() == ["7", ""]
    assert assignments.target.tolist() == ["a", ""]
    assert read_assignments(pl.DataFrame(table).drop("target")).target is None


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"report": [1]}, "column track: missing"),
        ({"track": [1]}, "column report: missing"),
        ({"report": [1, 1], "track": [1, 2]}, "row 2, column report: 1; expected an identifier"),
    ],
)
def test_says_what_is_wrong_with_assignments(table, message):
    with pytest.raises(DataFormatError, match=f"table, {message}"):
        read_assignments(pl.DataFrame(table))
