"""Results as data frames, and back."""

import numpy as np
import polars as pl
import pytest

from trackweave.domain.frames import LocalFrame
from trackweave.domain.tracks import TrackTable
from trackweave.domain.truth import TruthTable
from trackweave.formats.reading import read_reports
from trackweave.io.frames_out import assignments_frame, reports_frame, tracks_frame, truth_frame
from trackweave.io.tracks_in import read_priors
from trackweave.io.truth import read_truth

REPORTS = {
    "time": [0.0, 0.0, 1.5],
    "sensor": ["a", "b", "a"],
    "x": [1.0, 2.0, 3.0],
    "y": [0.1, 0.2, 1 / 3],
    "target": ["t", "", "t"],
}


def test_tracks_have_the_columns_of_the_interface():
    names = tracks_frame(TrackTable.empty(2)).columns
    assert names == [
        "time", "track", "status", "x", "y", "vx", "vy", "p_x_x", "p_x_y", "p_x_vx", "p_x_vy",
        "p_y_y", "p_y_vx", "p_y_vy", "p_vx_vx", "p_vx_vy", "p_vy_vy", "score", "hits",
        "last_update",
    ]  # fmt: skip
    geodetic = tracks_frame(TrackTable.empty(3), LocalFrame(0.0, 0.0), iso_time=True)
    assert geodetic.columns[3:12] == [
        "x", "y", "z", "lat", "lon", "alt_m", "vx", "vy", "vz"
    ]  # fmt: skip
    assert geodetic["time"].dtype == geodetic["last_update"].dtype == pl.Datetime("us", "UTC")


@pytest.mark.parametrize("dim", [2, 3])
def test_accelerations_stand_behind_the_covariances_where_they_are_known(dim: int):
    mean, pull = np.arange(1.0, 2 * dim + 1)[np.newaxis], np.arange(7.0, 7.0 + dim)[np.newaxis]
    one, time = np.ones(1, dtype=np.int64), np.zeros(1)
    table = TrackTable(
        time, one, one, mean, np.eye(2 * dim)[np.newaxis], time, one, time, acceleration=pull
    )
    frame = tracks_frame(table)
    names = ["ax", "ay", "az"][:dim]
    assert frame.columns[-3 - dim :] == [*names, "score", "hits", "last_update"]
    assert frame.select(names).row(0) == tuple(pull[0])
    # As tracks known beforehand they set out with positions and velocities alone.
    assert np.array_equal(read_priors(frame).mean, mean)


def test_what_is_known_of_being_there_stands_last_and_only_then():
    table = TrackTable(
        np.zeros(2), [1, 2], [1, 1], np.ones((2, 4)), np.stack([np.eye(4)] * 2), np.zeros(2),
        [1, 1], np.zeros(2), existence=[0.98765432, np.nan],
    )  # fmt: skip
    frame = tracks_frame(table)
    assert frame.columns[-2:] == ["last_update", "existence"]
    assert frame["existence"].to_list() == [0.987654, None]


def test_an_assignment_names_report_and_track_and_carries_the_rest():
    reports = read_reports(pl.DataFrame(REPORTS))
    frame = assignments_frame(reports, {0: 7, 2: 8})
    assert frame.columns == ["report", "time", "sensor", "track", "probability", "target"]
    assert frame.rows() == [
        (1, 0.0, "a", 7, None, "t"),
        (2, 0.0, "b", None, None, None),
        (3, 1.5, "a", 8, None, "t"),
    ]
    same = assignments_frame(reports, np.array([7, -1, 8]), np.array([0.5, np.nan, 1.0]))
    assert same["track"].to_list() == frame["track"].to_list()
    assert same["probability"].to_list() == [0.5, None, 1.0]


def test_no_report_may_belong_to_a_track():
    assert assignments_frame(read_reports(pl.DataFrame(REPORTS)), {})["track"].null_count() == 3


def test_carried_columns_give_way_to_ours():
    table = {**REPORTS, "track": [1, 2, 3], "reports_track": [4, 5, 6], "": [7, 8, 9]}
    frame = assignments_frame(read_reports(pl.DataFrame(table)), {})
    assert frame.columns[5:] == ["target", "reports_reports_track", "reports_track", ""]
    assert frame["reports_reports_track"].to_list() == [1, 2, 3]


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"sigma_x": [1.0, None, 2.0], "sigma_y": [1.0, None, 2.0], "scan": [1, 1, 2]},
        {"time": ["2024-05-01T00:00:00", "2024-05-01T00:00:00.25", "2024-05-01T00:00:01"]},
        {"z": [5.0, 6.0, 7.0], "note": ["u", None, "w"]},
    ],
)
def test_reports_read_back_as_they_were(more):
    reports = read_reports(pl.DataFrame({**REPORTS, **more}))
    again = read_reports(reports_frame(reports))
    for name in ("time", "sensor", "measurement", "sigma", "report"):
        np.testing.assert_array_equal(getattr(again, name), getattr(reports, name))
    assert again.iso_time == reports.iso_time
    assert again.carried["target"].tolist() == reports.carried["target"].tolist()
    assert (again.scan is None) == (reports.scan is None)


def test_reports_of_the_earth_read_back_to_the_millimetre():
    table = {"time": [0.0], "lat": [47.0], "lon": [8.2], "alt_m": [500.0]}
    reports = read_reports(pl.DataFrame(table), frame_origin=(47.5, 9.0))
    frame = reports_frame(reports)
    assert frame.columns == ["report", "time", "sensor", "lat", "lon", "alt_m"]
    again = read_reports(frame, frame_origin=(47.5, 9.0))
    np.testing.assert_allclose(again.measurement, reports.measurement, atol=1e-3)


@pytest.mark.parametrize("velocity", [None, [[1.0, 2.0], [3.0, 4.0]]])
def test_truth_reads_back_as_it_was(velocity):
    truth = TruthTable.from_columns([0.0, 1.0], ["a", "a"], [[1.0, 2.0], [3.0, 1 / 3]], velocity)
    again = read_truth(truth_frame(truth))
    np.testing.assert_array_equal(again.position, truth.position)
    assert (again.velocity is None) == (velocity is None)
