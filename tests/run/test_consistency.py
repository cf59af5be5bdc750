"""Tracks of one world: its clock, its plane, its units."""

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from oracles.local_tracks import sensor_table
from trackweave.domain.frames import LocalFrame
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.io.tracks_in import LocalTracks, read_local_tracks
from trackweave.run.consistency import on_one_plane, require_agreement

OBJECTS = {1: (0.0, 0.0), 2: (900.0, 400.0), 3: (-700.0, 1500.0)}
TIMES = [float(time) for time in range(10)]


def table(name: str = "a.csv", **options: object) -> LocalTracks:
    times = options.pop("times", TIMES)
    frame = sensor_table(np.random.default_rng(1), OBJECTS, times, **options)  # type: ignore[arg-type]
    return replace(read_local_tracks(frame), name=name)


def scaled(tracks: LocalTracks, factor: float, *, speeds: bool = True) -> LocalTracks:
    by = np.array([factor, factor, factor if speeds else 1.0, factor if speeds else 1.0])
    return tracks.with_states(
        tracks.tracks.mean * by, tracks.tracks.covariance * by[:, None] * by[None, :]
    )


def test_tracks_that_agree_pass() -> None:
    assert require_agreement({"A": table(), "B": table("b.csv")}) is None
    none = read_local_tracks(sensor_table(np.random.default_rng(1), OBJECTS, TIMES).clear())
    require_agreement({"A": table(), "B": none})


@pytest.mark.parametrize("tables", [{}, {"A": None}])
def test_refuses_fewer_than_two_sensors(tables: dict[str, object]) -> None:
    with pytest.raises(InvalidInputError, match="two sensors at least"):
        require_agreement({name: table() for name in tables})


def test_refuses_tables_without_any_tracks() -> None:
    none = read_local_tracks(sensor_table(np.random.default_rng(1), OBJECTS, TIMES).clear())
    with pytest.raises(DataFormatError, match="no tracks; expected some"):
        require_agreement({"A": none, "B": none})


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_refuses_positions_and_speeds_a_thousand_times_as_large(factor: float) -> None:
    with pytest.raises(
        DataFormatError, match=r"b\.csv, columns x, y, vx and vy: extent and speed"
    ):
        require_agreement({"A": table(), "B": scaled(table("b.csv"), factor)})


def test_refuses_positions_in_kilometres_beside_speeds_in_metres() -> None:
    wrong = scaled(table("b.csv"), 1e-3, speeds=False)
    with pytest.raises(
        DataFormatError, match=r"b\.csv, columns x and vx: tracks move 0\.001\d* times"
    ):
        require_agreement({"A": table(), "B": wrong})


@pytest.mark.parametrize("metres", [111_320.0, 60_000.0])
def test_refuses_degrees_beside_speeds_in_metres(metres: float) -> None:
    wrong = scaled(table("b.csv"), 1.0 / metres, speeds=False)
    with pytest.raises(
        DataFormatError, match=r"b\.csv, columns x and vx: .* as degrees do; expected metres"
    ):
        require_agreement({"A": table(), "B": wrong})


def test_a_sensor_that_sees_a_small_part_is_no_mistake_of_units() -> None:
    near = sensor_table(np.random.default_rng(2), {1: (0.0, 0.0), 2: (5.0, 5.0)}, TIMES)
    assert require_agreement({"A": table(), "B": read_local_tracks(near)}) is None


def test_refuses_times_that_do_not_overlap() -> None:
    late = table("b.csv", times=[100.0, 101.0])
    with pytest.raises(
        DataFormatError, match=r"b\.csv, column time: from 100 to 101 s, the other"
    ):
        require_agreement({"B": late, "A": table()})


def test_refuses_dates_beside_seconds_and_heights_beside_none() -> None:
    with pytest.raises(DataFormatError, match="column time: dates; expected seconds as in a"):
        require_agreement({"A": table(), "B": table("b.csv", iso_time=True)})
    flat = table("b.csv")
    high = flat.with_states(
        np.zeros((len(flat), 6)) + np.arange(len(flat))[:, None],
        np.tile(np.eye(6), (len(flat), 1, 1)),
    )
    with pytest.raises(DataFormatError, match="column z: tracks in 3 dimensions; expected 2"):
        require_agreement({"A": table(), "B": high})


def test_latitudes_bring_tables_of_different_planes_together() -> None:
    here, there = LocalFrame(60.0, 5.0), LocalFrame(60.3, 6.5)
    first = table(frame=here)
    # The same objects, as they are seen on another plane.
    latitude, longitude, _ = here.to_geodetic(first.tracks.mean[:, :2])
    place = there.to_plane(latitude, longitude, np.zeros(len(first)))[:, :2]
    ahead = here.to_geodetic(first.tracks.mean[:, :2] + first.tracks.mean[:, 2:])
    speed = there.to_plane(*ahead)[:, :2] - place
    second = replace(
        first.with_states(np.concatenate([place, speed], axis=1), first.tracks.covariance),
        name="b.csv",
    )
    assert np.abs(first.tracks.mean - second.tracks.mean).max() > 1e3
    moved, frame, notes = on_one_plane({"A": first, "B": second})
    assert frame is not None
    assert moved["A"].tracks.mean[:, :2] == pytest.approx(moved["B"].tracks.mean[:, :2], abs=1e-3)
    assert moved["A"].tracks.mean[:, 2:] == pytest.approx(moved["B"].tracks.mean[:, 2:], abs=0.05)
    assert np.linalg.det(moved["B"].tracks.covariance) == pytest.approx(
        np.linalg.det(first.tracks.covariance)
    )
    assert "plane" in notes[0]


def test_without_latitudes_everywhere_positions_stay_as_they_are() -> None:
    tables = {"A": table(), "B": table("b.csv", frame=LocalFrame(60.0, 5.0))}
    moved, frame, notes = on_one_plane(tables)
    assert frame is None
    assert moved["B"] is tables["B"]
    assert "not in a.csv" in notes[0]
    assert on_one_plane({"A": table(), "B": table("b.csv")})[2] == []


def test_refuses_positions_of_another_scale_than_latitudes() -> None:
    first = table(frame=LocalFrame(60.0, 5.0))
    with pytest.raises(DataFormatError, match=r"distances are 0\.001 times those of lat and lon"):
        on_one_plane({"A": first, "B": scaled(first, 1e-3)})


def test_pandas_tables_are_read_too() -> None:
    frame = sensor_table(np.random.default_rng(1), OBJECTS, TIMES)
    pandas = pytest.importorskip("pandas")
    found = read_local_tracks(pandas.DataFrame(frame.to_dict(as_series=False)))
    assert found.kind == "pandas"
    assert isinstance(frame, pl.DataFrame)
    assert len(found) == frame.height
