"""Tests of where reports lie on the plan."""

import numpy as np

from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import TrackTable
from trackweave.plotting.run import picture_of_run
from trackweave.plotting.scene import Scene, paths_of_sensors, places_of_reports


def reports(kind: MeasurementKind, row: list[float], platform: list[float] | None) -> ReportTable:
    return ReportTable(
        np.zeros(1),
        np.zeros(1, dtype=np.int64),
        ("radar",),
        np.array([row]),
        np.full((1, len(row)), np.nan),
        np.array(["1"]),
        kinds=(kind,),
        space=2,
        platform=None if platform is None else np.array([platform]),
    )


def test_a_position_is_where_it_says() -> None:
    table = reports(MeasurementKind.POSITION, [3.0, 4.0], None)
    assert places_of_reports(table, {}).tolist() == [[3.0, 4.0]]


def test_a_range_and_azimuth_count_from_the_sensor() -> None:
    table = reports(MeasurementKind.RANGE_AZIMUTH, [10.0, np.pi / 2], None)
    found = places_of_reports(table, {"radar": (100.0, 50.0)})
    np.testing.assert_allclose(found, [[110.0, 50.0]], atol=1e-9)


def test_a_sensor_that_moves_counts_from_where_it_was() -> None:
    moving = [7.0, 8.0, np.nan, 0.0, 0.0, 0.0]
    table = reports(MeasurementKind.RANGE_AZIMUTH, [10.0, 0.0], moving)
    found = places_of_reports(table, {"radar": (100.0, 50.0)})
    np.testing.assert_allclose(found, [[7.0, 18.0]], atol=1e-9)


def test_an_elevation_shortens_the_way_over_the_ground() -> None:
    table = reports(MeasurementKind.RANGE_AZIMUTH_ELEVATION, [10.0, 0.0, np.pi / 3], None)
    found = places_of_reports(table, {"radar": (0.0, 0.0, 2.0)})
    np.testing.assert_allclose(found, [[0.0, 5.0]], atol=1e-9)


def test_what_has_no_place_has_none() -> None:
    found = places_of_reports(reports(MeasurementKind.BEARING, [1.0], None), {})
    assert np.isnan(found).all()


def test_a_range_from_nobody_knows_where_counts_from_the_origin_as_in_runs() -> None:
    found = places_of_reports(reports(MeasurementKind.RANGE_AZIMUTH, [10.0, 0.0], None), {})
    np.testing.assert_allclose(found, [[0.0, 10.0]], atol=1e-9)


def test_a_sensor_that_moves_leaves_a_path() -> None:
    n = 6
    platform = np.zeros((n, 6))
    platform[:, 0] = [0.0, 0.0, 5.0, np.nan, 5.0, 9.0]
    sensor = np.array([0, 0, 0, 0, 0, 1])
    table = ReportTable(
        np.arange(n, dtype=float),
        sensor,
        ("camera", "other"),
        np.zeros((n, 1)),
        np.full((n, 1), 0.01),
        np.arange(n).astype(str),
        kinds=(MeasurementKind.BEARING,) * 2,
        space=2,
        platform=platform,
    )
    paths = paths_of_sensors(table)
    assert paths["camera"].tolist() == [[0.0, 0.0], [5.0, 0.0]]
    assert paths["other"].tolist() == [[9.0, 0.0]]
    scene = Scene(table, TrackTable.empty(2))
    assert picture_of_run(scene).startswith(b"\x89PNG")
    assert picture_of_run(scene) != picture_of_run(Scene(None, TrackTable.empty(2), title=""))


def test_a_sensor_that_says_nothing_of_itself_leaves_none() -> None:
    assert paths_of_sensors(reports(MeasurementKind.BEARING, [1.0], None)) == {}
