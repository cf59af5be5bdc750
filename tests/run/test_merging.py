"""Reports that may be of two objects at once are found and counted."""

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

import trackweave
from trackweave.arrays import FloatArray
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import CONFIRMED, TENTATIVE, TrackTable
from trackweave.models.coverage import FieldOfView
from trackweave.models.rotation import Rotation
from trackweave.models.sensors import Sensor
from trackweave.run.merging import MOST_NEAR, merged_reports

RADAR = Sensor("A", sigma=10.0, detection_probability=0.9, scan_period=1.0)


def report_table(time: list[float], place: list[list[float]]) -> ReportTable:
    n = len(time)
    return ReportTable(
        time=np.array(time),
        sensor=np.zeros(n, np.int64),
        sensors=("A",),
        measurement=np.array(place),
        sigma=np.full((n, 2), np.nan),
        report=np.arange(n).astype(str).astype(object),
    )


def history(rows: list[tuple[float, int, float]], status: int = CONFIRMED) -> TrackTable:
    """Rows of time, track and x; all lie on the line y = 500."""
    time, track, x = (np.array(column) for column in zip(*rows, strict=True))
    n = len(rows)
    mean = np.stack([x, np.full(n, 500.0), np.zeros(n), np.zeros(n)], axis=-1)
    ones = np.ones(n, dtype=np.int64)
    return TrackTable(
        time, track, status * ones, mean, np.tile(np.eye(4), (n, 1, 1)), time, ones, time
    )


# At time 1 tracks 1 and 2 are 15 m apart, and one report is there for both.
REPORTS = report_table([0.0, 0.0, 1.0, 2.0, 2.0], [[x, 500.0] for x in (0, 40, 20, 0, 40)])
ASSIGNED = {0: 1, 1: 2, 2: 1, 3: 1, 4: 2}
ROWS = [
    (0.0, 1, 0.0),
    (0.0, 2, 40.0),
    (1.0, 1, 12.0),
    (1.0, 2, 27.0),
    (2.0, 1, 0.0),
    (2.0, 2, 40.0),
]


def found(tracks: TrackTable, sensor: Sensor = RADAR) -> dict[int, int]:
    return merged_reports(REPORTS, ASSIGNED, tracks, [sensor])


def test_one_report_where_two_tracks_meet_may_be_of_both() -> None:
    assert found(history(ROWS)) == {2: 2}


def test_tracks_farther_apart_than_two_sigmas_are_told_apart() -> None:
    assert len(found(history([*ROWS[:3], (1.0, 2, 33.0), *ROWS[4:]]))) == 0
    assert len(found(history(ROWS), replace(RADAR, sigma=7.0))) == 0


def test_noise_counts_along_each_axis() -> None:
    assert len(found(history(ROWS), replace(RADAR, sigma=(7.0, 90.0)))) == 0
    assert len(found(history(ROWS), replace(RADAR, sigma=(8.0, 1.0)))) == 1


def test_a_track_that_was_never_confirmed_is_no_second_object() -> None:
    assert len(found(history(ROWS, TENTATIVE))) == 0
    assert len(found(history([row for row in ROWS if row[1] == 1]))) == 0


def test_two_reports_are_of_two_objects() -> None:
    reports = report_table([0.0, 1.0, 1.0, 2.0], [[20.0, 500.0]] * 4)
    rows = [(float(time), track, 20.0) for time in range(3) for track in (1, 2)]
    merged = merged_reports(reports, {0: 1, 1: 1, 2: 2, 3: 2}, history(rows), [RADAR])
    assert merged == {0: 2, 3: 1}


def test_what_the_sensor_cannot_see_is_not_missed() -> None:
    near = FieldOfView(max_range=500.2)  # 500.14 m to track 1, 500.7 m to track 2
    assert len(found(history(ROWS), replace(RADAR, field_of_view=near))) == 0
    far = FieldOfView(max_range=600.0)
    assert len(found(history(ROWS), replace(RADAR, field_of_view=far))) == 1


def test_a_sensor_that_does_not_scan_misses_nothing() -> None:
    assert len(found(history(ROWS), replace(RADAR, scan_period=None))) == 0


def test_bearings_are_never_merged() -> None:
    table = replace(
        REPORTS,
        measurement=np.zeros((5, 1)),
        sigma=np.full((5, 1), np.nan),
        kinds=(MeasurementKind.BEARING,),
        space=2,
    )
    camera = Sensor("A", sigma=0.1, scan_period=1.0, measurement=MeasurementKind.BEARING)
    assert len(merged_reports(table, ASSIGNED, history(ROWS), [camera])) == 0


def test_of_a_turning_beam_a_report_of_the_same_turn_counts() -> None:
    # Sectors of an eighth of a turn end at 0.5, 1.0, …: the two reports are in different ones.
    reports = report_table([0.4, 0.6, 4.4, 8.4, 8.6], [[20.0, 500.0]] * 5)
    radar = replace(RADAR, scan_period=4.0, rotation=Rotation(4.0))
    rows = [(end, track, 20.0) for end in (0.5, 1.0, 4.5, 8.5, 9.0) for track in (1, 2)]
    merged = merged_reports(reports, {0: 1, 1: 2, 2: 1, 3: 1, 4: 2}, history(rows), [radar])
    assert merged == {2: 2}


def test_a_run_without_tracks_has_none() -> None:
    assert len(merged_reports(REPORTS, {}, TrackTable.empty(2), [RADAR])) == 0
    assert len(merged_reports(REPORTS, ASSIGNED, TrackTable.empty(2), [RADAR])) == 0


def crossing(resolution: float) -> tuple[pl.DataFrame, int]:
    """Two objects that cross at a flat angle, and a sensor that merges what is too near."""
    rng = np.random.default_rng(3)
    rows: list[tuple[float, float, float]] = []
    n_merged = 0

    def see(time: int, place: FloatArray) -> None:
        x, y = place + rng.normal(0.0, 10.0, 2)
        rows.append((float(time), float(x), float(y)))

    for time in range(40):
        places = np.array([[20.0 * time, 6.0 * (time - 20)], [20.0 * time, -6.0 * (time - 20)]])
        if np.hypot(*(places[0] - places[1])) < resolution:
            see(time, places.mean(axis=0))
            n_merged += 1
        else:
            for place in places:
                see(time, place)
    return pl.DataFrame(rows, schema=["time", "x", "y"], orient="row"), n_merged


@pytest.mark.parametrize("resolution", [0.0, 20.0])
def test_a_crossing_within_the_resolution_is_counted(resolution: float) -> None:
    table, n_merged = crossing(resolution)
    config = {
        "motion": {"process_noise": 0.05, "max_speed": 40.0},
        "sensors": {
            "default": {
                "sigma": 10.0,
                "detection_probability": 0.9,
                "clutter_per_scan": 0.1,
                "scan_period": 1.0,
            }
        },
    }
    totals = trackweave.track(table, config, rng=np.random.default_rng(1)).run["totals"]
    assert totals["tracks"] == 2
    assert abs(totals["merged_reports"] - n_merged) <= 1


def test_a_report_among_a_crowd_of_tracks_is_not_looked_at() -> None:
    others = [(1.0, track, 20.0) for track in range(2, 2 + MOST_NEAR)]
    assert len(found(history([(1.0, 1, 20.0), *others]))) == 0
    assert len(found(history([(1.0, 1, 20.0), *others[:-1]]))) == 1


def test_the_second_is_the_nearest_and_nobody_shares_two_reports_of_one_time() -> None:
    reports = report_table([0.0, 0.0], [[20.0, 500.0]] * 2)
    # Tracks 1 and 2 have the reports; 3 and 4 have none, and 3 is near to both.
    rows = [(0.0, 1, 0.0), (0.0, 2, 8.0), (0.0, 3, 6.0), (0.0, 4, 27.0)]
    assert merged_reports(reports, {0: 1, 1: 2}, history(rows), [RADAR]) == {0: -1, 1: 3}
    rows[3] = (0.0, 4, -18.0)
    assert merged_reports(reports, {0: 1, 1: 2}, history(rows), [RADAR]) == {0: 4, 1: 3}


def test_how_near_is_told_in_metres() -> None:
    # The tracks are 15 m apart, whatever the sensor's noise.
    for sensor in (RADAR, replace(RADAR, sigma=1.0)):
        assert merged_reports(REPORTS, ASSIGNED, history(ROWS), [sensor], 15.5) == {2: 2}
        assert merged_reports(REPORTS, ASSIGNED, history(ROWS), [sensor], 14.5) == {}


def test_two_tracks_share_reports_only_where_that_is_allowed() -> None:
    table, n_merged = crossing(20.0)
    table = table.with_columns(shared_with=pl.lit("mine"))
    config = {
        "motion": {"process_noise": 0.05, "max_speed": 40.0},
        "sensors": {
            "default": {
                "sigma": 10.0,
                "detection_probability": 0.9,
                "clutter_per_scan": 0.1,
                "scan_period": 1.0,
            }
        },
    }
    alone = trackweave.track(table, config).assignments
    assert alone["shared_with"].to_list() == ["mine"] * table.height
    both = trackweave.track(table, {**config, "lifecycle": {"merge": 20.0}}).assignments
    shared = both.filter(pl.col("shared_with").is_not_null())
    assert abs(shared.height - n_merged) <= 1
    assert (shared["shared_with"] != shared["track"]).all()
    assert set(shared["shared_with"]) <= set(both["track"].drop_nulls())
    assert both["reports_shared_with"].to_list() == ["mine"] * table.height
    assert both.drop("shared_with", "reports_shared_with").equals(alone.drop("shared_with"))
