"""Where sensors stand may be told in degrees."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.config import load_configuration
from trackweave.domain.facts import Facts, Place
from trackweave.domain.frames import LocalFrame
from trackweave.domain.reports import ReportTable
from trackweave.errors import InvalidInputError
from trackweave.io.reports import reports_in
from trackweave.io.tables import RawTable
from trackweave.run.told_places import on_plane, standing, with_facts

RANGES = pl.DataFrame(
    {
        "time": np.arange(6.0),
        "sensor": ["A", "B"] * 3,
        "range_m": np.full(6, 9e3),
        "azimuth_deg": np.arange(6.0),
    }
)
FRAME = LocalFrame(54.0, 13.0)


def position_of(told: dict[str, object], name: str = "A", dim: int = 2) -> list[float]:
    return on_plane(load_configuration({"sensors": told}), FRAME, dim).sensor(name)["position"]


def test_a_place_in_degrees_becomes_a_position_on_the_plane() -> None:
    east, north = position_of({"A": {"place": [54.1, 13.0]}})
    assert abs(east) < 1.0
    assert north == pytest.approx(11_130, abs=20)
    assert position_of({"A": {"place": [54.0, 13.0, 25.0]}}, dim=3) == pytest.approx([0, 0, 25])


def test_a_place_for_all_gives_way_to_a_sensors_own_of_either_kind() -> None:
    told = {"default": {"place": [54.1, 13.0]}, "A": {"position": [1.0, 2.0]}, "B": {"sigma": 3.0}}
    assert position_of(told) == [1.0, 2.0]
    assert position_of(told, "B")[1] > 11_000
    told = {"default": {"position": [1.0, 2.0]}, "A": {"place": [54.1, 13.0]}}
    assert position_of(told)[1] > 11_000


@pytest.mark.parametrize("told", [[54.1, 13.2], [13.2, 54.1], [54.1, 13.2, 40.0]])
def test_a_position_in_degrees_is_refused(told: list[float]) -> None:
    with pytest.raises(InvalidInputError, match=r"sensors\.A\.position.*place = \[54\.1, 13\.2\]"):
        position_of({"A": {"position": told}})
    near_null_island = LocalFrame(0.1, 0.2)
    told_there = load_configuration({"sensors": {"A": {"position": [0.0, 0.0]}}})
    assert on_plane(told_there, near_null_island, 2) is told_there


def test_positions_that_seem_to_be_degrees_are_doubted() -> None:
    degrees = {"A": {"position": [54.1, 13.0]}, "B": {"position": [54.2, 13.1]}}
    metres = {"A": {"position": [54.0, 13.0]}, "B": {"position": [9e3, 40.0]}}
    notes = [tw.track(RANGES, {"sensors": told}).run["notes"] for told in (degrees, metres)]
    assert ["degrees are told as place" in " ".join(each) for each in notes] == [True, False]


def test_the_plane_of_ranges_lies_about_the_places_that_are_told() -> None:
    told = {"A": Place(54.0, 13.0), "B": Place(54.2, 13.4)}
    table = RawTable("x", RANGES, np.arange(1, 7), facts=Facts(places={"A": Place(1.0, 1.0)}))
    reports = reports_in(table, places=told)
    assert reports.frame is not None
    assert (reports.frame.latitude_deg, reports.frame.longitude_deg) == (54.1, 13.2)
    assert reports.facts.places["A"] == Place(1.0, 1.0)  # what the recording tells stays apart


def test_what_the_file_tells_comes_before_the_recording() -> None:
    facts = Facts(places={"A": Place(54.0, 13.0), "B": Place(54.0, 13.1)})
    table = RawTable("x", RANGES, np.arange(1, 7), facts=facts)
    told = load_configuration({"sensors": {"A": {"place": [54.1, 13.0]}}})
    filled = with_facts(told, reports_in(table, places=told.places()))
    assert filled.sensor("A")["position"][1] - filled.sensor("B")["position"][1] > 11_000
    assert "place" not in filled.sensor("A")


def test_a_run_lays_its_tracks_on_the_earth_where_places_are_told() -> None:
    sensors = {"A": {"place": [54.0, 13.0]}, "B": {"place": [54.2, 13.4]}}
    result = tw.track(RANGES, config={"sensors": sensors})
    assert result.run["input"]["frame_origin"] == [54.1, 13.2]
    assert set(result.run["configuration"]["sensors"]["A"]) & {"place", "position"} == {"position"}


def test_the_place_of_an_only_radar_may_be_told_for_all() -> None:
    one = RANGES.with_columns(sensor=pl.lit("025/011"))
    result = tw.track(one, config={"sensors": {"default": {"place": [54.0, 13.0]}}})
    assert result.run["input"]["frame_origin"] == [54.0, 13.0]
    position = result.run["configuration"]["sensors"]["025/011"]["position"]
    assert position == pytest.approx([0.0, 0.0], abs=1e-3)


def test_a_place_on_a_plane_of_its_own_is_refused_with_what_would_help() -> None:
    told = load_configuration({"sensors": {"A": {"place": [54.0, 13.0]}}})
    with pytest.raises(InvalidInputError, match=r"sensors.A.place: told in degrees, while x, y"):
        on_plane(told, None, 2)


@pytest.mark.parametrize("place", [[91, 0], [0, 361], [1], [1, 2, 3, 4]])
def test_what_is_no_place_is_refused(place: list[float]) -> None:
    with pytest.raises(InvalidInputError, match=r"sensors.A.place: .*; expected \[latitude, lon"):
        load_configuration({"sensors": {"A": {"place": place}}})


def test_a_sensor_has_one_place() -> None:
    with pytest.raises(InvalidInputError, match="position or place, not both"):
        load_configuration({"sensors": {"A": {"place": [1, 2], "position": [0, 0]}}})


def placed_in_rows(**columns: object) -> ReportTable:
    """Return forty reports of two sensors that say in each row where they are."""
    table = pl.DataFrame(
        {
            "time": np.arange(40.0),
            "sensor": ["A", "B"] * 20,
            "range_m": np.full(40, 9e3),
            "azimuth_deg": np.arange(40.0),
            "sensor_x": [100.0, -200.0] * 20,
            "sensor_y": [50.0, 0.0] * 20,
            **columns,
        }
    )
    return reports_in(RawTable("x", table, np.arange(1, 41)))


def test_a_sensor_that_stands_need_not_be_told_by_a_configuration() -> None:
    nothing = load_configuration({})
    found = standing(placed_in_rows(sensor_z=[7.0, 0.0] * 20), nothing)
    assert found.platform is None
    told = with_facts(nothing, found)
    assert told.sensor("A")["position"] == [100.0, 50.0, 7.0]
    assert told.sensor("B")["position"] == [-200.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        ({"sensor_x": [float(n) for n in range(40)]}, {}),
        ({"sensor_vx": [3.0] * 40}, {}),
        ({}, {"default": {"position": [0.0, 0.0]}}),
    ],
    ids=["moves", "has a speed", "told besides"],
)  # fmt: skip
def test_what_rows_say_stays_where_they_differ_or_more_is_told(columns, told) -> None:
    table = placed_in_rows(**columns)
    found = standing(table, load_configuration({"sensors": told}))
    # Sensor B of the first stands.
    kept = slice(0, None, 2)
    assert found.platform is not None
    np.testing.assert_array_equal(found.platform[kept], table.platform[kept])
    assert "A" not in found.facts.positions
