"""Particles linked in one line, as those know who come from trackpy."""

import json

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

import trackweave as tw
from trackweave.errors import InvalidInputError
from trackweave.metrics import assignment_quality


def wandering(n_frames: int = 20) -> tuple[pl.DataFrame, list[int]]:
    """Four particles far from one another, one of them unseen once, in no order."""
    rng = np.random.default_rng(2)
    rows = []
    for number in range(4):
        place = np.array([100.0 * number, 50.0])
        for frame in range(n_frames):
            place = place + rng.normal(0.0, 1.0, 2)
            if not (number == 2 and frame == 7):
                rows.append((frame, *place, number))
    order = rng.permutation(len(rows))
    table = pl.DataFrame([rows[k] for k in order], ["frame", "x", "y", "true"], orient="row")
    return table.drop("true"), table["true"].to_list()


@pytest.mark.parametrize(
    "make",
    [lambda t: t, lambda t: pd.DataFrame(t.to_dict(as_series=False)), pl.DataFrame.to_arrow],
)
def test_each_row_gets_its_particle_in_the_table_that_came(make):
    table, true = wandering()
    given = make(table)
    found = tw.link(given, search_range=5.0, memory=1)
    assert type(found) is type(given)
    particle = (
        found["particle"].to_pylist() if isinstance(found, pa.Table) else list(found["particle"])
    )
    assert len(set(zip(true, particle, strict=True))) == 4 == len(set(particle))
    assert particle[0] == 0


def test_without_memory_a_particle_unseen_is_another():
    table, true = wandering()
    found = tw.link(table, search_range=5.0)["particle"].to_list()
    assert len({p for t, p in zip(true, found, strict=True) if t == 2}) == 2


def test_what_stands_alone_is_a_particle():
    table = pl.DataFrame({"frame": [0, 1, 1], "x": [0.0, 0.5, 500.0], "y": [0.0] * 3})
    assert tw.link(table, search_range=3.0)["particle"].to_list() == [0, 0, 1]


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"search_range": 0.0}, "search_range"),
        ({"search_range": 5.0, "memory": -1}, "memory"),
        ({"search_range": 5.0, "t_column": "time"}, "column time: missing"),
        ({"search_range": 5.0, "pos_columns": ["x"]}, "two or three"),
        ({"search_range": 5.0, "pos_columns": ["x", "up"]}, "column up: missing"),
    ],
)
def test_what_cannot_be_used_is_refused(given, expected):
    table, _ = wandering(3)
    with pytest.raises(InvalidInputError, match=expected):
        tw.link(table, **given)


@pytest.mark.parametrize("misnamed", ["x", "y"])
def test_nothing_is_linked_by_a_height_in_the_place_of_a_misnamed_column(misnamed):
    table = wandering(3)[0].with_columns(z=0.0).rename({misnamed: f"pos_{misnamed}"})
    expected = rf"column {misnamed}: missing; expected frame and x, y\[, z\], .* pos_columns="
    with pytest.raises(InvalidInputError, match=expected):
        tw.link(table, search_range=8.0)
    places = ["pos_x", "y"] if misnamed == "x" else ["x", "pos_y"]
    assert len(tw.link(table, search_range=8.0, pos_columns=places)) == len(table)


@pytest.mark.parametrize("name", ["t", "Frame", "time", "timestamp"])
def test_the_column_of_frames_may_have_any_name_that_track_takes(name):
    table, _ = wandering(3)
    found = tw.link(table.rename({"frame": name}), search_range=5.0)
    assert found["particle"].to_list() == tw.link(table, search_range=5.0)["particle"].to_list()


def test_a_frame_goes_before_a_time():
    table = pl.DataFrame({"time": [0.5, 9.7], "frame": [1, 2], "x": [0.0, 0.5], "y": [0.0] * 2})
    assert tw.link(table, search_range=3.0)["particle"].to_list() == [0, 0]


@pytest.mark.parametrize(("column", "value"), [("frame", 0.5), ("x", float("nan")), ("y", None)])
def test_a_row_that_says_no_frame_or_place_is_named(column, value):
    table, _ = wandering(3)
    cells = [*table[column].to_list()[:-1], value]
    row = rf"row {len(table)}, column {column}: "
    with pytest.raises(InvalidInputError, match=row):
        tw.link(table.with_columns(pl.Series(column, cells, strict=False)), search_range=5.0)


def test_a_table_without_rows_has_no_particles():
    table, _ = wandering(3)
    assert tw.link(table.head(0), search_range=5.0)["particle"].to_list() == []


def test_two_particles_are_not_joined_though_one_ends_beside_the_other():
    table = pl.DataFrame({"frame": [0, 0, 1], "x": [0.0, 4.0, 3.0], "y": [0.0] * 3})
    assert tw.link(table, search_range=9.0)["particle"].to_list() == [0, 1, 1]


def cells(shared) -> tuple[pl.DataFrame, list[str]]:
    """A recording of dividing cells, and the cell of each row."""
    folder = shared / "data" / "cell_btrack"
    table = pl.read_csv(folder / "test_data.csv")
    known = json.loads((folder / "test_ground_truth.json").read_text())
    true = np.full(len(table), "", dtype=object)
    for name, rows in known.items():
        true[rows] = name
    return table, true.tolist()


@pytest.mark.shared
@pytest.mark.parametrize(("reach", "least"), [(10.0, 0.985), (12.0, 1.0), (15.0, 1.0)])
def test_cells_are_linked_rightly_where_their_steps_are_in_range(shared, reach, least):
    # One step of a cell is 10.34 long, which a range of 10 does not allow.
    table, true = cells(shared)
    found = tw.link(table, search_range=reach, pos_columns=["x", "y"])["particle"]
    assert assignment_quality(true, found.to_numpy()).idf1 >= least


@pytest.mark.shared
def test_a_large_range_joins_what_ends_to_what_begins_and_breaks_nothing(shared):
    table, true = cells(shared)
    found = tw.link(table, search_range=100.0)["particle"]
    assert found.n_unique() == 4
    assert assignment_quality(true, found.to_numpy()).idf1 > 0.67
