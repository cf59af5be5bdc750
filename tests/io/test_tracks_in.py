"""All rows of a sensor's tracks."""

from pathlib import Path

import numpy as np
import polars as pl
import pytest

from oracles.local_tracks import sensor_table
from trackweave.domain.frames import LocalFrame
from trackweave.errors import DataFormatError
from trackweave.io.tracks_in import read_local_tracks

OBJECTS = {4: (0.0, 0.0), 2: (500.0, 0.0)}


def table(**options: object) -> pl.DataFrame:
    return sensor_table(np.random.default_rng(1), OBJECTS, [0.0, 1.0, 2.0], **options)  # type: ignore[arg-type]


def test_reads_every_row_by_time_then_track() -> None:
    frame = table()
    found = read_local_tracks(frame.reverse())
    assert found.tracks.time.tolist() == [0.0, 0.0, 1.0, 1.0, 2.0, 2.0]
    assert found.tracks.track.tolist() == [2, 4] * 3
    assert found.tracks.mean[0].tolist() == list(frame.row(1)[3:7])
    assert found.tracks.covariance[0, 0, 2] == frame["p_x_vx"][1]
    assert found.latitude is None
    assert (found.iso_time, found.n_left_out, found.is_tentative) == (False, 0, False)


def test_reads_files_with_dates_and_latitudes(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(
        table(frame=LocalFrame(50.0, 8.0), iso_time=True).with_columns(
            pl.col("time").dt.strftime("%Y-%m-%dT%H:%M:%SZ"), pl.col("last_update").cast(pl.String)
        ).write_csv()
    )  # fmt: skip
    found = read_local_tracks(path)
    assert found.iso_time
    assert found.name == str(path)
    assert found.latitude is not None
    assert found.latitude[0] == pytest.approx(50.0, abs=1e-3)


def test_tentative_rows_take_part_only_where_there_are_no_others() -> None:
    frame = table()
    some = frame.with_columns(status=pl.Series(["tentative", "coasting"] * 3))
    found = read_local_tracks(some)
    assert found.tracks.track.tolist() == [2, 2, 2]
    assert found.n_left_out == 3
    none = read_local_tracks(frame.with_columns(status=pl.lit("tentative")))
    assert none.is_tentative
    assert len(none) == 6


def test_a_table_without_rows_is_a_sensor_that_sees_nothing() -> None:
    found = read_local_tracks(table().clear())
    assert len(found) == 0
    assert found.tracks.dim == 2


def test_refuses_tracks_without_covariance() -> None:
    with pytest.raises(DataFormatError, match="column p_x_y: missing; expected a tracks table"):
        read_local_tracks(table().drop("p_x_y"))


def test_refuses_a_covariance_that_is_not_positive_definite() -> None:
    frame = table()
    frame[3, "p_x_x"] = -1.0
    with pytest.raises(DataFormatError, match=r"row 4, column p_x_x: -1\.0; expected the start"):
        read_local_tracks(frame)


def test_refuses_a_track_that_is_at_two_places_at_one_time() -> None:
    frame = table()
    frame[3, "track"] = 4
    with pytest.raises(
        DataFormatError, match="row 4, column track: 4; expected one row of a track"
    ):
        read_local_tracks(frame)
